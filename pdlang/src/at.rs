//! What stands at a place of a text: what an editor asks.
//!
//! Contract. Answers come from what the compiler understood, also of laws with errors; what it does not know for certain has no
//! answer.

use crate::ast::{self, Item, ProbeLine};
use crate::emit::ir::{expr, home, shape, unit};
use crate::explain;
use crate::files::Files;
use crate::front::{self, Source};
use crate::ir::{Def, ExprKind, Law, Response, Shape};
use crate::known::CHECKS;
use crate::parse;
use crate::resolve::library::PRELUDE_TEXT;
use crate::resolve::names;
use crate::span::Span;
use crate::units::{self, Unit};
use crate::words;

/// A name in a text, and what it stands for.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Named {
    /// The name as it stands there.
    pub span: Span,
    /// `node scalar theta [a pure number]`, with the formula where there is one; the text of a function; a word of the language.
    pub is: String,
    /// What the law says of it, in words or in a comment beside it; or the language.
    pub doc: String,
    /// The sweeps that compute it, with when they run; of a law with errors none.
    pub computed: Vec<String>,
    /// Where it is defined, if in this text.
    pub definition: Option<Span>,
}

/// What the name at byte `offset` of the text of the file at `path` stands for.
pub fn at(text: &str, path: &str, files: &mut Files, offset: usize) -> Option<Named> {
    let span = word(text, offset)?;
    let name = &parse::spelled(&text[span.start as usize..span.end as usize]);
    let source = &front::source(text, path, files);
    let value = |law| named(law, source, name, span);
    let answer = answered(source, span);
    let computed = |law| {
        let found = value(law)?;
        let computed = explain::computed(law, name, answer.map(|answer| answer.kind));
        Some(Named { computed, ..found })
    };
    let sound = source.checked.laws.iter().find_map(computed);
    let found = sound
        .or_else(|| source.faulty.iter().find_map(value))
        .or_else(|| chosen(source, name, span))
        .or_else(|| not_reached(source, name, span))
        .or_else(|| word_of_language(source, name, span));
    found.map(|found| Named { span, ..found })
}

/// The name around `offset` that is neither in a comment nor in a string.
fn word(text: &str, offset: usize) -> Option<Span> {
    let inside = |c: char| c.is_alphabetic() || c.is_ascii_digit() || c == '_';
    let before = text.get(..offset)?;
    let start = before.trim_end_matches(inside).len();
    let after = &text[offset..];
    let end = offset + after.len() - after.trim_start_matches(inside).len();
    let line = &text[text[..start].rfind('\n').map_or(0, |k| k + 1)..start];
    let quoted = line.matches('"').count() % 2 == 1;
    if start == end || quoted || comment_in(line).is_some() {
        return None;
    }
    Some(Span {
        start: start as u32,
        end: end as u32,
        prelude: false,
    })
}

/// The comment at the end of a line.
fn comment_in(line: &str) -> Option<&str> {
    let begins = |(k, _): &(usize, &str)| line[..*k].matches('"').count().is_multiple_of(2);
    let marks = line.match_indices('#').chain(line.match_indices("//"));
    let (k, mark) = marks.filter(begins).min()?;
    Some(line[k + mark.len()..].trim())
}

/// The comment behind what begins at a place, on its line, or on the lines above it.
fn comment(text: &str, start: u32) -> String {
    let (above, rest) = text.split_at_checked(start as usize).unwrap_or_default();
    if let Some(beside) = rest.lines().next().and_then(comment_in) {
        return beside.into();
    }
    let alone = |line: &&str| line.trim_start().starts_with(['#', '/']);
    let above = above.rsplit('\n').skip(1).take_while(alone);
    let lines: Vec<&str> = above.filter_map(comment_in).collect();
    lines.into_iter().rev().collect::<Vec<_>>().join(" ")
}

