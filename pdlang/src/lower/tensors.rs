//! Vectors and tensors component by component: products, parts, determinant and inverse.

use super::{Lowering, Value};
use crate::ir::{FLAT, Shape};
use crate::poly::{Atom, Func, Poly, Rate};
use crate::ratio::Ratio;

impl Lowering<'_> {
    pub(super) fn dot(&mut self, u: &[Poly], v: &[Poly]) -> Poly {
        let mut all_xi = true;
        let mut all_y = true;
        for a in 0..self.dim {
            let xi = self.algebra.poly(Atom::Xi(a as u8));
            let y = self.algebra.poly(Atom::Y(a as u8));
            all_xi &= u[a] == xi && v[a] == xi;
            all_y &= u[a] == y && v[a] == y;
        }
        if all_xi {
            let x = self.algebra.intern(Atom::X);
            return Poly::power(x, 2);
        }
        if all_y {
            let y = self.algebra.deformed_length();
            return self.algebra.powi(&y, 2);
        }
        let mut sum = Poly::zero();
        for (p, q) in u.iter().zip(v) {
            let t = self.algebra.mul(p, q);
            sum = self.algebra.add(&sum, &t);
        }
        sum
    }

    pub(super) fn norm(&mut self, v: &[Poly]) -> Poly {
        let squared = self.dot(v, v);
        self.algebra.sqrt(&squared)
    }

    pub(super) fn outer(&mut self, u: &[Poly], v: &[Poly]) -> Value {
        (0..self.dim * self.dim)
            .map(|k| self.algebra.mul(&u[k / self.dim], &v[k % self.dim]))
            .collect()
    }

    pub(super) fn trace(&mut self, t: &[Poly]) -> Poly {
        (0..self.dim).fold(Poly::zero(), |s, a| {
            self.algebra.add(&s, &t[a * self.dim + a])
        })
    }

    pub(super) fn transpose(&self, t: &[Poly]) -> Value {
        (0..self.dim * self.dim)
            .map(|k| t[(k % self.dim) * self.dim + k / self.dim].clone())
            .collect()
    }

    pub(super) fn diagonal(&self, v: &[Poly], shape: Shape) -> Value {
        let d = self.dim;
        match shape {
            Shape::Vector => (0..d * d)
                .map(|k| match k / d == k % d {
                    true => v[k / d].clone(),
                    false => Poly::zero(),
                })
                .collect(),
            _ => (0..d).map(|a| v[a * d + a].clone()).collect(),
        }
    }

    pub(super) fn sym(&mut self, t: &[Poly]) -> Value {
        let half = Ratio::from_f64(0.5).unwrap_or(Ratio::ONE);
        let transposed = self.transpose(t);
        let sums: Vec<Poly> = t
            .iter()
            .zip(&transposed)
            .map(|(p, q)| self.algebra.add(p, q))
            .collect();
        sums.iter().map(|p| self.algebra.scale(p, half)).collect()
    }

    pub(super) fn dev(&mut self, t: &[Poly]) -> Value {
        let third = Ratio::ONE
            .div(Ratio::int(self.dim as i64))
            .unwrap_or(Ratio::ONE);
        let trace = self.trace(t);
        let mean = self.algebra.scale(&trace, third);
        let eye = self.identity();
        (0..t.len())
            .map(|k| {
                if eye[k].is_zero() {
                    t[k].clone()
                } else {
                    self.algebra.sub(&t[k], &mean)
                }
            })
            .collect()
    }

    pub(super) fn minor(&mut self, t: &[Poly], r: usize, c: usize) -> Poly {
        let d = self.dim;
        let pick = |r: usize, c: usize| t[(r % d) * d + c % d].clone();
        match d {
            1 => Poly::int(1),
            2 => {
                let m = pick(r + 1, c + 1);
                if (r + c).is_multiple_of(2) {
                    m
                } else {
                    m.neg()
                }
            }
            // Cyclic indices carry the sign in three dimensions.
            _ => {
                let p = self.algebra.mul(&pick(r + 1, c + 1), &pick(r + 2, c + 2));
                let q = self.algebra.mul(&pick(r + 1, c + 2), &pick(r + 2, c + 1));
                self.algebra.sub(&p, &q)
            }
        }
    }

    pub(super) fn det(&mut self, t: &[Poly]) -> Poly {
        let mut sum = Poly::zero();
        for c in 0..self.dim {
            let m = self.minor(t, 0, c);
            let p = self.algebra.mul(&t[c], &m);
            sum = self.algebra.add(&sum, &p);
        }
        sum
    }

    /// The reciprocal of the determinant of a shape, or 0 where the bonds lie in a line or a plane.
    fn unless_flat(&mut self, det: &Poly, t: &[Poly]) -> Poly {
        let mut sizes: Vec<Poly> = Vec::new();
        for p in t.iter().filter(|p| !p.is_zero()) {
            let size = self.algebra.func(Func::Abs, vec![p.clone()]);
            if !sizes.contains(&size) {
                sizes.push(size);
            }
        }
        let largest = sizes
            .into_iter()
            .reduce(|a, b| self.algebra.func(Func::Max, vec![a, b]));
        let r = self.algebra.recip(det);
        let Some(largest) = largest else {
            return r;
        };
        let cube = self.algebra.powi(&largest, self.dim as i32);
        let least = self.algebra.number(FLAT);
        let least = self.algebra.mul(&cube, &least);
        let size = self.algebra.func(Func::Abs, vec![det.clone()]);
        let full = self.algebra.func(Func::Lt, vec![least, size]);
        self.algebra.func(Func::Select, vec![full, r, Poly::zero()])
    }

    pub(super) fn inverse(&mut self, t: &[Poly]) -> Value {
        let det = self.det(t);
        let nature = self.algebra.nature_of(&det);
        let r = match nature.sums && nature.rate < Rate::Step && self.dim > 1 {
            true => self.unless_flat(&det, t),
            false => self.algebra.recip(&det),
        };
        (0..t.len())
            .map(|k| {
                let m = self.minor(t, k % self.dim, k / self.dim);
                self.algebra.mul(&m, &r)
            })
            .collect()
    }
}
