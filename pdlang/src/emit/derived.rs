//! What the compiler derives from a law, once more as formulas: the force state from the energy, and the tangent, in the names
//! of the law and for any number of dimensions.
//!
//! Contract. The formulas are expressions of the language. [`definitions`] writes them back as text, which the tests compare with
//! the force and the tangent that the compiler derives from the lowered law: two derivations that share nothing. A law with a
//! function whose slope is not known here has no formulas, and its page says so.

mod algebra;
mod changes;
mod read;
mod slopes;
mod written;

use crate::ast::{Expr, Item, Model, ResponseKind};
use crate::front::Source;
use crate::ir::{BinaryOp, Home, Law, Shape};
use algebra::Sum;
use changes::Changes;
use read::Scope;
use slopes::{Bonds, Slopes};

/// What a name of a derivation stands for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Meaning {
    /// The slope of an energy by a quantity.
    Slope(String, String),
    /// The change of a quantity.
    Change(String),
    /// A force state, of a family.
    State(Option<String>),
}

/// A formula with a name.
#[derive(Clone, Debug)]
struct Line {
    meaning: Meaning,
    name: String,
    home: Home,
    shape: Shape,
    value: Sum,
}

/// A formula as it is shown.
#[derive(Clone, Debug)]
pub(super) struct Formula {
    pub name: String,
    pub meaning: Meaning,
    pub home: Home,
    pub shape: Shape,
    pub value: Expr,
}

/// The formulas of a law.
pub(super) struct Derived {
    /// Slopes of the energy, then force states; empty where the law gives its forces itself.
    pub force: Vec<Formula>,
    /// The force density of a node.
    pub total: Expr,
    pub tangent: Vec<Formula>,
    /// The change of the force density of a node.
    pub change: Expr,
}

impl Derived {
    /// What the names of the formulas stand for.
    pub(super) fn meanings(&self) -> Vec<(String, Meaning, Shape)> {
        let eta = ("d_eta".into(), Meaning::Change("eta".into()), Shape::Vector);
        let all = self.force.iter().chain(&self.tangent);
        let all = all.map(|f| (f.name.clone(), f.meaning.clone(), f.shape));
        std::iter::once(eta).chain(all).collect()
    }
}

/// The force and the tangent of a law that has forces. `None` where it has none, or a slope is not known here.
pub(super) fn of(law: &Law, model: &Model, source: &Source) -> Option<Derived> {
    let scope = Scope::new(law, model, source);
    let mut named: Vec<Line> = vec![];
    let mut states: Vec<(Bonds, Line)> = vec![];
    // Pairs act at both ends by their own sum.
    let mut pairs: Vec<(Bonds, Line)> = vec![];
    for item in &model.items {
        let Item::Response(r) = item else { continue };
        let value = scope.read(&r.expr)?;
        let bonds = Bonds {
            word: "sum".into(),
            family: r.family.as_ref().map(|f| f.text.clone()),
        };
        let along = |value: Sum| value.times(&scope.bond("M", Shape::Vector));
        let line = |value| Line {
            meaning: Meaning::State(bonds.family.clone()),
            name: String::new(),
            home: Home::Bond,
            shape: Shape::Vector,
            value,
        };
        match r.kind {
            ResponseKind::Energy => {
                let slopes = Slopes::of(&scope, &r.name.text, &value)?;
                named.extend(slopes.lines);
                for state in slopes.states {
                    let value = along(state.along)?.plus(&state.vector)?;
                    let meaning = Meaning::State(state.bonds.family.clone());
                    states.push((
                        state.bonds,
                        Line {
                            meaning,
                            ..line(value)
                        },
                    ));
                }
            }
            ResponseKind::State if value.shape() == Shape::Vector => {
                states.push((bonds.clone(), line(value)));
            }
            ResponseKind::State => states.push((bonds.clone(), line(along(value)?))),
            ResponseKind::Pair => pairs.push((bonds.clone(), line(along(value)?))),
            // The force of a node is there already.
            ResponseKind::Force => return None,
            ResponseKind::Rate => {}
        }
    }
    if states.is_empty() && pairs.is_empty() {
        return None;
    }
    let several = states.len() + pairs.len() > 1;
    for (k, (bonds, line)) in states.iter_mut().chain(&mut pairs).enumerate() {
        line.name = match &bonds.family {
            Some(family) => format!("T_state_{family}"),
            None if several && k > 0 => format!("T_state_{}", bonds.word),
            None => "T_state".into(),
        };
    }
    let total = |prefix: &str| {
        let both = states.iter().map(|(bonds, line)| {
            let t = written::name(&format!("{prefix}{}", line.name));
            let difference = binary(BinaryOp::Sub, t.clone(), written::prime(t));
            written::call(&bonds.word, bonds.family.as_deref(), vec![difference])
        });
        let one = pairs.iter().map(|(bonds, line)| {
            let t = written::name(&format!("{prefix}{}", line.name));
            written::call(&bonds.word, bonds.family.as_deref(), vec![t])
        });
        let all = both.chain(one);
        all.reduce(|a, b| binary(BinaryOp::Add, a, b))
    };
    let last: Vec<Line> = states
        .iter()
        .chain(&pairs)
        .map(|(_, line)| line.clone())
        .collect();
    let tangent = Changes::of(&scope, &named, &last)?;
    named.extend(last.iter().cloned());
    Some(Derived {
        total: total("")?,
        change: total("d_")?,
        force: named.iter().map(shown).collect(),
        tangent: tangent.iter().map(shown).collect(),
    })
}

use written::binary;

fn shown(line: &Line) -> Formula {
    Formula {
        name: line.name.clone(),
        meaning: line.meaning.clone(),
        home: line.home,
        shape: line.shape,
        value: written::sum(&line.value),
    }
}

/// The direction of a change, as a field of displacements.
pub const DIRECTION: &str = "w_field";

/// The formulas as definitions of the language, and the force of a node that they make: instead of the responses of the law that
/// the text holds. With `tangent`, the force is its change for displacements that change by the field [`DIRECTION`].
///
/// `None` where the law has no formulas.
pub fn definitions(text: &str, tangent: bool) -> Option<Vec<String>> {
    let source = crate::front::source(text, "", &mut crate::files::nowhere);
    let (law, model) = (source.checked.laws.first()?, source.models.first()?);
    let derived = of(law, model, &source)?;
    let mut lines = vec![];
    let mut formulas: Vec<&Formula> = derived.force.iter().collect();
    if tangent {
        lines.push(format!("field {DIRECTION} : vector length \"direction\""));
        lines.push(format!("bond d_eta : vector = {DIRECTION}' - {DIRECTION}"));
        formulas.extend(&derived.tangent);
    }
    for f in formulas {
        let home = if f.home == Home::Bond { "bond" } else { "node" };
        let shape = match f.shape {
            Shape::Vector => " : vector",
            Shape::Tensor | Shape::Symmetric => " : tensor",
            _ => "",
        };
        lines.push(format!(
            "{home} {}{shape} = {}",
            f.name,
            super::plain::expr(&f.value)
        ));
    }
    let total = if tangent {
        &derived.change
    } else {
        &derived.total
    };
    lines.push(format!(
        "force derived_force = {}",
        super::plain::expr(total)
    ));
    Some(lines)
}
