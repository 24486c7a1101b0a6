//! The energy that opens a surface.
//!
//! Every bond across a unit area is stretched until it breaks, by a uniform expansion, and the work on it is summed: with
//! the work `w` of a bond of length `r`, half the integral of `w r` over the horizon, times the mean of the cosine. That is
//! the critical energy release rate of bond-based laws, which must be the declared parameter in J/m^2. Where bonds share
//! their energy, as in state-based laws, no bond has an energy of its own, and what is off is a warning.

use pdlang::ir::Flavour;
use pdlang::oracle::{Oracle, State};

use super::constants::{self, EXACT, Families, Quantity};
use super::continuum::{self, directions};
use super::subject::{RELEASE_RATE, Subject, has_unit};
use super::{Level, Verdict};

const RADIAL: usize = 24;
const CHECK: &str = "fracture_energy";

pub fn check(subject: &Subject, flavour: Flavour) -> Result<Vec<Verdict>, String> {
    let law = subject.law;
    let declared = law
        .params
        .iter()
        .position(|p| has_unit(&p.unit, RELEASE_RATE));
    let (Some(declared), Some(rule)) = (declared, law.breaks.first()) else {
        let why = "the law declares no energy release rate, or no bond breaks";
        return Ok(vec![Verdict::skip(CHECK, flavour, why)]);
    };
    let expected = subject.params[declared];
    let Some(measured) = release_rate(subject, flavour)? else {
        return Ok(vec![Verdict::skip(
            CHECK,
            flavour,
            "no expansion breaks a bond",
        )]);
    };
    let right = (measured / expected - 1.0).abs() <= EXACT;
    let level = match right {
        true => Level::Pass,
        false if of_bonds(subject, flavour)? => Level::Fail,
        false => Level::Warn,
    };
    let verdict = Verdict {
        measured: Some(measured),
        expected: Some(expected),
        ..Verdict::new(CHECK, flavour, level)
    };
    let place = subject.place_of(critical(subject).unwrap_or(rule.when));
    Ok(vec![verdict.of(&law.params[declared].name).blames(place, |name| {
        format!("a surface takes {:.6} of the declared `{}` to open: {name} decides when a bond breaks", measured / expected, law.params[declared].name)
    })])
}

/// The definition that the first rule of breaking compares with, where it is one.
fn critical(subject: &Subject) -> Option<pdlang::ir::ExprId> {
    let law = subject.law;
    let declared = |kind: &pdlang::ir::ExprKind| match kind {
        pdlang::ir::ExprKind::Param(p) => has_unit(&law.params[p.index()].unit, RELEASE_RATE),
        _ => false,
    };
    let found = subject
        .definitions()
        .find(|def| super::place::contains(law, def.expr, &declared));
    found.map(|def| def.expr)
}

/// Whether Poisson's ratio is that of bonds alone.
fn of_bonds(subject: &Subject, flavour: Flavour) -> Result<bool, String> {
    if flavour.dim() == 1 {
        return Ok(true);
    }
    let families = Families::continuum(subject.law, flavour, subject.horizon);
    let settings = constants::settings(subject, flavour, &subject.params);
    let ask = |q| constants::measure(q, subject.law, &families, &settings);
    let ratio = ask(Quantity::Shear)? / ask(Quantity::Isotropic)?;
    let bonds = if flavour == Flavour::Solid { 0.6 } else { 0.5 };
    Ok((ratio / bonds - 1.0).abs() < 1e-6)
}

/// `None` where no expansion up to 1 breaks a bond.
fn release_rate(subject: &Subject, flavour: Flavour) -> Result<Option<f64>, String> {
    let text = |error: pdlang::oracle::Error| error.to_string();
    let dim = flavour.dim();
    let points = continuum::ball(
        dim,
        subject.horizon,
        constants::cross(flavour),
        RADIAL,
        false,
    );
    let body = continuum::single(&points);
    let settings = constants::settings(subject, flavour, &subject.params);
    let oracle = Oracle::new(subject.law, &body, &settings).map_err(text)?;
    let state = oracle.state();
    let ways = directions(dim, false).len();
    let cosine = [1.0, 2.0 / std::f64::consts::PI, 0.5][dim - 1];
    let mut sum = 0.0;
    for shell in 0..RADIAL {
        let bond = shell * ways;
        let Some(stretch) = critical_stretch(&oracle, &state, bond, dim).map_err(text)? else {
            return Ok(None);
        };
        let length = body.bonds[bond].length();
        let mut work = 0.0;
        for (t, w) in continuum::gauss(6) {
            let force = oracle
                .bond_force_under(&state, bond, &expansion(t * stretch, dim))
                .map_err(text)?;
            let along: f64 = (0..3).map(|a| force[a] * body.bonds[bond].xi[a]).sum();
            work += w * stretch * along;
        }
        let weight: f64 = body.bonds[bond..bond + ways].iter().map(|b| b.weight).sum();
        sum += 0.5 * cosine * work * length * weight;
    }
    // Per area: of a plate its thickness has been counted, of a bar its cross-section.
    Ok(Some(sum))
}

fn expansion(strain: f64, dim: usize) -> [[f64; 3]; 3] {
    std::array::from_fn(|a| std::array::from_fn(|b| if a == b && a < dim { strain } else { 0.0 }))
}

/// The least expansion that breaks a bond, by bisection of its logarithm.
fn critical_stretch(
    oracle: &Oracle,
    state: &State,
    bond: usize,
    dim: usize,
) -> Result<Option<f64>, pdlang::oracle::Error> {
    let breaks = |s: f64| oracle.breaks_under(state, bond, &expansion(s, dim));
    let (mut low, mut high) = (1e-9_f64, 1.0_f64);
    if !breaks(high)? {
        return Ok(None);
    }
    for _ in 0..80 {
        let middle = (low * high).sqrt();
        match breaks(middle)? {
            true => high = middle,
            false => low = middle,
        }
    }
    Ok(Some(high))
}
