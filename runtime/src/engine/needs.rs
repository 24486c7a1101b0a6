//! Which sweeps of the step stage serve the force, and which the rates of the fields.
use crate::spec::{RateSpec, Spec, Stage, Stepped, SweepSpec};

/// What an evaluation is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Need {
    /// The force, the rates, and all that later stages read.
    All,
    /// Everything but what the rates alone need; [`super::Engine::rates`] is then out of date.
    Motion,
    /// The rates of the fields at full steps; the force is then out of date.
    Rates,
    /// The rates of the fields at half steps, and what breaks bonds: all that does not read those fields.
    Half,
    /// What [`Need::Motion`] needs beyond [`Need::Half`].
    Rest,
}

/// For every sweep: whether the motion and whether the rates need it. Only sweeps of the step stage are asked for.
#[derive(Debug, Default)]
pub(super) struct Needs {
    motion: Vec<bool>,
    rates: Vec<bool>,
    half: Vec<bool>,
}

impl Needs {
    pub(super) fn of(spec: &Spec) -> Needs {
        let step = |s: &SweepSpec| s.stage == Stage::Step;
        let slots = |half: bool| -> Vec<u32> {
            let chosen = move |r: &&RateSpec| (r.stepped == Stepped::Half) == half;
            let slots = |r: &RateSpec| [Some(r.rate), r.damping];
            spec.rates
                .iter()
                .filter(chosen)
                .flat_map(slots)
                .flatten()
                .collect()
        };
        let kills = |s: &SweepSpec| s.kills && step(s);
        let for_rates = closure(spec, slots(false), |_| false);
        let half = closure(spec, slots(true), kills);
        let mut read = [&spec.force[..], &spec.tangent].concat();
        read.extend(spec.energy);
        read.extend(spec.named.iter().flat_map(|(_, slots)| slots));
        for s in spec.sweeps.iter().filter(|s| s.stage > Stage::Step) {
            read.extend(s.own.iter().chain(&s.nbr));
        }
        let for_motion = closure(spec, read, kills);
        // A sweep that nobody asks for runs with the motion.
        let motion = (for_motion.iter().zip(&for_rates))
            .map(|(motion, rates)| *motion || !rates)
            .collect();
        Needs {
            motion,
            rates: for_rates,
            half,
        }
    }

    pub(super) fn includes(&self, sweep: usize, need: Need) -> bool {
        match need {
            Need::All => true,
            Need::Motion => self.motion[sweep],
            Need::Rates => self.rates[sweep],
            Need::Half => self.half[sweep],
            Need::Rest => self.motion[sweep] && !self.half[sweep],
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
