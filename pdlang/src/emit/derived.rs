//! What the compiler derives from a law, once more as formulas: the force state from the energy, and the tangent, in the names
//! of the law and for any number of dimensions.
//!
//! Contract. The formulas are expressions of the language. [`definitions`] writes them back as text, which the tests compare with
//! the force and the tangent that the compiler derives from the lowered law: two derivations that share nothing. A law with a
//! function whose slope is not known here has no formulas, nor has one whose formulas fill pages, and its page says so. Whatever
//! a law calls its own, the names of the formulas are others, and what it hides of the prelude is written out.

mod algebra;
mod changes;
mod factors;
mod read;
mod size;
mod slopes;
mod written;

use crate::ast::{Expr, Item, Model, ResponseKind};
use crate::front::Source;
use crate::ir::{BinaryOp, Home, Law, Shape};
use algebra::Sum;
use changes::Changes;
use read::Scope;
use slopes::Slopes;

/// The bonds of a sum: its word and its family.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Bonds {
    pub word: String,
    pub family: Option<String>,
}

impl Bonds {
    /// What tells names of these bonds from those of the intact bonds of the horizon.
    fn mark(&self) -> String {
        let family = self.family.as_ref().map(|family| format!("_{family}"));
        let word = if self.word == "sum" { "" } else { "_sum0" };
        family.unwrap_or_default() + word
    }
}

/// What a name of a derivation stands for.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Meaning {
    /// The slope of an energy by a quantity; by one of bonds, from those of a sum.
    Slope(String, String, Option<Bonds>),
    /// The change of a quantity.
    Change(String),
    /// A force state on the bonds of a sum.
    State(Bonds),
    /// A force of bonds, which their other ends do not add to.
    Pair(Bonds),
}

/// Why there are no formulas.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Missing {
    /// A slope is not known here.
    Slope,
    /// One of them is too long to be of use.
    Length,
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
    /// Changes of quantities, and that of the force density of a node.
    pub tangent: Result<(Vec<Formula>, Expr), Missing>,
    /// The name of the change of the relative displacement.
    pub small: String,
}

impl Derived {
    /// What the formulas say.
    pub(super) fn values(&self) -> impl Iterator<Item = &Expr> {
        let tangent = self.tangent.iter().flat_map(|(lines, _)| lines);
        self.force.iter().chain(tangent).map(|f| &f.value)
    }

    /// What the names of the formulas stand for.
    pub(super) fn meanings(&self) -> Vec<(String, Meaning, Shape)> {
        let change = Meaning::Change("eta".into());
        let eta = (self.small.clone(), change, Shape::Vector);
        let tangent = self.tangent.iter().flat_map(|(lines, _)| lines);
        let all = self.force.iter().chain(tangent);
        let all = all.map(|f| (f.name.clone(), f.meaning.clone(), f.shape));
        std::iter::once(eta).chain(all).collect()
    }
}

/// The force and the tangent of a law that has forces.
pub(super) fn of(law: &Law, model: &Model, source: &Source) -> Result<Derived, Missing> {
    let scope = &Scope::new(law, model, source);
    let forces = forces(scope, model).ok_or(Missing::Slope)?;
    let force = shown(forces.lines())?;
    let total = forces.total(str::to_string).ok_or(Missing::Slope)?;
    let tangent = forces.tangent(scope).ok_or(Missing::Slope);
    let tangent = tangent.and_then(|(lines, change)| Ok((shown(lines.iter())?, change)));
    Ok(Derived {
        force,
        total,
        tangent,
        small: scope.change("eta"),
    })
}

/// The forces of a law, bond by bond.
struct Forces {
    /// Slopes of the energy that have names.
    named: Vec<Line>,
    /// What acts on which bonds.
    last: Vec<(Bonds, Line)>,
}

