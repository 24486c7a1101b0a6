//! Small plane waves in a law: on its lattice, in its continuum, and in the local limit of that.
//!
//! A wave `u exp(i(k.x - Omega t))` has `rho Omega^2 u = M(k) u`. [`Stencil`] is the law on a lattice, collected once from
//! its tangent; `M(k)` at any wave vector, its slopes and its Taylor coefficients are sums over it (all units are SI; wave
//! vectors in 1/m). [`continuum`] is the same of the continuum, by a quadrature. [`study`] puts together what
//! `pdlang dispersion` shows: the branches along a direction, long-wave speeds and moduli against the declared ones,
//! modes without energy, the largest frequency and the stable step.
//!
//! A law without a force but with the rate of a scalar field, heat conduction for instance, has rates of decay in
//! the place of squared frequencies.

pub mod branches;
pub mod continuum;
pub mod hermitian;
mod pixels;
pub mod plot;
pub mod stencil;
pub mod zone;

use pdlang::ir::{Flavour, Response, Shape};
use pdlang_runtime::density::Density;
use pdlang_runtime::engine::Breaking;
use pdlang_runtime::spec::Stepped;
use pdlang_runtime::spectrum;
use std::f64::consts::PI;

pub use branches::{Follower, Wave};
pub use continuum::Moving;
pub use hermitian::Hermitian;
pub use pdlang_runtime::matching::root_series;
pub use stencil::{Block, Stencil};
pub use zone::{NOTHING, ZeroMode, Zone};

use crate::verify::ask::{self, Case};
use crate::verify::constants::{self, Families, Quantity};
use crate::verify::{Subject, bodies};

/// Bonds of the free block at most.
const BLOCK: f64 = 2e6;
/// Where one looks for modes without energy along the direction.
const FINE: usize = 360;

/// What is asked.
#[derive(Clone, Debug)]
pub struct Request {
    pub flavour: Flavour,
    /// Any length.
    pub direction: [f64; 3],
    /// Wave numbers, without 0, up to the edge of the Brillouin zone.
    pub points: usize,
}

/// One wave number.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// [1/m]
    pub k: f64,
    /// By branch, as [`Study::branches`].
    pub lattice: Vec<Wave>,
    /// Stiffness over density of the continuum of the law [rad^2/s^2], of a field the rate of decay [1/s]; none where
    /// the law has no quadrature.
    pub continuum: Option<Vec<f64>>,
    /// Of the local law.
    pub local: Option<Vec<f64>>,
}

/// A branch and its long waves.
#[derive(Clone, Debug, PartialEq)]
pub struct Branch {
    /// `L`, `T`, `T1`, `T2`; of a field its name.
    pub name: String,
    /// Unit vector of the motion of long waves.
    pub polarisation: [f64; 3],
    /// Square of the speed [m^2/s^2], of a field the diffusivity [m^2/s].
    pub lattice: f64,
    pub continuum: Option<f64>,
}

/// A modulus, conductivity or expansion.
#[derive(Clone, Debug, PartialEq)]
pub struct Modulus {
    pub name: String,
    pub lattice: f64,
    pub continuum: f64,
    /// By the parameters of the law.
    pub declared: f64,
}

/// The largest frequency and the step that it allows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// [rad/s], of a field the rate of decay [1/s].
    pub fastest: f64,
    /// `2/omega` [s].
    pub dt: f64,
}

/// All that is known of the waves of a law.
#[derive(Clone, Debug)]
pub struct Study {
    pub flavour: Flavour,
    pub moving: Moving,
    /// Unit vector.
    pub direction: [f64; 3],
    pub spacing: f64,
    pub horizon: f64,
    pub density: f64,
    /// Wave number at the edge of the Brillouin zone [1/m].
    pub edge: f64,
    pub branches: Vec<Branch>,
    pub rows: Vec<Row>,
    pub moduli: Vec<Modulus>,
    /// Wave numbers of the direction at which some waves cost nothing [1/m].
    pub zero: Vec<ZeroMode>,
    pub zone: Zone,
    /// Of the unbounded lattice.
    pub step: Step,
    /// Of a block with free surfaces, as a run finds it: an upper estimate within two percent. And its nodes.
    pub free: Option<(Step, usize)>,
    /// What is not symmetric in the tangent, over its largest entry.
    pub asymmetry: f64,
    pub warnings: Vec<String>,
    pub notes: Vec<String>,
}

