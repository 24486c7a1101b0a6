//! Energy, force and tangent belong together.
//!
//! On a lattice with holes and a cloud, whole and with half of the bonds broken, at strains from 1e-4 to 0.1: the force is
//! minus the slope of the energy and the tangent the slope of the force, along random displacements by central
//! differences; and the tangent is symmetric in the inner product of the volumes. Where a law has a corner, as `max` has, a
//! difference across it is no slope: what is wrong must be wrong in three states. An energy that jumps shows on the way from
//! rest, where the work of the force is not what the energy gains.

use pdlang::ir::{ExprKind, Flavour};
use pdlang_runtime::body::Body;

use super::ask::{self, Case, largest, relative};
use super::continuum::gauss;
use super::place::{contains, expr_of};
use super::subject::Subject;
use super::{Level, Verdict, balance, bodies};

const STRAINS: [f64; 3] = [1e-4, 1e-2, 1e-1];
/// Step of the differences, as part of the strain.
const STEP: f64 = 1e-4;
const SLOPE: f64 = 1e-5;
const SYMMETRIC: f64 = 1e-10;
const TRIES: u64 = 3;
/// Points of a path, and the share of its work that no quadrature of a continuous force misses.
const PATH: usize = 24;
const JUMP: f64 = 5e-4;

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
    let along = |k: u64| bodies::deformation(body, strain, 100 + k);
    let (mut gradient, mut tangent) = (f64::INFINITY, f64::INFINITY);
    for k in 0..TRIES {
        let (u, du) = (bodies::deformation(body, strain, 8 + 31 * k), along(k));
        let (plus, above) = at(case, &u, &du, STEP);
        let (minus, below) = at(case, &u, &du, -STEP);
        let (force, _) = at(case, &u, &du, 0.0);
        let (done, size) = work(body, &force, &du);
        gradient = gradient.min(relative(&[(above - below) / (2.0 * STEP)], &[-done], size));
        case.force();
        let slope = case.tangent(&du);
        let pairs = plus.iter().zip(&minus);
        let difference: Vec<[f64; 3]> = pairs
            .map(|(p, m)| std::array::from_fn(|a| (p[a] - m[a]) / (2.0 * STEP)))
            .collect();
        let (slope, difference) = (slope.as_flattened(), difference.as_flattened());
        tangent = tangent.min(relative(slope, difference, largest(difference)));
        if gradient < SLOPE && tangent < SLOPE {
            break;
        }
    }
    let path = path(case, body, &bodies::deformation(body, strain, 8));
    gradient = gradient.max(if path > JUMP { path } else { 0.0 });
    if gradient > worst.gradient.0 {
        worst.gradient = (gradient, strain);
    }
    if tangent > worst.tangent.0 {
        worst.tangent = (tangent, strain);
    }
    let (a, b) = (along(50), along(51));
    case.force();
    let (ka, kb) = (case.tangent(&a), case.tangent(&b));
    let ((left, size), (right, _)) = (work(body, &ka, &b), work(body, &kb, &a));
    worst.skew = worst.skew.max(relative(&[left], &[right], size));
}

/// Force and energy at `u + h du`.
fn at(case: &mut Case, u: &[[f64; 3]], du: &[[f64; 3]], h: f64) -> (Vec<[f64; 3]>, f64) {
    let pairs = u.iter().zip(du);
    let moved: Vec<[f64; 3]> = pairs
        .map(|(u, du)| std::array::from_fn(|a| u[a] + h * du[a]))
        .collect();
    case.displace(&moved);
    (case.force(), case.total_energy())
}

/// The work of force densities on displacements, and the sum of the sizes of its parts.
fn work(body: &Body, force: &[[f64; 3]], du: &[[f64; 3]]) -> (f64, f64) {
    let (mut sum, mut size) = (0.0, 0.0);
    for ((f, du), volume) in force.iter().zip(du).zip(&body.volume) {
        for (f, du) in f.iter().zip(du) {
            sum += volume * f * du;
            size += volume * (f * du).abs();
        }
    }
    (sum, size)
}

/// What the energy gains on the way to a displacement and the force has not worked, over all that it worked: a jump.
fn path(case: &mut Case, body: &Body, u: &[[f64; 3]]) -> f64 {
    let rest = vec![[0.0; 3]; u.len()];
    let (_, start) = at(case, &rest, u, 0.0);
    let (mut done, mut size) = (0.0, 0.0);
    for (t, weight) in gauss(PATH) {
        let (force, _) = at(case, &rest, u, t);
        let (work, parts) = work(body, &force, u);
        (done, size) = (done + weight * work, size + weight * parts);
    }
    let (_, end) = at(case, &rest, u, 1.0);
    relative(&[end - start], &[-done], size)
}
