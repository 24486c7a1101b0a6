//! What is known of a law without a body: units of its outputs, and its probes.

use pdlang::ir::Response;
use pdlang::probe;

use super::place::expr_of;
use super::subject::Subject;
use super::{Level, Verdict};

pub fn check(subject: &Subject) -> Vec<Verdict> {
    let mut verdicts = vec![units(subject)];
    verdicts.extend(probes(subject));
    verdicts
}

/// The compiler has refused every other unit.
fn units(subject: &Subject) -> Verdict {
    let law = subject.law;
    let one = |r: &Response| {
        let unit = law.exprs[expr_of(r).index()].unit.symbol();
        match r {
            Response::Energy(_) => format!("an energy density in {unit}"),
            Response::Pair(..) => format!("a pair force in {unit}"),
            Response::State(..) => format!("a force state in {unit}"),
            Response::Force(_) => format!("a force density in {unit}"),
            Response::Rate(f, _) => format!("a rate of {} in {unit}", law.fields[f.index()].name),
        }
    };
    let outputs: Vec<String> = law.responses.iter().map(one).collect();
    Verdict {
        flavour: None,
        ..Verdict::new("text", law.flavours[0], Level::Pass)
    }
    .says(format!("the law answers {}", outputs.join(", ")))
}

fn probes(subject: &Subject) -> Vec<Verdict> {
    let outcomes = probe::run(subject.law);
    if outcomes.is_empty() {
        let none = Verdict::skip("probes", subject.law.flavours[0], "the law has no probe");
        return vec![Verdict {
            flavour: None,
            ..none
        }];
    }
    let flavour = |name: &str| {
        let found = subject.law.probes.iter().find(|p| p.name == name);
        found.map(|p| p.flavour)
    };
    let one = |outcome: &probe::Outcome| {
        let expectation = &outcome.expectation;
        let level = if outcome.holds() {
            Level::Pass
        } else {
            Level::Fail
        };
        let list = |values: &[f64]| {
            let shown: Vec<String> = values.iter().map(|v| format!("{v:.6e}")).collect();
            shown.join(", ")
        };
        let single = |values: &[f64]| if let [one] = values { Some(*one) } else { None };
        let verdict = Verdict {
            flavour: flavour(&outcome.probe),
            measured: outcome.found.as_ref().ok().and_then(|v| single(v)),
            expected: single(&expectation.value),
            ..Verdict::new("probes", subject.law.flavours[0], level)
        };
        let place = super::place::of_span(subject.text, expectation.span);
        let verdict = verdict.of(format!("{}: {}", outcome.probe, expectation.text));
        match &outcome.found {
            Ok(found) => verdict.blames(place, |_| {
                let (found, expected) = (list(found), list(&expectation.value));
                format!(
                    "`{}` is {found}, where the law expects {expected}",
                    expectation.text
                )
            }),
            Err(error) => verdict.blames(place, |_| error.to_string()),
        }
    };
    outcomes.iter().map(one).collect()
}
