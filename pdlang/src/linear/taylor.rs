//! Taylor polynomials of lowered values in the displacement, at rest.
//!
//! Contract. A value becomes its terms of the orders 0, 1 and 2, product by product and function by function; what a
//! definition names keeps its name, of every order for itself. With `loose`, what is not smooth is formed of what is left
//! of its arguments and then held; without, it is an error.

use std::collections::{BTreeMap, HashMap};

use super::{Keep, Rough};
use crate::damping::reads;
use crate::lower::{Lowering, Reading};
use crate::poly::{Algebra, Atom, AtomId, Func, Monomial, Poly, Rate, StateKind};
use crate::ratio::Ratio;

/// Terms of the orders 0, 1 and 2 in the displacement.
type Series = [Poly; 3];

pub(super) struct Taylor<'t, 'l> {
    lowering: &'t mut Lowering<'l>,
    reading: Reading,
    loose: bool,
    memo: HashMap<AtomId, Series>,
}

impl<'t, 'l> Taylor<'t, 'l> {
    pub fn new(lowering: &'t mut Lowering<'l>, reading: Reading, loose: bool) -> Self {
        Taylor {
            lowering,
            reading,
            loose,
            memo: HashMap::new(),
        }
    }

    fn algebra(&mut self) -> &mut Algebra {
        self.lowering.algebra
    }

    /// What is kept of a value.
    pub fn kept(&mut self, p: &Poly, keep: Keep) -> Result<Poly, Rough> {
        let degree = degree(self.algebra(), p);
        let linear = match keep {
            Keep::Second => degree.is_some_and(|d| d <= 2),
            _ => degree.is_some_and(|d| d <= 1),
        };
        if linear {
            return Ok(p.clone());
        }
        let s = self.poly(p)?;
        Ok(match keep {
            Keep::First => self.algebra().sum(&s[..2]),
            Keep::Second => self.algebra().sum(&s),
            Keep::Shown | Keep::Sides => self.left(&s),
        })
    }

    /// The first order; and the second where there is no first one, or one that is there for a field only: that of
    /// `(s - alpha T)^2` is no more than its mixed term.
    fn left(&mut self, s: &Series) -> Poly {
        let of_field = |atom: &Atom| matches!(atom, Atom::State(StateKind::Slot, _));
        let mixed = reads(self.lowering.algebra, &s[1], &of_field, &mut HashMap::new());
        let whole = s[1].is_zero() || mixed;
        self.algebra().sum(if whole { &s[..] } else { &s[..2] })
    }

    fn poly(&mut self, p: &Poly) -> Result<Series, Rough> {
        let mut sum: Series = Default::default();
        for (m, c) in &p.0 {
            let mut term = held(Poly::constant(*c));
            for (a, n) in &m.0 {
                let factor = self.power(*a, *n)?;
                term = self.product(&term, &factor);
            }
            sum = std::array::from_fn(|k| self.algebra().add(&sum[k], &term[k]));
        }
        if self.lowering.dim == 1 {
            sum = sum.map(|p| self.along_a_line(p));
        }
        Ok(sum)
    }

    /// In one dimension xi^2 is x^2.
    fn along_a_line(&mut self, p: Poly) -> Poly {
        let (xi, x) = (
            self.algebra().intern(Atom::Xi(0)),
            self.algebra().intern(Atom::X),
        );
        let mut sum = Poly::zero();
        for (m, c) in p.0 {
            let even = m.degree(xi) / 2 * 2;
            let square = Monomial(vec![(xi, -1), (x, 1)]).powi(even);
            let m = m.mul(&in_order(square));
            sum = self.algebra().add(&sum, &Poly(vec![(m, c)]));
        }
        sum
    }

    fn product(&mut self, a: &Series, b: &Series) -> Series {
        let mut out: Series = Default::default();
        for (i, p) in a.iter().enumerate() {
            for (j, q) in b.iter().enumerate().take(3 - i) {
                let t = self.algebra().mul(p, q);
                out[i + j] = self.algebra().add(&out[i + j], &t);
            }
        }
        out
    }

