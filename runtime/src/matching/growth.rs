//! Whether a bar between two matching boundaries keeps still: its growth, from the powers of one step.
//!
//! A wave that a boundary sends back may grow on its way to and fro, and a boundary may have motions of its own that
//! grow. Both are in the step of a closed bar, `L` planes between two boundaries: the step is squared again and again,
//! and what its norm gains is the rate of the fastest growth, however slow. What grows at the same rate in a longer bar
//! is a motion of the boundary; waves grow the slower the longer the bar.

use super::chain::Chain;
use super::coefficients::{Coefficients, Rule, Steps};
use super::strip::Strip;

/// Planes between the boundaries, at least.
const PLANES: usize = 40;
/// Of the step, over the inverse of the largest frequency.
const STEP: f64 = 0.1;
/// How often the step is squared.
const SQUARES: i32 = 36;

/// The fastest growth of what a bar between two such boundaries can do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Growth {
    /// Over the largest frequency of the chain.
    pub rate: f64,
    /// Whether a bar twice as long grows as fast: a motion of the boundary itself.
    pub of_boundary: bool,
}

impl Growth {
    /// What is wrong with a condition that grows.
    pub(super) fn sentence(&self, chain: &Chain, conditions: &[Coefficients]) -> String {
        let rate = self.rate * chain.largest();
        let negative = conditions.iter().flat_map(|c| &c.c).find(|c| **c < 0.0);
        match (self.of_boundary, negative) {
            (true, Some(c)) => format!(
                "has a motion of its own that grows at {rate:.2e} 1/s, as conditions with negative coefficients do ({c:.4})"
            ),
            (true, None) => format!("has a motion of its own that grows at {rate:.2e} 1/s"),
            (false, _) => {
                format!(
                    "sends waves back stronger than they come: {PLANES} planes between two of them grow at {rate:.2e} 1/s"
                )
            }
        }
    }
}

/// The growth of the closed bar.
pub fn growth(chain: &Chain, conditions: &[Coefficients], rule: Rule, strip: &Strip) -> Growth {
    let planes = PLANES.max(4 * chain.reach());
    let rate = of_bar(chain, conditions, (rule, strip), planes);
    let longer = if rate > super::STILL {
        of_bar(chain, conditions, (rule, strip), 2 * planes)
    } else {
        rate
    };
    Growth {
        rate,
        of_boundary: longer > 0.8 * rate,
    }
}

/// Rate of growth over the largest frequency.
fn of_bar(
    chain: &Chain,
    conditions: &[Coefficients],
    (rule, strip): (Rule, &Strip),
    planes: usize,
) -> f64 {
    let dt = STEP / chain.largest();
    let bar = Bar {
        chain,
        strip,
        steps: Steps::of(conditions, rule, dt),
        dt,
        planes,
    };
    let size = bar.size();
    let mut power = vec![0.0; size * size];
    for column in 0..size {
        let mut state = vec![0.0; size];
        state[column] = 1.0;
        bar.advance(&mut state);
        for (row, value) in state.iter().enumerate() {
            power[row * size + column] = *value;
        }
    }
    let (mut log, mut last) = (0.0, 0.0);
    for k in 0..SQUARES {
        let norm = power.iter().map(|v| v * v).sum::<f64>().sqrt();
        if !(norm > 0.0 && norm.is_finite()) {
            return f64::INFINITY;
        }
        power.iter_mut().for_each(|v| *v /= norm);
        let whole = log + norm.ln();
        if k > 0 {
            last = (whole - 0.5 * log) / 2f64.powi(k - 1);
        }
        if k + 1 < SQUARES {
            power = squared(&power, size);
        }
        log = 2.0 * whole;
    }
    (last / STEP).max(0.0)
}

/// A bar between two boundaries.
struct Bar<'a> {
    chain: &'a Chain,
    strip: &'a Strip,
    steps: Steps,
    dt: f64,
    /// Planes between the boundaries.
    planes: usize,
}

