//! What stands at a place of a text: what an editor asks.
//!
//! Contract. Answers come from laws that were understood, so that a law with an error has none; what the library does not
//! know for certain has no answer.

use crate::emit::ir::{expr, home, shape, unit};
use crate::files::Files;
use crate::front;
use crate::ir::{Def, ExprKind, Home, Law, Shape};
use crate::span::Span;
use crate::units::Unit;

/// A name in a text, and what it stands for.
#[derive(Clone, Debug, PartialEq)]
pub struct Named {
    /// The name as it stands there.
    pub span: Span,
    /// `node scalar theta [a pure number]`, with the formula where there is one; of a function nothing.
    pub is: String,
    /// What the law says of it.
    pub doc: String,
    /// Where it is defined, if in this text.
    pub definition: Option<Span>,
}

/// What the name at byte `offset` of the text of the file at `path` stands for.
pub fn at(text: &str, path: &str, files: &mut Files, offset: usize) -> Option<Named> {
    let span = word(text, offset)?;
    let name = &text[span.start as usize..span.end as usize];
    let source = front::source(text, path, files);
    let value = |law| named(law, text, name, span);
    if let Some(found) = source.checked.laws.iter().find_map(value) {
        return Some(found);
    }
    let called = text[span.end as usize..].trim_start().starts_with('(');
    let function = source.library.own.functions.get(name);
    let function = function.filter(|f| called && !f.name.span.prelude)?;
    Some(Named {
        span,
        is: String::new(),
        doc: String::new(),
        definition: Some(function.name.span),
    })
}

/// The name around `offset` that is neither in a comment nor in a string.
fn word(text: &str, offset: usize) -> Option<Span> {
    let inside = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let before = text.get(..offset)?;
    let start = before.trim_end_matches(inside).len();
    let after = &text[offset..];
    let end = offset + after.len() - after.trim_start_matches(inside).len();
    let line = &text[text[..start].rfind('\n').map_or(0, |k| k + 1)..start];
    let quoted = line.matches('"').count() % 2 == 1;
    if start == end || quoted || line.contains('#') {
        return None;
    }
    Some(Span {
        start: start as u32,
        end: end as u32,
        prelude: false,
    })
}

fn named(law: &Law, text: &str, name: &str, span: Span) -> Option<Named> {
    let kinds = law.exprs.iter().filter(|e| e.span == span);
    let used = kinds.filter_map(|e| of_kind(law, text, &e.kind));
    let defined = declared(law, text).filter(|(_, known)| known.definition == Some(span));
    used.chain(defined)
        .find(|(known, _)| *known == name)
        .map(|(_, known)| Named { span, ..known })
}

type Known<'l> = (&'l str, Named);

/// What an expression that is a name stands for.
fn of_kind<'l>(law: &'l Law, text: &str, kind: &ExprKind) -> Option<Known<'l>> {
    match kind {
        ExprKind::Param(k) => Some(param(law, k.index())),
        ExprKind::Def(k) => Some(def(law, text, &law.defs[k.index()])),
        ExprKind::Field(k) => Some(field(law, k.index())),
        ExprKind::History(k) => Some(history(law, k.index())),
        ExprKind::Weight(k) => Some(weight(law, k.index())),
        ExprKind::Influence(k) => Some(influence(law, k.index())),
        _ => None,
    }
}

/// Everything that a law gives a name.
fn declared<'l>(law: &'l Law, text: &'l str) -> impl Iterator<Item = Known<'l>> {
    let params = (0..law.params.len()).map(|k| param(law, k));
    let defs = law.defs.iter().map(move |d| def(law, text, d));
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
        span,
        is,
        doc: doc.to_string(),
        definition: Some(span).filter(|span| !span.prelude),
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

fn def<'l>(law: &'l Law, text: &str, d: &'l Def) -> Known<'l> {
    let is = typed(law, home(d.home), d.shape, &d.name, &d.unit);
    let formula = written(law, text, d).unwrap_or_else(|| expr(law, d.expr));
    known(&d.name, format!("{is} = {formula}"), "", d.span)
}

/// The formula as it stands in the text, where it does: not if it is that of a function or of the prelude.
fn written(law: &Law, text: &str, d: &Def) -> Option<String> {
    let formula = law.exprs[d.expr.index()].span;
    if d.span.prelude || formula.prelude || d.home == Home::Constant {
        return None;
    }
    let between = text.get(d.span.end as usize..formula.start as usize)?;
    let direct = between.trim_end().ends_with('=') && between.matches('=').count() == 1;
    let formula = text.get(formula.start as usize..formula.end as usize)?;
    direct.then(|| formula.split_whitespace().collect::<Vec<_>>().join(" "))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::files::nowhere;

    const LAWS: &str = r#"# theta here is in a comment
fn twice(a) = 2*a
model one "theta" cite "a, eq. 1" {
  influence omega = 1/x
  param K : pressure > 0 "bulk modulus"
  node m = sum(omega*x^2)
  node theta = dim/m * sum(omega*x*e)
  energy W = twice(K)*theta^2/2
}
model two "t" cite "a, eq. 1" { param K : pressure "k" energy W = nothing*K }
"#;

    fn find(before: &str, name: &str) -> Option<Named> {
        let start = LAWS.find(&format!("{before}{name}")).unwrap() + before.len();
        at(LAWS, "", &mut nowhere, start)
    }

    fn line(before: &str, name: &str) -> String {
        find(before, name).unwrap().is
    }

    fn defined(before: &str, name: &str) -> String {
        let span = find(before, name).unwrap().definition.unwrap();
        LAWS[..span.start as usize].lines().count().to_string()
            + &LAWS[span.start as usize..span.end as usize]
    }

    #[test]
    fn a_name_says_home_shape_unit_and_formula() {
        let theta = "node scalar theta [a pure number] = dim/m * sum(omega*x*e)";
        assert_eq!(line("twice(K)*", "theta"), theta);
        assert_eq!(line("node ", "theta"), theta);
        assert_eq!(line("twice(", "K"), "param scalar K [Pa]");
        assert_eq!(find("twice(", "K").unwrap().doc, "bulk modulus");
        assert!(line("sum(omega*x*", "e").starts_with("bond scalar e [m] = "));
    }

    #[test]
    fn definitions_are_found_in_the_text_and_not_in_the_prelude() {
        assert_eq!(defined("twice(K)*", "theta"), "7theta");
        assert_eq!(defined("dim/", "m"), "6m");
        assert_eq!(defined("twice(", "K"), "5K");
        assert_eq!(defined("sum(", "omega"), "4omega");
        assert_eq!(defined("energy W = ", "twice"), "2twice");
        assert_eq!(find("sum(omega*x*", "e").unwrap().definition, None);
    }

    #[test]
    fn nothing_is_said_of_comments_strings_words_and_laws_with_errors() {
        for (before, name) in [
            ("# ", "theta"),
            ("model one \"", "theta"),
            ("", "#"),
            ("model one \"theta\" ", "cite"),
            ("energy W = nothing*", "K"),
        ] {
            assert_eq!(find(before, name), None, "{before}{name}");
        }
    }

    #[test]
    fn every_place_of_any_text_has_an_answer_or_none() {
        let text = "model ω \"t\" { node θ = sum(x) fn ( } \u{1F600}";
        for offset in 0..text.len() + 3 {
            let _ = at(text, "", &mut nowhere, offset);
        }
    }
}