/// The text that a definition of this name stands in; a file that is used is not here.
fn text_of<'s>(source: &Source<'s>, name: &str, span: Span) -> Option<&'s str> {
    let library = &source.library;
    let functions = library.prelude.functions.get(name).map(|f| f.name.span);
    let definitions = library.prelude.definitions.get(name).map(|d| d.name.span);
    let prelude = [functions, definitions].contains(&Some(span));
    let own =
        library.own.functions.contains_key(name) || library.own.definitions.contains_key(name);
    match span.prelude {
        false => Some(library.text),
        true => (prelude && !own).then_some(PRELUDE_TEXT),
    }
}

/// A check that a law is known to fail, or the influence function that it chooses.
fn chosen(source: &Source, name: &str, span: Span) -> Option<Named> {
    let said = |is: String, doc: &str| Named {
        is,
        doc: doc.into(),
        ..Named::default()
    };
    source
        .models
        .iter()
        .flat_map(|m| &m.items)
        .find_map(|item| match item {
            Item::Known(known) => {
                known.checks.iter().find(|check| check.span == span)?;
                let (_, checked) = CHECKS.iter().find(|(check, _)| *check == name)?;
                Some(said(format!("known {name}"), checked))
            }
            Item::Influence(slot) => {
                slot.default
                    .as_ref()
                    .filter(|d| d.span.start == span.start)?;
                let function = source.library.influence(name)?;
                let params = function.params.iter();
                let params: Vec<String> = params
                    .map(|p| format!("{} [{}]", p.name, p.unit.describe(&[])))
                    .collect();
                let is = format!("influence {name}({})", params.join(", "));
                Some(said(is, &function.doc))
            }
            _ => None,
        })
}

/// A name of a law where the compiler did not come to: in a line that cannot be read, and in probes.
fn not_reached(source: &Source, name: &str, span: Span) -> Option<Named> {
    let text = source.library.text;
    let mut models = source.models.iter();
    let model = models.rfind(|model| model.name.span.start < span.start)?;
    let before = &text[..span.start as usize];
    let line = before.rsplit('\n').next()?.trim();
    // Units, components, kinds, parameters of influence functions and of functions are others of that name.
    let unit = line.ends_with(|c: char| c.is_ascii_digit()) || line.rfind('[') > line.rfind(']');
    let functions = source.library.own.functions.values();
    let mut functions = functions.map(|f| f.name.span.start..=f.body.span.end);
    if unit
        || line.ends_with(['.', ':'])
        || line.starts_with("influence")
        || functions.any(|function| function.contains(&span.start))
    {
        return None;
    }
    // So are the nodes and numbers of probes.
    let binds = |line: &ProbeLine| match line {
        ProbeLine::Let(bound, _) | ProbeLine::Node { name: bound, .. } => bound.text == name,
        _ => false,
    };
    let probed = |item: &Item| matches!(item, Item::Probe(p) if p.lines.iter().any(binds));
    if model.items.iter().any(probed) {
        return None;
    }
    let laws = &source.checked.laws;
    let mut laws = laws.iter().chain(&source.faulty);
    let law = laws.find(|law| law.span == model.name.span)?;
    let mut known = declared(law, source);
    known
        .find(|(known, _)| *known == name)
        .map(|(_, known)| known)
}

