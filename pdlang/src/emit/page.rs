//! The page of a law, generated from its text: what it says, in which notation, with which parameters.

use super::derived::Derived;
use super::latex::Notation;
use super::render::{DOLLAR, Form, Part};
use crate::ast::{self, Components, Item, Model, ProbeLine, ResponseKind, Setting};
use crate::front::Source;
use crate::ir::{Bound, Field, Home, Law, Meet, Param, Response};
use crate::resolve::walk;
use crate::span::Span;
use std::collections::BTreeSet;

/// The page of a law in the notation of a form; `more` stands before its probes.
pub(super) fn parts(
    law: &Law,
    model: &Model,
    source: &Source,
    form: Form,
    more: &[Part],
) -> Vec<Part> {
    let derived = super::derived::of(law, model, source);
    let notation = Notation {
        law,
        plain: form == Form::Terminal,
        meanings: derived.as_ref().map_or_else(|_| vec![], |d| d.meanings()),
    };
    let mut parts: Vec<Part> = vec![Part::Text(format!("`{}`", law.name))];
    parts.extend(law.cites.iter().map(|cite| Part::Text(said(cite))));
    parts.push(Part::Text(facts(law)));
    parts.push(Part::Heading("The law as it is written".into()));
    parts.push(Part::Code(without_probes(source.library.text, model)));
    if !law.params.is_empty() {
        parts.push(Part::Heading("Parameters".into()));
        let rows = law.params.iter().map(|p| param(p, &notation)).collect();
        parts.push(Part::Table(
            vec!["symbol", "unit", "bounds", "default", "what"],
            rows,
        ));
    }
    unknowns(law, &notation, &mut parts);
    parts.push(Part::Heading("Definitions".into()));
    parts.push(Part::Text(legend(notation.plain).into()));
    for item in &model.items {
        parts.extend(equation(item, &notation, source));
    }
    let shown = derived.as_ref().ok();
    parts.extend(functions(model, source, &notation, shown));
    parts.extend(super::formulas::parts(derived.as_ref(), model, &notation));
    parts.extend_from_slice(more);
    parts.extend(super::computed::parts(law));
    for item in &model.items {
        if let Item::Probe(probe) = item {
            if !parts
                .iter()
                .any(|p| matches!(p, Part::Heading(h) if h == "Probes"))
            {
                parts.push(Part::Heading("Probes".into()));
            }
            parts.extend(probed(probe, &notation));
        }
    }
    parts
}

/// Words of a law: their signs are no marks of the page.
fn said(words: &str) -> String {
    words.replace('$', DOLLAR).replace('`', "'")
}

/// What the words of the formulas mean.
fn legend(plain: bool) -> &'static str {
    match plain {
        true => {
            "dim is the number of dimensions, delta the horizon; sum runs over the intact bonds of a node and weighs them with the \
             volume of their other end, sum0 over those of the undamaged body; ball is the integral over the whole horizon. A prime is \
             the other end of the bond."
        }
        false => {
            "$\\dim$ is the number of dimensions, $\\delta$ the horizon, $V_j$ the volume of the node at the other end of a bond, \
             $\\mathcal{H}$ the family of intact bonds, $\\mathcal{H}_0$ that of the undamaged body, $\\mathcal{B}_\\delta$ the \
             whole horizon. A prime is the other end of the bond."
        }
    }
}

/// For which bodies it is, what it answers, whether bonds break.
fn facts(law: &Law) -> String {
    let flavours: Vec<String> = law
        .flavours
        .iter()
        .map(|f| format!("`{}`", f.name()))
        .collect();
    let mut answers: Vec<&str> = vec![];
    for response in &law.responses {
        let word = match response {
            Response::Energy(_) => "an energy",
            Response::Pair(..) => "bond forces",
            Response::State(..) => "a force state",
            Response::Force(_) => "a force",
            Response::Rate(..) => "rates of fields",
        };
        if !answers.contains(&word) {
            answers.push(word);
        }
    }
    let breaks = if law.breaks.is_empty() {
        "Its bonds do not break."
    } else {
        "Its bonds can break."
    };
    format!(
        "For {}. It gives {}. {breaks}",
        flavours.join(", "),
        answers.join(" and ")
    )
}

