//! Probes: values of a law that are known in closed form, on a few nodes or in a homogeneous deformation.
//!
//! Contract. A [`Probe`] is plain data: the resolver has evaluated every number of it. [`run`] asks the
//! [oracle](crate::oracle), which reads the law before anything is derived from it, and compares. What the
//! compiler makes of the law is compared with the oracle elsewhere.

mod body;
pub(crate) mod number;

pub(crate) use body::bonded;

use crate::check;
use crate::diag::Diagnostic;
use crate::ir::{DefId, FieldId, Flavour, InfluenceFn, Law, WeightId};
use crate::oracle::{Ball, Error, Oracle, Settings, State, Value};
use crate::span::Span;
use crate::units::Unit;

/// The longest horizon in spacings of a lattice, and the most nodes: the oracle is slow.
pub(crate) const MAX_REACH: f64 = 4.0;
pub(crate) const MAX_NODES: usize = 50;

/// Relative error of an expectation that states none.
pub const TOLERANCE: f64 = 1e-12;

/// A probe of a law. All values are in SI units.
#[derive(Clone, Debug)]
pub struct Probe {
    pub name: String,
    pub flavour: Flavour,
    /// One value per parameter of the law.
    pub params: Vec<f64>,
    /// One function per influence slot of the law, with the values of its parameters.
    pub influences: Vec<(InfluenceFn, Vec<f64>)>,
    pub horizon: f64,
    /// Thickness in 2D, cross-section in 1D, 1 in 3D.
    pub cross: f64,
    /// Names of the weights that are 1.
    pub without: Vec<String>,
    pub place: Place,
    pub expectations: Vec<Expectation>,
    pub span: Span,
}

/// Where a law is probed.
#[derive(Clone, Debug)]
pub enum Place {
    /// Nodes, and the pairs between which bonds are broken. Nodes closer than the horizon are bonded.
    Nodes(Vec<Node>, Vec<(usize, usize)>),
    /// A node of an unbounded lattice that is deformed by a constant gradient: u = H X.
    Lattice {
        spacing: f64,
        gradient: [[f64; 3]; 3],
        /// Fields that are not zero.
        fields: Vec<(FieldId, Vec<f64>)>,
    },
}

#[derive(Clone, Debug)]
pub struct Node {
    pub name: String,
    pub position: [f64; 3],
    pub volume: f64,
    pub u: [f64; 3],
    pub v: [f64; 3],
    /// Fields that are not zero.
    pub fields: Vec<(FieldId, Vec<f64>)>,
}

impl Node {
    /// At the origin, at rest, without a volume.
    pub(crate) fn named(name: &str) -> Node {
        Node {
            name: name.into(),
            position: [0.0; 3],
            volume: 0.0,
            u: [0.0; 3],
            v: [0.0; 3],
            fields: Vec::new(),
        }
    }
}

/// What is known of one quantity.
#[derive(Clone, Debug)]
pub struct Expectation {
    /// As written: `W(a)`.
    pub text: String,
    pub quantity: Quantity,
    /// The components, row by row.
    pub value: Vec<f64>,
    /// Unit of the quantity, without that of influence functions.
    pub unit: Unit,
    pub within: Within,
    pub span: Span,
}

/// A quantity that the oracle can be asked for. Nodes are numbers; the node of a lattice is number 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Quantity {
    Force(usize),
    Energy(usize),
    Rate(FieldId, usize),
    Constant(DefId),
    AtNode(DefId, usize),
    OnBond(DefId, usize, usize),
    Weight(WeightId, usize, usize),
}

/// How far a value may be off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Within {
    /// Of the largest component; of a force, also of the largest force of a bond.
    Relative(f64),
    /// In the unit of the quantity.
    Absolute(f64),
}

/// What became of one expectation.
#[derive(Clone, Debug)]
pub struct Outcome {
    pub probe: String,
    pub expectation: Expectation,
    /// The components, or why there are none.
    pub found: Result<Vec<f64>, Error>,
    /// The largest error that is allowed.
    pub allowed: f64,
}

impl Outcome {
    pub fn holds(&self) -> bool {
        let expected = &self.expectation.value;
        let near = |(a, b): (&f64, &f64)| a == b || (a - b).abs() <= self.allowed;
        match &self.found {
            Ok(found) => found.len() == expected.len() && found.iter().zip(expected).all(near),
            Err(_) => false,
        }
    }
}

/// Every expectation of every probe of a law, in the order of the text.
pub fn run(law: &Law) -> Vec<Outcome> {
    law.probes
        .iter()
        .flat_map(|probe| run_one(law, probe))
        .collect()
}