/// A function, a kind, or what the language itself has of that name.
fn word_of_language(source: &Source, name: &str, span: Span) -> Option<Named> {
    let text = source.library.text;
    let (before, rest) = (&text[..span.start as usize], &text[span.end as usize..]);
    let (before, rest) = (before.trim_end(), rest.trim_start());
    let said = |is: String, doc: &str| {
        let doc = doc.into();
        Some(Named {
            is,
            doc,
            ..Named::default()
        })
    };
    if rest.starts_with(['(', '[']) {
        if let Some(doc) = names::function_doc(name) {
            return said(format!("{name}(..)"), doc);
        }
        if let Some(found) = function(source, name) {
            return Some(found);
        }
    }
    let typed = before.ends_with(':');
    if let Some(doc) = words::in_table(&words::SHAPES, name).filter(|_| typed) {
        return said(name.into(), doc);
    }
    let meets = before.ends_with("meets");
    if let Some(doc) = words::in_table(&words::MEETINGS, name).filter(|_| meets) {
        return said(format!("meets {name}"), doc);
    }
    if let Some(doc) = words::in_table(&words::FLAVOURS, name) {
        return said(format!("flavour {name}"), doc);
    }
    let mut shapes = words::SHAPES.iter();
    let shape_before = shapes.find_map(|(shape, _)| before.strip_suffix(shape));
    if shape_before.unwrap_or(before).trim_end().ends_with(':')
        && let Some(kind) = units::named_kind(name)
    {
        return said(format!("{name} [{}]", kind.describe(&[])), "");
    }
    if let Some(p) = names::PRIMITIVES.iter().find(|p| p.name == name) {
        let of = p.unit.describe(&[]);
        let is = format!("{} {} {name} [{of}]", home(p.home), shape(p.shape));
        return said(is, p.doc);
    }
    said(name.into(), words::said(name)?)
}

/// A function as it is written.
fn function(source: &Source, name: &str) -> Option<Named> {
    let function = source.library.function(name, false)?;
    let at = function.name.span;
    let definition = Some(at).filter(|at| !at.prelude);
    let Some(text) = text_of(source, name, at) else {
        let params: Vec<&str> = function.params.iter().map(|p| p.text.as_str()).collect();
        let is = format!("fn {name}({})", params.join(", "));
        return Some(Named {
            is,
            ..Named::default()
        });
    };
    Some(Named {
        is: format!(
            "fn {}",
            text.get(at.start as usize..function.body.span.end as usize)?
        ),
        doc: comment(text, at.start),
        definition,
        ..Named::default()
    })
}

/// The answer whose name stands at a place, as it is written.
fn answered<'s>(source: &'s Source, span: Span) -> Option<&'s ast::Response> {
    let mut items = source.models.iter().flat_map(|model| &model.items);
    items.find_map(|item| match item {
        Item::Response(response) => Some(response).filter(|r| r.name.span == span),
        _ => None,
    })
}

fn answer(law: &Law, source: &Source, written: &ast::Response) -> Option<Named> {
    let exprs = law.responses.iter().map(|response| match response {
        Response::Energy(e) | Response::Force(e) => e,
        Response::Pair(_, e) | Response::State(_, e) | Response::Rate(_, e) => e,
    });
    let at = written.expr.span;
    let value = exprs.map(|e| &law.exprs[e.index()]);
    let value = value.into_iter().find(|value| value.span == at)?;
    let what = format!("{:?}", written.kind).to_lowercase();
    let is = typed(law, &what, value.shape, &written.name.text, &value.unit);
    let text = source.library.text;
    let formula = text.get(at.start as usize..at.end as usize)?;
    let doc = comment(text, written.name.span.start);
    Some(Named {
        is: format!("{is} = {}", one_line(formula)),
        doc,
        ..Named::default()
    })
}

fn named(law: &Law, source: &Source, name: &str, span: Span) -> Option<Named> {
    if let Some(written) = answered(source, span) {
        return answer(law, source, written);
    }
    let kinds = law.exprs.iter().filter(|e| e.span == span);
    let used = kinds.filter_map(|e| of_kind(law, source, &e.kind));
    let defined = declared(law, source).filter(|(_, known)| known.definition == Some(span));
    used.chain(defined)
        .find(|(known, _)| *known == name)
        .map(|(_, known)| known)
}

type Known<'l> = (&'l str, Named);

/// What an expression that is a name stands for.
fn of_kind<'l>(law: &'l Law, source: &Source, kind: &ExprKind) -> Option<Known<'l>> {
    match kind {
        ExprKind::Param(k) => Some(param(law, k.index())),
        ExprKind::Def(k) => Some(def(law, source, &law.defs[k.index()])),
        ExprKind::Field(k) => Some(field(law, k.index())),
        ExprKind::History(k) => Some(history(law, k.index())),
        ExprKind::Weight(k) => Some(weight(law, k.index())),
        ExprKind::Influence(k) => Some(influence(law, k.index())),
        _ => None,
    }
}

