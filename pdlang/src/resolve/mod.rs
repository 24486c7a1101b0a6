//! [`ast`](crate::ast) -> [`ir`](crate::ir): names become ids, and every rule of the language is checked on the way.
//!
//! The journey of a model: `declare` (its names) -> `order` (its definitions, without cycles) -> `define`
//! (each of them, then responses, breaks, updates), with `elaborate`, `lookup`, `calls` and `typing` for
//! expressions and `library` for what is defined outside of it.

mod calls;
pub(crate) mod declare;
mod define;
mod elaborate;
mod facts;
pub(crate) mod influence;
pub(crate) mod library;
mod lookup;
mod meets;
pub(crate) mod modules;
pub(crate) mod names;
mod numbers;
mod order;
mod params;
mod probes;
mod typing;
mod under;
pub(crate) mod walk;

use crate::ast::{Item, Model, ResponseKind};
use crate::check;
use crate::diag::Diagnostic;
use crate::ir::{ExprId, Flavour, Home, Law, Response};
use crate::span::Span;
use elaborate::Symbol;
pub(crate) use elaborate::{Context, Elaborator};
use library::Library;
use std::collections::HashMap;

/// The law that a model describes. `Err`: something is wrong with it, and this is what was understood.
pub(crate) fn law(
    model: &Model,
    library: &Library,
    report: &mut Vec<Diagnostic>,
) -> Result<Law, Box<Law>> {
    let mut findings = Vec::new();
    metadata(model, &mut findings);
    let flavours = served(model, &mut findings);
    let mut law = Elaborator::new(library, Context::Law, &mut findings);
    law.declare(model);
    law.histories_in_families(model);
    for item in order::order(model, law.report) {
        let (name, symbol) = match item {
            Item::Weight(weight) => (&weight.name, law.weigh(weight).map(Symbol::Weight)),
            Item::Definition(definition) => {
                (&definition.name, law.define(definition).map(Symbol::Def))
            }
            _ => continue,
        };
        let symbol = symbol.unwrap_or(Symbol::Broken);
        law.symbols.insert(name.text.clone(), symbol);
    }
    let (responses, breaks, after_step) = law.answers(model);
    let knowns = check::knowns::read(model, law.report);
    let mut law = Law {
        name: model.name.text.clone(),
        span: model.name.span,
        title: model
            .title
            .as_ref()
            .map(|title| title.text.clone())
            .unwrap_or_default(),
        cites: model.cites.iter().map(|cite| cite.text.clone()).collect(),
        flavours,
        params: law.params,
        influences: law.influences,
        families: law.families,
        fields: law.fields,
        histories: law.histories,
        weights: law.weights,
        defs: law.defs,
        responses,
        breaks,
        after_step,
        knowns,
        probes: Vec::new(),
        exprs: law.exprs,
    };
    let sound =
        |findings: &[Diagnostic]| model.complete && !findings.iter().any(Diagnostic::is_error);
    if sound(&findings) {
        let staggered = check::half::unstaggered(&law);
        findings.extend(staggered);
        findings.extend(check::ends::unlike(model, &law));
        findings.extend(check::ends::one_way(&law));
        findings.extend(check::kept::elsewhere(&law));
    }
    if sound(&findings) {
        law.probes = probes(model, &law, library, &mut findings);
        // In a law with errors, what seems unused may be needed where the error is.
        order::unused(model, &mut findings);
        findings.extend(check::added::warnings(model));
        check::differences::warn(model, &mut findings);
    }
    let sound = sound(&findings);
    report.append(&mut findings);
    if sound { Ok(law) } else { Err(Box::new(law)) }
}

/// The probes of a law that is right.
fn probes(
    model: &Model,
    law: &Law,
    library: &Library,
    report: &mut Vec<Diagnostic>,
) -> Vec<crate::probe::Probe> {
    let energy = model.items.iter().find_map(|item| match item {
        Item::Response(r) if r.kind == ResponseKind::Energy => Some(r.name.text.as_str()),
        _ => None,
    });
    let (mut found, mut names) = (Vec::new(), HashMap::new());
    for item in &model.items {
        let Item::Probe(written) = item else { continue };
        if check::duplicates::first(&mut names, &written.name, report) {
            found.extend(probes::probe(written, law, energy, library, report));
        }
    }
    found
}

