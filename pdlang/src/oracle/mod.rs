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
mod force;
mod influence;
mod number;
mod quadrature;
mod uniform;
mod value;
mod waves;

pub use body::{Body, Bond, Node, State};
pub use number::{Complex, Dual, Real};
pub use quadrature::integrate;
pub use value::Value;

use crate::ir::{self, ExprId, ExprKind, FamilyId, FieldId, Response};
use evaluate::{Evaluator, Place};
use std::fmt;

/// Operations of an expression that are more work than remembering it.
const LONG: usize = 16;

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
    /// Names of the weights that are 1 instead of computed.
    pub without: Vec<String>,
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
    /// Whether it is remembered wherever it is read.
    shared: Vec<bool>,
    /// Whether it is made of sums that only breaking bonds change.
    shapes: Vec<bool>,
    /// Whether a sum is read at the other end of a bond.
    second_ring: bool,
    /// Per weight and bond.
    weights: Vec<Vec<f64>>,
    /// Per node: the nodes whose energy its displacement can change, where the law looks no further than to them.
    reaches: Vec<Vec<usize>>,
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
        let order = in_order(law);
        let mut oracle = Oracle {
            law,
            body,
            settings,
            reverse: body.reverses(),
            bonds_of: body.bonds_by_node(),
            member: Vec::new(),
            omega: Vec::new(),
            balls: vec![None; law.exprs.len()],
            sums: depends_on(law, &order, |kind| matches!(kind, ExprKind::Reduce(..))),
            shared: shared(&order),
            shapes: Vec::new(),
            second_ring: false,
            weights: Vec::new(),
            reaches: Vec::new(),
        };
        let moves = depends_on(law, &order, |kind| matches!(kind, ExprKind::Eta));
        oracle.second_ring = law.exprs.iter().any(|expr| match expr.kind {
            ExprKind::Prime(a) => oracle.sums[a.index()] && moves[a.index()],
            _ => false,
        });
        let changes = depends_on(law, &order, |kind| {
            use ExprKind::{Eta, Field, History, TimeStep, Velocity};
            matches!(kind, Eta | Field(_) | History(_) | TimeStep | Velocity)
        });
        let steady = oracle.sums.iter().zip(&changes);
        oracle.shapes = steady.map(|(sums, changes)| *sums && !changes).collect();
        oracle.reaches = oracle.reaches();
        oracle.omega = oracle.influence_values()?;
        oracle.member = vec![vec![true; body.bonds.len()]; law.families.len()];
        oracle.integrate_balls()?;
        oracle.filter_families()?;
        oracle.weigh()?;
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

    /// Value of influence function `slot` of the law at bond length `r` [m].
    ///
    /// # Errors
    /// When the function reads more than the bond length.
    pub fn influence(&self, slot: usize, r: f64) -> Result<f64, Error> {
        let (function, values) = &self.settings.influences[slot];
        influence::value(function, values, r, self.settings.horizon)
    }

    /// Per node, whether it belongs to the part of the body that a field lives on. Elsewhere the field is zero,
    /// whatever the state says.
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn lives(&self, state: &State, field: FieldId) -> Result<Vec<bool>, Error> {
        let evaluator = self.evaluator(state)?;
        (0..self.body.nodes.len())
            .map(|node| evaluator.lives(field, node))
            .collect()
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
                let mut values = self.per_node(&evaluator, *expr)?;
                for (node, value) in values.iter_mut().enumerate() {
                    if !evaluator.lives(*field, node)? {
                        *value = value.map(|_| 0.0);
                    }
                }
                rates.push((*field, values));
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

    /// The velocities after this step is accepted, per node; a node without intact bonds keeps its own.
    ///
    /// # Errors
    /// When the state does not fit the law.
    pub fn next_velocities(&self, state: &State) -> Result<Vec<[f64; 3]>, Error> {
        let evaluator = self.evaluator(state)?;
        let mut next = state.v.clone();
        for (k, v) in next.iter_mut().enumerate() {
            let bonded = |b: &usize| evaluator.intact(FamilyId(0), *b);
            if let Some(rule) = self.law.after_step
                && self.bonds_of[k].iter().any(bonded)
            {
                *v = evaluator.at(rule, Place::Node(k))?.vector()?;
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
        self.values(state, def)
    }

    /// As [`Oracle::named`], by number.
    pub(crate) fn named_def(&self, state: &State, id: ir::DefId) -> Result<Vec<Value<f64>>, Error> {
        self.values(state, &self.law.defs[id.index()])
    }

    /// A weight on a bond of the body.
    pub(crate) fn weight(&self, id: ir::WeightId, bond: usize) -> Option<f64> {
        self.weights[id.index()].get(bond).copied()
    }

    /// The bond between two nodes, where there is one.
    pub(crate) fn bond(&self, from: usize, to: usize) -> Option<usize> {
        let bonds = &self.body.bonds;
        bonds.iter().position(|b| b.from == from && b.to == to)
    }

    fn values(&self, state: &State, def: &ir::Def) -> Result<Vec<Value<f64>>, Error> {
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

    fn evaluator<'o>(&'o self, state: &'o State) -> Result<Evaluator<'o, 'a, f64>, Error> {
        Evaluator::new(self, state, state.u.clone())
    }

    fn per_node(&self, evaluator: &Evaluator<f64>, expr: ExprId) -> Result<Vec<Value<f64>>, Error> {
        (0..self.body.nodes.len())
            .map(|i| evaluator.at(expr, Place::Node(i)))
            .collect()
    }

    /// The node itself and its neighbours.
    fn reaches(&self) -> Vec<Vec<usize>> {
        let nodes = 0..self.body.nodes.len();
        let mut reaches: Vec<Vec<usize>> = nodes.map(|k| vec![k]).collect();
        for bond in &self.body.bonds {
            reaches[bond.from].push(bond.to);
            reaches[bond.to].push(bond.from);
        }
        for reached in &mut reaches {
            reached.sort_unstable();
            reached.dedup();
        }
        reaches
    }

    /// Whether the displacement of node `k` can change the energy of node `i`: everyone's, where the law looks
    /// beyond neighbours.
    fn reaches_to(&self, k: usize, i: usize) -> bool {
        self.second_ring || self.reaches[k].binary_search(&i).is_ok()
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

    /// Weights of the undamaged body, each after those that it reads.
    fn weigh(&mut self) -> Result<(), Error> {
        let state = self.state();
        for weight in &self.law.weights {
            let bonds = 0..self.body.bonds.len();
            let values = match self.settings.without.contains(&weight.name) {
                true => vec![1.0; bonds.len()],
                false => {
                    let evaluator = self.evaluator(&state)?;
                    let value = |b| evaluator.at(weight.expr, Place::Bond(b))?.scalar();
                    bonds.map(value).collect::<Result<_, _>>()?
                }
            };
            self.weights.push(values);
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

/// All expressions, each behind what it is formed from, and that. Depth first, with an explicit stack.
fn in_order(law: &ir::Law) -> Vec<(ExprId, Vec<ExprId>)> {
    let mut seen = vec![false; law.exprs.len()];
    let mut order = Vec::with_capacity(law.exprs.len());
    for root in 0..law.exprs.len() {
        let mut open = vec![(ExprId(root as u32), None)];
        while let Some((id, parts)) = open.pop() {
            match parts {
                Some(parts) => order.push((id, parts)),
                None if seen[id.index()] => {}
                None => {
                    seen[id.index()] = true;
                    let parts = law.behind(id);
                    let below = parts.clone();
                    open.push((id, Some(parts)));
                    open.extend(below.into_iter().map(|part| (part, None)));
                }
            }
        }
    }
    order
}

/// Which expressions contain what is asked for, directly or through definitions.
fn depends_on(
    law: &ir::Law,
    order: &[(ExprId, Vec<ExprId>)],
    asked: fn(&ExprKind) -> bool,
) -> Vec<bool> {
    let mut found = vec![false; law.exprs.len()];
    for (id, parts) in order {
        let k = id.index();
        found[k] = asked(&law.exprs[k].kind) || parts.iter().any(|a| found[a.index()]);
    }
    found
}

/// Which expressions are remembered wherever they are read: those with several readers that are long to form. What a
/// law doubles again and again would else be formed as often as it has leaves.
fn shared(order: &[(ExprId, Vec<ExprId>)]) -> Vec<bool> {
    let mut readers = vec![0_usize; order.len()];
    for part in order.iter().flat_map(|(_, parts)| parts) {
        readers[part.index()] += 1;
    }
    let mut operations = vec![0_usize; order.len()];
    let mut shared = vec![false; order.len()];
    for (id, parts) in order {
        let k = id.index();
        operations[k] = 1 + parts.iter().map(|a| operations[a.index()]).sum::<usize>();
        shared[k] = readers[k] > 1 && operations[k] > LONG;
        if shared[k] {
            operations[k] = 1;
        }
    }
    shared
}

#[cfg(test)]
mod tests;