impl Bar<'_> {
    fn all(&self) -> usize {
        self.planes + 2 * self.chain.reach()
    }

    /// Planes at either end of which conditions read where they were a step before; with one condition none.
    fn older(&self) -> usize {
        match self.steps.times {
            ..=2 => 0,
            _ => self.chain.reach() + self.steps.reach,
        }
    }

    /// Displacements of all planes; those of the planes at the ends a step before; velocities, in the middle of steps, of
    /// the planes between the boundaries.
    fn size(&self) -> usize {
        self.all() + 2 * self.older() + self.planes
    }

    fn advance(&self, state: &mut [f64]) {
        let (layers, planes, all) = (self.chain.reach(), self.planes, self.all());
        let kept = self.older();
        let (u, rest) = state.split_at_mut(all);
        let (older, v) = rest.split_at_mut(2 * kept);
        let before = u.to_vec();
        let reach = layers as isize;
        for (k, v) in v.iter_mut().enumerate() {
            let at = |l: isize| before[(layers + k).wrapping_add_signed(l)];
            let pull = (-reach..=reach).map(|l| self.chain.pull(l) * at(l));
            *v += self.dt * pull.sum::<f64>();
        }
        for (k, v) in v.iter().enumerate() {
            u[layers + k] += self.dt * v;
        }
        // The plane `k` from an end.
        let of = |right: bool, k: usize| if right { all - 1 - k } else { k };
        for m in 0..layers {
            for right in [false, true] {
                let depth = layers - 1 - m;
                let went = self.steps.went(before[of(right, depth)], |j, t| match t {
                    0 => u[of(right, depth + j)],
                    1 => before[of(right, depth + j)],
                    _ => older[usize::from(right) * kept + depth + j],
                });
                u[of(right, depth)] += went;
            }
        }
        for k in 0..kept {
            older[k] = before[of(false, k)];
            older[kept + k] = before[of(true, k)];
        }
        self.smooth(u, &before, v);
        debug_assert_eq!(v.len(), planes);
    }

    /// Exchanges velocities of neighbouring planes, inside of either boundary and with its innermost plane.
    fn smooth(&self, u: &[f64], before: &[f64], v: &mut [f64]) {
        let (layers, planes) = (self.chain.reach(), self.planes);
        if self.strip.planes == 0 {
            return;
        }
        let most = self.strip.exchanged(self.dt);
        let at = |k: usize| (u[k] - before[k]) / self.dt;
        let whole: Vec<f64> = std::iter::once(at(layers - 1))
            .chain(v.iter().copied())
            .chain([at(layers + planes)])
            .collect();
        let share = |k: usize| match k {
            0 => 1.0,
            k if k > planes => 1.0,
            k => self.strip.share((k - 1).min(planes - k)),
        };
        // Planes behind the strip take no part.
        let both = |a: usize, b: usize| match share(a).min(share(b)) {
            0.0 => 0.0,
            _ => 0.5 * (share(a) + share(b)),
        };
        for (k, v) in v.iter_mut().enumerate() {
            for (a, b) in [(k + 1, k), (k + 1, k + 2)] {
                *v += most * both(a, b) * (whole[b] - whole[a]);
            }
        }
    }
}