fn metadata(model: &Model, report: &mut Vec<Diagnostic>) {
    if model
        .title
        .as_ref()
        .is_none_or(|title| title.text.trim().is_empty())
    {
        report.push(check::titles::missing(&model.name));
    }
    report.extend(check::citations::check(&model.name, &model.cites));
}

/// The flavours named after `for`; all without it.
fn served(model: &Model, report: &mut Vec<Diagnostic>) -> Vec<Flavour> {
    if model.flavours.is_empty() {
        return Flavour::ALL.to_vec();
    }
    report.extend(check::flavours::named(&model.flavours));
    let named = |flavour: &Flavour| {
        model
            .flavours
            .iter()
            .any(|name| name.text == flavour.name())
    };
    Flavour::ALL.into_iter().filter(named).collect()
}

impl Elaborator<'_> {
    fn histories_in_families(&mut self, model: &Model) {
        for item in &model.items {
            let Item::History(written) = item else {
                continue;
            };
            let family = self.family(written.family.as_ref());
            if let (Some(family), Some(Symbol::History(id))) =
                (family, self.symbols.get(&written.name.text).copied())
            {
                self.histories[id.index()].family = family;
            }
        }
    }

    /// Families, responses, breaks, updates and what follows a step, and whether there are as many of them as there should be.
    fn answers(&mut self, model: &Model) -> (Vec<Response>, Vec<crate::ir::Break>, Option<ExprId>) {
        let (mut responses, mut breaks) = (Vec::new(), Vec::new());
        let mut after_step = None;
        for item in &model.items {
            match item {
                Item::Family(family) => drop(self.filter(family)),
                Item::Field(field) => drop(self.live(field)),
                Item::Response(response) => responses.extend(self.respond(response)),
                Item::Break(breaking) => breaks.extend(self.breaking(breaking)),
                Item::Update(update) => drop(self.update(update)),
                Item::AfterStep(after) => after_step = self.after_step(after),
                _ => {}
            }
        }
        count_answers(model, self.report);
        (responses, breaks, after_step)
    }
}

/// One energy, one force of a node, one rate per field, one update per history, and something at all.
fn count_answers(model: &Model, report: &mut Vec<Diagnostic>) {
    let mut seen: HashMap<(&str, &str), Span> = HashMap::new();
    for item in &model.items {
        let (what, key, name) = match item {
            Item::Response(response) if response.kind == ResponseKind::Energy => {
                ("energy", "", &response.name)
            }
            Item::Response(response) if response.kind == ResponseKind::Force => {
                ("force", "", &response.name)
            }
            Item::Response(response) if response.kind == ResponseKind::Rate => {
                ("rate", response.name.text.as_str(), &response.name)
            }
            Item::Update(update) => ("update", update.name.text.as_str(), &update.name),
            Item::AfterStep(after) => ("rule after the step", "", &after.name),
            _ => continue,
        };
        if let Some(earlier) = seen.insert((what, key), name.span) {
            report.push(check::responses::twice(what, name, earlier));
        }
    }
    for item in &model.items {
        if let Item::History(history) = item
            && !seen.contains_key(&("update", history.name.text.as_str()))
        {
            report.push(check::responses::without_update(&history.name));
        }
        if let Item::Field(field) = item
            && field.half
            && !seen.contains_key(&("rate", field.name.text.as_str()))
        {
            report.push(check::half::without_rate(&field.name));
        } else if let Item::Field(field) = item
            && field.lives.is_some()
            && !seen.contains_key(&("rate", field.name.text.as_str()))
        {
            report.push(check::parts::without_rate(&field.name));
        }
    }
    if model.complete
        && !model
            .items
            .iter()
            .any(|item| matches!(item, Item::Response(_)))
    {
        report.push(check::responses::none(&model.name));
    }
}

/// Homes are ordered from the constants outwards.
const _: () =
    assert!((Home::Constant as u8) < Home::Node as u8 && (Home::Node as u8) < Home::Bond as u8);

#[cfg(test)]
mod documented;
#[cfg(test)]
mod moduli_tests;