/// What the probes of a law find, as findings at their places; a warning for a law without any.
pub fn findings(law: &Law) -> Vec<Diagnostic> {
    if law.probes.is_empty() {
        return vec![check::unprobed::warning(&law.name, law.span)];
    }
    let outcomes = run(law);
    let wrong = outcomes.iter().filter(|outcome| !outcome.holds());
    wrong.map(check::probed::failed).collect()
}

fn run_one(law: &Law, probe: &Probe) -> Vec<Outcome> {
    let asked = |found: Result<(Vec<f64>, f64), Error>, expectation: &Expectation| {
        let (found, scale) = match found {
            Ok((found, scale)) => (Ok(found), scale),
            Err(error) => (Err(error), 0.0),
        };
        let largest = |values: &[f64]| values.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let allowed = match expectation.within {
            Within::Relative(part) => part * largest(&expectation.value).max(scale),
            Within::Absolute(error) => error,
        };
        Outcome {
            probe: probe.name.clone(),
            expectation: expectation.clone(),
            found,
            allowed,
        }
    };
    let (body, deform) = body::build(law, probe);
    let settings = Settings {
        flavour: probe.flavour,
        params: probe.params.clone(),
        influences: probe.influences.clone(),
        horizon: probe.horizon,
        ball: Ball::Integral { cross: probe.cross },
        without: probe.without.clone(),
    };
    let oracle = Oracle::new(law, &body, &settings);
    let ask = |expectation: &Expectation| {
        let found = match &oracle {
            Ok(oracle) => {
                let state = deform(oracle.state());
                placed(law, probe, oracle, &state)
                    .and_then(|()| ask(law, probe, oracle, &state, expectation))
            }
            Err(error) => Err(error.clone()),
        };
        asked(found, expectation)
    };
    probe.expectations.iter().map(ask).collect()
}

/// Whether fields are set only where they live.
fn placed(law: &Law, probe: &Probe, oracle: &Oracle, state: &State) -> Result<(), Error> {
    for (k, field) in law.fields.iter().enumerate() {
        let Some(lives) = &field.lives else { continue };
        let here = oracle.lives(state, FieldId(k as u32))?;
        let set = |v: &Value<f64>| flat(*v, probe.flavour.dim()).iter().any(|x| *x != 0.0);
        let values = state.fields[k].iter();
        if values.zip(here).any(|(v, here)| !here && set(v)) {
            let (name, text) = (&field.name, &lives.text);
            return Err(Error(format!(
                "`{name}` is set at a node where it does not live: it does where `{text}`"
            )));
        }
    }
    Ok(())
}

/// The components of a quantity, and the scale of its rounding errors.
fn ask(
    law: &Law,
    probe: &Probe,
    oracle: &Oracle,
    state: &State,
    expectation: &Expectation,
) -> Result<(Vec<f64>, f64), Error> {
    let dim = probe.flavour.dim();
    let named = |def: DefId| oracle.named_def(state, def);
    let exact = |value: Value<f64>| (flat(value, dim), 0.0);
    let missing = || Error("there is no such place".into());
    let at = |values: Vec<Value<f64>>, k: usize| {
        let value = values.get(k).copied().ok_or_else(missing)?;
        Ok(exact(value))
    };
    match expectation.quantity {
        Quantity::Force(k) => {
            let (force, scale) = oracle.force_on(state, k)?;
            Ok((force[..dim].to_vec(), scale))
        }
        Quantity::Energy(k) => Ok((vec![oracle.energy_of(state, k)?], 0.0)),
        Quantity::Constant(def) => at(named(def)?, 0),
        Quantity::AtNode(def, k) => at(named(def)?, k),
        Quantity::OnBond(def, from, to) => {
            let bond = oracle.bond(from, to).ok_or_else(missing)?;
            at(named(def)?, bond)
        }
        Quantity::Weight(weight, from, to) => {
            let bond = oracle.bond(from, to).ok_or_else(missing)?;
            Ok((vec![oracle.weight(weight, bond).ok_or_else(missing)?], 0.0))
        }
        Quantity::Rate(field, k) => {
            let rates = oracle.rates(state)?;
            let found = rates.into_iter().find(|(id, _)| *id == field);
            let name = &law.fields[field.index()].name;
            let (_, values) =
                found.ok_or_else(|| Error(format!("the law has no rate of `{name}`")))?;
            at(values, k)
        }
    }
}

/// The components of a value in `dim` dimensions, row by row.
fn flat(value: Value<f64>, dim: usize) -> Vec<f64> {
    match value {
        Value::Scalar(x) => vec![x],
        Value::Vector(v) => v[..dim].to_vec(),
        Value::Tensor(t) => t[..dim]
            .iter()
            .flat_map(|row| row[..dim].to_vec())
            .collect(),
        Value::Boolean(b) => vec![f64::from(u8::from(b))],
    }
}

#[cfg(test)]
mod tests;
