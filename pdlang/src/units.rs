//! Units of measurement: exponents of the seven SI base units and of the opaque units of influence functions.

use crate::ast::{Kind, UnitExpr};
use crate::check;
use crate::diag::Diagnostic;
use crate::parse;

/// Product of powers. Exponents are in halves, so that square roots stay exact.
#[derive(Clone, PartialEq, Eq, Hash, Debug, Default)]
pub struct Unit {
    /// Metre, kilogram, second, ampere, kelvin, mole, candela; twice the exponent.
    pub base: [i16; 7],
    /// (influence function of the law, twice the exponent), sorted, no zero exponents.
    pub opaque: Vec<(u32, i16)>,
}

const BASE_NAMES: [&str; 7] = ["m", "kg", "s", "A", "K", "mol", "cd"];

impl Unit {
    /// The unit of a pure number.
    pub const NUMBER: Unit = Unit {
        base: [0; 7],
        opaque: Vec::new(),
    };

    /// From whole exponents of metre, kilogram and second.
    pub const fn mechanical(metre: i16, kilogram: i16, second: i16) -> Unit {
        Unit {
            base: [2 * metre, 2 * kilogram, 2 * second, 0, 0, 0, 0],
            opaque: Vec::new(),
        }
    }

    pub const fn length() -> Unit {
        Unit::mechanical(1, 0, 0)
    }

    pub const fn volume() -> Unit {
        Unit::mechanical(3, 0, 0)
    }

    pub const fn velocity() -> Unit {
        Unit::mechanical(1, 0, -1)
    }

    pub const fn time() -> Unit {
        Unit::mechanical(0, 0, 1)
    }

    /// J/m^3 = Pa.
    pub const fn energy_density() -> Unit {
        Unit::mechanical(-1, 1, -2)
    }

    /// N/m^3, the unit of what a node feels.
    pub const fn force_density() -> Unit {
        Unit::mechanical(-2, 1, -2)
    }

    /// N/m^6, the unit of a force state and of a pair force.
    pub const fn bond_force() -> Unit {
        Unit::mechanical(-5, 1, -2)
    }

    /// The unit of influence function number `k` of a law, about which nothing is known.
    pub fn opaque(k: u32) -> Unit {
        Unit {
            opaque: vec![(k, 2)],
            ..Unit::NUMBER
        }
    }

    pub fn is_number(&self) -> bool {
        self == &Unit::NUMBER
    }

    /// Without the units of influence functions.
    pub fn without_opaque(&self) -> Unit {
        Unit {
            base: self.base,
            opaque: Vec::new(),
        }
    }

    pub fn times(&self, other: &Unit) -> Unit {
        let mut product = self.clone();
        for (k, exponent) in product.base.iter_mut().zip(other.base) {
            *k = k.saturating_add(exponent);
        }
        for &(k, exponent) in &other.opaque {
            product.add_opaque(k, exponent);
        }
        product
    }

    pub fn per(&self, other: &Unit) -> Unit {
        self.times(&other.inverse())
    }

    pub fn inverse(&self) -> Unit {
        Unit {
            base: self.base.map(i16::saturating_neg),
            opaque: self
                .opaque
                .iter()
                .map(|&(k, n)| (k, n.saturating_neg()))
                .collect(),
        }
    }

    /// `None` where an exponent would not be a multiple of one half, or is absurdly large.
    pub fn power(&self, exponent: f64) -> Option<Unit> {
        let scale = |n: i16| {
            let scaled = f64::from(n) * exponent;
            ((scaled - scaled.round()).abs() < 1e-9 && scaled.abs() < 1000.0)
                .then(|| scaled.round() as i16)
        };
        let mut result = Unit::NUMBER;
        for (to, &from) in result.base.iter_mut().zip(&self.base) {
            *to = scale(from)?;
        }
        for &(k, n) in &self.opaque {
            result.add_opaque(k, scale(n)?);
        }
        Some(result)
    }

    fn add_opaque(&mut self, k: u32, exponent: i16) {
        match self.opaque.binary_search_by_key(&k, |entry| entry.0) {
            Ok(at) => {
                self.opaque[at].1 = self.opaque[at].1.saturating_add(exponent);
                if self.opaque[at].1 == 0 {
                    self.opaque.remove(at);
                }
            }
            Err(at) if exponent != 0 => self.opaque.insert(at, (k, exponent)),
            Err(_) => {}
        }
    }

