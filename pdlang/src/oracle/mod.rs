//! The oracle: what a law says, computed the slow and obvious way.
//!
//! Input: an [`ir::Law`] as it was checked, *before* anything is derived, and a small explicit body.
//! Output: forces, energies, tangents, rates, breaking bonds and next histories, straight from their
//! definitions. The force of an energy is `-(1/V_i) dU/du_i` of `U = sum_i V_i W_i` by dual numbers, the
//! tangent its second derivative, so nothing here can repeat a mistake of the compiler's derivation.
//! Cost: one evaluation of all bonds per node and direction. Made for bodies of up to a hundred nodes.
//!
//! Rules that the compiler shares: sums are weighted with `weight` (volume of the other end times its
//! partial-volume factor); division by an empty sum, and the inverse of an empty tensor sum, give zero,
//! so that a node without intact bonds answers nothing.

mod body;
mod evaluate;
mod influence;
mod number;
mod quadrature;
mod value;

pub use body::{Body, Bond, Node, State};
pub use number::{Dual, Real};
pub use quadrature::integrate;
pub use value::Value;

use crate::ir::{self, ExprId, ExprKind, FamilyId, FieldId, Response};
use evaluate::{Evaluator, Place};
use std::fmt;

/// Why the oracle could not answer: a law that the checks should have refused, or a body that does not fit it.
#[derive(Clone, Debug, PartialEq)]
pub struct Error(pub String);

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Error {}

/// What `ball(..)` means.
#[derive(Clone, Debug)]
pub enum Ball {
    /// The integral over the horizon; `cross` is the thickness [m] in 2D, the cross-section [m^2] in 1D, 1 in 3D.
    Integral { cross: f64 },
    /// The sum over a full lattice family: (bond vector [m], weight [m^3]).
    Lattice(Vec<([f64; 3], f64)>),
}

/// The choices of a scene that a law leaves open.
#[derive(Clone, Debug)]
pub struct Settings {
    pub flavour: ir::Flavour,
    /// SI values, one per parameter of the law.
    pub params: Vec<f64>,
    /// One function per influence slot of the law, with the values of its parameters.
    pub influences: Vec<(ir::InfluenceFn, Vec<f64>)>,
    /// Horizon [m].
    pub horizon: f64,
    pub ball: Ball,
}

/// A field and its time derivative per node.
pub type Rate = (FieldId, Vec<Value<f64>>);

/// A law on a body, ready to be asked.
pub struct Oracle<'a> {
    law: &'a ir::Law,
    body: &'a Body,
    settings: &'a Settings,
    /// Per bond of the body: the reverse bond.
    reverse: Vec<Option<usize>>,
    /// Per node: its bonds.
    bonds_of: Vec<Vec<usize>>,
    /// Per family and bond: whether the bond belongs to it.
    member: Vec<Vec<bool>>,
    /// Per influence slot and bond.
    omega: Vec<Vec<f64>>,
    /// Value of each `ball(..)`, by expression.
    balls: Vec<Option<f64>>,
    /// Whether an expression depends on a sum.
    sums: Vec<bool>,
}

impl<'a> Oracle<'a> {
    /// # Errors
    /// When the body or the settings do not fit the law, or a `ball` integral diverges.
    pub fn new(law: &'a ir::Law, body: &'a Body, settings: &'a Settings) -> Result<Self, Error> {
        if settings.params.len() != law.params.len()
            || settings.influences.len() != law.influences.len()
        {
            return Err(Error(
                "one value per parameter and influence function is needed".into(),
            ));
        }
        body.check()?;
        let mut oracle = Oracle {
            law,
            body,
            settings,
            reverse: body.reverses(),
            bonds_of: body.bonds_by_node(),
            member: Vec::new(),
            omega: Vec::new(),
            balls: vec![None; law.exprs.len()],
            sums: depends_on_sums(law),
        };
        oracle.omega = oracle.influence_values()?;
        oracle.member = vec![vec![true; body.bonds.len()]; law.families.len()];
        oracle.integrate_balls()?;
        oracle.filter_families()?;
        Ok(oracle)
    }

    /// The undeformed state: everything at rest, all bonds intact, fields zero, histories at their start.
    pub fn state(&self) -> State {
        State::rest(self.law, self.body)
    }

    /// Whether bond `bond` of the body belongs to family `family`.
    pub fn in_family(&self, family: FamilyId, bond: usize) -> bool {
        self.member[family.index()][bond]
    }

