//! A law, linearised: what is left of its answers for small displacements.
//!
//! Contract. Works on lowered polynomials, before anything is derived from them. An energy becomes its Taylor polynomial
//! of second order in the displacement, at rest; a force, a force state and a rate that of first order. What is one
//! already stays as it is. Velocities, fields and histories are held. So the force is the full one at rest, plus the
//! full tangent at rest times the displacement, and everything behind treats the law as any other.
//!
//! Breaking and what outputs show need not be smooth: there every comparison, absolute value or extreme is formed of
//! what is left of its arguments, the first order or, where there is none, the second.
//!
//! Refused are laws that have no such form: answers that are not smooth at rest, memories of displacements, and
//! velocities that a law replaces.

mod refused;
mod taylor;

use crate::diag::Diagnostic;
use crate::ir::ExprId;
use crate::lower::{Lowering, Reading};
use crate::poly::Poly;

pub use refused::refused;
use taylor::Taylor;

/// What is kept of a value.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Keep {
    /// Of forces, force states and rates.
    First,
    /// Of energies.
    Second,
    /// Of definitions, which outputs show: the first order, or the second where there is no other. All, where the
    /// answers of the law are linear as they stand.
    Shown,
    /// Of conditions of breaking: of either side the same.
    Sides,
}

/// What linearising a law has found so far.
#[derive(Default)]
pub struct Linear {
    /// Whether some answer was not linear as it stood.
    changed: bool,
    pub refused: Vec<Diagnostic>,
}

/// Has no slope at rest.
struct Rough;

impl Lowering<'_> {
    /// What is left of the components of `e` for small displacements; everything, of a law that is not linearised.
    pub fn small(
        &mut self,
        e: ExprId,
        parts: Vec<Poly>,
        reading: Reading,
        keep: Keep,
    ) -> Vec<Poly> {
        let Some(linear) = &self.linear else {
            return parts;
        };
        if keep == Keep::Shown && !linear.changed {
            return parts;
        }
        let loose = matches!(keep, Keep::Shown | Keep::Sides);
        let mut taylor = Taylor::new(self, reading, loose);
        let found: Result<Vec<Poly>, Rough> = parts.iter().map(|p| taylor.kept(p, keep)).collect();
        let Some(linear) = &mut self.linear else {
            return parts;
        };
        match found {
            Ok(found) => {
                linear.changed |= keep != Keep::Sides && found != parts;
                found
            }
            Err(Rough) => {
                let why = refused::rough(self.law, e);
                if !linear.refused.contains(&why) {
                    linear.refused.push(why);
                }
                parts
            }
        }
    }
}

#[cfg(test)]
mod tests;