/// Everything that a law gives a name.
fn declared<'l>(law: &'l Law, source: &'l Source) -> impl Iterator<Item = Known<'l>> {
    let params = (0..law.params.len()).map(|k| param(law, k));
    let defs = law.defs.iter().map(move |d| def(law, source, d));
    let fields = (0..law.fields.len()).map(|k| field(law, k));
    let histories = (0..law.histories.len()).map(|k| history(law, k));
    let weights = (0..law.weights.len()).map(|k| weight(law, k));
    let influences = (0..law.influences.len()).map(|k| influence(law, k));
    params
        .chain(defs)
        .chain(fields)
        .chain(histories)
        .chain(weights)
        .chain(influences)
}

fn known<'l>(name: &'l str, is: String, doc: &str, span: Span) -> Known<'l> {
    let named = Named {
        is,
        doc: doc.to_string(),
        definition: Some(span).filter(|span| !span.prelude),
        ..Named::default()
    };
    (name, named)
}

fn typed(law: &Law, what: &str, s: Shape, name: &str, u: &Unit) -> String {
    format!("{what} {} {name} [{}]", shape(s), unit(law, u))
}

fn param(law: &Law, k: usize) -> Known<'_> {
    let p = &law.params[k];
    let is = typed(law, "param", Shape::Scalar, &p.name, &p.unit);
    known(&p.name, is, &p.doc, p.span)
}

fn field(law: &Law, k: usize) -> Known<'_> {
    let f = &law.fields[k];
    let is = typed(law, "field", f.shape, &f.name, &f.unit);
    known(&f.name, is, &f.doc, f.span)
}

fn history(law: &Law, k: usize) -> Known<'_> {
    let h = &law.histories[k];
    let what = format!("history {}", home(h.home));
    known(
        &h.name,
        typed(law, &what, h.shape, &h.name, &h.unit),
        "",
        h.span,
    )
}

fn weight(law: &Law, k: usize) -> Known<'_> {
    let w = &law.weights[k];
    let is = typed(law, "weight bond", Shape::Scalar, &w.name, &Unit::NUMBER);
    known(&w.name, is, &w.doc, w.span)
}

fn influence(law: &Law, k: usize) -> Known<'_> {
    let i = &law.influences[k];
    let function = i.default.as_ref();
    let doc = function.map_or("", |function| function.doc.as_str());
    let is = format!("influence {}, a function of the bond length", i.name);
    known(&i.name, is, doc, i.span)
}

fn def<'l>(law: &'l Law, source: &Source, d: &'l Def) -> Known<'l> {
    let is = typed(law, home(d.home), d.shape, &d.name, &d.unit);
    let text = text_of(source, &d.name, d.span);
    let formula = text.and_then(|text| written(law, text, d));
    let formula = formula.unwrap_or_else(|| expr(law, d.expr));
    let doc = text.map_or(String::new(), |text| comment(text, d.span.start));
    known(&d.name, format!("{is} = {formula}"), &doc, d.span)
}

/// The formula as it stands in the text, where it does: not if it is that of a function.
fn written(law: &Law, text: &str, d: &Def) -> Option<String> {
    let formula = law.exprs[d.expr.index()].span;
    if formula.prelude != d.span.prelude {
        return None;
    }
    let between = text.get(d.span.end as usize..formula.start as usize)?;
    let direct = between.trim_end().ends_with('=') && between.matches('=').count() == 1;
    let formula = text.get(formula.start as usize..formula.end as usize)?;
    direct.then(|| one_line(formula))
}

fn one_line(formula: &str) -> String {
    formula.split_whitespace().collect::<Vec<_>>().join(" ")
}

#[cfg(test)]
mod tests;