    /// As a user would write it: `"Pa"`, `"N/m^6"`, `"kg m s^-3 K^-1"`; empty for a number. Without
    /// opaque units, [`parse`] reads it back.
    pub fn symbol(&self) -> String {
        if let Some((_, symbol, _)) = KINDS
            .iter()
            .find(|(_, symbol, base)| !symbol.is_empty() && doubled(base) == self.base)
        {
            return (*symbol).to_string();
        }
        match self.base {
            [metre, 2, -4, 0, 0, 0, 0] if metre % 2 == 0 => per_length("N", metre / 2 - 1),
            base => product(&base),
        }
    }

    /// [`Unit::symbol`], with opaque units as `[omega]`, and in words for a number.
    pub fn describe(&self, influences: &[String]) -> String {
        let mut parts: Vec<String> = Vec::new();
        if self.base != [0; 7] {
            parts.push(self.symbol());
        }
        for &(k, exponent) in &self.opaque {
            let name = influences
                .get(k as usize)
                .map_or("influence", String::as_str);
            parts.push(raised(&format!("[{name}]"), exponent));
        }
        if parts.is_empty() {
            "a pure number".into()
        } else {
            parts.join(" ")
        }
    }
}

fn doubled(base: &[i16; 7]) -> [i16; 7] {
    base.map(|n| 2 * n)
}

fn per_length(force: &str, metres: i16) -> String {
    match metres {
        0 => force.into(),
        1 => format!("{force} m"),
        -1 => format!("{force}/m"),
        n if n > 0 => format!("{force} m^{n}"),
        n => format!("{force}/m^{}", -n),
    }
}

fn product(base: &[i16; 7]) -> String {
    let factors = BASE_NAMES
        .iter()
        .zip(base)
        .filter(|(_, exponent)| **exponent != 0);
    factors
        .map(|(name, exponent)| raised(name, *exponent))
        .collect::<Vec<_>>()
        .join(" ")
}

fn raised(name: &str, halves: i16) -> String {
    match halves {
        2 => name.into(),
        n if n % 2 == 0 => format!("{name}^{}", n / 2),
        n => format!("{name}^{}", f64::from(n) / 2.0),
    }
}

/// The words for units.
#[cfg(test)]
pub(crate) fn kind_names() -> impl Iterator<Item = &'static str> {
    KINDS.iter().map(|kind| kind.0)
}

/// Named kinds: name, preferred symbol, exponents of the base units.
const KINDS: &[(&str, &str, [i16; 7])] = &[
    ("number", "", [0, 0, 0, 0, 0, 0, 0]),
    ("angle", "", [0, 0, 0, 0, 0, 0, 0]),
    ("length", "m", [1, 0, 0, 0, 0, 0, 0]),
    ("area", "m^2", [2, 0, 0, 0, 0, 0, 0]),
    ("volume", "m^3", [3, 0, 0, 0, 0, 0, 0]),
    ("mass", "kg", [0, 1, 0, 0, 0, 0, 0]),
    ("time", "s", [0, 0, 1, 0, 0, 0, 0]),
    ("current", "A", [0, 0, 0, 1, 0, 0, 0]),
    ("temperature", "K", [0, 0, 0, 0, 1, 0, 0]),
    ("frequency", "1/s", [0, 0, -1, 0, 0, 0, 0]),
    ("velocity", "m/s", [1, 0, -1, 0, 0, 0, 0]),
    ("acceleration", "m/s^2", [1, 0, -2, 0, 0, 0, 0]),
    ("density", "kg/m^3", [-3, 1, 0, 0, 0, 0, 0]),
    ("force", "N", [1, 1, -2, 0, 0, 0, 0]),
    ("force_density", "N/m^3", [-2, 1, -2, 0, 0, 0, 0]),
    ("pressure", "Pa", [-1, 1, -2, 0, 0, 0, 0]),
    ("stress", "", [-1, 1, -2, 0, 0, 0, 0]),
    ("energy", "J", [2, 1, -2, 0, 0, 0, 0]),
    ("energy_density", "", [-1, 1, -2, 0, 0, 0, 0]),
    ("energy_release_rate", "J/m^2", [0, 1, -2, 0, 0, 0, 0]),
    ("power", "W", [2, 1, -3, 0, 0, 0, 0]),
    ("viscosity", "Pa s", [-1, 1, -1, 0, 0, 0, 0]),
    ("micromodulus", "N/m^6", [-5, 1, -2, 0, 0, 0, 0]),
    ("conductivity", "W/(m K)", [1, 1, -3, 0, -1, 0, 0]),
    ("specific_heat", "J/(kg K)", [2, 0, -2, 0, -1, 0, 0]),
    ("heat_source", "W/m^3", [-1, 1, -3, 0, 0, 0, 0]),
    ("heating_rate", "K/s", [0, 0, -1, 0, 1, 0, 0]),
    ("thermal_expansion", "1/K", [0, 0, 0, 0, -1, 0, 0]),
    ("diffusivity", "m^2/s", [2, 0, -1, 0, 0, 0, 0]),
];

