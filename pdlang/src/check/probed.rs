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
            Diagnostic::error(CODE, message)
                .at(expected.span, label)
                .help(format!(
                    "off by {off:.3e}, allowed {:.3e}: the derivation, the law or the tolerance is wrong",
                    outcome.allowed
                ))
        }
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