    /// Strain energy density of every node [J/m^3]; zero for a law without energy.
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn energy(&self, state: &State) -> Result<Vec<f64>, Error> {
        let evaluator = self.evaluator(state)?;
        self.energy_density(&evaluator)
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

    /// Largest sum of force magnitudes of one node's bonds, max_i sum_j |f_ij| w_ij [N/m^3]: what rounding
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
        Ok(self
            .bonds_of
            .iter()
            .map(|own| own.iter().map(size).sum())
            .fold(0.0, f64::max))
    }

    /// Time derivatives of the fields, per node.
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn rates(&self, state: &State) -> Result<Vec<Rate>, Error> {
        let evaluator = self.evaluator(state)?;
        let mut rates = Vec::new();
        for response in &self.law.responses {
            if let Response::Rate(field, expr) = response {
                rates.push((*field, self.per_node(&evaluator, *expr)?));
            }
        }
        Ok(rates)
    }

    /// Bonds that a `break when` condition ends in this state: (family, bond).
    /// Only the conditions tested before the force, or only those tested after it.
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn breaks(&self, state: &State, after: bool) -> Result<Vec<(FamilyId, usize)>, Error> {
        let evaluator = self.evaluator(state)?;
        let mut broken = Vec::new();
        for rule in self.law.breaks.iter().filter(|rule| rule.after == after) {
            for b in 0..self.body.bonds.len() {
                if evaluator.intact(rule.family, b)
                    && evaluator.at(rule.when, Place::Bond(b))?.boolean()?
                {
                    broken.push((rule.family, b));
                }
            }
        }
        Ok(broken)
    }

    /// The histories after this step is accepted, in the order of the law's list: per node or per bond.
    /// A history of a broken bond, or of a bond outside its family, keeps its value.
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn next_histories(&self, state: &State) -> Result<Vec<Vec<Value<f64>>>, Error> {
        let evaluator = self.evaluator(state)?;
        let mut next = state.histories.clone();
        for (history, values) in self.law.histories.iter().zip(&mut next) {
            for (k, value) in values.iter_mut().enumerate() {
                let place = match history.home {
                    ir::Home::Bond if !evaluator.intact(history.family, k) => continue,
                    ir::Home::Bond => Place::Bond(k),
                    _ => Place::Node(k),
                };
                *value = evaluator.at(history.update, place)?;
            }
        }
        Ok(next)
    }

    /// A definition of the law by its name: one value for a constant, one per node, or one per bond of the body.
    ///
    /// # Errors
    /// When there is no such definition, or the state does not fit the law.
    pub fn named(&self, state: &State, name: &str) -> Result<Vec<Value<f64>>, Error> {
        let def = self.law.defs.iter().find(|def| def.name == name);
        let def = def.ok_or_else(|| Error(format!("the law defines no `{name}`")))?;
        let evaluator = self.evaluator(state)?;
        match def.home {
            ir::Home::Constant => Ok(vec![evaluator.at(def.expr, Place::Nowhere)?]),
            ir::Home::Node => self.per_node(&evaluator, def.expr),
            ir::Home::Bond => {
                let bonds = 0..self.body.bonds.len();
                bonds
                    .map(|b| evaluator.at(def.expr, Place::Bond(b)))
                    .collect()
            }
        }
    }

    fn dim(&self) -> usize {
        self.settings.flavour.dim()
    }

    fn has_energy(&self) -> bool {
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

    fn evaluator<'o>(&'o self, state: &'o State) -> Result<Evaluator<'o, 'a, f64>, Error> {
        Evaluator::new(self, state, state.u.clone())
    }

    fn per_node(&self, evaluator: &Evaluator<f64>, expr: ExprId) -> Result<Vec<Value<f64>>, Error> {
        (0..self.body.nodes.len())
            .map(|i| evaluator.at(expr, Place::Node(i)))
            .collect()
    }

    fn energy_density<T: Real>(&self, evaluator: &Evaluator<T>) -> Result<Vec<T>, Error> {
        let mut density = vec![T::constant(0.0); self.body.nodes.len()];
        for response in &self.law.responses {
            if let Response::Energy(expr) = response {
                for (i, w) in density.iter_mut().enumerate() {
                    *w = *w + evaluator.at(*expr, Place::Node(i))?.scalar()?;
                }
            }
        }
        Ok(density)
    }

    /// sum_i V_i W_i / V_k, whose slope along u_k is minus the force density of node k.
    fn energy_over<T: Real>(&self, evaluator: &Evaluator<T>, k: usize) -> Result<T, Error> {
        let mut sum = T::constant(0.0);
        for (node, w) in self.body.nodes.iter().zip(self.energy_density(evaluator)?) {
            sum = sum + w * T::constant(node.volume / self.body.nodes[k].volume);
        }
        Ok(sum)
    }