    fn power(&mut self, a: AtomId, n: i32) -> Result<Series, Rough> {
        let s = self.atom(a)?;
        if is_held(&s) {
            return Ok(held(self.algebra().powi(&s[0], n)));
        }
        let factor = match n < 0 {
            true => self.function(Func::Recip, &[s])?,
            false => s,
        };
        let mut out = factor.clone();
        for _ in 1..n.unsigned_abs() {
            if out.iter().all(Poly::is_zero) {
                break;
            }
            out = self.product(&out, &factor);
        }
        Ok(out)
    }

    fn atom(&mut self, id: AtomId) -> Result<Series, Rough> {
        if let Some(known) = self.memo.get(&id) {
            return Ok(known.clone());
        }
        if self.algebra().nature(id).rate < Rate::Step {
            return Ok(held(Poly::atom(id)));
        }
        let found = match self.algebra().atom(id).clone() {
            Atom::Eta(_) => [Poly::zero(), Poly::atom(id), Poly::zero()],
            Atom::Y(a) => {
                let (xi, eta) = (Atom::Xi(a), Atom::Eta(a));
                [
                    self.algebra().poly(xi),
                    self.algebra().poly(eta),
                    Poly::zero(),
                ]
            }
            Atom::Extension => self.extension(),
            Atom::InverseY => {
                let mut length = self.extension();
                length[0] = self.algebra().poly(Atom::X);
                self.function(Func::Recip, &[length])?
            }
            Atom::Named(name, p) => {
                let s = self.poly(&p)?;
                let names = [format!("{name}_0"), name.clone(), format!("{name}_2")];
                match is_held(&s) && s[0] == p {
                    true => held(Poly::atom(id)),
                    false => self.each(s, |t, k, part| t.named(names[k].clone(), part)),
                }
            }
            Atom::Sum(reduction, family, body) if reduction.is_extreme() => {
                let s = self.poly(&body)?;
                if !is_held(&s) && !self.loose {
                    return Err(Rough);
                }
                let left = self.left(&s);
                held(self.algebra().poly(Atom::Sum(reduction, family, left)))
            }
            Atom::Sum(reduction, family, body) => {
                let s = self.poly(&body)?;
                let reading = self.reading;
                self.each(s, |t, _, part| {
                    t.lowering.reduce(reduction, family, &part, reading)
                })
            }
            Atom::Prime(a) => {
                let s = self.atom(a)?;
                self.each(s, |t, _, part| t.algebra().prime(&part))
            }
            Atom::Func(f, args) => {
                let args: Result<Vec<Series>, Rough> = args.iter().map(|p| self.poly(p)).collect();
                self.function(f, &args?)?
            }
            _ => held(Poly::atom(id)),
        };
        self.memo.insert(id, found.clone());
        Ok(found)
    }

    fn each(&mut self, s: Series, mut act: impl FnMut(&mut Self, usize, Poly) -> Poly) -> Series {
        let mut k = 0;
        s.map(|part| {
            k += 1;
            match part.is_zero() {
                true => part,
                false => act(self, k - 1, part),
            }
        })
    }

    /// Kept whole where it has several terms.
    fn named(&mut self, name: String, p: Poly) -> Poly {
        match p.0.len() > 1 {
            true => self.algebra().poly(Atom::Named(name, p)),
            false => p,
        }
    }