/// The text of a law up to its probes, which have a part of the page of their own.
fn without_probes(text: &str, model: &Model) -> String {
    let first = model.items.iter().find_map(|item| match item {
        Item::Probe(probe) => Some(probe.name.span.start as usize),
        _ => None,
    });
    let Some(end) = first.and_then(|at| text.get(..at)) else {
        return text.trim_end().into();
    };
    let mut lines: Vec<&str> = end.lines().collect();
    // The line of the probe, and what is said about it above.
    lines.pop();
    while lines
        .last()
        .is_some_and(|l| l.trim().is_empty() || l.trim_start().starts_with('#'))
    {
        lines.pop();
    }
    format!("{}\n}}", lines.join("\n"))
}

fn param(p: &Param, notation: &Notation) -> Vec<String> {
    let side = |b: Option<Bound>, strict: &str, loose: &str| {
        b.map(|b| {
            format!(
                "${} {}$",
                if b.inclusive { loose } else { strict },
                notation.number(b.value)
            )
        })
    };
    let (ge, le) = if notation.plain {
        (">=", "<=")
    } else {
        ("\\ge", "\\le")
    };
    let sides = [side(p.lower, ">", ge), side(p.upper, "<", le)];
    let unit = if p.unit.is_number() {
        "1".into()
    } else {
        p.unit.symbol()
    };
    let met = match &p.meet {
        meet if *meet == Meet::default() => None,
        Meet::Formula(text, _) => Some(format!("`{text}`")),
        meet => Meet::WORDS
            .iter()
            .find(|(_, known)| known == meet)
            .map(|(word, _)| word.to_string()),
    };
    let met = met.map_or(String::new(), |met| {
        format!("; between two materials: {met}")
    });
    vec![
        format!("${}$", notation.name(&p.name)),
        unit,
        sides.into_iter().flatten().collect::<Vec<_>>().join(", "),
        p.default
            .map(|v| format!("${}$", notation.number(v)))
            .unwrap_or_default(),
        said(&p.doc) + &met,
    ]
}

/// When and where a field is.
fn lives(field: &Field) -> String {
    let when = if field.half {
        "field at half steps"
    } else {
        "field"
    };
    match &field.lives {
        Some(lives) => format!("{when}, where `{}`", lives.text),
        None => when.into(),
    }
}

/// Fields and histories.
fn unknowns(law: &Law, notation: &Notation, parts: &mut Vec<Part>) {
    let unit = |unit: &crate::units::Unit| {
        if unit.is_number() {
            "1".into()
        } else {
            unit.symbol()
        }
    };
    let fields = law.fields.iter().map(|f| {
        vec![
            format!("${}$", notation.name(&f.name)),
            unit(&f.unit),
            lives(f),
            said(&f.doc),
        ]
    });
    let histories = law.histories.iter().map(|h| {
        let place = if h.home == Home::Bond {
            "memory of a bond"
        } else {
            "memory of a node"
        };
        vec![
            format!("${}$", notation.name(&h.name)),
            unit(&h.unit),
            place.into(),
            String::new(),
        ]
    });
    let rows: Vec<Vec<String>> = fields.chain(histories).collect();
    if !rows.is_empty() {
        parts.push(Part::Heading("Fields and memory".into()));
        parts.push(Part::Table(vec!["symbol", "unit", "lives", "what"], rows));
    }
}

