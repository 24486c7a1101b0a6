//! Waves on a lattice: modes without energy, speeds, frequencies and the stable step.
//!
//! From the stencil of the law on a lattice of the bodies' horizon, waves with 0, 1/2 and 1 times the largest wave number along
//! every axis, and with 1/4 along one: a wave without stiffness is one that the law does not see, one with a negative stiffness grows without end.
//! A long wave runs at the speed of the lattice's own moduli. The largest frequency and the step are those of a free block.

use pdlang::ir::{ExprKind, Flavour};
use pdlang_runtime::density::Density;
use pdlang_runtime::engine::Breaking;
use pdlang_runtime::spectrum;
use std::f64::consts::{PI, TAU};

use super::ask::{self, Case};
use super::constants::{self, Quantity};
use super::place::{self, Place};
use super::subject::Subject;
use super::{Level, Verdict, bodies};
use crate::waves::Stencil;

/// Nodes along a long wave.
const LONG: f64 = 48.0;
/// Stiffness over the largest one that is none.
const NOTHING: f64 = 1e-6;
/// The curve of a long wave lies below its tangent.
const SPEED: f64 = 0.03;

pub fn check(subject: &Subject, flavour: Flavour) -> Result<Vec<Verdict>, String> {
    const CHECKS: [&str; 3] = ["zero_energy", "speeds", "step"];
    if !subject.has_force() {
        let skip = |check| Verdict::skip(check, flavour, "the law has no force");
        return Ok(CHECKS.map(skip).to_vec());
    }
    let stencil = Stencil::of_motion(subject, flavour)?;
    let waves = waves(&stencil);
    Ok(vec![
        modes(subject, flavour, &waves),
        speeds(subject, flavour, &stencil),
        step(subject, flavour, &waves)?,
    ])
}

/// A wave vector in units of the largest along an axis, and the stiffness of its polarisations, ascending [Pa/m^2].
struct Wave {
    k: [f64; 3],
    stiffness: Vec<f64>,
}

/// On the lattice of the bodies' horizon.
fn waves(stencil: &Stencil) -> Vec<Wave> {
    let steps = |a: usize| if a < stencil.dim { 0..3 } else { 0..1 };
    // A longer wave, which every law with a modulus sees, is the scale where the law sees none of the others.
    let mut waves = vec![wave(stencil, [0.25, 0.0, 0.0])];
    for i in steps(0) {
        for j in steps(1) {
            for l in steps(2) {
                let k = [i, j, l].map(|n| 0.5 * f64::from(n));
                // What differs by a swap of axes is the same on a cubic lattice for most laws, but not for all.
                if k != [0.0; 3] {
                    waves.push(wave(stencil, k));
                }
            }
        }
    }
    waves
}

fn wave(stencil: &Stencil, k: [f64; 3]) -> Wave {
    let matrix = stencil.matrix(k.map(|c| c * PI / stencil.spacing));
    Wave {
        k,
        stiffness: matrix.pairs().iter().map(|p| p.value).collect(),
    }
}

fn top(waves: &[Wave]) -> f64 {
    waves
        .iter()
        .flat_map(|w| &w.stiffness)
        .fold(0.0_f64, |m, v| m.max(v.abs()))
}

fn modes(subject: &Subject, flavour: Flavour, waves: &[Wave]) -> Verdict {
    let top = top(waves);
    let all = || waves.iter().flat_map(|w| &w.stiffness);
    let none = all().filter(|v| v.abs() <= NOTHING * top).count();
    let board = waves
        .iter()
        .find(|w| w.k.iter().take(flavour.dim()).all(|k| *k == 1.0));
    let board = board
        .and_then(|w| w.stiffness.first())
        .map_or(0.0, |v| v / top);
    let level = if none == 0 && top > 0.0 {
        Level::Pass
    } else {
        Level::Fail
    };
    let verdict = Verdict {
        measured: Some(none as f64),
        expected: Some(0.0),
        ..Verdict::new("zero_energy", flavour, level)
    };
    let says = format!("a checkerboard has {board:.2} of the largest stiffness");
    verdict.says(says).blames(blind(subject).or(subject.force_place()), |name| {
        let count = all().count();
        format!("{none} of {count} waves have no stiffness (a checkerboard has {board:.1e} of the largest): {name} does not see them")
    })
}

