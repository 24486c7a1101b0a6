//! The twin of an engine: the same sums on the same scene, written with AVX-512 intrinsics, for one thread.
use pdlang_runtime::body::Body;
use pdlang_runtime::engine::{Engine, State};

/// Which sums, with what they start from.
pub enum Sums {
    /// c = 18 K/(pi delta^4) [N/m^6].
    Pmb(f64),
    /// B = 15 G/m and q = 3 (3K - 5G)/m^2 of every node, for the two sweeps of each step.
    Lps([Vec<f64>; 2]),
    /// 2 dim k/ball(omega x^2) [W/(m^5 K)] and 1/(density cv), of the rate of the temperature.
    Heat { c: f64, storage: f64 },
    /// With omega = 1.
    Correspondence(Elastic),
}

/// The material of the twin of stabilised correspondence, with omega = 1.
#[derive(Clone, Copy, Default)]
pub struct Elastic {
    /// Lame parameters [Pa].
    pub lambda: f64,
    pub mu: f64,
    /// Micro-modulus times the factor of the stabilisation [N/m^6].
    pub penalty: f64,
}

#[cfg(target_arch = "x86_64")]
pub use intrinsics::Twin;

#[cfg(target_arch = "x86_64")]
mod intrinsics {
    use super::{Body, Elastic, Engine, State, Sums};
    use crate::bench::{cloud, lattice};
    use pdlang_runtime::engine::Isa;

    pub struct Twin {
        kind: Kind,
        loops: Loops,
        /// Where the twin has every node, in user order.
        slots: Vec<usize>,
    }

    #[derive(Clone, Copy)]
    enum Kind {
        Pmb,
        Lps,
        Heat,
        Correspondence(Elastic),
    }

    enum Loops {
        Lattice(Box<lattice::Twin>),
        Cloud(Box<cloud::Twin>),
    }

    impl Twin {
        /// In the state of an engine on a body of [`crate::bench::scene`]; `s0` is the critical stretch. None where the
        /// processor lacks AVX-512.
        pub fn new(body: &Body, sums: &Sums, s0: f64, e: &Engine, s: &State) -> Option<Twin> {
            if !Isa::Avx512.available() {
                return None;
            }
            let n = (body.x.len() as f64).cbrt().round() as usize;
            let (kind, c) = match sums {
                Sums::Pmb(c) => (Kind::Pmb, *c),
                Sums::Lps(_) => (Kind::Lps, 0.0),
                Sums::Heat { c, .. } => (Kind::Heat, *c),
                Sums::Correspondence(e) => (Kind::Correspondence(*e), 0.0),
            };
            let (mut loops, slots): (Loops, Vec<usize>) = if e.report().traversal == "lattice" {
                let twin = Box::new(lattice::Twin::new(n, c, s0));
                let slot = |i: usize| twin.slot([i % n, i / n % n, i / n / n]);
                let slots = (0..body.x.len()).map(slot).collect();
                (Loops::Lattice(twin), slots)
            } else {
                let twin = Box::new(cloud::Twin::new(&body.x, e.slots(), e.len(), c, s0));
                let slots = (0..body.x.len()).map(|i| e.slot(i)).collect();
                (Loops::Cloud(twin), slots)
            };
            let (u, b, q) = match &mut loops {
                Loops::Lattice(t) => (&mut t.u, &mut t.b, &mut t.q),
                Loops::Cloud(t) => (&mut t.u, &mut t.b, &mut t.q),
            };
            for (node, &slot) in slots.iter().enumerate() {
                (0..3).for_each(|a| u[a][slot] = s.u[a][e.slot(node)]);
                match sums {
                    Sums::Lps(values) => (b[slot], q[slot]) = (values[0][node], values[1][node]),
                    Sums::Heat { storage, .. } => {
                        q[slot] = *storage;
                        let temperature = e.state_slots("T").unwrap_or_default();
                        for k in temperature {
                            u[0][slot] = s.slots[k][e.slot(node)];
                        }
                    }
                    Sums::Pmb(_) | Sums::Correspondence(_) => {}
                }
            }
            if let Kind::Correspondence(e) = &kind {
                match &mut loops {
                    Loops::Lattice(t) => t.set_up(e),
                    Loops::Cloud(t) => t.set_up(e),
                }
            }
            Some(Twin { kind, loops, slots })
        }

        pub fn run(&mut self) {
            match (&mut self.loops, self.kind) {
                (Loops::Lattice(t), Kind::Pmb) => t.pmb(),
                (Loops::Lattice(t), Kind::Lps) => t.lps(),
                (Loops::Lattice(t), Kind::Heat) => t.heat(),
                (Loops::Lattice(t), Kind::Correspondence(e)) => t.correspondence(&e),
                (Loops::Cloud(t), Kind::Pmb) => t.pmb(),
                (Loops::Cloud(t), Kind::Lps) => t.lps(),
                (Loops::Cloud(t), Kind::Heat) => t.heat(),
                (Loops::Cloud(t), Kind::Correspondence(e)) => t.correspondence(&e),
            }
        }

        /// Largest difference to the forces of an engine, or to its rate of a field, relative to the largest one.
        pub fn distance(&self, e: &Engine) -> f64 {
            let f = match &self.loops {
                Loops::Lattice(t) => &t.f,
                Loops::Cloud(t) => &t.f,
            };
            let rates: Vec<&[f64]> = e.rates().map(|r| r.drive).collect();
            let forces: Vec<&[f64]> = e.force().iter().map(Vec::as_slice).collect();
            let answers = match self.kind {
                Kind::Heat => rates,
                _ => forces,
            };
            let (mut miss, mut size) = (0.0f64, 0.0f64);
            for (node, &slot) in self.slots.iter().enumerate() {
                for (f, answer) in f.iter().zip(&answers) {
                    let apart = (f[slot] - answer[e.slot(node)]).abs();
                    if apart.is_nan() {
                        return f64::NAN;
                    }
                    miss = miss.max(apart);
                    size = size.max(f[slot].abs());
                }
            }
            miss / size
        }
    }
}

/// No twin on this processor.
#[cfg(not(target_arch = "x86_64"))]
pub enum Twin {}

#[cfg(not(target_arch = "x86_64"))]
impl Twin {
    pub fn new(_: &Body, _: &Sums, _: f64, _: &Engine, _: &State) -> Option<Twin> {
        None
    }
    pub fn run(&mut self) {}
    pub fn distance(&self, _: &Engine) -> f64 {
        0.0
    }
}