/// Units with a name: symbol, factor to SI, exponents, and whether SI prefixes apply.
const UNITS: &[(&str, f64, [i16; 7], bool)] = &[
    ("m", 1.0, [1, 0, 0, 0, 0, 0, 0], true),
    ("g", 1e-3, [0, 1, 0, 0, 0, 0, 0], true),
    ("s", 1.0, [0, 0, 1, 0, 0, 0, 0], true),
    ("A", 1.0, [0, 0, 0, 1, 0, 0, 0], true),
    ("K", 1.0, [0, 0, 0, 0, 1, 0, 0], true),
    ("mol", 1.0, [0, 0, 0, 0, 0, 1, 0], true),
    ("cd", 1.0, [0, 0, 0, 0, 0, 0, 1], false),
    ("Hz", 1.0, [0, 0, -1, 0, 0, 0, 0], true),
    ("N", 1.0, [1, 1, -2, 0, 0, 0, 0], true),
    ("Pa", 1.0, [-1, 1, -2, 0, 0, 0, 0], true),
    ("J", 1.0, [2, 1, -2, 0, 0, 0, 0], true),
    ("W", 1.0, [2, 1, -3, 0, 0, 0, 0], true),
    ("C", 1.0, [0, 0, 1, 1, 0, 0, 0], true),
    ("V", 1.0, [2, 1, -3, -1, 0, 0, 0], true),
    ("ohm", 1.0, [2, 1, -3, -2, 0, 0, 0], true),
    ("t", 1e3, [0, 1, 0, 0, 0, 0, 0], false),
    ("rad", 1.0, [0; 7], true),
    ("deg", std::f64::consts::PI / 180.0, [0; 7], false),
    ("°", std::f64::consts::PI / 180.0, [0; 7], false),
    ("%", 1e-2, [0; 7], false),
];

const PREFIXES: &[(&str, f64)] = &[
    ("p", 1e-12),
    ("n", 1e-9),
    ("u", 1e-6),
    ("µ", 1e-6),
    ("μ", 1e-6),
    ("m", 1e-3),
    ("c", 1e-2),
    ("d", 1e-1),
    ("k", 1e3),
    ("M", 1e6),
    ("G", 1e9),
    ("T", 1e12),
];

/// A named unit, with or without a prefix: factor to SI and unit.
fn named(symbol: &str) -> Option<(f64, Unit)> {
    let exact = |name: &str| UNITS.iter().find(|unit| unit.0 == name);
    if let Some((_, factor, base, _)) = exact(symbol) {
        return Some((
            *factor,
            Unit {
                base: doubled(base),
                opaque: Vec::new(),
            },
        ));
    }
    let (scale, unit) = PREFIXES.iter().find_map(|(prefix, scale)| {
        let unit = exact(symbol.strip_prefix(prefix)?)?;
        unit.3.then_some((*scale, unit))
    })?;
    Some((
        scale * unit.1,
        Unit {
            base: doubled(&unit.2),
            opaque: Vec::new(),
        },
    ))
}

/// `value` times `factor`; a factor such as 1e-3 divides by 1000, which is rounded once instead of twice.
pub(crate) fn scale(value: f64, factor: f64) -> f64 {
    let divisor = (1.0 / factor).round();
    if factor < 1.0 && divisor * factor == 1.0 {
        value / divisor
    } else {
        value * factor
    }
}

fn integer_power(factor: f64, power: f64) -> f64 {
    if power.fract() == 0.0 && power.abs() < 100.0 {
        factor.powi(power as i32)
    } else {
        factor.powf(power)
    }
}

/// Names a user may have meant, for "did you mean".
pub(crate) fn known_units() -> impl Iterator<Item = String> {
    let prefixed = UNITS
        .iter()
        .filter(|unit| unit.3)
        .flat_map(|unit| PREFIXES.iter().map(move |p| format!("{}{}", p.0, unit.0)));
    UNITS.iter().map(|unit| unit.0.to_string()).chain(prefixed)
}

pub(crate) fn known_kinds() -> impl Iterator<Item = &'static str> {
    KINDS.iter().map(|kind| kind.0)
}

