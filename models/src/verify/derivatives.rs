//! Energy, force and tangent belong together.
//!
//! On a lattice with holes and a cloud, whole and with half of the bonds broken, at strains from 1e-4 to 0.1: the force is
//! minus the slope of the energy and the tangent the slope of the force, along random displacements by central
//! differences; and the tangent is symmetric in the inner product of the volumes. Where a law has a corner, as `max` has, a
//! difference across it is no slope: what is wrong must be wrong along three directions.

use pdlang::ir::{ExprKind, Flavour};
use pdlang_runtime::body::Body;

use super::ask::{self, Case, largest, relative};
use super::place::{contains, expr_of};
use super::subject::Subject;
use super::{Level, Verdict, balance, bodies};

const STRAINS: [f64; 3] = [1e-4, 1e-2, 1e-1];
/// Step of the differences, as part of the strain.
const STEP: f64 = 1e-4;
const SLOPE: f64 = 1e-5;
const SYMMETRIC: f64 = 1e-10;
const TRIES: u64 = 3;

/// The worst of each.
#[derive(Default)]
struct Worst {
    gradient: (f64, f64),
    tangent: (f64, f64),
    skew: f64,
}

pub fn check(subject: &Subject, flavour: Flavour) -> Result<Vec<Verdict>, String> {
    const CHECKS: [&str; 3] = ["gradient", "tangent", "symmetry"];
    if !subject.has_force() {
        let skip = |check| Verdict::skip(check, flavour, "the law has no force");
        return Ok(CHECKS.map(skip).to_vec());
    }
    let mut worst = Worst::default();
    for body in ask::bodies_of(subject, flavour) {
        for half in [false, true] {
            let mut case = Case::new(subject, flavour, body.clone())?;
            if half {
                case.cut(&bodies::half_broken(&body, subject.horizon, 7));
            }
            balance::warm(subject, &mut case);
            for strain in STRAINS {
                compare(&mut case, &body, strain, &mut worst);
            }
        }
    }
    let place = subject.force_place();
    let gradient = match subject.has_energy() && alone(subject) {
        true => {
            let (error, strain) = worst.gradient;
            Verdict::error(CHECKS[0], flavour, error, SLOPE).blames(place.clone(), |name| {
                format!("the force is not the slope of {name} at a strain of {strain:e}: the energy jumps there, or is no function of the displacements")
            })
        }
        false if subject.has_energy() => Verdict::skip(
            CHECKS[0],
            flavour,
            "the law adds forces to those of its energy",
        ),
        false => Verdict::skip(CHECKS[0], flavour, "the law has no energy"),
    };
    let (error, strain) = worst.tangent;
    let tangent = Verdict::error(CHECKS[1], flavour, error, SLOPE).blames(place.clone(), |name| {
        format!("the tangent is not the slope of the force of {name} at a strain of {strain:e}: the force jumps there")
    });
    let mut symmetry = Verdict::error(CHECKS[2], flavour, worst.skew, SYMMETRIC);
    let remembers = subject.law.responses.iter().any(|r| {
        let memory = |kind: &ExprKind| matches!(kind, ExprKind::History(_) | ExprKind::Velocity);
        contains(subject.law, expr_of(r), &memory)
    });
    if symmetry.level == Level::Fail && remembers {
        symmetry.level = Level::Warn;
    }
    let symmetry = symmetry.blames(place, |name| {
        format!("the force of {name} has no potential: what two displacements do to each other depends on which came first")
    });
    Ok(vec![gradient, tangent, symmetry])
}

/// Whether all forces are those of the energy.
fn alone(subject: &Subject) -> bool {
    use pdlang::ir::Response::{Energy, Rate};
    let all = subject.law.responses.iter();
    all.clone().all(|r| matches!(r, Energy(_) | Rate(..)))
}

fn compare(case: &mut Case, body: &Body, strain: f64, worst: &mut Worst) {
    let u = bodies::deformation(body, strain, 8);
    let along = |k: u64| bodies::deformation(body, strain, 100 + k);
    let at = |case: &mut Case, du: &[[f64; 3]], h: f64| {
        let moved: Vec<[f64; 3]> = u
            .iter()
            .zip(du)
            .map(|(u, du)| std::array::from_fn(|a| u[a] + h * du[a]))
            .collect();
        case.displace(&moved);
        let force = case.force();
        (force, case.total_energy())
    };
    let (mut gradient, mut tangent) = (f64::INFINITY, f64::INFINITY);
    for k in 0..TRIES {
        let du = along(k);
        let (plus, above) = at(case, &du, STEP);
        let (minus, below) = at(case, &du, -STEP);
        let (force, _) = at(case, &du, 0.0);
        let work: f64 = (0..du.len())
            .map(|i| body.volume[i] * (0..3).map(|a| force[i][a] * du[i][a]).sum::<f64>())
            .sum();
        let size: f64 = (0..du.len())
            .map(|i| body.volume[i] * (0..3).map(|a| (force[i][a] * du[i][a]).abs()).sum::<f64>())
            .sum();
        gradient = gradient.min(relative(&[(above - below) / (2.0 * STEP)], &[-work], size));
        case.force();
        let slope = case.tangent(&du);
        let difference: Vec<[f64; 3]> = plus
            .iter()
            .zip(&minus)
            .map(|(p, m)| std::array::from_fn(|a| (p[a] - m[a]) / (2.0 * STEP)))
            .collect();
        let scale = largest(difference.as_flattened());
        tangent = tangent.min(relative(
            slope.as_flattened(),
            difference.as_flattened(),
            scale,
        ));
        if gradient < SLOPE && tangent < SLOPE {
            break;
        }
    }
    if gradient > worst.gradient.0 {
        worst.gradient = (gradient, strain);
    }
    if tangent > worst.tangent.0 {
        worst.tangent = (tangent, strain);
    }
    let (a, b) = (along(50), along(51));
    let (ka, kb) = (case.tangent(&a), case.tangent(&b));
    let work = |x: &[[f64; 3]], y: &[[f64; 3]], size: bool| -> f64 {
        let mut sum = 0.0;
        for ((x, y), volume) in x.iter().zip(y).zip(&body.volume) {
            for (x, y) in x.iter().zip(y) {
                sum += volume * if size { (x * y).abs() } else { x * y };
            }
        }
        sum
    };
    let skew = relative(
        &[work(&ka, &b, false)],
        &[work(&kb, &a, false)],
        work(&ka, &b, true),
    );
    worst.skew = worst.skew.max(skew);
}