    /// |xi + eta| - |xi| = xi.eta/x + (eta.eta - (xi.eta)^2/x^2)/(2 x) + ..; along a line the first term is all.
    fn extension(&mut self) -> Series {
        let dim = self.lowering.dim as u8;
        let dot = |t: &mut Self, name: &str, left: fn(u8) -> Atom| {
            let mut sum = Poly::zero();
            for a in 0..dim {
                let (p, q) = (t.algebra().poly(left(a)), t.algebra().poly(Atom::Eta(a)));
                let term = t.algebra().mul(&p, &q);
                sum = t.algebra().add(&sum, &term);
            }
            t.named(name.into(), sum)
        };
        let x = self.algebra().intern(Atom::X);
        let along = dot(self, "xi.eta", Atom::Xi);
        let first = self.algebra().mul(&along, &Poly::power(x, -1));
        if dim == 1 {
            return [Poly::zero(), first, Poly::zero()];
        }
        let square = dot(self, "eta.eta", Atom::Eta);
        let parallel = self.algebra().mul(&first, &first);
        let across = self.algebra().sub(&square, &parallel);
        let across = self.algebra().mul(&across, &Poly::power(x, -1));
        let second = self.scaled(&across, 1, 2);
        [Poly::zero(), first, second]
    }

    fn scaled(&mut self, p: &Poly, a: i64, b: i64) -> Poly {
        let k = Ratio::int(a).div(Ratio::int(b)).unwrap_or(Ratio::ONE);
        self.algebra().scale(p, k)
    }

    /// f(s) from value, slope and half of the curvature of f at the first term of s.
    fn function(&mut self, f: Func, args: &[Series]) -> Result<Series, Rough> {
        use Func::*;
        let a = &args[0];
        if args.iter().all(is_held) {
            let args = args.iter().map(|s| s[0].clone()).collect();
            return Ok(held(self.formed(f, args)));
        }
        let smooth = match f {
            Recip | Sqrt | Ln | Pow => !a[0].is_zero(),
            Exp | Sin | Cos | Tan => true,
            Select => is_held(a),
            _ => false,
        };
        if !smooth {
            if !self.loose {
                return Err(Rough);
            }
            let args = args.iter().map(|s| self.left(s)).collect();
            return Ok(held(self.formed(f, args)));
        }
        if f == Select {
            return Ok(std::array::from_fn(|k| {
                let (p, q) = (args[1][k].clone(), args[2][k].clone());
                match p == q {
                    true => p,
                    false => self.formed(Select, vec![a[0].clone(), p, q]),
                }
            }));
        }
        if f == Pow && !is_held(&args[1]) {
            // b^n = exp(n ln b).
            let log = self.function(Ln, &args[..1])?;
            let exponent = self.product(&args[1], &log);
            let value = self.formed(Pow, vec![a[0].clone(), args[1][0].clone()]);
            let half = self.scaled(&value, 1, 2);
            return Ok(self.composed([value.clone(), value, half], &exponent));
        }
        let exponent = args.get(1).map(|s| s[0].clone()).unwrap_or_default();
        let terms = self.terms(f, &a[0], &exponent);
        Ok(self.composed(terms, a))
    }

    /// Value, slope and half of the curvature of a smooth function.
    fn terms(&mut self, f: Func, at: &Poly, exponent: &Poly) -> Series {
        use Func::*;
        let args = match f {
            Pow => vec![at.clone(), exponent.clone()],
            _ => vec![at.clone()],
        };
        let value = self.formed(f, args);
        let inverse = match f {
            Recip => value.clone(),
            Sqrt | Ln | Pow => self.algebra().recip(at),
            _ => Poly::zero(),
        };
        match f {
            Recip | Sqrt | Pow => {
                // at^n: n at^(n-1), n (n-1)/2 at^(n-2).
                let n = match f {
                    Recip => Poly::int(-1),
                    Sqrt => self.scaled(&Poly::int(1), 1, 2),
                    _ => exponent.clone(),
                };
                let below = self.algebra().sub(&n, &Poly::int(1));
                let slope = self.algebra().mul(&n, &value);
                let slope = self.algebra().mul(&slope, &inverse);
                let bend = self.algebra().mul(&below, &slope);
                let bend = self.algebra().mul(&bend, &inverse);
                let bend = self.scaled(&bend, 1, 2);
                [value, slope, bend]
            }
            Ln => {
                let square = self.algebra().mul(&inverse, &inverse);
                let bend = self.scaled(&square, -1, 2);
                [value, inverse, bend]
            }
            Sin | Cos => {
                let other = if f == Sin { Cos } else { Sin };
                let slope = self.formed(other, vec![at.clone()]);
                let slope = if f == Sin { slope } else { slope.neg() };
                let bend = self.scaled(&value, -1, 2);
                [value, slope, bend]
            }
            Tan => {
                let square = self.algebra().mul(&value, &value);
                let slope = self.algebra().add(&Poly::int(1), &square);
                let bend = self.algebra().mul(&value, &slope);
                [value, slope, bend]
            }
            _ => {
                let half = self.scaled(&value, 1, 2);
                [value.clone(), value, half]
            }
        }
    }