fn equation(item: &Item, notation: &Notation, source: &Source) -> Option<Part> {
    let set = |words: &str, left: String, right: &ast::Expr| {
        Some(Part::Equation(
            words.into(),
            format!("{left} = {}", notation.expr(right)),
        ))
    };
    match item {
        Item::Influence(slot) => {
            let name = notation.name(&slot.name.text);
            match &slot.default {
                Some(default) => set(
                    "Influence function, unless the scene chooses another:",
                    name,
                    default,
                ),
                None => Some(Part::Text(format!(
                    "The influence function ${name}$ is chosen by the scene."
                ))),
            }
        }
        Item::Definition(d) => {
            let home = match d.home {
                Home::Constant => "a constant",
                Home::Node => "at a node",
                Home::Bond => "on a bond",
            };
            let words = match remark(source.library.text, d.name.span) {
                Some(remark) => format!("{}, {home}:", said(remark)),
                None => format!("{home}:"),
            };
            set(&capital(&words), notation.name(&d.name.text), &d.expr)
        }
        Item::Response(r) => {
            let name = notation.name(&r.name.text);
            match r.kind {
                ResponseKind::Energy => set(
                    "Strain energy density, of which the force is the derivative:",
                    name,
                    &r.expr,
                ),
                ResponseKind::Pair => set("Force density of a bond, along it:", name, &r.expr),
                ResponseKind::State => set(
                    "Force state; a node feels that of its bonds less that of the bonds from their other ends:",
                    name,
                    &r.expr,
                ),
                ResponseKind::Force => set(
                    "Force density of a node:",
                    notation.bold(&r.name.text),
                    &r.expr,
                ),
                ResponseKind::Rate => set("Rate:", notation.rate(&r.name.text), &r.expr),
            }
        }
        Item::Update(u) => {
            let name = notation.name(&u.name.text);
            Some(Part::Equation(
                "When a step is accepted:".into(),
                format!("{name} {} {}", notation.becomes(), notation.expr(&u.expr)),
            ))
        }
        Item::AfterStep(a) => Some(Part::Equation(
            "When a step is accepted, a node with intact bonds gets the velocity".into(),
            format!(
                "{} {} {}",
                notation.name(&a.name.text),
                notation.becomes(),
                notation.expr(&a.expr)
            ),
        )),
        Item::Family(f) => Some(Part::Equation(
            format!("The family `{}` consists of the bonds with", f.name.text),
            notation.expr(&f.filter),
        )),
        Item::Weight(w) => {
            let words = w
                .doc
                .as_ref()
                .map_or("weight".into(), |doc| said(&doc.text));
            let words = format!("{words}, computed once, unless the scene says 1:");
            set(&capital(&words), notation.name(&w.name.text), &w.expr)
        }
        Item::Break(b) => {
            let of = b
                .family
                .as_ref()
                .map(|f| format!(" of the family `{}`", f.text));
            let when = if b.after {
                ", after the force, where"
            } else {
                " where"
            };
            Some(Part::Equation(
                format!("A bond{} breaks{when}", of.unwrap_or_default()),
                notation.expr(&b.when),
            ))
        }
        Item::Known(k) => {
            let checks: Vec<String> = k.checks.iter().map(|c| format!("`{}`", c.text)).collect();
            let words = format!("Known ({}): {}.", checks.join(", "), said(&k.reason.text));
            Some(Part::Text(words))
        }
        Item::Param(_) | Item::Field(_) | Item::History(_) | Item::Probe(_) => None,
    }
}

/// The comment at the end of the line of a name.
fn remark(text: &str, name: Span) -> Option<&str> {
    let line = text.get(name.end as usize..)?.lines().next()?;
    let (_, comment) = line.split_once('#')?;
    Some(comment.trim())
}

/// Formulas keep their letters.
fn capital(words: &str) -> String {
    let mut letters = words.chars();
    let plain = letters.clone().take(2).all(char::is_lowercase) || words.starts_with("a ");
    match letters.next().filter(|_| plain) {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => words.into(),
    }
}

/// Definitions of the library that the law and its formulas use, in alphabetical order.
fn functions(
    model: &Model,
    source: &Source,
    notation: &Notation,
    derived: Option<&Derived>,
) -> Vec<Part> {
    let own: BTreeSet<&str> = model
        .items
        .iter()
        .filter_map(crate::resolve::declare::declared)
        .map(|name| name.text.as_str())
        .collect();
    let (mut seen, mut open) = (BTreeSet::new(), Vec::new());
    for item in &model.items {
        for expr in expressions(item) {
            walk::called(expr, &mut open);
        }
    }
    let mut found = Vec::new();
    for value in derived.iter().flat_map(|d| d.values()) {
        walk::called(value, &mut open);
    }
    while let Some(name) = open.pop() {
        if own.contains(name.as_str()) || !seen.insert(name.clone()) {
            continue;
        }
        if let Some(f) = source.library.function(&name, false) {
            walk::called(&f.body, &mut open);
            let args: Vec<String> = f.params.iter().map(|p| notation.bare(&p.text)).collect();
            let left = format!("{}({})", notation.bare(&name), args.join(", "));
            let formula = format!("{left} = {}", notation.expr(&f.body));
            found.push((name, String::new(), formula));
        } else if let Some(d) = source.library.definition(&name, false) {
            walk::called(&d.expr, &mut open);
            let mut hidden = vec![];
            if !source.library.own.definitions.contains_key(&name) {
                walk::mentioned(&d.expr, &mut hidden);
            }
            hidden.retain(|n| own.contains(n.as_str()));
            let names: Vec<String> = hidden.iter().map(|n| format!("`{n}`")).collect();
            // The prelude sees nothing but the prelude.
            let words = match names.is_empty() {
                true => String::new(),
                false => format!(
                    "With the library's {}, not that of the law:",
                    names.join(" and ")
                ),
            };
            let formula = format!("{} = {}", notation.name(&name), notation.expr(&d.expr));
            found.push((name, words, formula));
        }
    }
    found.sort();
    let line = |(_, words, formula): (String, String, String)| Part::Equation(words, formula);
    let heading = (!found.is_empty()).then(|| Part::Heading("From the library".into()));
    heading
        .into_iter()
        .chain(found.into_iter().map(line))
        .collect()
}

