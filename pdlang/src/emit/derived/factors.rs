//! The product rule: a product, seen from each of its factors.

use super::algebra::{Atom, Product, Sum, contracted, is_scalar, outer};
use crate::ir::Shape;
use crate::ratio::Ratio;

/// A factor of a product, and what its slope or its change is multiplied with.
pub(super) struct Factor<'p> {
    pub atom: &'p Atom,
    /// All of the product, for a scalar with one power less and the power before it; what stands before a tensor.
    before: Product,
    /// Tensors behind a tensor.
    behind: &'p [Atom],
}

/// The factors of a product that `moves` picks. `None` where a number would overflow.
pub(super) fn factors<'p>(
    p: &'p Product,
    moves: impl Fn(&Atom) -> bool,
) -> Option<Vec<Factor<'p>>> {
    let mut all = vec![];
    for (k, (atom, power)) in p.scalars.iter().enumerate() {
        if !moves(atom) {
            continue;
        }
        let mut before = p.clone();
        before.number = before.number.mul(*power)?;
        before.scalars[k].1 = power.add(Ratio::int(-1))?;
        if before.scalars[k].1.is_zero() {
            before.scalars.remove(k);
        }
        all.push(Factor {
            atom,
            before,
            behind: &[],
        });
    }
    for (k, atom) in p.tensors.iter().enumerate() {
        if moves(atom) {
            let before = Product {
                tensors: p.tensors[..k].to_vec(),
                ..p.clone()
            };
            let behind = &p.tensors[k + 1..];
            all.push(Factor {
                atom,
                before,
                behind,
            });
        }
    }
    Some(all)
}

impl Factor<'_> {
    /// The change of the product, for that of the factor.
    pub(super) fn change(&self, own: &Sum) -> Option<Sum> {
        let before = Sum(vec![self.before.clone()]);
        before.times(own)?.times(&tensors(self.behind))
    }

    /// The slope by the factor, for the slope `by` of the product.
    pub(super) fn slope(&self, by: &Sum) -> Option<Sum> {
        if is_scalar(self.atom.shape) {
            return contracted(by, &Sum(vec![self.before.clone()]));
        }
        let scalars = Sum(vec![Product {
            tensors: vec![],
            ..self.before.clone()
        }]);
        let mut slope = scalars.times(by)?;
        if !self.before.tensors.is_empty() {
            slope = tensors(&self.before.tensors).transposed()?.times(&slope)?;
        }
        match self.behind {
            [] => Some(slope),
            [.., last] if last.shape == Shape::Vector => outer(&slope, &tensors(self.behind)),
            _ => slope.times(&tensors(self.behind).transposed()?),
        }
    }
}

fn tensors(list: &[Atom]) -> Sum {
    Sum(vec![Product {
        number: Ratio::ONE,
        scalars: vec![],
        tensors: list.to_vec(),
    }])
}
