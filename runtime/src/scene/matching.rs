//! `[[matching]]`: sides of a lattice that let waves out.

use super::document::{Data, Value};
use super::problem::Problem;
use super::section::{Section, listed, nearest};
use crate::matching::{MOST, Match, Matching, Rule, Side};
use crate::spec::Spec;

const RULES: [(&str, Rule); 2] = [
    ("trapezoidal", Rule::Trapezoidal),
    ("explicit", Rule::Explicit),
];

const WAVES: [(&str, Match); 3] = [
    ("both", Match::Both),
    ("own", Match::Own),
    ("longitudinal", Match::Longitudinal),
];

pub(super) fn read(section: Section<'_>, spec: &Spec) -> Option<Matching> {
    let sides = sides(&section, spec.dim);
    let sides = section.require("sides", sides, "[\"-x\", \"+x\"], or \"all\"");
    let order = order(&section);
    let layers = section.count("layers", 1);
    let rule = section.choice("rule", &RULES);
    let waves = section.choice("waves", &WAVES);
    let smooth = section.count("smooth", 0);
    let unstable = section.flag("unstable");
    let given = |key: &str, read: bool| section.value(key).is_none() || read;
    let whole = given("layers", layers.is_some())
        && given("rule", rule.is_some())
        && given("waves", waves.is_some())
        && given("smooth", smooth.is_some())
        && given("unstable", unstable.is_some());
    if spec.force.is_empty() {
        let problem = Problem::new(format!(
            "`{}` has no force, so that no wave of it can leave",
            spec.law
        ))
        .at(section.span.clone(), "")
        .help("matching boundaries are for laws that move: leave it out");
        section.reader.complain(problem);
    }
    section.finish();
    let (sides, order) = (sides?, order?);
    whole.then(|| Matching {
        sides,
        order,
        layers: layers.map(|l| l as usize),
        rule: rule.unwrap_or_default(),
        waves: waves.unwrap_or_default(),
        smooth: smooth.map(|planes| planes as usize),
        unstable: unstable.unwrap_or(false),
    })
}

fn order(section: &Section<'_>) -> Option<usize> {
    let Some(value) = section.value("order") else {
        return Some(1);
    };
    let order = section.count("order", 1)? as usize;
    if order <= MOST {
        return Some(order);
    }
    let problem = Problem::new(format!("`order` must be at most {MOST}"))
        .at(value.span.clone(), format!("expected 1 to {MOST}"))
        .help("1 is stable with nearly every law, higher orders with some");
    section.reader.complain(problem);
    None
}

pub(super) fn sides(section: &Section<'_>, dim: usize) -> Option<Vec<Side>> {
    let value = section.value("sides")?;
    match &value.data {
        Data::Text(word) if word == "all" => Some(Side::all(dim).collect()),
        Data::Text(_) => Some(vec![side(section, value, dim)?]),
        Data::List(list) if !list.is_empty() => {
            let read: Vec<_> = list.iter().map(|v| side(section, v, dim)).collect();
            read.into_iter().collect()
        }
        _ => section.reader.wrong_type(
            value,
            "a list of sides such as [\"-x\", \"+x\"], or \"all\"",
        ),
    }
}

fn side(section: &Section<'_>, value: &Value, dim: usize) -> Option<Side> {
    let names = &Side::NAMES[..2 * dim];
    let Data::Text(word) = &value.data else {
        return section
            .reader
            .wrong_type(value, "a side of the body such as \"-x\"");
    };
    if let Some(side) = Side::all(dim).find(|s| s.name() == word) {
        return Some(side);
    }
    let problem = Problem::new(format!("the body has no side \"{word}\""))
        .at(value.span.clone(), format!("expected {}", listed(names)));
    section.reader.complain(match nearest(word, names) {
        Some(near) => problem.help(format!("did you mean \"{near}\"?")),
        None => problem,
    });
    None
}