    fn slope_of_energy(&self, state: &State, k: usize, a: usize) -> Result<f64, Error> {
        let seed =
            |i: usize, c: usize| Dual::new(state.u[i][c], if (i, c) == (k, a) { 1.0 } else { 0.0 });
        let evaluator = Evaluator::new(self, state, self.displacements(seed))?;
        Ok(self.energy_over(&evaluator, k)?.slope)
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
        Ok(self.energy_over(&evaluator, k)?.slope.slope)
    }

    /// T_ij: derivative of the total energy by the relative displacement of one directed bond, over V_i w_ij.
    fn slope_by_bond(&self, state: &State, b: usize) -> Result<[f64; 3], Error> {
        let Bond { from, weight, .. } = self.body.bonds[b];
        let mut slope = [0.0; 3];
        for (a, slope) in slope.iter_mut().enumerate().take(self.dim()) {
            let rest = |i: usize, c: usize| Dual::new(state.u[i][c], 0.0);
            let mut evaluator = Evaluator::new(self, state, self.displacements(rest))?;
            evaluator.stretch_only(b, a);
            *slope = self.energy_over(&evaluator, from)?.slope / weight;
        }
        Ok(slope)
    }

    /// Sum over the bonds of each node of the force densities that the law states outright.
    fn direct_force<T: Real>(&self, evaluator: &Evaluator<T>) -> Result<Vec<[T; 3]>, Error> {
        let mut force = vec![value::zero_vector(); self.body.nodes.len()];
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

    /// `pair` times M, and T - T' of every `state`, of one bond.
    fn direct_bond_force<T: Real>(
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
                    add(
                        self.force_state(evaluator, *expr, self.reverse_of(b)?)?,
                        -1.0,
                    );
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

    fn reverse_of(&self, b: usize) -> Result<usize, Error> {
        let Bond { from, to, .. } = self.body.bonds[b];
        self.reverse[b].ok_or_else(|| Error(format!("the bond {from} -> {to} has no reverse")))
    }

    fn influence_values(&self) -> Result<Vec<Vec<f64>>, Error> {
        let slots = 0..self.law.influences.len();
        let of = |slot| {
            self.body
                .bonds
                .iter()
                .map(move |bond| self.influence(slot, bond.length()))
        };
        slots.map(|slot| of(slot).collect()).collect()
    }

    fn influence(&self, slot: usize, r: f64) -> Result<f64, Error> {
        let (function, values) = &self.settings.influences[slot];
        influence::value(function, values, r, self.settings.horizon)
    }

    fn filter_families(&mut self) -> Result<(), Error> {
        let state = self.state();
        for (k, family) in self.law.families.iter().enumerate() {
            let Some(filter) = family.filter else {
                continue;
            };
            let evaluator = self.evaluator(&state)?;
            let bonds = 0..self.body.bonds.len();
            let member: Result<Vec<bool>, Error> = bonds
                .map(|b| evaluator.at(filter, Place::Bond(b))?.boolean())
                .collect();
            self.member[k] = member?;
        }
        Ok(())
    }

    fn integrate_balls(&mut self) -> Result<(), Error> {
        let state = self.state();
        for (k, expr) in self.law.exprs.iter().enumerate() {
            if let ExprKind::Ball(integrand) = expr.kind {
                self.balls[k] = Some(self.ball(&state, integrand)?);
            }
        }
        Ok(())
    }

    fn ball(&self, state: &State, integrand: ExprId) -> Result<f64, Error> {
        let evaluator = self.evaluator(state)?;
        let at = |xi| evaluator.at(integrand, Place::Reference(xi))?.scalar();
        match &self.settings.ball {
            Ball::Lattice(family) => {
                let mut sum = 0.0;
                for (xi, weight) in family {
                    sum += at(*xi)? * weight;
                }
                Ok(sum)
            }
            Ball::Integral { cross } => {
                let shell = |r: f64| match self.dim() {
                    1 => 2.0 * cross,
                    2 => std::f64::consts::TAU * r * cross,
                    _ => 2.0 * std::f64::consts::TAU * r * r,
                };
                integrate(
                    self.settings.horizon,
                    &|r| Ok(at([r, 0.0, 0.0])? * shell(r)),
                )
            }
        }
    }
}

/// Which expressions contain a sum, directly or through definitions.
fn depends_on_sums(law: &ir::Law) -> Vec<bool> {
    let mut of_def = vec![false; law.defs.len()];
    for (k, def) in law.defs.iter().enumerate() {
        of_def[k] = evaluate::contains_sum(law, def.expr, &of_def);
    }
    (0..law.exprs.len())
        .map(|k| evaluate::contains_sum(law, ExprId(k as u32), &of_def))
        .collect()
}

#[cfg(test)]
mod tests;
