//! `[time]`: the end of a run, its step, and whether it may leave out what does not change.

use super::problem::Problem;
use super::section::Section;
use crate::language::dimension::{NUMBER, TIME};
use crate::simulate::{End, StepRule};

/// Both rules, and whether chunks may sleep.
pub(super) fn read(section: Section<'_>) -> Option<(End, StepRule, bool)> {
    let end = end(&section);
    let step = step(&section);
    let sleep = section.flag("sleep").unwrap_or(true);
    section.finish();
    Some((end?, step?, sleep))
}

fn end(section: &Section<'_>) -> Option<End> {
    let steps = section.count("steps", 0);
    let until = section.positive("until", TIME);
    if section.value("steps").is_some() && section.value("until").is_some() {
        return both(section, "steps", "until");
    }
    let until = until.map(|u| End::Time(u.value));
    let end = steps.map(End::Steps).or(until);
    match (section.value("until"), end) {
        (Some(_), end) => end,
        (None, end) => section.require("steps", end, "1000, or until = \"100 us\""),
    }
}

fn step(section: &Section<'_>) -> Option<StepRule> {
    let dt = section.positive("dt", TIME);
    let safety = section.positive("safety", NUMBER);
    match (section.value("dt"), section.value("safety")) {
        (Some(_), Some(_)) => both(section, "dt", "safety"),
        (Some(_), None) => dt.map(|dt| StepRule::Fixed(dt.value)),
        (None, Some(_)) => {
            let safety = safety?;
            if safety.value <= 1.0 {
                return Some(StepRule::Stable {
                    safety: safety.value,
                });
            }
            let problem = Problem::new("`safety` is a share of the stable time step")
                .at(safety.span, "expected at most 1");
            section.reader.complain(problem);
            None
        }
        (None, None) => Some(StepRule::default()),
    }
}

fn both<T>(section: &Section<'_>, a: &str, b: &str) -> Option<T> {
    let spans = [a, b].map(|k| {
        section
            .entry(k)
            .map(|e| e.key_span.clone())
            .unwrap_or_default()
    });
    let [first, second] = spans;
    let problem = Problem::new(format!("`{a}` and `{b}` say the same thing twice"))
        .at(second, "give one of the two")
        .at(first, "the other one");
    section.reader.complain(problem);
    None
}
