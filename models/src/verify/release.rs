//! A crack releases energy.
//!
//! A box of a lattice is expanded in all directions, and half of its bonds are broken there: what is left stores less
//! energy, because a bond that is gone stores none. A law whose sums are over intact bonds and divided by such sums keeps
//! the stiffness of a node whatever it has lost.

use pdlang::ir::{ExprKind, Flavour, Reduction};

use super::ask::{self, Case};
use super::place::Place;
use super::subject::Subject;
use super::{Level, Verdict, bodies, place};

const STRAIN: f64 = 1e-3;
/// Relative change of the energy of a node that is none.
const SAME: f64 = 1e-6;

pub fn check(subject: &Subject, flavour: Flavour) -> Result<Vec<Verdict>, String> {
    let check = "release";
    if !subject.has_energy() {
        return Ok(vec![Verdict::skip(check, flavour, "the law has no energy")]);
    }
    if subject.law.breaks.is_empty() {
        return Ok(vec![Verdict::skip(
            check,
            flavour,
            "no bond of the law breaks",
        )]);
    }
    let [body, _] = ask::bodies_of(subject, flavour);
    let u: Vec<[f64; 3]> = body.x.iter().map(|x| x.map(|c| STRAIN * c)).collect();
    let mut case = Case::new(subject, flavour, body.clone())?;
    case.displace(&u);
    case.force();
    let whole = case.energy();
    case.cut(&bodies::half_broken(&body, subject.horizon, 3));
    case.force();
    let left = case.energy();
    let same = whole
        .iter()
        .zip(&left)
        .filter(|(a, b)| (*b / *a - 1.0).abs() < SAME)
        .count();
    let [before, after] =
        [whole, left].map(|w| w.iter().zip(&body.volume).map(|(w, v)| w * v).sum::<f64>());
    let share = after / before;
    let level = match () {
        () if 2 * same > body.x.len() => Level::Fail,
        () if share > 1.0 => Level::Warn,
        () => Level::Pass,
    };
    let verdict = Verdict {
        measured: Some(share),
        expected: Some(1.0),
        ..Verdict::new(check, flavour, level)
    };
    let place = match level {
        Level::Fail => normalised(subject).or(subject.energy_place()),
        _ => subject.energy_place(),
    };
    Ok(vec![verdict.blames(place, |name| match level {
        Level::Fail => format!(
            "with half of its bonds broken a node keeps its energy: {name} is a sum over intact bonds, where `sum0` is over all that there ever were"
        ),
        _ => format!("with half of its bonds broken a body has {share:.2} of its energy, by {name}: at these parameters a term of it is negative"),
    })])
}

/// The first definition with a sum over intact bonds that knows of no displacement.
fn normalised(subject: &Subject) -> Option<Place> {
    let law = subject.law;
    let holds = |expr| {
        let still = |kind: &ExprKind| match kind {
            ExprKind::Reduce(Reduction::Sum, _, a) => !place::moves(law, *a),
            _ => false,
        };
        place::contains(law, expr, &still)
    };
    let definition = subject.definitions().find(|def| holds(def.expr));
    definition.and_then(|def| subject.place(def.span))
}