    fn composed(&mut self, [value, slope, bend]: Series, s: &Series) -> Series {
        let first = self.algebra().mul(&slope, &s[1]);
        let second = self.algebra().mul(&slope, &s[2]);
        let square = self.algebra().mul(&s[1], &s[1]);
        let curved = self.algebra().mul(&bend, &square);
        [value, first, self.algebra().add(&second, &curved)]
    }

    /// The function in the normal form; at 0 and 1 by its value, so that what is nothing at rest is seen to be.
    fn formed(&mut self, f: Func, args: Vec<Poly>) -> Poly {
        let zero = args[0].is_zero();
        let one = args[0].as_ratio() == Some(Ratio::ONE);
        match f {
            Func::Ln if one => Poly::zero(),
            Func::Sqrt | Func::Pow if one => Poly::int(1),
            Func::Recip => self.algebra().recip(&args[0]),
            Func::Sqrt => self.algebra().sqrt(&args[0]),
            Func::Pow => self.algebra().pow(&args[0], &args[1]),
            Func::Exp | Func::Cos if zero => Poly::int(1),
            Func::Sin | Func::Tan if zero => Poly::zero(),
            _ => self.algebra().func(f, args),
        }
    }
}

fn held(p: Poly) -> Series {
    [p, Poly::zero(), Poly::zero()]
}

fn is_held(s: &Series) -> bool {
    s[1].is_zero() && s[2].is_zero()
}

fn in_order(mut m: Monomial) -> Monomial {
    m.0.sort();
    m
}

/// The degree in the displacement of what is a polynomial of it.
fn degree(algebra: &Algebra, p: &Poly) -> Option<u32> {
    degree_in(algebra, p, &mut BTreeMap::new())
}

fn degree_in(algebra: &Algebra, p: &Poly, memo: &mut BTreeMap<AtomId, Option<u32>>) -> Option<u32> {
    let mut largest = 0;
    for (m, _) in &p.0 {
        let mut sum = 0_u32;
        for (a, n) in &m.0 {
            let degree = match degree_of(algebra, *a, memo)? {
                0 => 0,
                d => d.checked_mul(u32::try_from(*n).ok()?)?,
            };
            sum = sum.checked_add(degree)?;
        }
        largest = largest.max(sum);
    }
    Some(largest)
}

fn degree_of(
    algebra: &Algebra,
    id: AtomId,
    memo: &mut BTreeMap<AtomId, Option<u32>>,
) -> Option<u32> {
    if algebra.nature(id).rate < Rate::Step {
        return Some(0);
    }
    if let Some(known) = memo.get(&id) {
        return *known;
    }
    let still = |d: Option<u32>| d.filter(|d| *d == 0);
    let found = match algebra.atom(id) {
        Atom::Eta(_) | Atom::Y(_) => Some(1),
        Atom::Extension | Atom::InverseY => None,
        Atom::Named(_, p) => degree_in(algebra, p, memo),
        Atom::Sum(r, _, body) if r.is_extreme() => still(degree_in(algebra, body, memo)),
        Atom::Sum(_, _, body) => degree_in(algebra, body, memo),
        Atom::Prime(a) => degree_of(algebra, *a, memo),
        Atom::Func(_, args) => {
            let all = args.iter().map(|p| still(degree_in(algebra, p, memo)));
            all.collect::<Option<Vec<u32>>>().map(|_| 0)
        }
        _ => Some(0),
    };
    memo.insert(id, found);
    found
}
