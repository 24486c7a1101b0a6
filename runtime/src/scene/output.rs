//! `[output]`: what a run writes, and when.

use super::document::{Data, Value};
use super::problem::Problem;
use super::section::{Placed, Section, listed, nearest};
use super::shape;
use crate::language::dimension::TIME;
use crate::observe::{Outputs, Picture, Schedule, View, split};
use crate::simulate::End;
use crate::spec::{FieldSpec, Spec};

const VIEWS: [(&str, View); 5] = [
    ("top", View::Top),
    ("bottom", View::Bottom),
    ("front", View::Front),
    ("side", View::Side),
    ("above", View::Above),
];

/// Rows that a history has when the scene does not say how often.
const ROWS: u64 = 200;

/// What is written, and whether a table of nodes is.
pub(super) fn read(section: Section<'_>, spec: &Spec, end: Option<End>) -> Option<(Outputs, bool)> {
    let fields = schedule(&section, "every", Schedule::Ends);
    let history = schedule(&section, "history", usual_history(end));
    let checkpoints = schedule(&section, "checkpoint", Schedule::Never);
    let quantities = quantities(&section, spec);
    let nodes = section.flag("nodes");
    let pictured = section.value("picture").is_some();
    let usual = if pictured {
        Schedule::Ends
    } else {
        Schedule::Never
    };
    let pictures = schedule(&section, "pictures", usual);
    let mut names = Vec::new();
    let mut views: Vec<_> = section
        .sections("picture")
        .into_iter()
        .map(|s| picture(s, spec, &mut names))
        .collect();
    if views.is_empty() && pictures.as_ref().is_some_and(|p| *p != Schedule::Never) {
        views.push(Some(usual_picture(spec)));
    }
    section.finish();
    let outputs = Outputs {
        history: history?,
        fields: fields?,
        quantities: quantities?,
        pictures: pictures?,
        views: views.into_iter().collect::<Option<_>>()?,
        checkpoints: checkpoints?,
    };
    Some((outputs, nodes.unwrap_or(false)))
}

fn usual_history(end: Option<End>) -> Schedule {
    match end {
        Some(End::Steps(n)) => Schedule::Steps((n / ROWS).max(1)),
        Some(End::Time(t)) => Schedule::Period(t / ROWS as f64),
        None => Schedule::Ends,
    }
}

/// The damage, or the first field of a law that cannot break.
fn usual_picture(spec: &Spec) -> Picture {
    let field = spec.fields.first().filter(|_| !spec.breaks);
    let quantity = field.map_or("damage", |f| &f.name);
    Picture {
        name: quantity.into(),
        quantity: quantity.into(),
        view: View::Top,
        range: None,
        width: 800,
        deformed: false,
        region: None,
    }
}

/// A number of steps, a period in time, a list of times, `"ends"` or `"never"`.
fn schedule(section: &Section<'_>, key: &str, usual: Schedule) -> Option<Schedule> {
    let Some(value) = section.value(key) else {
        return Some(usual);
    };
    match &value.data {
        Data::Text(word) if word == "never" => Some(Schedule::Never),
        Data::Text(word) if word == "ends" => Some(Schedule::Ends),
        Data::Number(0.0, _) => {
            let problem = Problem::new(format!("`{key} = 0` is not a number of steps"))
                .at(value.span.clone(), "every how many steps?")
                .help(format!(
                    "{key} = \"never\" writes nothing, {key} = \"ends\" the first and the last state, {key} = 1 every step"
                ));
            section.reader.complain(problem);
            None
        }
        Data::Number(_, true) => section.count(key, 1).map(Schedule::Steps),
        Data::List(list) => {
            let times = list.iter().map(|v| section.reader.quantity(v, TIME));
            times.collect::<Option<Vec<f64>>>().map(Schedule::Times)
        }
        Data::Text(_) => section.positive(key, TIME).map(|t| Schedule::Period(t.value)),
        _ => section.reader.wrong_type(
            value,
            "a whole number of steps, a period such as \"10 us\", a list of times, \"ends\" or \"never\"",
        ),
    }
}

/// What can be written for this law.
fn known(spec: &Spec) -> Vec<&str> {
    let mut names = match spec.force.is_empty() {
        false => vec!["displacement", "velocity", "force"],
        true => vec![],
    };
    names.extend(["damage", "position", "volume"]);
    if spec.energy.is_some() {
        names.push("energy");
    }
    names.extend(spec.fields.iter().map(|f| f.name.as_str()));
    names.extend(spec.named.iter().map(|(name, _)| name.as_str()));
    names
}

