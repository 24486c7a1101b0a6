//! How the values of a parameter at the two ends of a bond between materials become one: by a word, or by an
//! expression in `a` and `b` and in `fa` and `fb`, the fractions of the bond's length in their materials.
//!
//! An expression must be a mean: the same when the two ends change places, or a bond would have two values, and that
//! value itself where both are equal, or one material in two parts would be another one. That is found out by trying.

use crate::ast;
use crate::check::meets as say;
use crate::diag::Diagnostic;
use crate::direct;
use crate::ir::{ExprKind, Flavour, Meet};
use crate::probe::number::Known;
use crate::resolve::elaborate::{Context, Elaborator};
use crate::resolve::library::Library;
use crate::units::Unit;

/// Values to try [SI]: none is special, and their ratios are between two and a million.
const TRIED: [(f64, f64); 3] = [(1.37, 2.91), (0.0183, 41.7), (3.1e6, 7.7)];

/// Values of `fa` to try.
const FRACTIONS: [f64; 3] = [0.5, 0.137, 0.861];

pub(crate) fn meet(
    written: &ast::Expr,
    unit: &Unit,
    library: &Library,
    report: &mut Vec<Diagnostic>,
) -> Option<Meet> {
    if let ast::ExprKind::Name(word) = &written.kind {
        let known = Meet::WORDS.iter().find(|(known, _)| known == word);
        if known.is_none() {
            report.push(say::unknown(word, written.span));
        }
        return known.map(|(_, meet)| meet.clone());
    }
    let before = report.len();
    let mut elaborator = Elaborator::new(library, Context::Scene, report);
    let part = Unit::NUMBER;
    let names = [("a", unit), ("b", unit), ("fa", &part), ("fb", &part)];
    elaborator.add_variables(names.iter().map(|(name, unit)| (*name, (*unit).clone())));
    let root = elaborator.elaborate(written)?;
    if !elaborator.is_scalar_of(root, unit) {
        return None;
    }
    let exprs = elaborator.exprs;
    let of_flavour = exprs.iter().any(|e| matches!(e.kind, ExprKind::Case(_)));
    let value = |a: f64, b: f64, fa: f64| {
        let values = [a, b, fa, 1.0 - fa];
        let known = Known {
            exprs: &exprs,
            values: &values,
            flavour: Flavour::Solid,
        };
        known.number(root).unwrap_or(f64::NAN)
    };
    let near = |a: f64, b: f64| (a - b).abs() <= 1e-9 * a.abs().max(b.abs());
    let all = |good: &dyn Fn(f64, f64, f64) -> bool| {
        let mut tried = TRIED
            .iter()
            .flat_map(|(a, b)| FRACTIONS.iter().map(move |f| (*a, *b, *f)));
        tried.all(|(a, b, f)| good(a, b, f))
    };
    let symmetric = all(&|a, b, f| near(value(a, b, f), value(b, a, 1.0 - f)));
    let itself = all(&|a, _, f| near(value(a, a, f), a));
    if of_flavour || !symmetric || !itself {
        report.push(match (of_flavour, symmetric) {
            (true, _) => say::of_flavour(written.span),
            (_, false) => say::not_symmetric(written.span),
            _ => say::no_mean(written.span, value(1.0, 1.0, 0.25)),
        });
    }
    let text = (written.span.start as usize)..(written.span.end as usize);
    let text = library.text.get(text).unwrap_or_default();
    (report.len() == before).then(|| Meet::Formula(text.into(), direct::tape(&exprs, root)))
}
