//! What two materials have on a bond between them: where on it they meet, and what value a parameter has there.
use super::SetupError;
use crate::body::Body;
use crate::shape::{Shape, tolerance};
use crate::spec::{Meet, Op, Spec};
use crate::tape::Function;
use std::ops::RangeInclusive;

/// [`Meet`], ready to be evaluated.
pub(super) enum Rule {
    Arithmetic,
    Harmonic,
    Series,
    Min,
    Max,
    Formula { function: Function, lengths: bool },
}

/// Fractions of a bond in the materials of its two ends. Half each where it is not known.
pub(super) type Fractions = [f64; 2];

pub(super) const HALVES: Fractions = [0.5, 0.5];

impl Rule {
    /// One per parameter of the law.
    pub fn all(spec: &Spec) -> Result<Vec<Rule>, SetupError> {
        let rule = |p: &crate::spec::ParamSpec| {
            let m = |e| SetupError::law(&spec.law, format!("how `{}` meets: {e}", p.name));
            Rule::new(&p.meet).map_err(m)
        };
        spec.params.iter().map(rule).collect()
    }

    fn new(meet: &Meet) -> Result<Rule, crate::tape::TapeError> {
        Ok(match meet {
            Meet::Arithmetic => Rule::Arithmetic,
            Meet::Harmonic => Rule::Harmonic,
            Meet::Series => Rule::Series,
            Meet::Min => Rule::Min,
            Meet::Max => Rule::Max,
            Meet::Formula(_, tape) => Rule::Formula {
                function: Function::new(tape, 4)?,
                lengths: tape.ops.iter().any(|op| matches!(op, Op::Var(2 | 3))),
            },
        })
    }

    /// Whether it asks how much of the bond lies in either material.
    pub fn by_lengths(&self) -> bool {
        matches!(self, Rule::Series | Rule::Formula { lengths: true, .. })
    }

    /// The value between ends with the values `a` and `b`.
    pub fn of(&self, a: f64, b: f64, [fa, fb]: Fractions) -> f64 {
        // A part without length counts for nothing, whatever its value.
        let part = |f: f64, v: f64| if f == 0.0 { 0.0 } else { f / v };
        match self {
            _ if a == b => a,
            Rule::Formula { function, .. } => function.call(&[a, b, fa, fb]),
            Rule::Arithmetic => 0.5 * (a + b),
            Rule::Harmonic if a.is_infinite() => 2.0 * b,
            Rule::Harmonic if b.is_infinite() => 2.0 * a,
            Rule::Harmonic => 2.0 * a * b / (a + b),
            Rule::Series => 1.0 / (part(fa, a) + part(fb, b)),
            Rule::Min => a.min(b),
            Rule::Max => a.max(b),
        }
    }
}

/// Intervals of a bond at whose ends its material is looked up: a layer thinner than one of them may be overlooked.
const LOOKS: usize = 32;

/// Where the materials are.
pub(super) struct Regions {
    shapes: Vec<Shape>,
    tolerance: f64,
    /// Where a period begins, and its length [m].
    periods: [Option<(f64, f64)>; 3],
}

impl Regions {
    pub fn new(body: &Body) -> Regions {
        let extent = |a: usize| {
            let x = body.x.iter().map(|x| x[a]);
            x.fold(
                f64::INFINITY..=f64::NEG_INFINITY,
                |r: RangeInclusive<f64>, x| r.start().min(x)..=r.end().max(x),
            )
        };
        // The gap between the last node and the image of the first belongs half to each.
        let period = |a: usize| {
            let (period, extent) = (body.periodic[a]?, extent(a));
            Some((0.5 * (extent.start() + extent.end() - period), period))
        };
        Regions {
            shapes: body.regions.clone(),
            tolerance: tolerance(body.spacing),
            periods: std::array::from_fn(period),
        }
    }

    /// How much of the bond from `a` to `b` lies in the regions of its two ends, of what lies in either.
    pub fn fractions(&self, a: [f64; 3], b: [f64; 3]) -> Fractions {
        if self.shapes.is_empty() {
            return HALVES;
        }
        let point = |t: f64| std::array::from_fn(|k| a[k] + t * (b[k] - a[k]));
        let at = |t: f64| self.region(point(t), 0.0);
        // Nodes on a boundary belong to the region, though a step away from it leads out.
        let ends = [0.0, 1.0].map(|t| self.region(point(t), self.tolerance));
        let mut lengths = [0.0; 2];
        let mut add = |region: usize, length: f64| {
            for (sum, end) in lengths.iter_mut().zip(ends) {
                *sum += if end == region { length } else { 0.0 };
            }
        };
        let (mut from, mut region) = (0.0, ends[0]);
        for k in 1..=LOOKS {
            let to = k as f64 / LOOKS as f64;
            let next = if k == LOOKS { ends[1] } else { at(to) };
            let change = match next == region {
                true => to,
                false => last(from, to, |t| at(t) == region),
            };
            add(region, change - from);
            add(next, to - change);
            (from, region) = (to, next);
        }
        match lengths[0] + lengths[1] {
            all if all > 0.0 && ends[0] != ends[1] => lengths.map(|l| l / all),
            _ => HALVES,
        }
    }

