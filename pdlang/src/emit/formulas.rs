//! The parts of a law's page that nobody wrote: its force and its tangent.

use super::derived::{Derived, Formula, Missing};
use super::latex::Notation;
use super::render::Part;
use crate::ast::{Item, Model, ResponseKind};

pub(super) fn parts(
    derived: Result<&Derived, &Missing>,
    model: &Model,
    notation: &Notation,
) -> Vec<Part> {
    let derived = match derived {
        Ok(derived) => derived,
        Err(why) => return without(why, model),
    };
    let energy = model
        .items
        .iter()
        .any(|item| matches!(item, Item::Response(r) if r.kind == ResponseKind::Energy));
    let words = match energy {
        true => {
            "Derived from the energy: nobody wrote it. A slope by a quantity of a bond is per volume of both of its ends; a node \
             feels what its bonds pull, less what they pull at their other ends."
        }
        false => "From the bond forces of the law.",
    };
    let mut parts = vec![heading("The force"), Part::Text(words.into())];
    parts.extend(derived.force.iter().map(|f| equation(f, notation)));
    let (force, change) = match notation.plain {
        true => ("force".to_string(), "d_force".to_string()),
        false => ("\\mathbf{f}".into(), "\\mathrm{d}\\mathbf{f}".into()),
    };
    let equation_of = |left: &str, right| {
        Part::Equation(String::new(), format!("{left} = {}", notation.expr(right)))
    };
    parts.push(equation_of(&force, &derived.total));
    parts.push(heading("The tangent"));
    let (changes, whole) = match &derived.tangent {
        Ok(tangent) => tangent,
        Err(why) => {
            parts.push(Part::Text(kept("it", *why)));
            return parts;
        }
    };
    let eta = notation.name("eta");
    let small = match notation.plain {
        true => derived.small.clone(),
        false => format!("\\mathrm{{d}}{eta}"),
    };
    parts.push(Part::Text(format!(
        "What a small change ${small}$ of the relative displacements changes, fields and what is remembered held fast."
    )));
    parts.extend(changes.iter().map(|f| equation(f, notation)));
    parts.push(equation_of(&change, whole));
    parts
}

/// A force that the law writes itself stands among its definitions; a law of fields has none.
fn without(why: &Missing, model: &Model) -> Vec<Part> {
    let given = |item: &Item| matches!(item, Item::Response(r) if r.kind == ResponseKind::Force);
    let rates = |item: &Item| matches!(item, Item::Response(r) if r.kind != ResponseKind::Rate);
    if model.items.iter().any(given) || !model.items.iter().any(rates) {
        return vec![];
    }
    let words = kept("both", *why);
    vec![heading("Force and tangent"), Part::Text(words)]
}

/// Why formulas of what the compiler derives are not shown.
fn kept(what: &str, why: Missing) -> String {
    let why = match why {
        Missing::Slope => "a function whose slope has no formula on this page",
        Missing::Length => "a length of pages",
    };
    format!(
        "The compiler derives {what}; {why} keeps the formulas from standing here. `pdlang emit --stage passes` shows what is computed."
    )
}

fn heading(words: &str) -> Part {
    Part::Heading(words.into())
}

fn equation(f: &Formula, notation: &Notation) -> Part {
    let formula = format!("{} = {}", notation.name(&f.name), notation.expr(&f.value));
    Part::Equation(String::new(), formula)
}