fn expressions(item: &Item) -> Vec<&ast::Expr> {
    match item {
        Item::Definition(d) => vec![&d.expr],
        Item::Response(r) => vec![&r.expr],
        Item::Update(u) => vec![&u.expr],
        Item::AfterStep(a) => vec![&a.expr],
        Item::Family(f) => vec![&f.filter],
        Item::Field(f) => f.lives.iter().collect(),
        Item::Weight(w) => vec![&w.expr],
        Item::Break(b) => vec![&b.when],
        _ => Vec::new(),
    }
}

fn probed(probe: &ast::Probe, notation: &Notation) -> Vec<Part> {
    let settings: Vec<String> = probe.settings.iter().map(|s| set(s, notation)).collect();
    let mut text = format!(
        "`{}` ({}): {}.",
        probe.name.text,
        probe.flavour.text,
        settings.join(", ")
    );
    let mut rows = Vec::new();
    for line in &probe.lines {
        match line {
            ProbeLine::Let(name, value) => {
                text += &format!(
                    " ${} = {}$.",
                    notation.name(&name.text),
                    notation.expr(value)
                );
            }
            ProbeLine::Node {
                name,
                position,
                settings,
            } => {
                let at = format!(
                    "${} = {}$",
                    notation.name("X"),
                    components(position, notation)
                );
                text += &format!(" Node `{}`: {at}{}.", name.text, rest(settings, notation));
            }
            ProbeLine::Lattice {
                spacing, settings, ..
            } => {
                text += &format!(
                    " A lattice of spacing ${}${}.",
                    notation.expr(spacing),
                    rest(settings, notation)
                );
            }
            ProbeLine::Cut(a, b) => {
                text += &format!(" The bond between `{}` and `{}` is broken.", a.text, b.text);
            }
            ProbeLine::Expect(e) => {
                let places: Vec<&str> = e.place.iter().map(|p| p.text.as_str()).collect();
                let place = if places.is_empty() {
                    String::new()
                } else {
                    format!(" at `{}`", places.join(" - "))
                };
                let name = match (e.rate, e.name.text.as_str()) {
                    (true, name) => format!("${}$", notation.rate(name)),
                    (_, "force") => "force".into(),
                    (_, name) => format!("${}$", notation.name(name)),
                };
                rows.push(vec![
                    format!("{name}{place}"),
                    format!("${}$", components(&e.value, notation)),
                ]);
            }
        }
    }
    vec![
        Part::Text(text),
        Part::Table(vec!["quantity", "value"], rows),
    ]
}

fn rest(settings: &[Setting], notation: &Notation) -> String {
    settings
        .iter()
        .map(|s| format!(", {}", set(s, notation)))
        .collect()
}

fn set(setting: &Setting, notation: &Notation) -> String {
    let name = match setting.name.text.as_str() {
        name @ ("u" | "v" | "H") => notation.bold(name),
        name => notation.name(name),
    };
    format!("${name} = {}$", components(&setting.value, notation))
}

fn components(value: &Components, notation: &Notation) -> String {
    let row = |row: &Vec<ast::Expr>| {
        let parts: Vec<String> = row.iter().map(|e| notation.expr(e)).collect();
        format!("({})", parts.join(", "))
    };
    match value.rows.as_slice() {
        [one] if one.len() == 1 => notation.expr(&one[0]),
        [one] => row(one),
        rows => format!("({})", rows.iter().map(row).collect::<Vec<_>>().join(", ")),
    }
}
