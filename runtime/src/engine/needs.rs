//! Which sweeps of the step stage serve the force, and which the rates of the fields.
use crate::spec::{Spec, Stage, SweepSpec};

/// What an evaluation is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// The force, the rates, and all that later stages read.
    All,
    /// Everything but what the rates alone need; [`super::Engine::rates`] is then out of date.
    Motion,
    /// The rates of the fields; the force is then out of date.
    Rates,
}

/// For every sweep: whether the motion and whether the rates need it. Only sweeps of the step stage are asked for.
#[derive(Debug, Default)]
pub(super) struct Needs {
    motion: Vec<bool>,
    rates: Vec<bool>,
}

impl Needs {
    pub(super) fn of(spec: &Spec) -> Needs {
        let step = |s: &SweepSpec| s.stage == Stage::Step;
        let rates: Vec<u32> = spec.rates.iter().map(|r| r.1).collect();
        let for_rates = closure(spec, rates, |_| false);
        let mut read = [&spec.force[..], &spec.tangent].concat();
        read.extend(spec.energy);
        read.extend(spec.named.iter().flat_map(|(_, slots)| slots));
        for s in spec.sweeps.iter().filter(|s| s.stage > Stage::Step) {
            read.extend(s.own.iter().chain(&s.nbr));
        }
        let for_motion = closure(spec, read, |s| s.kills && step(s));
        // A sweep that nobody asks for runs with the motion.
        let motion = (for_motion.iter().zip(&for_rates))
            .map(|(motion, rates)| *motion || !rates)
            .collect();
        Needs {
            motion,
            rates: for_rates,
        }
    }

    pub(super) fn includes(&self, sweep: usize, need: Need) -> bool {
        match need {
            Need::All => true,
            Need::Motion => self.motion[sweep],
            Need::Rates => self.rates[sweep],
        }
    }
}

/// The sweeps that write the slots in `read`, or what those sweeps read, and so on.
fn closure(spec: &Spec, mut read: Vec<u32>, also: impl Fn(&SweepSpec) -> bool) -> Vec<bool> {
    let mut needed = vec![false; spec.sweeps.len()];
    // A sweep reads what earlier ones wrote.
    for (k, s) in spec.sweeps.iter().enumerate().rev() {
        if also(s) || s.out.iter().any(|slot| read.contains(slot)) {
            needed[k] = true;
            read.extend(s.own.iter().chain(&s.nbr));
        }
    }
    needed
}