/// What moves in a law: displacements where it has a force, else its first scalar field with a rate.
///
/// # Errors
/// Where waves have no real frequency, or nothing moves.
pub fn moving(subject: &Subject) -> Result<Moving, String> {
    let law = subject.law;
    if subject.has_force() {
        let spec = subject
            .compiled(*law.flavours.first().ok_or("the law is for no flavour")?)?
            .spec;
        let half = spec.rates.iter().find(|r| r.stepped == Stepped::Half);
        let named = |slot: u32| spec.fields.iter().find(|f| f.slots.contains(&slot));
        return match half {
            None => Ok(Moving::Displacement),
            Some(rate) => Err(format!(
                "`{}` damps motion by its field `{}`, at rates that a scene sets: its waves have no real frequency; ask a law without such fields",
                law.name,
                named(rate.field).map_or("", |f| f.name.as_str())
            )),
        };
    }
    let rated = law.responses.iter().find_map(|r| match r {
        Response::Rate(f, _) if law.fields[f.index()].shape == Shape::Scalar => Some(*f),
        _ => None,
    });
    rated.map(Moving::Field).ok_or_else(|| {
        format!(
            "`{}` has neither a force nor the rate of a scalar field: nothing runs through it",
            law.name
        )
    })
}

/// The stencil of what moves in a law.
///
/// # Errors
/// As [`moving`] and [`Stencil::of_motion`].
pub fn stencil(subject: &Subject, flavour: Flavour) -> Result<Stencil, String> {
    match moving(subject)? {
        Moving::Displacement => Stencil::of_motion(subject, flavour),
        Moving::Field(field) => {
            Stencil::of_field(subject, flavour, &subject.law.fields[field.index()].name)
        }
    }
}

/// Asks everything.
///
/// # Errors
/// Where the law cannot be asked; what the continuum cannot answer is a note.
pub fn study(subject: &Subject, request: &Request) -> Result<Study, String> {
    let (flavour, dim) = (request.flavour, request.flavour.dim());
    let moving = moving(subject)?;
    let stencil = stencil(subject, flavour)?;
    let stiffness = stencil.taylor([1.0, 0.0, 0.0], 1)[0];
    if !stiffness.as_flattened().iter().all(|v| v.is_finite()) {
        return Err("the stiffness of the lattice is no finite number: a parameter is too large or too small".into());
    }
    let density = match moving {
        Moving::Displacement => subject.density,
        Moving::Field(_) => 1.0,
    };
    let direction = unit(request.direction, dim)?;
    let largest = direction.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
    let edge = PI / (stencil.spacing * largest);
    let zone = zone::zone(&stencil);
    let mut notes = notes(subject, moving);
    let mut warnings = Vec::new();

    let long = long_waves(&stencil, direction);
    let names = Follower::new(&long, direction);
    let local = match subject.law.families.len() {
        1 => continuum::local(subject, flavour, moving, direction).map(Some),
        _ => {
            notes.push(
                "families of some of the bonds have no continuum: the lattice alone is shown"
                    .into(),
            );
            Ok(None)
        }
    };
    let local = local.unwrap_or_else(|error| {
        notes.push(format!("no continuum: {error}"));
        None
    });
    let branches = branches_of(
        subject,
        moving,
        &long,
        local.as_ref(),
        direction,
        density,
        &names,
    );

    let scale = NOTHING * (zone.largest.value.max(0.0) / density).sqrt();
    let mut follower = Follower::new(&long, direction);
    let mut beyond = local.as_ref().map(|m| Follower::new(m, direction));
    let mut rows = Vec::new();
    for point in 1..=request.points.max(1) {
        let k = edge * point as f64 / request.points.max(1) as f64;
        let vector = direction.map(|c| c * k);
        let pairs = follower.next(&stencil.matrix(vector));
        let lattice = pairs
            .iter()
            .map(|p| branches::wave(&stencil, density, vector, p, scale));
        let beyond = match &mut beyond {
            None => None,
            Some(beyond) => {
                let matrix = continuum::matrix(subject, flavour, moving, direction, k)?;
                Some(
                    beyond
                        .next(&matrix)
                        .iter()
                        .map(|p| p.value / density)
                        .collect(),
                )
            }
        };
        let straight = |b: &Branch| b.continuum.map(|c| c * k * k);
        rows.push(Row {
            k,
            lattice: lattice.collect(),
            continuum: beyond,
            local: branches.iter().map(straight).collect(),
        });
    }

    let asymmetry = rows
        .iter()
        .map(|row| stencil.asymmetry(direction.map(|c| c * row.k)))
        .fold(0.0, f64::max);
    if asymmetry > 1e-9 {
        warnings.push(format!(
            "the tangent is not symmetric, by {asymmetry:.1e} of its largest entry: frequencies are those of its symmetric part"
        ));
    }
    if zone.least.value < -1e-9 * zone.largest.value.abs() {
        warnings.push(format!(
            "a wave has the stiffness {:.1e} of the largest and grows without end",
            zone.least.value / zone.largest.value
        ));
    }
    let moduli = moduli(subject, flavour, moving, &branches)?;
    let off = |m: &&Modulus| (m.lattice / m.declared - 1.0).abs() > constants::LATTICE;
    let off: Vec<String> = (moduli.iter().filter(off))
        .map(|m| format!("{} {:.2}", m.name, m.lattice / m.declared))
        .collect();
    if !off.is_empty() {
        warnings.push(format!(
            "constants of this lattice over the declared ones: {}. More spacings in a horizon, `--constants lattice` or `--partial-volume` may mend it, in a scene `constants = \"lattice\"` in [material] or `partial_volume = true` in [family]",
            off.join(", ")
        ));
    }
    for b in &branches {
        let Some(continuum) = b.continuum.filter(|c| *c > 0.0 && moduli.is_empty()) else {
            continue;
        };
        let ratio = b.lattice / continuum;
        if (ratio - 1.0).abs() > constants::LATTICE {
            warnings.push(format!(
                "the long-wave stiffness of branch {} is {ratio:.2} of that of the continuum",
                b.name
            ));
        }
    }
    let step = Step {
        fastest: frequency(moving, zone.largest.value / density),
        dt: 2.0 / frequency(moving, zone.largest.value / density),
    };
    Ok(Study {
        flavour,
        moving,
        direction,
        spacing: stencil.spacing,
        horizon: subject.horizon,
        density: subject.density,
        edge,
        zero: along(&stencil, direction, edge, zone.largest.value),
        branches,
        rows,
        moduli,
        step,
        zone,
        free: free(subject, flavour, moving, step.fastest)?,
        asymmetry,
        warnings,
        notes,
    })
}