/// The motion, the damage of what can break, and the fields that change.
fn usual_quantities(spec: &Spec) -> Vec<String> {
    let mut names = match (spec.force.is_empty(), spec.breaks) {
        (false, _) => vec!["displacement", "velocity", "damage"],
        (true, true) => vec!["damage"],
        (true, false) => vec![],
    };
    let changes = |f: &&FieldSpec| spec.rates.iter().any(|r| f.slots.contains(&r.field));
    names.extend(spec.fields.iter().filter(changes).map(|f| f.name.as_str()));
    names.into_iter().map(String::from).collect()
}

fn quantities(section: &Section<'_>, spec: &Spec) -> Option<Vec<String>> {
    let Some(value) = section.value("fields") else {
        return Some(usual_quantities(spec));
    };
    let Data::List(list) = &value.data else {
        return section
            .reader
            .wrong_type(value, "a list of names such as [\"damage\"]");
    };
    let names: Vec<_> = list
        .iter()
        .map(|v| quantity(section, v, spec, false))
        .collect();
    names.into_iter().collect()
}

/// The name of something that can be written; pictures may ask for a component, `velocity.z` or `stress.xy`.
fn quantity(section: &Section<'_>, value: &Value, spec: &Spec, part: bool) -> Option<String> {
    let Data::Text(name) = &value.data else {
        return section.reader.wrong_type(value, "a name in quotes");
    };
    let known = known(spec);
    let whole = if part { split(name).0 } else { name };
    if known.contains(&whole) {
        return Some(name.clone());
    }
    let problem = Problem::new(format!("`{}` has no quantity `{name}`", spec.law))
        .at(value.span.clone(), format!("expected {}", listed(&known)));
    let energy = spec.energy.map(|slot| &spec.slots[slot as usize].name);
    section.reader.complain(match nearest(whole, &known) {
        _ if energy.is_some_and(|energy| energy == whole) => {
            problem.help("the energy density of a law is \"energy\", whatever the law calls it")
        }
        Some(near) => problem.help(format!("did you mean \"{near}\"?")),
        None => problem,
    });
    None
}

/// `[[output.picture]]`.
fn picture(section: Section<'_>, spec: &Spec, names: &mut Vec<Placed<String>>) -> Option<Picture> {
    let reader = section.reader;
    let place = section.span.clone();
    let usual = usual_picture(spec);
    let quantity = match section.value("of") {
        Some(value) => quantity(&section, value, spec, true),
        None => Some(usual.quantity),
    };
    let view = section.choice("view", &VIEWS);
    let range = range(&section);
    let width = section.count("width", 16);
    let deformed = section.flag("deformed");
    let given = section.text("name");
    let region = section
        .value("region")
        .map(|_| shape::read(&section, "region", spec.dim));
    section.finish();
    let quantity = quantity?;
    let name = match given {
        Some(given) => Placed {
            value: given.value.to_string(),
            span: given.span,
        },
        None => Placed {
            value: quantity.replace('.', "_"),
            span: place,
        },
    };
    if let Some(first) = names.iter().find(|other| other.value == name.value) {
        let shared = name.value;
        let problem = Problem::new(format!("two pictures are called `{shared}`"))
            .at(name.span, "this one would overwrite the other")
            .at(first.span.clone(), "the other one")
            .help(format!(
                "a picture without a name is called after its quantity: add name = \"{shared}-2\""
            ));
        reader.complain(problem);
        return None;
    }
    names.push(name.clone());
    Some(Picture {
        name: name.value,
        quantity,
        view: view.unwrap_or_default(),
        range: range?,
        width: width.map_or(usual.width, |w| w.min(8192) as u32),
        deformed: deformed.unwrap_or(false),
        region: match region {
            Some(shape) => Some(shape?),
            None => None,
        },
    })
}

/// `range = [0, 1]`, in SI units.
fn range(section: &Section<'_>) -> Option<Option<(f64, f64)>> {
    let Some(value) = section.value("range") else {
        return Some(None);
    };
    match &value.data {
        Data::List(list) => match list.as_slice() {
            [
                Value {
                    data: Data::Number(a, _),
                    ..
                },
                Value {
                    data: Data::Number(b, _),
                    ..
                },
            ] if a < b => Some(Some((*a, *b))),
            _ => section
                .reader
                .wrong_type(value, "two numbers, the smaller one first"),
        },
        _ => section
            .reader
            .wrong_type(value, "two numbers, the smaller one first"),
    }
}
