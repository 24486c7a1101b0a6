//! Degenerate families.
//!
//! Input: a node without bonds, nodes on a line and (in 3D) on a plane, both off all axes and a millionth of a spacing off
//! themselves, and a lattice that moves by a billionth of a spacing or not at all. Every answer must be a finite number, a
//! body at rest has exactly no force; and a nearly flat family that answers far more than a full one is warned of.

use pdlang::ir::Flavour;
use pdlang::oracle::{self, Ball, Oracle, Value};
use pdlang_runtime::body::Body;

use super::ask::{self, Case, largest};
use super::place::Place;
use super::subject::{Subject, TEMPERATURE};
use super::{Level, Verdict, balance, bodies};

const STRAIN: f64 = 1e-3;
/// Forces of a nearly flat family over those of a full one that are worth a warning.
const AMPLIFIED: f64 = 1e4;

pub fn check(subject: &Subject, flavour: Flavour) -> Result<Vec<Verdict>, String> {
    let spacing = subject.spacing();
    let mut verdicts = Vec::new();
    let [full, cloud] = ask::bodies_of(subject, flavour);
    let strained = |body: &Body, strain: f64| bodies::deformation(body, strain, 12);
    let normal = {
        let mut case = Case::new(subject, flavour, cloud.clone())?;
        case.displace(&strained(&cloud, STRAIN));
        largest(case.force().as_flattened())
    };
    let mut worst = 0.0_f64;
    let mut warned = None;
    for (name, body) in degenerate(&cloud, flavour, spacing) {
        let mut case = Case::new(subject, flavour, body.clone())?;
        let u = strained(&body, STRAIN);
        balance::warm(subject, &mut case);
        case.displace(&u);
        let mut answers = [case.force().into_flattened(), case.energy()].concat();
        let force = largest(&answers);
        answers.extend(case.tangent(&u).into_flattened());
        for (_, field, rated) in ask::scalar_fields(subject.law, TEMPERATURE) {
            if rated {
                answers.extend(case.rate(&field.name));
            }
        }
        if !largest(&answers).is_finite() {
            let place = infinite(subject, flavour, &body, &u).or(subject.force_place());
            let verdict = Verdict::new("limits", flavour, Level::Fail).of(name);
            verdicts.push(verdict.blames(place, |definition| {
                format!("{name}: {definition} is no finite number there; a sum that may be empty or flat stands in a denominator")
            }));
        } else if force > AMPLIFIED * normal && normal > 0.0 {
            warned = Some((name, force / normal));
        }
        worst = worst.max(force / normal.max(f64::MIN_POSITIVE));
    }
    if let Some((name, times)) = warned {
        let verdict = Verdict {
            measured: Some(times),
            expected: Some(AMPLIFIED),
            ..Verdict::new("limits", flavour, Level::Warn).of(name)
        };
        verdicts.push(verdict.blames(inverted(subject).or(subject.force_place()), |definition| {
            format!("{name}: {definition} makes forces {times:.0e} times those of a full family: it inverts what is nearly singular")
        }));
    }
    let mut case = Case::new(subject, flavour, full.clone())?;
    let rest = largest(case.force().as_flattened());
    if rest != 0.0 {
        let verdict = Verdict {
            measured: Some(rest),
            expected: Some(0.0),
            ..Verdict::new("limits", flavour, Level::Fail).of("at rest")
        };
        verdicts.push(verdict.blames(subject.force_place(), |definition| {
            format!("a body at rest is pulled by {rest:.1e} N/m^3: {definition} is not zero without displacements")
        }));
    }
    case.displace(&strained(&full, 1e-9));
    let small = case.force().into_flattened();
    if !largest(&small).is_finite() {
        let verdict = Verdict::new("limits", flavour, Level::Fail).of("e -> 0");
        verdicts.push(verdict.blames(subject.force_place(), |definition| {
            format!("{definition} is no finite number at vanishing extensions")
        }));
    }
    if verdicts.is_empty() {
        let pass = Verdict::new("limits", flavour, Level::Pass);
        verdicts.push(pass.says("every answer is finite, and a body at rest has no force"));
    }
    Ok(verdicts)
}

/// Bodies whose families are degenerate.
fn degenerate(like: &Body, flavour: Flavour, spacing: f64) -> Vec<(&'static str, Body)> {
    let dim = flavour.dim();
    let body = |x: Vec<[f64; 3]>| Body {
        volume: vec![like.volume[0]; x.len()],
        x,
        ..like.clone()
    };
    let along = |k: usize, l: usize, off: f64| -> [f64; 3] {
        let (s, t) = (k as f64 * 0.8 * spacing, l as f64 * 0.8 * spacing);
        let tilted = [0.6 * s - 0.48 * t, 0.64 * s + 0.6 * t, 0.48 * s + 0.64 * t];
        let sign = if (k + l).is_multiple_of(2) { off } else { -off };
        let bent = [
            tilted[0] - sign * spacing,
            tilted[1] + sign * spacing * 0.5,
            tilted[2] + sign * spacing,
        ];
        std::array::from_fn(|a| if a < dim { bent[a] } else { 0.0 })
    };
    let line = |off: f64| (0..5).map(|k| along(k, 0, off)).collect::<Vec<_>>();
    let mut list = vec![("a node without bonds", body(vec![[0.0; 3]]))];
    if dim > 1 {
        list.push(("nodes on a line", body(line(0.0))));
        list.push(("nodes almost on a line", body(line(1e-6))));
    }
    if dim > 2 {
        let plane = |off: f64| {
            (0..16)
                .map(|k| along(k / 4, k % 4, off))
                .collect::<Vec<_>>()
        };
        list.push(("nodes on a plane", body(plane(0.0))));
        list.push(("nodes almost on a plane", body(plane(1e-6))));
    }
    list
}

/// The first definition that is no finite number.
fn infinite(subject: &Subject, flavour: Flavour, body: &Body, u: &[[f64; 3]]) -> Option<Place> {
    let nodes = body.x.iter().zip(&body.volume);
    let nodes = nodes
        .map(|(x, v)| oracle::Node {
            position: *x,
            volume: *v,
        })
        .collect();
    let explicit = oracle::Body::within(nodes, subject.horizon);
    let settings = subject.settings(flavour, Ball::Integral { cross: body.cross });
    let oracle = Oracle::new(subject.law, &explicit, &settings).ok()?;
    let mut state = oracle.state();
    state.u = u.to_vec();
    let finite = |v: &Value<f64>| match v {
        Value::Scalar(a) => a.is_finite(),
        Value::Vector(v) => v.iter().all(|c| c.is_finite()),
        Value::Tensor(t) => t.as_flattened().iter().all(|c| c.is_finite()),
        Value::Boolean(_) => true,
    };
    let wrong = subject.definitions().find(|def| {
        let values = oracle.named(&state, &def.name);
        values.is_ok_and(|values| !values.iter().all(finite))
    });
    wrong.and_then(|def| subject.place(def.span))
}

/// The first definition that inverts a tensor.
fn inverted(subject: &Subject) -> Option<Place> {
    use pdlang::ir::{Builtin, ExprKind};
    let inverse = |kind: &ExprKind| matches!(kind, ExprKind::Call(Builtin::Inverse, _));
    let found = subject
        .definitions()
        .find(|def| super::place::contains(subject.law, def.expr, &inverse));
    found.and_then(|def| subject.place(def.span))
}