/// A frequency of a squared one; a rate of decay as it is.
pub fn frequency(moving: Moving, value: f64) -> f64 {
    match moving {
        Moving::Displacement => value.max(0.0).sqrt(),
        Moving::Field(_) => value,
    }
}

fn unit(direction: [f64; 3], dim: usize) -> Result<[f64; 3], String> {
    let length = direction
        .iter()
        .take(dim)
        .map(|c| c * c)
        .sum::<f64>()
        .sqrt();
    if !(length > 0.0 && length.is_finite()) || direction.iter().skip(dim).any(|c| *c != 0.0) {
        return Err(format!(
            "a direction of {dim} dimensions is not 0, and 0 beyond them"
        ));
    }
    Ok(direction.map(|c| c / length))
}

/// `M/k^2` of ever longer waves of a lattice, exactly.
fn long_waves(stencil: &Stencil, n: [f64; 3]) -> Hermitian {
    let first = stencil.taylor(n, 1)[0];
    Hermitian::part(stencil.size, first, [[0.0; 3]; 3]).0
}

fn branches_of(
    subject: &Subject,
    moving: Moving,
    long: &Hermitian,
    local: Option<&Hermitian>,
    n: [f64; 3],
    density: f64,
    order: &Follower,
) -> Vec<Branch> {
    let continuum = local.map(|m| Follower::new(m, n));
    let pairs = order.last();
    let name = |k: usize| match (moving, k, long.size) {
        (Moving::Field(f), ..) => subject.law.fields[f.index()].name.clone(),
        (_, 0, _) => "L".into(),
        (_, _, 2) => "T".into(),
        (_, k, _) => format!("T{k}"),
    };
    let branch = |(k, pair): (usize, &hermitian::Pair)| Branch {
        name: name(k),
        polarisation: pair.vector.map(|z| z.re),
        lattice: pair.value / density,
        continuum: continuum.as_ref().map(|c| c.last()[k].value / density),
    };
    pairs.iter().enumerate().map(branch).collect()
}