fn squared(a: &[f64], n: usize) -> Vec<f64> {
    let mut out = vec![0.0; n * n];
    for (row, out) in a.chunks_exact(n).zip(out.chunks_exact_mut(n)) {
        for (factor, b) in row.iter().zip(a.chunks_exact(n)) {
            if *factor != 0.0 {
                out.iter_mut().zip(b).for_each(|(o, b)| *o += factor * b);
            }
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The chain of planes of a bond-based law whose bonds all have the same constant.
    fn bonds(n: usize) -> Chain {
        let pull = |l: isize| match l.unsigned_abs() {
            0 => 0.0,
            l => 1.0 / l as f64,
        };
        chain((-(n as isize)..=n as isize).map(pull).collect())
    }

    /// The correspondence chain of eq. 20 and 38, with the stabilisation of 39; spacing, density and modulus 1.
    fn correspondence(n: usize, gs: f64) -> Chain {
        let m = n as isize;
        let a = (n * (n + 1) * (2 * n + 1)) as f64 / 3.0;
        let mut s = vec![0.0; 4 * n + 1];
        let mut add = |l: isize, v: f64| s[(l + 2 * m) as usize] += v;
        let steps: Vec<isize> = (-m..=m).filter(|i| *i != 0).collect();
        // C_BB of a horizon of n spacings, over the weight of the family.
        let g = gs * 2.0 / (n as f64).powi(3) / (2.0 * n as f64);
        for &i in &steps {
            for &j in &steps {
                let product = (i * j) as f64;
                add(i + j, product / (a * a) - g * product / a);
                add(i, -product / (a * a) + g * product / a);
            }
            add(i, 2.0 * g);
            add(0, -2.0 * g);
        }
        chain(s)
    }

    fn chain(mut s: Vec<f64>) -> Chain {
        let rest: f64 = s.iter().sum();
        let middle = s.len() / 2;
        s[middle] -= rest;
        Chain::new(s, 1.0)
    }

    fn rate(chain: &Chain, n: usize) -> Growth {
        let c = Coefficients::of(&chain.series(n), n, 1.0).unwrap();
        growth(chain, &[c], Rule::Trapezoidal, &Strip::new(0, 1, chain))
    }

    #[test]
    fn the_first_order_is_stable() {
        for n in [1, 2, 3, 5] {
            let found = rate(&bonds(n), 1);
            assert!(found.rate <= super::super::STILL, "{n}: {found:?}");
        }
        for (n, gs) in [(1, 0.0), (1, 0.25), (2, 0.0), (2, 1.0), (3, 0.0), (3, 3.5)] {
            let found = rate(&correspondence(n, gs), 1);
            assert!(found.rate <= super::super::STILL, "{n} {gs}: {found:?}");
        }
    }

    /// What the eigenvalues of the closed bar say: stable, waves that grow, motions of the boundary.
    #[test]
    fn higher_orders_are_told_apart() {
        let still = |chain: Chain, n: usize| {
            let found = rate(&chain, n);
            assert!(found.rate <= super::super::STILL, "{found:?}");
        };
        (2..=4).for_each(|n| still(bonds(1), n));
        for gs in [0.26, 0.5, 0.99] {
            still(correspondence(1, gs), 2);
        }
        for gs in [0.26, 0.5, 0.66] {
            still(correspondence(1, gs), 3);
        }
        still(correspondence(2, 2.5), 2);
        still(correspondence(2, 3.4), 2);
        let grows = |chain: Chain, n: usize, of_boundary: bool| {
            let found = rate(&chain, n);
            assert!(found.rate > super::super::STILL, "{found:?}");
            assert_eq!(found.of_boundary, of_boundary, "{found:?}");
        };
        grows(bonds(2), 2, false);
        grows(bonds(2), 3, false);
        grows(bonds(3), 2, true);
        grows(correspondence(1, 0.2), 2, false);
        grows(correspondence(2, 0.5), 2, true);
        grows(correspondence(2, 1.5), 2, true);
        grows(correspondence(2, 2.0), 2, false);
        grows(correspondence(2, 4.0), 2, false);
        grows(correspondence(3, 3.0), 2, true);
        grows(correspondence(3, 2.4), 3, true);
    }

    /// Longitudinal and transverse waves at once: the second condition is that of 0.6 of the own speed. A body may drift,
    /// which is on the edge, and short waves come back stronger.
    #[test]
    fn two_conditions_grow() {
        for chain in [
            bonds(1),
            bonds(3),
            correspondence(1, 0.5),
            correspondence(3, 0.0),
        ] {
            let own = chain.series(1);
            let other = [own[0] * 0.6];
            let both = [&own[..], &other].map(|a| Coefficients::of(a, 1, 1.0).unwrap());
            let none = Strip::new(0, 2, &chain);
            let found = growth(&chain, &both, Rule::Trapezoidal, &none);
            assert!(found.rate > super::super::STILL, "{found:?}");
        }
    }

    /// Speeds and the first coefficients of dispersion in closed form: 17/30 - 17 Gs/64 and 13/120 for n = 2.
    #[test]
    fn series_of_the_correspondence_chain() {
        let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        let plain = correspondence(2, 0.0).series(4);
        [1.0, 17.0 / 30.0, 13.0 / 120.0, 257.0 / 25200.0]
            .iter()
            .zip(&plain)
            .for_each(|(a, b)| near(*a, *b));
        let held = correspondence(2, 0.5).series(3);
        near(held[1], 17.0 / 30.0 - 17.0 * 0.5 / 64.0);
        near(held[2], 13.0 / 120.0 - 0.5 / 160.0 - 289.0 * 0.25 / 8192.0);
        let bonds = bonds(2).series(2);
        assert!((bonds[1] / bonds[0] - 0.153_093_108_924 / 1.224_744_871_392).abs() < 1e-11);
    }
}
