//! A law at a node of an unbounded body: uniform displacement gradients, and displacements about one node.
//!
//! Where all nodes are alike, one node stands for all. Its bonds lead to itself: what is read at the other end of a
//! bond is the node's own, and a bond seen from there is the opposite one. The weights of the bonds are those of a
//! quadrature over the horizon, or of a lattice. Slopes and curvatures are exact, by dual numbers.

use super::evaluate::{Evaluator, Place};
use super::number::{Dual, Real};
use super::{Error, Oracle, State, Value};
use crate::ir::{FieldId, Response};

/// A second-order tensor.
pub type Gradient = [[f64; 3]; 3];

/// A direction and a value, component by component.
fn seeded<T: Real>(of: impl Fn(usize, usize) -> T) -> [[T; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|k| of(i, k)))
}

impl Oracle<'_> {
    /// Strain energy density of a node under the gradient `h` [J/m^3]; zero for a law without energy.
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn energy_under(&self, state: &State, node: usize, h: &Gradient) -> Result<f64, Error> {
        let evaluator = self.evaluator(state)?.strained(*h);
        self.density(&evaluator, node)
    }

    /// The stress under the gradient `h` along the increment `a`: `P(h) : a` [Pa]. That of an energy is its slope, that
    /// of bond forces half the sum of `f xi`.
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn stress(
        &self,
        state: &State,
        node: usize,
        h: &Gradient,
        a: &Gradient,
    ) -> Result<f64, Error> {
        let moved = |i: usize, k: usize| Dual::new(h[i][k], a[i][k]);
        let rest = state.u.iter().map(|u| u.map(Dual::constant)).collect();
        let evaluator = super::Evaluator::new(self, state, rest)?.strained(seeded(moved));
        let mut stress = self.density(&evaluator, node)?.slope;
        let evaluator = self.evaluator(state)?.strained(*h);
        for &b in &self.bonds_of[node] {
            let (force, bond) = (self.direct_bond_force(&evaluator, b)?, &self.body.bonds[b]);
            stress += 0.5 * bond.weight * contracted(force, bond.xi, a);
        }
        Ok(stress)
    }

    /// The stiffness under the gradient `h`: the slope of `P : a` along the increment `b` [Pa].
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn stiffness(
        &self,
        state: &State,
        node: usize,
        h: &Gradient,
        (a, b): (&Gradient, &Gradient),
    ) -> Result<f64, Error> {
        let mut stiffness = 0.0;
        if self.has_energy() {
            let moved = |i: usize, k: usize| {
                Dual::new(Dual::new(h[i][k], b[i][k]), Dual::new(a[i][k], 0.0))
            };
            let rest = state.u.iter().map(|u| u.map(Dual::constant)).collect();
            let evaluator = super::Evaluator::new(self, state, rest)?.strained(seeded(moved));
            stiffness += self.density(&evaluator, node)?.slope.slope;
        }
        let moved = |i: usize, k: usize| Dual::new(h[i][k], b[i][k]);
        let rest = state.u.iter().map(|u| u.map(Dual::constant)).collect();
        let evaluator = super::Evaluator::new(self, state, rest)?.strained(seeded(moved));
        for &k in &self.bonds_of[node] {
            let (force, bond) = (self.direct_bond_force(&evaluator, k)?, &self.body.bonds[k]);
            let slope = force.map(|f| f.slope);
            stiffness += 0.5 * bond.weight * contracted(slope, bond.xi, a);
        }
        Ok(stiffness)
    }

    /// Force on a node by the other end of one of its bonds under the gradient `h`, `T - T'` [N/m^6]. That of an energy
    /// is its slope by this bond alone.
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn bond_force_under(
        &self,
        state: &State,
        bond: usize,
        h: &Gradient,
    ) -> Result<[f64; 3], Error> {
        let evaluator = self.evaluator(state)?.strained(*h);
        let mut force = self.direct_bond_force(&evaluator, bond)?;
        if self.has_energy() {
            for (b, sign) in [(bond, 1.0), (self.reverse_of(bond)?, -1.0)] {
                for (a, f) in force.iter_mut().enumerate().take(self.dim()) {
                    let rest = state.u.iter().map(|u| u.map(Dual::constant)).collect();
                    let moved = |i: usize, k: usize| Dual::new(h[i][k], 0.0);
                    let mut evaluator =
                        super::Evaluator::new(self, state, rest)?.strained(seeded(moved));
                    evaluator.stretch_only(b, a);
                    let slope = self.density(&evaluator, self.body.bonds[b].from)?.slope;
                    *f += sign * slope / self.body.bonds[b].weight;
                }
            }
        }
        Ok(force)
    }

    /// Whether a bond breaks under the gradient `h`.
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn breaks_under(&self, state: &State, bond: usize, h: &Gradient) -> Result<bool, Error> {
        let evaluator = self.evaluator(state)?.strained(*h);
        for rule in &self.law.breaks {
            if evaluator.intact(rule.family, bond)
                && evaluator.at(rule.when, Place::Bond(bond))?.boolean()?
            {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Change of the force density that the law states for a node, `force f = ..`, as the body moves along `du`
    /// [N/m^3]; zero where it states none.
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn stated_force(
        &self,
        state: &State,
        node: usize,
        du: &[[f64; 3]],
    ) -> Result<[f64; 3], Error> {
        let moved =
            |(u, du): (&[f64; 3], &[f64; 3])| std::array::from_fn(|a| Dual::new(u[a], du[a]));
        let u = state.u.iter().zip(du).map(moved).collect();
        let evaluator = super::Evaluator::new(self, state, u)?;
        Ok(self.node_force(&evaluator, node)?.map(|f| f.slope))
    }

    /// The rate of a field at one node; `None` for a field without one.
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn rate(
        &self,
        state: &State,
        field: FieldId,
        node: usize,
    ) -> Result<Option<Value<f64>>, Error> {
        self.rate_of(&self.evaluator(state)?, field, node)
    }

    pub(super) fn rate_of<T: Real>(
        &self,
        evaluator: &Evaluator<T>,
        field: FieldId,
        node: usize,
    ) -> Result<Option<Value<T>>, Error> {
        for response in &self.law.responses {
            if let Response::Rate(id, expr) = response
                && *id == field
            {
                return Ok(Some(evaluator.at(*expr, Place::Node(node))?));
            }
        }
        Ok(None)
    }
}

/// `f xi : a`.
fn contracted(f: [f64; 3], xi: [f64; 3], a: &Gradient) -> f64 {
    let row = |i: usize| a[i][0] * xi[0] + a[i][1] * xi[1] + a[i][2] * xi[2];
    f[0] * row(0) + f[1] * row(1) + f[2] * row(2)
}