/// Where waves along the direction cost nothing.
fn along(stencil: &Stencil, n: [f64; 3], edge: f64, largest: f64) -> Vec<ZeroMode> {
    let none = NOTHING * NOTHING * largest;
    let values = |k: f64| stencil.matrix(n.map(|c| c * k)).pairs();
    let least = |k: f64| values(k).first().map_or(0.0, |p| p.value);
    let step = edge / FINE as f64;
    let fine: Vec<f64> = (0..=FINE + 1).map(|i| least(i as f64 * step)).collect();
    let mut zero: Vec<ZeroMode> = Vec::new();
    for i in 1..=FINE {
        if fine[i] > fine[i - 1] || fine[i] > fine[i + 1] {
            continue;
        }
        // Where all of the direction is loose, its edge stands for it.
        if i < FINE && fine[i - 1].max(fine[i]).max(fine[i + 1]) <= none {
            continue;
        }
        // Golden section of the valley.
        let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
        let (mut a, mut b) = ((i as f64 - 1.0) * step, (i as f64 + 1.0) * step);
        while b - a > 1e-10 * edge {
            let (c, d) = (b - ratio * (b - a), a + ratio * (b - a));
            if least(c) < least(d) { b = d } else { a = c }
        }
        let middle = (0.5 * (a + b)).min(edge);
        let k = if least(i as f64 * step) <= least(middle) {
            i as f64 * step
        } else {
            middle
        };
        if least(k) <= none && k > 0.5 * step {
            zero.push(ZeroMode {
                k: n.map(|c| c * k),
                count: values(k).iter().filter(|p| p.value <= none).count(),
            });
        }
    }
    zero
}

/// Moduli of a law with a force; the conductivity of a field, from its diffusivity.
fn moduli(
    subject: &Subject,
    flavour: Flavour,
    moving: Moving,
    branches: &[Branch],
) -> Result<Vec<Modulus>, String> {
    let law = subject.law;
    let declared = |q| constants::expected(q, law, &subject.params, flavour);
    if let Moving::Field(field) = moving {
        let what = Quantity::Conductivity(field.index());
        let capacity = constants::capacity(law, &subject.params);
        let found = branches
            .first()
            .and_then(|b| b.continuum.map(|c| (b.lattice, c)));
        return Ok(match (declared(what), capacity, found) {
            (Some(declared), Some(capacity), Some((lattice, continuum))) => vec![Modulus {
                name: what.name(flavour),
                lattice: lattice * capacity,
                continuum: continuum * capacity,
                declared,
            }],
            _ => Vec::new(),
        });
    }
    let mut list = constants::quantities(law, &subject.params, flavour);
    list.retain(|q| !matches!(q, Quantity::Expansion(_) | Quantity::Conductivity(_)));
    let whole = Families::continuum(law, flavour, subject.horizon);
    let lattice = Families::lattice(subject, flavour);
    let of_continuum = constants::settings(subject, flavour, &subject.params);
    let of_lattice = constants::lattice_settings(subject, flavour);
    let one = |what: &Quantity| {
        Ok(Modulus {
            name: what.name(flavour),
            lattice: constants::measure(*what, law, &lattice, &of_lattice)?,
            continuum: constants::measure(*what, law, &whole, &of_continuum)?,
            declared: declared(*what).unwrap_or_default(),
        })
    };
    list.iter().map(one).collect()
}

/// The largest frequency of a block with free surfaces, where it is larger than that of the lattice: a block is small.
fn free(
    subject: &Subject,
    flavour: Flavour,
    moving: Moving,
    unbounded: f64,
) -> Result<Option<(Step, usize)>, String> {
    let dim = flavour.dim();
    let side = (2.0 * subject.reach).ceil().max(6.0);
    let ball = [2.0, 3.2, 4.2][dim - 1] * subject.reach.powi(dim as i32);
    if side.powi(dim as i32) * ball > BLOCK {
        return Ok(None);
    }
    let shape = std::array::from_fn(|a| if a < dim { side as u32 } else { 1 });
    let body = bodies::lattice(ask::runtime_flavour(flavour), shape, false);
    let mut case = Case::new(subject, flavour, ask::sized(subject, body))?;
    case.engine.forces(&mut case.state, Breaking::Held);
    let spec = case.engine.spec().clone();
    let density = Density::uniform(subject.density);
    let found = spectrum::stable_step(&mut case.engine, &spec, &case.state, &density, 0.0, 1.0);
    let fastest = match moving {
        Moving::Displacement => found.omega,
        Moving::Field(_) => found.rate,
    };
    let fastest = fastest.max(unbounded);
    let step = Step {
        fastest,
        dt: 2.0 / fastest,
    };
    Ok(Some((step, case.body.x.len())))
}

fn notes(subject: &Subject, moving: Moving) -> Vec<String> {
    let law = subject.law;
    let mut notes = Vec::new();
    let rated = law
        .responses
        .iter()
        .any(|r| matches!(r, Response::Rate(..)));
    if let Moving::Field(field) = moving {
        let name = &law.fields[field.index()].name;
        notes.push(format!("the law has no force: rates at which waves of `{name}` decay take the place of frequencies"));
    } else if rated {
        notes.push("fields are held: with heat, waves are isothermal".into());
    }
    if !law.histories.is_empty() {
        notes.push("histories are held: waves too fast to change them".into());
    }
    notes
}