fn forces(scope: &Scope, model: &Model) -> Option<Forces> {
    let mut named: Vec<Line> = vec![];
    let mut last: Vec<(Bonds, Line)> = vec![];
    let mut add = |meaning: Meaning, value: Sum| {
        let (Meaning::State(bonds) | Meaning::Pair(bonds)) = &meaning else {
            return None;
        };
        // The energy and the law itself may both give forces of the same bonds.
        match last.iter_mut().find(|(_, line)| line.meaning == meaning) {
            Some((_, line)) => line.value = line.value.plus(&value)?,
            None => last.push((bonds.clone(), forces_of(scope, &meaning, bonds, value))),
        }
        Some(())
    };
    for item in &model.items {
        let Item::Response(r) = item else { continue };
        let bonds = Bonds {
            word: "sum".into(),
            family: r.family.as_ref().map(|f| f.text.clone()),
        };
        match r.kind {
            ResponseKind::Energy => {
                let slopes = Slopes::of(scope, &r.name.text, &scope.read(&r.expr)?)?;
                named.extend(slopes.lines);
                for state in slopes.states {
                    let value = along(scope, &state.along)?.plus(&state.vector)?;
                    add(Meaning::State(state.bonds), value)?;
                }
            }
            ResponseKind::State => {
                let value = scope.read(&r.expr)?;
                let value = match value.shape() {
                    Shape::Vector => value,
                    _ => along(scope, &value)?,
                };
                add(Meaning::State(bonds), value)?;
            }
            ResponseKind::Pair => {
                let value = along(scope, &scope.read(&r.expr)?)?;
                add(Meaning::Pair(bonds), value)?;
            }
            // The force of a node is there already.
            ResponseKind::Force => return None,
            ResponseKind::Rate => {}
        }
    }
    Some(Forces { named, last })
}

impl Forces {
    /// The force density of a node, made of forces with these names.
    fn total(&self, called: impl Fn(&str) -> String) -> Option<Expr> {
        let all = self.last.iter().map(|(bonds, line)| {
            let t = written::name(&called(&line.name));
            let felt = match line.meaning {
                // A pair acts at both ends by their own sums.
                Meaning::Pair(_) => t,
                _ => binary(BinaryOp::Sub, t.clone(), written::prime(t)),
            };
            written::call(&bonds.word, bonds.family.as_deref(), vec![felt])
        });
        all.reduce(|a, b| binary(BinaryOp::Add, a, b))
    }

    fn lines(&self) -> impl Iterator<Item = &Line> {
        let last = self.last.iter().map(|(_, line)| line);
        self.named.iter().chain(last)
    }

    /// What a change of the displacements changes, and that of the force density of a node.
    fn tangent(&self, scope: &Scope) -> Option<(Vec<Line>, Expr)> {
        let last: Vec<Line> = self.last.iter().map(|(_, line)| line.clone()).collect();
        let change = self.total(|name| scope.change(name))?;
        let lines = Changes::of(&scope.with(&self.named), &self.named, &last)?;
        Some((lines, change))
    }
}

fn along(scope: &Scope, value: &Sum) -> Option<Sum> {
    value.times(&scope.bond("M")?)
}

fn forces_of(scope: &Scope, meaning: &Meaning, bonds: &Bonds, value: Sum) -> Line {
    let word = match meaning {
        Meaning::Pair(_) => "T_pair",
        _ => "T_state",
    };
    Line {
        name: scope.called(meaning, format!("{word}{}", bonds.mark())),
        meaning: meaning.clone(),
        home: Home::Bond,
        shape: Shape::Vector,
        value,
    }
}

use written::binary;

/// Formulas as they are shown, if all of them are short enough.
fn shown<'l>(lines: impl Iterator<Item = &'l Line>) -> Result<Vec<Formula>, Missing> {
    let one = |line: &Line| {
        let fits = size::factors(&line.value) <= size::MOST_FACTORS;
        fits.then(|| Formula {
            name: line.name.clone(),
            meaning: line.meaning.clone(),
            home: line.home,
            shape: line.shape,
            value: written::sum(&line.value),
        })
    };
    let all: Option<_> = lines.map(one).collect();
    all.ok_or(Missing::Length)
}

/// The direction of a change, as a field of displacements.
pub const DIRECTION: &str = "w_field";

/// The formulas as definitions of the language, and the force of a node that they make: instead of the responses of the law that
/// the text holds. With `tangent`, the force is its change for displacements that change by the field [`DIRECTION`].
///
/// `None` where the law has no formulas, or where its page has none because they are too long.
pub fn definitions(text: &str, tangent: bool) -> Option<Vec<String>> {
    let source = crate::front::source(text, "", &mut crate::files::nowhere);
    let (law, model) = (source.checked.laws.first()?, source.models.first()?);
    let derived = of(law, model, &source).ok()?;
    let (changes, change) = derived.tangent.clone().ok().unzip();
    let mut lines = vec![];
    let mut formulas: Vec<&Formula> = derived.force.iter().collect();
    if tangent {
        lines.push(format!("field {DIRECTION} : vector length \"direction\""));
        let small = &derived.small;
        lines.push(format!(
            "bond {small} : vector = {DIRECTION}' - {DIRECTION}"
        ));
        formulas.extend(changes.iter().flatten());
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
    let total = match tangent {
        true => &change?,
        false => &derived.total,
    };
    lines.push(format!(
        "force derived_force = {}",
        super::plain::expr(total)
    ));
    Some(lines)
}
