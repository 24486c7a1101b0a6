//! PD061: a law that does not give the value that a probe expects.

use crate::diag::Diagnostic;
use crate::probe::Outcome;
use crate::units::Unit;

const CODE: &str = "PD061";

pub(crate) fn failed(outcome: &Outcome) -> Diagnostic {
    let expected = &outcome.expectation;
    let what = format!("the probe `{}` fails: `{}`", outcome.probe, expected.text);
    let label = format!("expected {}", shown(&expected.value, &expected.unit));
    match &outcome.found {
        Err(error) => Diagnostic::error(CODE, format!("{what} has no value"))
            .at(expected.span, label)
            .help(error.to_string()),
        Ok(found) => {
            let message = format!("{what} is {}", shown(found, &expected.unit));
            let off = found.iter().zip(&expected.value);
            let off = off.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let help = match outcome.allowed == 0.0 && expected.value.iter().all(|v| *v == 0.0) {
                true => format!(
                    "zero has no part of itself: say the absolute error, `within 1e-9{}`",
                    bracketed(&expected.unit)
                ),
                false => format!(
                    "off by {off:.3e}, allowed {:.3e}: the derivation, the law or the tolerance is wrong",
                    outcome.allowed
                ),
            };
            Diagnostic::error(CODE, message)
                .at(expected.span, label)
                .help(help)
        }
    }
}

/// A unit as it stands behind a number.
fn bracketed(unit: &Unit) -> String {
    match unit.is_number() {
        true => String::new(),
        false => format!(" [{}]", unit.symbol()),
    }
}

/// `(1.5, 0, 0) N/m^3`, every component to the last digit.
fn shown(values: &[f64], unit: &Unit) -> String {
    let digits: Vec<String> = values.iter().map(|v| number(*v)).collect();
    let unit = match unit.is_number() {
        true => String::new(),
        false => format!(" {}", unit.symbol()),
    };
    match digits.as_slice() {
        [one] => format!("{one}{unit}"),
        _ => format!("({}){unit}", digits.join(", ")),
    }
}

fn number(value: f64) -> String {
    match value.abs() {
        size if size != 0.0 && !(1e-4..1e6).contains(&size) => format!("{value:e}"),
        _ => value.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use crate::check::tests::law;
    use crate::{front, probe};

    fn one_bond(expected: &str) -> String {
        law(&format!(
            "bond t3 = e/x - 1e-3 probe p in bar where K = 1 GPa, delta = 2 mm, area = 1 mm^2 {{
            node a = 0, V = 1 mm^3 node b = 1 mm, V = 1 mm^3, u = 1.0000001 um {expected} }}"
        ))
    }

    fn helps(expected: &str) -> Vec<String> {
        let checked = front::file(&one_bond(expected));
        assert!(!checked.has_errors(), "{:?}", checked.diagnostics);
        let findings = probe::findings(&checked.laws[0]);
        findings.into_iter().map(|f| f.help.unwrap()).collect()
    }

    #[test]
    fn zero_takes_an_absolute_error() {
        for within in ["1e-9", "1e-9 [1]"] {
            let expected = format!("expect t3(a, b) = 0 within {within}");
            assert_eq!(helps(&expected), [""; 0], "{within}");
        }
        let off = helps("expect t3(a, b) = 0 within 1e-11");
        assert!(
            off[0].starts_with("off by 1.000e-10, allowed 1.000e-11"),
            "{off:?}"
        );
        let said = |unit: &str| {
            format!("zero has no part of itself: say the absolute error, `within 1e-9{unit}`")
        };
        assert_eq!(helps("expect t3(a, b) = 0"), [said("")]);
        assert_eq!(helps("expect W(a) = 0 within 1e-9"), [said(" [Pa]")]);
        assert_eq!(helps("expect W(a) = 0 within 1 [GPa]"), [""; 0]);
    }

    #[test]
    fn says_what_was_found_and_where() {
        let text = law(
            "probe p in bar where K = 1 GPa, delta = 2 mm, area = 1 mm^2 {
            node a = 0, V = 1 mm^3 node b = 1 mm, V = 1 mm^3, u = 1 um expect W(a) = 3 Pa }",
        );
        let checked = front::file(&text);
        assert!(!checked.has_errors(), "{:?}", checked.diagnostics);
        let findings = probe::findings(&checked.laws[0]);
        let [finding] = findings.as_slice() else {
            panic!("{findings:?}")
        };
        let span = finding.span();
        assert_eq!(&text[span.start as usize..span.end as usize], "3 Pa");
        assert!(
            finding.is_error()
                && finding
                    .message
                    .starts_with("the probe `p` fails: `W(a)` is 249.99")
        );
    }
}