/// The first definition that sums displacements: what a wave may cancel in.
fn blind(subject: &Subject) -> Option<Place> {
    let law = subject.law;
    let sums = |kind: &ExprKind| matches!(kind, ExprKind::Reduce(_, _, a) if place::moves(law, *a));
    let found = subject
        .definitions()
        .find(|def| place::contains(law, def.expr, &sums));
    found.and_then(|def| subject.place(def.span))
}

/// Speeds of a long wave along an axis, which one of twice the length must share. What is expected is that of the declared
/// constants: a lattice has its own.
fn speeds(subject: &Subject, flavour: Flavour, stencil: &Stencil) -> Verdict {
    let along = |length: f64| -> Vec<f64> {
        let wave = wave(stencil, [2.0 / length, 0.0, 0.0]);
        let number = TAU / (length * stencil.spacing);
        let speed = |v: &f64| (v / subject.density).abs().sqrt() * v.signum() / number;
        wave.stiffness.iter().map(speed).collect()
    };
    let (short, long) = (along(LONG), along(2.0 * LONG));
    let fastest = long.last().copied().unwrap_or_default();
    // What has no stiffness at all is the business of `zero_energy`.
    let pairs = short
        .iter()
        .zip(&long)
        .filter(|(_, c)| c.abs() > 1e-3 * fastest);
    let worst = pairs.map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    let real = long.iter().all(|c| *c > -1e-3 * fastest);
    let level = if worst <= SPEED && real && fastest > 0.0 {
        Level::Pass
    } else {
        Level::Fail
    };
    let verdict = Verdict {
        measured: Some(fastest),
        expected: longitudinal(subject, flavour),
        ..Verdict::new("speeds", flavour, level)
    };
    let list = |speeds: &[f64]| {
        let shown: Vec<String> = speeds.iter().rev().map(|c| format!("{c:.5e}")).collect();
        shown.join(" and ")
    };
    let says = format!(
        "long waves run at {} m/s, at {} kg/m^3",
        list(&long),
        subject.density
    );
    verdict.says(says).blames(subject.force_place(), |name| {
        format!("long waves have no speed of their own: {} m/s, and {} at half of the length, by {name}", list(&long), list(&short))
    })
}

/// The speed of longitudinal waves of the constants that the law declares.
fn longitudinal(subject: &Subject, flavour: Flavour) -> Option<f64> {
    let value = |q| constants::expected(q, subject.law, &subject.params, flavour);
    let (dim, isotropic) = (flavour.dim() as f64, value(Quantity::Isotropic)?);
    let shear = if dim > 1.0 {
        value(Quantity::Shear)?
    } else {
        0.0
    };
    Some(((isotropic + 2.0 * shear * (dim - 1.0) / dim) / subject.density).sqrt())
}

fn step(subject: &Subject, flavour: Flavour, waves: &[Wave]) -> Result<Verdict, String> {
    let top = top(waves);
    let least = waves
        .iter()
        .flat_map(|w| &w.stiffness)
        .fold(f64::INFINITY, |m, v| m.min(*v));
    let shape = std::array::from_fn(|a| if a < flavour.dim() { 6 } else { 1 });
    let body = bodies::lattice(ask::runtime_flavour(flavour), shape, false);
    let mut case = Case::new(subject, flavour, ask::sized(subject, body))?;
    case.engine.forces(&mut case.state, Breaking::Held);
    let spec = case.engine.spec().clone();
    let density = Density::uniform(subject.density);
    let found = spectrum::stable_step(&mut case.engine, &spec, &case.state, &density, 0.0, 1.0);
    let unstable = least < -1e-9 * top;
    let level = if !unstable && found.dt.is_finite() && found.dt > 0.0 {
        Level::Pass
    } else {
        Level::Fail
    };
    let verdict = Verdict {
        measured: Some(found.dt),
        ..Verdict::new("step", flavour, level)
    };
    let says = format!(
        "the largest frequency of a block is {:.4e} rad/s, the stable step {:.4e} s",
        found.omega, found.dt
    );
    Ok(verdict.says(says).blames(subject.force_place(), |name| match unstable {
        true => format!("a wave has the stiffness {:.1e} of the largest and grows without end: {name} pushes where it should pull", least / top),
        false => format!("no step is stable: the block has the frequency {} rad/s by {name}", found.omega),
    }))
}
