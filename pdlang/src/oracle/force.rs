//! Energy, force and tangent.

use super::evaluate::{Evaluator, Place};
use super::number::{Dual, Real};
use super::value::{self, Value};
use super::{Bond, Error, Oracle, State};
use crate::ir::{ExprId, Response};

impl Oracle<'_> {
    /// Strain energy density of every node [J/m^3]; zero for a law without energy.
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn energy(&self, state: &State) -> Result<Vec<f64>, Error> {
        let evaluator = self.evaluator(state)?;
        (0..self.body.nodes.len())
            .map(|i| self.density(&evaluator, i))
            .collect()
    }

    /// Force density of every node [N/m^3].
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn force(&self, state: &State) -> Result<Vec<[f64; 3]>, Error> {
        let mut force = self.direct_force(&self.evaluator(state)?)?;
        if self.has_energy() {
            for (k, f) in force.iter_mut().enumerate() {
                for (a, f) in f.iter_mut().enumerate().take(self.dim()) {
                    *f -= self.slope_of_energy(state, k, a)?;
                }
            }
        }
        Ok(force)
    }

    /// Strain energy density of one node [J/m^3].
    pub(crate) fn energy_of(&self, state: &State, k: usize) -> Result<f64, Error> {
        self.density(&self.evaluator(state)?, k)
    }

    /// Force density of one node [N/m^3], and the sum of the magnitudes of its own and its bonds' forces.
    pub(crate) fn force_on(&self, state: &State, k: usize) -> Result<([f64; 3], f64), Error> {
        let evaluator = self.evaluator(state)?;
        let mut force = self.node_force(&evaluator, k)?;
        let length = |v: [f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
        let mut scale = length(force);
        for &b in &self.bonds_of[k] {
            let weight = self.body.bonds[b].weight;
            let direct = self.direct_bond_force(&evaluator, b)?;
            let mut whole = direct;
            if self.has_energy() {
                let (own, back) = (
                    self.slope_by_bond(state, b)?,
                    self.slope_by_bond(state, self.reverse_of(b)?)?,
                );
                whole = std::array::from_fn(|a| direct[a] + own[a] - back[a]);
            }
            force = std::array::from_fn(|a| force[a] + direct[a] * weight);
            scale += length(whole) * weight;
        }
        if self.has_energy() {
            for (a, f) in force.iter_mut().enumerate().take(self.dim()) {
                *f -= self.slope_of_energy(state, k, a)?;
            }
        }
        Ok((force, scale))
    }

    /// Derivative of the force density along the displacement increment `du` [N/m^3].
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn tangent(&self, state: &State, du: &[[f64; 3]]) -> Result<Vec<[f64; 3]>, Error> {
        let moved = |i: usize, a: usize| Dual::new(state.u[i][a], du[i][a]);
        let evaluator = Evaluator::new(self, state, self.displacements(moved))?;
        let direct = self.direct_force(&evaluator)?;
        let mut tangent: Vec<[f64; 3]> = direct.iter().map(|f| f.map(|c| c.slope)).collect();
        if self.has_energy() {
            for (k, t) in tangent.iter_mut().enumerate() {
                for (a, t) in t.iter_mut().enumerate().take(self.dim()) {
                    *t -= self.curvature_of_energy(state, du, k, a)?;
                }
            }
        }
        Ok(tangent)
    }

    /// Force on node `from` by node `to`, per directed bond of the body: T_ij - T_ji [N/m^6]; zero where the
    /// bond is broken in every family that bears force. For an energy, T is its derivative by the bond alone.
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn bond_forces(&self, state: &State) -> Result<Vec<[f64; 3]>, Error> {
        let mut half = vec![[0.0; 3]; self.body.bonds.len()];
        if self.has_energy() {
            for (b, t) in half.iter_mut().enumerate() {
                *t = self.slope_by_bond(state, b)?;
            }
        }
        let evaluator = self.evaluator(state)?;
        let mut forces = vec![[0.0; 3]; self.body.bonds.len()];
        for (b, f) in forces.iter_mut().enumerate() {
            let back = self.reverse[b].map_or([0.0; 3], |r| half[r]);
            let direct = self.direct_bond_force(&evaluator, b)?;
            *f = std::array::from_fn(|a| half[b][a] - back[a] + direct[a]);
        }
        Ok(forces)
    }

    /// Largest sum of force magnitudes of one node's bonds and its own, max_i sum_j |f_ij| w_ij [N/m^3]: what rounding
    /// errors of a force are measured against.
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn force_scale(&self, state: &State) -> Result<f64, Error> {
        let forces = self.bond_forces(state)?;
        let size = |b: &usize| {
            let norm: f64 = forces[*b].iter().map(|c| c * c).sum();
            norm.sqrt() * self.body.bonds[*b].weight
        };
        let evaluator = self.evaluator(state)?;
        let mut largest = 0.0_f64;
        for (k, own) in self.bonds_of.iter().enumerate() {
            let alone = self.node_force(&evaluator, k)?;
            let alone = alone.iter().map(|c| c * c).sum::<f64>().sqrt();
            largest = largest.max(alone + own.iter().map(size).sum::<f64>());
        }
        Ok(largest)
    }

    pub(super) fn has_energy(&self) -> bool {
        self.law
            .responses
            .iter()
            .any(|r| matches!(r, Response::Energy(_)))
    }

    fn displacements<T>(&self, of: impl Fn(usize, usize) -> T) -> Vec<[T; 3]> {
        (0..self.body.nodes.len())
            .map(|i| std::array::from_fn(|a| of(i, a)))
            .collect()
    }

    pub(super) fn density<T: Real>(&self, evaluator: &Evaluator<T>, i: usize) -> Result<T, Error> {
        let mut density = T::constant(0.0);
        for response in &self.law.responses {
            if let Response::Energy(expr) = response {
                density = density + evaluator.at(*expr, Place::Node(i))?.scalar()?;
            }
        }
        Ok(density)
    }

    /// sum_i V_i W_i / V_k over the nodes that count; minus its slope along u_k is the force density of node k.
    fn energy_over<T: Real>(
        &self,
        evaluator: &Evaluator<T>,
        k: usize,
        counts: impl Fn(usize) -> bool,
    ) -> Result<T, Error> {
        let mut sum = T::constant(0.0);
        for (i, node) in self.body.nodes.iter().enumerate() {
            if counts(i) {
                let share = T::constant(node.volume / self.body.nodes[k].volume);
                sum = sum + self.density(evaluator, i)? * share;
            }
        }
        Ok(sum)
    }

    fn slope_of_energy(&self, state: &State, k: usize, a: usize) -> Result<f64, Error> {
        let seed =
            |i: usize, c: usize| Dual::new(state.u[i][c], if (i, c) == (k, a) { 1.0 } else { 0.0 });
        let evaluator = Evaluator::new(self, state, self.displacements(seed))?;
        Ok(self
            .energy_over(&evaluator, k, |i| self.reaches_to(k, i))?
            .slope)
    }

    fn curvature_of_energy(
        &self,
        state: &State,
        du: &[[f64; 3]],
        k: usize,
        a: usize,
    ) -> Result<f64, Error> {
        let seed = |i: usize, c: usize| {
            let unit = if (i, c) == (k, a) { 1.0 } else { 0.0 };
            Dual::new(Dual::new(state.u[i][c], du[i][c]), Dual::new(unit, 0.0))
        };
        let evaluator = Evaluator::new(self, state, self.displacements(seed))?;
        Ok(self
            .energy_over(&evaluator, k, |i| self.reaches_to(k, i))?
            .slope
            .slope)
    }

    /// T_ij: derivative of the total energy by the relative displacement of one directed bond, over V_i w_ij.
    fn slope_by_bond(&self, state: &State, b: usize) -> Result<[f64; 3], Error> {
        let Bond {
            from, to, weight, ..
        } = self.body.bonds[b];
        let counts = |i: usize| i == from || i == to || self.second_ring;
        let mut slope = [0.0; 3];
        for (a, slope) in slope.iter_mut().enumerate().take(self.dim()) {
            let rest = |i: usize, c: usize| Dual::new(state.u[i][c], 0.0);
            let mut evaluator = Evaluator::new(self, state, self.displacements(rest))?;
            evaluator.stretch_only(b, a);
            *slope = self.energy_over(&evaluator, from, counts)?.slope / weight;
        }
        Ok(slope)
    }

    /// The force densities that the law states outright: of nodes, and the sum over the bonds of each node.
    fn direct_force<T: Real>(&self, evaluator: &Evaluator<T>) -> Result<Vec<[T; 3]>, Error> {
        let mut force = vec![value::zero_vector(); self.body.nodes.len()];
        for (k, f) in force.iter_mut().enumerate() {
            *f = self.node_force(evaluator, k)?;
        }
        for (b, bond) in self.body.bonds.iter().enumerate() {
            let (f, weight) = (
                self.direct_bond_force(evaluator, b)?,
                T::constant(bond.weight),
            );
            let own: &mut [T; 3] = &mut force[bond.from];
            *own = std::array::from_fn(|a| own[a] + f[a] * weight);
        }
        Ok(force)
    }

    pub(super) fn node_force<T: Real>(
        &self,
        evaluator: &Evaluator<T>,
        k: usize,
    ) -> Result<[T; 3], Error> {
        for response in &self.law.responses {
            if let Response::Force(expr) = response {
                return evaluator.at(*expr, Place::Node(k))?.vector();
            }
        }
        Ok(value::zero_vector())
    }

    /// `pair` times M, and T - T' of every `state`, of one bond.
    pub(super) fn direct_bond_force<T: Real>(
        &self,
        evaluator: &Evaluator<T>,
        b: usize,
    ) -> Result<[T; 3], Error> {
        let mut force = value::zero_vector();
        let mut add = |f: [T; 3], sign: f64| {
            force = std::array::from_fn(|a| force[a] + f[a] * T::constant(sign));
        };
        for response in &self.law.responses {
            match response {
                Response::Pair(family, expr) if evaluator.intact(*family, b) => {
                    add(self.force_state(evaluator, *expr, b)?, 1.0);
                }
                Response::State(family, expr) if evaluator.intact(*family, b) => {
                    add(self.force_state(evaluator, *expr, b)?, 1.0);
                    let back = self.force_state(evaluator, *expr, self.reverse_of(b)?)?;
                    add(back.map(|t| evaluator.there(b, t)), -1.0);
                }
                _ => {}
            }
        }
        Ok(force)
    }

    /// A force state as a vector: a scalar acts along the deformed bond.
    fn force_state<T: Real>(
        &self,
        evaluator: &Evaluator<T>,
        expr: ExprId,
        b: usize,
    ) -> Result<[T; 3], Error> {
        match evaluator.at(expr, Place::Bond(b))? {
            Value::Vector(t) => Ok(t),
            t => evaluator.direction(b)?.scaled(t.scalar()?).vector(),
        }
    }
}
