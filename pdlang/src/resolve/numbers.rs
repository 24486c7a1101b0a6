//! Scalar expressions of values that are known: what a probe sets and expects.

use crate::ast;
use crate::check::{probes, quantities};
use crate::diag::Diagnostic;
use crate::ir::{Flavour, Shape};
use crate::probe::number::Known;
use crate::resolve::elaborate::{Context, Elaborator};
use crate::resolve::library::Library;
use crate::units::Unit;

/// Values by name. A name that is set again hides the value before.
pub(crate) struct Numbers<'a> {
    pub library: &'a Library<'a>,
    flavour: Flavour,
    names: Vec<(String, Unit)>,
    values: Vec<f64>,
}

impl<'a> Numbers<'a> {
    pub(crate) fn new(library: &'a Library<'a>, flavour: Flavour) -> Self {
        Numbers {
            library,
            flavour,
            names: Vec::new(),
            values: Vec::new(),
        }
    }

    pub(crate) fn add(&mut self, name: &str, value: f64, unit: Unit) {
        match self.names.iter().position(|(known, _)| known == name) {
            Some(k) => (self.names[k].1, self.values[k]) = (unit, value),
            None => {
                self.names.push((name.into(), unit));
                self.values.push(value);
            }
        }
    }

    /// As `add`, unless the name has a value.
    pub(crate) fn add_new(&mut self, name: &str, value: f64, unit: &Unit) {
        if self.names.iter().all(|(known, _)| known != name) {
            self.add(name, value, unit.clone());
        }
    }

    /// SI value and unit of an expression.
    pub(crate) fn number(
        &self,
        written: &ast::Expr,
        report: &mut Vec<Diagnostic>,
    ) -> Option<(f64, Unit)> {
        self.evaluate(written, None, report)
    }

    /// SI value of an expression in this unit; zero and infinity fit any.
    pub(crate) fn of_unit(
        &self,
        written: &ast::Expr,
        unit: &Unit,
        report: &mut Vec<Diagnostic>,
    ) -> Option<f64> {
        Some(self.evaluate(written, Some(unit), report)?.0)
    }

    fn evaluate(
        &self,
        written: &ast::Expr,
        unit: Option<&Unit>,
        report: &mut Vec<Diagnostic>,
    ) -> Option<(f64, Unit)> {
        let mut elaborator = Elaborator::new(self.library, Context::Scene, report);
        let names = self
            .names
            .iter()
            .map(|(name, unit)| (name.as_str(), unit.clone()));
        elaborator.add_variables(names);
        let root = elaborator.elaborate(written)?;
        if elaborator.expr(root).shape != Shape::Scalar {
            elaborator.complain(probes::not_a_scalar(written.span));
            return None;
        }
        let found = elaborator.expr(root).unit.clone();
        if let Some(unit) = unit.filter(|unit| found != **unit && !elaborator.facts(root).any_unit)
        {
            let (found, unit) = (elaborator.describe(&found), elaborator.describe(unit));
            elaborator.complain(quantities::wrong_unit(
                "this value",
                written.span,
                Some(&found),
                &unit,
            ));
            return None;
        }
        let known = Known {
            exprs: &elaborator.exprs,
            values: &self.values,
            flavour: self.flavour,
        };
        match known.number(root).filter(|value| !value.is_nan()) {
            Some(value) => Some((value, found)),
            None => {
                report.push(quantities::not_a_number("this value", written.span));
                None
            }
        }
    }
}
