//! Numbers with units, as scenes and parameters write them: `14.9 GPa`, `0.5 mm`, `2200 kg/m^3`, `inf`.

use crate::ast;
use crate::diag::Diagnostic;
use crate::parse;
use crate::units::{self, Unit};

/// A number with a unit.
#[derive(Clone, PartialEq, Debug)]
pub struct Quantity {
    /// SI value.
    pub value: f64,
    pub unit: Unit,
    /// False for `5`: the unit was left out.
    pub has_unit: bool,
}

impl Quantity {
    /// Zero and infinity need no unit.
    pub fn fits(&self, unit: &Unit) -> bool {
        self.unit == *unit || !self.has_unit && (self.value == 0.0 || self.value.is_infinite())
    }
}

/// Reads a number with its unit.
///
/// # Errors
/// Findings that point into `text`.
pub fn parse(text: &str) -> Result<Quantity, Vec<Diagnostic>> {
    let written = parse::quantity(text)?;
    let mut report = Vec::new();
    evaluate(&written, &mut report).ok_or(report)
}

pub(crate) fn evaluate(written: &ast::Quantity, report: &mut Vec<Diagnostic>) -> Option<Quantity> {
    match &written.unit {
        None => Some(Quantity {
            value: written.value,
            unit: Unit::NUMBER,
            has_unit: false,
        }),
        Some(unit) => {
            let (factor, unit) = units::evaluate(unit, report)?;
            Some(Quantity {
                value: units::scale(written.value, factor),
                unit,
                has_unit: true,
            })
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_values_in_si() {
        let modulus = parse("14.9 GPa").unwrap();
        assert!((modulus.value - 14.9e9).abs() < 1e-3);
        assert_eq!(modulus.unit, Unit::energy_density());
        assert_eq!(parse("-3").unwrap().value, -3.0);
        assert_eq!(parse("inf").unwrap().value, f64::INFINITY);
        assert!(parse("0").unwrap().fits(&Unit::length()));
        assert!(!parse("1").unwrap().fits(&Unit::length()));
        assert_eq!(parse("2200 kg/m^3").unwrap().unit.symbol(), "kg/m^3");
        assert_eq!(parse("5 mm^2").unwrap().value, 5e-6);
        assert_eq!(parse("0.5 mm").unwrap().value, 5e-4);
    }
}