    /// The last region that contains a point, counted from 1; 0 for none.
    fn region(&self, mut x: [f64; 3], tolerance: f64) -> usize {
        for (x, period) in x.iter_mut().zip(self.periods) {
            if let Some((start, length)) = period {
                *x -= ((*x - start) / length).floor() * length;
            }
        }
        let here = |shape: &Shape| shape.contains(x, tolerance);
        self.shapes.iter().rposition(here).map_or(0, |k| k + 1)
    }
}

/// Where between `from` and `to` a statement ceases to hold, to rounding.
fn last(mut from: f64, mut to: f64, holds: impl Fn(f64) -> bool) -> f64 {
    loop {
        let middle = 0.5 * (from + to);
        if middle <= from || middle >= to {
            return middle;
        }
        match holds(middle) {
            true => from = middle,
            false => to = middle,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn regions(shapes: Vec<Shape>, period: Option<(f64, f64)>) -> Regions {
        Regions {
            shapes,
            tolerance: 1e-6,
            periods: [period, None, None],
        }
    }

    fn slab(from: f64, to: f64) -> Shape {
        let all = f64::INFINITY;
        Shape::Box {
            from: [from, -all, -all],
            to: [to, all, all],
        }
    }

    fn along_x(regions: &Regions, from: f64, to: f64) -> Fractions {
        regions.fractions([from, 0.3, -0.1], [to, 0.3, -0.1])
    }

    #[track_caller]
    fn near(found: Fractions, expected: Fractions) {
        for (f, e) in found.iter().zip(expected) {
            assert!((f - e).abs() < 1e-14, "{found:?} is not {expected:?}");
        }
    }

    #[test]
    fn a_plane_divides_a_bond() {
        let r = regions(vec![slab(1.0, 9.0)], None);
        near(along_x(&r, 0.0, 4.0), [0.25, 0.75]);
        near(along_x(&r, 4.0, 0.0), [0.75, 0.25]);
        near(along_x(&r, 0.0, 1.0 + 1e-9), [1.0 / (1.0 + 1e-9), 1e-9]);
        // Both ends in one region, and a region that is not known.
        assert_eq!(along_x(&r, 2.0, 4.0), HALVES);
        assert_eq!(along_x(&regions(vec![], None), 0.0, 4.0), HALVES);
    }

    #[test]
    fn a_node_on_the_boundary_may_have_nothing_of_the_bond() {
        let r = regions(vec![slab(1.0, 9.0)], None);
        assert_eq!(along_x(&r, 0.0, 1.0), [1.0, 0.0]);
        assert_eq!(along_x(&r, 1.0 - 1e-7, 0.0)[0], 0.0);
    }

    #[test]
    fn a_sphere_divides_a_slanting_bond() {
        let (center, radius) = ([0.1, -0.2, 0.3], 0.7);
        let r = regions(vec![Shape::Sphere { center, radius }], None);
        let (x, xi) = ([0.2, -0.1, 0.35], [1.1, -0.7, 0.9]);
        // |x + t xi - center| = radius
        let d: [f64; 3] = std::array::from_fn(|a| x[a] - center[a]);
        let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
        let (a, b, c) = (dot(xi, xi), dot(d, xi), dot(d, d) - radius * radius);
        let t = (-b + (b * b - a * c).sqrt()) / a;
        let end = std::array::from_fn(|k| x[k] + xi[k]);
        near(r.fractions(x, end), [t, 1.0 - t]);
    }

    #[test]
    fn the_last_region_counts_and_a_third_for_neither() {
        let r = regions(vec![slab(1.0, 9.0), slab(1.5, 2.5), slab(3.0, 9.0)], None);
        // 0..1 outside, 1..1.5 and 2.5..3 in the first, 3..4 in the last.
        near(along_x(&r, 0.0, 4.0), [0.5, 0.5]);
        near(along_x(&r, 0.0, 3.5), [2.0 / 3.0, 1.0 / 3.0]);
        near(along_x(&r, 1.1, 3.25), [0.9 / 1.15, 0.25 / 1.15]);
    }

    #[test]
    fn a_bond_across_a_period_sees_the_other_side() {
        // Nodes at 0.5, .., 9.5 of a period of 10.
        let r = regions(vec![slab(0.0, 1.25)], Some((0.0, 10.0)));
        near(along_x(&r, 9.5, 10.5), [0.5, 0.5]);
        near(along_x(&r, 0.5, -1.5), [0.25, 0.75]);
        near(along_x(&r, 11.0, 13.0), [0.125, 0.875]);
    }

    #[test]
    fn rules_agree_with_their_names() {
        let (a, b) = (1.0, 3.0);
        assert_eq!(Rule::Harmonic.of(a, b, [0.25, 0.75]), 1.5);
        assert_eq!(Rule::Series.of(a, b, [0.25, 0.75]), 2.0);
        assert_eq!(Rule::Series.of(b, a, [0.75, 0.25]), 2.0);
        assert_eq!(Rule::Series.of(a, b, HALVES), 1.5);
        let inf = f64::INFINITY;
        assert_eq!(Rule::Harmonic.of(inf, b, HALVES), 6.0);
        assert_eq!(Rule::Series.of(inf, b, HALVES), 6.0);
        assert_eq!(Rule::Series.of(0.0, b, [0.0, 1.0]), b);
        assert_eq!(Rule::Series.of(0.0, b, HALVES), 0.0);
        assert_eq!(Rule::Series.of(inf, b, [1.0, 0.0]), inf);
    }
}
