//! Parameters of laws and of influence functions: unit, bounds, default.

use crate::ast::{self, Name};
use crate::check::{self, bounds};
use crate::diag::Diagnostic;
use crate::ir::{Bound, CompareOp, Meet, Param};
use crate::quantity;
use crate::span::Span;
use crate::units::{self, Unit};

/// `None` when something is wrong, and reported.
pub(crate) fn param(written: &ast::Param, report: &mut Vec<Diagnostic>) -> Option<Param> {
    let unit = units::of_kind(&written.kind, report)?;
    let name = &written.name;
    let mut interval = Interval {
        name,
        unit: &unit,
        lower: None,
        upper: None,
        last: name.span,
    };
    let mut good = true;
    for bound in &written.bounds {
        good &= interval.restrict(bound, report).is_some();
    }
    let (lower, upper, last) = (interval.lower, interval.upper, interval.last);
    if good && bounds::is_empty(lower, upper) {
        report.push(bounds::empty(name, last));
        good = false;
    }
    let default = match &written.default {
        None => None,
        Some(default) => Some(value(
            &format!("the default of `{}`", name.text),
            default,
            &unit,
            report,
        )?),
    };
    let chosen = default.zip(written.default.as_ref()).filter(|_| good);
    if let Some((_, default)) = chosen.filter(|(value, _)| !bounds::contains(lower, upper, *value))
    {
        report.push(bounds::outside(name, default.span, last));
        good = false;
    }
    let doc = written
        .doc
        .as_ref()
        .map(|doc| doc.text.clone())
        .unwrap_or_default();
    good.then(|| Param {
        name: name.text.clone(),
        doc,
        unit: unit.clone(),
        lower,
        upper,
        default,
        meet: Meet::default(),
        span: name.span,
    })
}

/// SI value of a quantity that must have this unit; zero and infinity need none.
pub(crate) fn value(
    what: &str,
    written: &ast::Quantity,
    unit: &Unit,
    report: &mut Vec<Diagnostic>,
) -> Option<f64> {
    let found = quantity::evaluate(written, report)?;
    if found.fits(unit) {
        return Some(found.value);
    }
    let symbol = found.has_unit.then(|| found.unit.describe(&[]));
    report.push(check::quantities::wrong_unit(
        what,
        written.span,
        symbol.as_deref(),
        &unit.describe(&[]),
    ));
    None
}

struct Interval<'a> {
    name: &'a Name,
    unit: &'a Unit,
    lower: Option<Bound>,
    upper: Option<Bound>,
    /// The bound read last, which a finding points at.
    last: Span,
}

impl Interval<'_> {
    fn restrict(&mut self, bound: &ast::Bound, report: &mut Vec<Diagnostic>) -> Option<()> {
        let what = format!("a bound of `{}`", self.name.text);
        match bound {
            ast::Bound::Side(op, quantity) => {
                self.last = quantity.span;
                let value = value(&what, quantity, self.unit, report)?;
                let inclusive = matches!(op, CompareOp::Le | CompareOp::Ge);
                match op {
                    CompareOp::Lt | CompareOp::Le => self.below(Bound { value, inclusive }),
                    CompareOp::Gt | CompareOp::Ge => self.above(Bound { value, inclusive }),
                }
            }
            ast::Bound::Interval {
                lower,
                lower_in,
                upper,
                upper_in,
                span,
            } => {
                self.last = *span;
                let ends = (
                    value(&what, lower, self.unit, report),
                    value(&what, upper, self.unit, report),
                );
                self.above(Bound {
                    value: ends.0?,
                    inclusive: *lower_in,
                });
                self.below(Bound {
                    value: ends.1?,
                    inclusive: *upper_in,
                });
            }
        }
        Some(())
    }

    fn above(&mut self, bound: Bound) {
        let tighter = self.lower.is_none_or(|old| {
            bound.value > old.value || bound.value == old.value && !bound.inclusive
        });
        self.lower = if tighter { Some(bound) } else { self.lower };
    }

    fn below(&mut self, bound: Bound) {
        let tighter = self.upper.is_none_or(|old| {
            bound.value < old.value || bound.value == old.value && !bound.inclusive
        });
        self.upper = if tighter { Some(bound) } else { self.upper };
    }
}