/// Factor to SI and unit of a written product of units.
pub(crate) fn evaluate(written: &UnitExpr, report: &mut Vec<Diagnostic>) -> Option<(f64, Unit)> {
    let mut result = (1.0, Unit::NUMBER);
    let mut known = true;
    for (name, power) in &written.factors {
        match named(&name.text)
            .and_then(|(factor, unit)| Some((integer_power(factor, *power), unit.power(*power)?)))
        {
            Some((factor, unit)) => result = (result.0 * factor, result.1.times(&unit)),
            None => {
                known = false;
                report.push(check::units::unknown_unit(name));
            }
        }
    }
    known.then_some(result)
}

/// Unit of a kind, named or in brackets. The factor of `[MPa]` has no meaning: values state their own.
pub(crate) fn of_kind(kind: &Kind, report: &mut Vec<Diagnostic>) -> Option<Unit> {
    match kind {
        Kind::Unit(written) => Some(evaluate(written, report)?.1),
        Kind::Named(name) => {
            let known = named_kind(&name.text);
            if known.is_none() {
                report.push(check::units::unknown_kind(name));
            }
            known
        }
    }
}

/// The unit of a kind by its word, `pressure`.
pub(crate) fn named_kind(name: &str) -> Option<Unit> {
    let (_, _, base) = KINDS.iter().find(|known| known.0 == name)?;
    Some(Unit {
        base: doubled(base),
        opaque: Vec::new(),
    })
}

/// Reads a unit such as `"GPa"`, `"kg/m^3"`, `"W/(m K)"`: factor to SI, and unit. Empty is a number.
///
/// # Errors
/// Findings that point into `text`.
pub fn parse(text: &str) -> Result<(f64, Unit), Vec<Diagnostic>> {
    if text.trim().is_empty() {
        return Ok((1.0, Unit::NUMBER));
    }
    let written = parse::unit(text)?;
    let mut report = Vec::new();
    evaluate(&written, &mut report).ok_or(report)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_prefixes_products_and_powers() {
        let cases = [
            ("GPa", 1e9, [-1, 1, -2, 0]),
            ("mm", 1e-3, [1, 0, 0, 0]),
            ("m", 1.0, [1, 0, 0, 0]),
            ("kg/m^3", 1.0, [-3, 1, 0, 0]),
            ("kg m^-3", 1.0, [-3, 1, 0, 0]),
            ("J/m²", 1.0, [0, 1, -2, 0]),
            ("W/(m K)", 1.0, [1, 1, -3, -1]),
            ("1/s", 1.0, [0, 0, -1, 0]),
            ("t", 1e3, [0, 1, 0, 0]),
            ("%", 1e-2, [0, 0, 0, 0]),
            ("", 1.0, [0, 0, 0, 0]),
        ];
        for (text, factor, [m, kg, s, k]) in cases {
            let (found, unit) = parse(text).unwrap();
            assert!((found / factor - 1.0).abs() < 1e-15, "{text}: {found}");
            assert_eq!(unit.base, [2 * m, 2 * kg, 2 * s, 0, 2 * k, 0, 0], "{text}");
        }
    }

    #[test]
    fn symbols_read_back() {
        for text in [
            "Pa",
            "N/m^6",
            "W/(m K)",
            "kg/m^3",
            "J/m^2",
            "m^2",
            "1/s",
            "kg m s^-3 A^-1",
            "Pa m^0.5",
        ] {
            let (factor, unit) = parse(text).unwrap();
            assert_eq!(
                (factor, &unit),
                (1.0, &parse(&unit.symbol()).unwrap().1),
                "{text} -> {}",
                unit.symbol()
            );
        }
        assert_eq!(parse("kg m^-1 s^-2").unwrap().1.symbol(), "Pa");
        assert_eq!(parse("N/m^6").unwrap().1.symbol(), "N/m^6");
    }

    #[test]
    fn powers_stay_exact_or_fail() {
        let area = parse("m^2").unwrap().1;
        assert_eq!(area.power(0.5), Some(Unit::length()));
        assert_eq!(area.power(0.3), None);
        assert_eq!(
            Unit::opaque(1).times(&Unit::opaque(1).inverse()),
            Unit::NUMBER
        );
    }

    #[test]
    fn unknown_units_are_errors() {
        assert_eq!(parse("GPA").unwrap_err()[0].code, "PD011");
        assert_eq!(parse("kg/").unwrap_err()[0].code, "PD001");
    }
}
