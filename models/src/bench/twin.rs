//! The twin of an engine: the same sums on the same scene, written with AVX-512 intrinsics, for one thread.
use pdlang_runtime::body::Body;
use pdlang_runtime::engine::{Engine, State};

/// Which sums, with what they start from.
pub enum Sums {
    /// c = 18 K/(pi delta^4) [N/m^6].
    Pmb(f64),
    /// B = 15 G/m and q = 3 (3K - 5G)/m^2 of every node, for the two sweeps of each step.
    Lps([Vec<f64>; 2]),
}

#[cfg(target_arch = "x86_64")]
pub use intrinsics::Twin;

#[cfg(target_arch = "x86_64")]
mod intrinsics {
    use super::{Body, Engine, State, Sums};
    use crate::bench::{cloud, lattice};
    use pdlang_runtime::engine::Isa;

    pub struct Twin {
        pmb: bool,
        loops: Loops,
        /// Where the twin has every node, in user order.
        slots: Vec<usize>,
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
            let (pmb, c) = match sums {
                Sums::Pmb(c) => (true, *c),
                Sums::Lps(_) => (false, 0.0),
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
                if let Sums::Lps(values) = sums {
                    (b[slot], q[slot]) = (values[0][node], values[1][node]);
                }
            }
            Some(Twin { pmb, loops, slots })
        }

        pub fn run(&mut self) {
            match (&mut self.loops, self.pmb) {
                (Loops::Lattice(t), true) => t.pmb(),
                (Loops::Lattice(t), false) => t.lps(),
                (Loops::Cloud(t), true) => t.pmb(),
                (Loops::Cloud(t), false) => t.lps(),
            }
        }

        /// Largest difference to the forces of an engine, relative to the largest force.
        pub fn distance(&self, e: &Engine) -> f64 {
            let f = match &self.loops {
                Loops::Lattice(t) => &t.f,
                Loops::Cloud(t) => &t.f,
            };
            let (mut miss, mut size) = (0.0f64, 0.0f64);
            for (node, &slot) in self.slots.iter().enumerate() {
                for a in 0..3 {
                    miss = miss.max((f[a][slot] - e.force()[a][e.slot(node)]).abs());
                    size = size.max(f[a][slot].abs());
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
