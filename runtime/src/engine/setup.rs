//! Making an engine: check, estimate, lay out, evaluate, run the reference stage.
use super::breakable::breaks;
use super::constants::{AtReferenceBond, Materials};
use super::convolution::Convolution;
use super::geometry::{Geometry, Kept, Streams, share, table, vector};
use super::levels::{Grading, group};
use super::needs::Needs;
use super::parts::Parts;
use super::program::{Choice, Program, programs};
use super::records;
use super::redo::Redo;
use super::sleep::Sleep;
use super::{
    BondData, Engine, Home, Isa, Law, Precision, Settings, SetupError, Traversal, check, memory,
    single,
};
use crate::body::Body;
use crate::lane::Record;
use crate::layout::{
    Family, Filter, INCLUSIVE, Layout, Shape, cloud, lattice, partial_volume, plan_lattice,
};
use crate::pages::zeros;
use crate::spec::{SlotKind, Spec, Stage};
use crate::tape::{Code, Limits, Place, length, truth};
use crate::traverse::CHUNK;
use std::collections::BTreeSet;
use std::time::{Duration, Instant};

/// Lanes of a lattice chunk that must hold a node on average, or the cloud is faster.
const FILL: f64 = 0.45;
/// Slots per node above which a padded box is a waste of memory.
const SPARSE: usize = 40;
/// Kinds of bonds above which a table of them is one.
const KINDS: f64 = 1e6;

pub(super) fn engine(body: &Body, law: Law, settings: Settings) -> Result<Engine, SetupError> {
    let spec = law.spec;
    check::spec(&spec)?;
    check::body(body)?;
    check::settings(&spec, body, &settings)?;
    let grouped = group(body, &settings)?;
    let (body, settings) = (&*grouped.body, &*grouped.settings);
    if spec.dim != body.flavour.dim() {
        let m = format!(
            "it has {} dimensions, the body is {}",
            spec.dim,
            body.flavour.name()
        );
        return Err(SetupError::law(&spec.law, m));
    }
    let materials = Materials::new(&spec, body, settings)?;
    let lattice = use_lattice(body, settings, materials.by_lengths())?;
    let isa = settings.isa.unwrap_or_else(Isa::best);
    let mut programs = programs(
        &spec,
        &Choice {
            kernel: law.kernel,
            isa,
            lattice,
            single: single::wanted(&spec, settings, lattice)?,
            flavour: body.flavour,
        },
    )?;
    for (p, sweep) in programs.iter_mut().zip(&spec.sweeps) {
        p.kills = p.kills && breaks(sweep, &materials);
    }
    memory::check(&spec, &programs, body, settings, lattice)?;
    let filters = filters(&spec, body, &materials)?;
    let began = Instant::now();
    let (layout, families) = lay_out(body, settings, lattice, &materials, &filters, isa);
    let search = began.elapsed();
    drop(filters);
    for f in &families {
        if f.present.len() + 1 >= (i32::MAX as usize) / CHUNK {
            return Err(SetupError::Body(
                "the body has too many bonds for one engine: use a larger spacing".into(),
            ));
        }
    }
    let (geometry, streams) = geometry(
        &spec, &programs, body, settings, &layout, &families, &materials, isa,
    );
    let tables = single::tables(&programs, &families, &materials, spec.dim, isa);
    materials.check()?;
    let constants = materials.own();
    drop(materials);
    let mut engine = assemble(
        spec,
        isa,
        lattice,
        layout,
        families,
        programs,
        geometry,
        streams,
        constants,
        grouped.grading.clone(),
    );
    engine.search = search;
    engine.rounded.tables = tables;
    let rest = engine.state();
    engine.refresh_whole(&rest);
    engine.reference_stage(&rest, &settings.without);
    engine.check_range(&rest)?;
    engine.drop_streams_of_the_reference();
    if let (Traversal::Convolution, Some(grid)) = (settings.traversal, &body.grid) {
        let plan = plan_lattice(body, grid, settings.reach(), settings.materials.len());
        // Steady sums read what it writes.
        engine.run_stage(Stage::Family, &rest);
        let convolution = Convolution::new(&engine, plan.cells(body, grid), memory::available())?;
        engine.convolution = Some(Box::new(convolution));
    }
    Ok(engine)
}

/// `by_lengths`: bonds between the same two materials differ.
fn use_lattice(body: &Body, settings: &Settings, by_lengths: bool) -> Result<bool, SetupError> {
    let fail = |m: &str| Err(SetupError::Traversal(m.into(), "use `cloud`".into()));
    let chosen = matches!(
        settings.traversal,
        Traversal::Lattice | Traversal::Convolution
    );
    let (Some(grid), true) = (&body.grid, settings.traversal != Traversal::Cloud) else {
        return match chosen {
            true => fail("the lattice traversal needs a body on a regular grid"),
            false => Ok(false),
        };
    };
    if by_lengths {
        return match chosen {
            true => fail(
                "a parameter meets by the lengths of a bond in two materials, so that no two bonds need be alike",
            ),
            false => Ok(false),
        };
    }
    let uniform = body
        .volume
        .iter()
        .all(|v| (v - body.volume[0]).abs() <= 1e-12 * body.volume[0]);
    if chosen {
        return if uniform {
            Ok(true)
        } else {
            fail("the lattice traversal needs equal node volumes")
        };
    }
    let reach = (settings.reach() / grid.spacing).min(1e6);
    let padded: f64 = (0..body.flavour.dim())
        .map(|a| grid.shape[a] as f64 + 2.0 * reach)
        .product();
    let pairs = (settings.materials.len() * settings.materials.len()) as f64;
    let many = pairs * neighbours(body, settings.reach()) > KINDS;
    if !uniform || many || padded > (SPARSE * body.x.len()) as f64 + 1e5 {
        return Ok(false);
    }
    let plan = plan_lattice(body, grid, settings.reach(), settings.materials.len());
    Ok(body.x.len() as f64 >= FILL * (plan.chunks * CHUNK) as f64 || body.x.len() < 1000)
}

/// Filters of the named families, as code.
fn filters<'a>(
    spec: &Spec,
    body: &Body,
    materials: &'a Materials<'a>,
) -> Result<Vec<Option<BoxedFilter<'a>>>, SetupError> {
    let dim = spec.dim;
    let limits = Limits {
        dim,
        influences: spec.influences.len(),
        constants: spec.constants.outs.len(),
        ..Limits::default()
    };
    let one = |f: &crate::spec::FamilySpec| {
        let Some(tape) = &f.filter else {
            return Ok(None);
        };
        let code = Code::new(tape, Place::Filter, &limits, body.flavour)
            .map_err(|e| SetupError::law(&spec.law, format!("family `{}`: {e}", f.name)))?;
        let keep = move |ends: [[f64; 3]; 2], weight: f64, pair: usize| {
            let xi = vector(ends, dim);
            truth(
                &code,
                &mut AtReferenceBond {
                    constants: materials.on_bond(pair, ends, &mut vec![]),
                    influences: &materials.pairs[pair].influences,
                    xi,
                    length: length(xi, dim),
                    weight,
                },
            )
        };
        Ok(Some(Box::new(keep) as BoxedFilter))
    };
    spec.families.iter().map(one).collect()
}

type BoxedFilter<'a> = Box<dyn Fn([[f64; 3]; 2], f64, usize) -> bool + Sync + 'a>;

fn lay_out(
    body: &Body,
    s: &Settings,
    on_lattice: bool,
    materials: &Materials,
    filters: &[Option<BoxedFilter>],
    isa: Isa,
) -> (Layout, Vec<Family>) {
    let filters: Vec<Option<Filter>> = filters
        .iter()
        .map(|f| f.as_ref().map(|f| &**f as Filter))
        .collect();
    let horizons: Vec<f64> = materials.pairs.iter().map(|p| p.horizon).collect();
    match &body.grid {
        Some(grid) if on_lattice => {
            let plan = plan_lattice(body, grid, s.reach(), materials.count);
            lattice(body, grid, &plan, &horizons, s.partial_volume, &filters)
        }
        _ => cloud(body, &horizons, s.partial_volume, &filters, isa),
    }
}

#[allow(clippy::too_many_arguments)]
fn geometry(
    spec: &Spec,
    programs: &[Program],
    body: &Body,
    settings: &Settings,
    layout: &Layout,
    families: &[Family],
    materials: &Materials,
    isa: Isa,
) -> (Vec<Geometry>, Vec<Kept>) {
    let weight = |xi: [f64; 3], other: usize, pair: usize| {
        let r = length(xi, spec.dim);
        let fraction = if settings.partial_volume {
            partial_volume(r, materials.pairs[pair].horizon, body.spacing)
        } else {
            1.0
        };
        fraction * layout.volume[layout.ghosts.origin(other)]
    };
    let mut streams = Streams::new(layout, families, materials, &weight);
    let mut geometry = vec![];
    for (p, s) in programs.iter().zip(&spec.sweeps) {
        geometry.push(match &families[p.family].shape {
            Shape::Stencil(stencil) => {
                table(p, stencil, materials, spec.dim, isa, Precision::Double)
            }
            Shape::List(_) => streams.add(p, &s.streams),
        });
    }
    let mut streams = streams.values();
    share(&mut streams, &mut geometry);
    (geometry, streams)
}

#[allow(clippy::too_many_arguments)]
fn assemble(
    spec: Spec,
    isa: Isa,
    lattice: bool,
    layout: Layout,
    families: Vec<Family>,
    programs: Vec<Program>,
    geometry: Vec<Geometry>,
    streams: Vec<Kept>,
    constants: Vec<f64>,
    grading: Grading,
) -> Engine {
    let (homes, arrays, state_slots) = homes(&spec);
    let mut reads_ghosts = vec![false; spec.slots.len()];
    for p in &programs {
        for &k in &p.nbr {
            reads_ghosts[k] = true;
        }
    }
    let bonds = (0..families.len())
        .map(|f| bond_data(&spec, &programs, &layout, &families[f], f))
        .collect();
    let parts = Parts::new(&spec, &homes, arrays, state_slots);
    let count = spec.constants.outs.len();
    let materials = layout.parts.iter().enumerate();
    let constants_at = materials
        .flat_map(|(m, part)| part.clone().map(move |_| (m * count) as u32))
        .collect();
    let redo = Redo::new(&programs, spec.slots.len(), layout.chunks());
    let records = |v: &dyn Fn(usize) -> [f64; 3]| -> Vec<Record> {
        let record = |slot: usize| {
            let [a, b, c] = v(slot);
            Record([a, b, c, 0.0])
        };
        if lattice {
            vec![]
        } else {
            (0..layout.len).map(record).collect()
        }
    };
    let mut listed = vec![false; layout.len / CHUNK];
    families.iter().for_each(|f| f.mark_listed(&mut listed));
    let (groups, uses) = match lattice {
        true => (vec![], vec![Default::default(); programs.len()]),
        false => records::groups(&spec, &programs, layout.len),
    };
    let rounded = single::Rounded::new(&spec, &programs, layout.len);
    Engine {
        groups,
        uses,
        x_records: records(&|slot| layout.position(slot)),
        u_records: records(&|_| [0.0; 3]),
        listed,
        arrays: (0..arrays).map(|_| zeros(layout.len)).collect(),
        broken: vec![0; layout.chunks()],
        needs: Needs::of(&spec),
        sleep: Sleep::new(&spec, &programs, &homes),
        twins: twins(&spec, &homes),
        spec,
        isa,
        lattice,
        layout,
        families,
        programs,
        geometry,
        streams,
        constants,
        constants_at,
        grading,
        homes,
        reads_ghosts,
        state_slots,
        parts,
        bonds,
        redo,
        convolution: None,
        rounded,
        search: Duration::ZERO,
        unread: BTreeSet::new(),
    }
}

/// Forces first, then tangents, so that each is a slice of arrays.
fn homes(spec: &Spec) -> (Vec<Home>, usize, usize) {
    let mut homes = vec![None; spec.slots.len()];
    let (mut arrays, mut states) = (0, 0);
    for &k in spec.force.iter().chain(&spec.tangent) {
        homes[k as usize].get_or_insert(Home::Array(arrays));
        arrays += 1;
    }
    for (home, slot) in homes.iter_mut().zip(&spec.slots) {
        if home.is_some() {
            continue;
        }
        *home = Some(match slot.kind {
            SlotKind::Displacement(a) => Home::Displacement(a as usize),
            SlotKind::Velocity(a) => Home::Velocity(a as usize),
            SlotKind::Position(a) => Home::Position(a as usize),
            SlotKind::State => {
                states += 1;
                Home::State(states - 1)
            }
            SlotKind::Increment(_) | SlotKind::TimeStep | SlotKind::Computed(_) => {
                arrays += 1;
                Home::Array(arrays - 1)
            }
        });
    }
    (homes.into_iter().flatten().collect(), arrays, states)
}

/// Arrays of equal components of a force or a tangent: the one that sweeps write, and the one that is to have the same.
fn twins(spec: &Spec, homes: &[Home]) -> Vec<(usize, usize)> {
    let answers = spec.force.iter().chain(&spec.tangent).enumerate();
    let twin = |(to, k): (usize, &u32)| match homes[*k as usize] {
        Home::Array(from) if from != to => Some((from, to)),
        _ => None,
    };
    answers.filter_map(twin).collect()
}

fn bond_data(
    spec: &Spec,
    programs: &[Program],
    layout: &Layout,
    family: &Family,
    f: usize,
) -> BondData {
    let initial: Vec<f64> = spec
        .histories
        .iter()
        .filter(|h| h.bond && h.family as usize == f)
        .map(|h| h.initial)
        .collect();
    let reads_reverse = programs.iter().any(|p| p.family == f && p.reads_reverse);
    BondData {
        next: initial
            .iter()
            .map(|&v| vec![v; super::history_len(family)])
            .collect(),
        weights: spec
            .weights
            .iter()
            .filter(|w| w.family as usize == f)
            .map(|_| vec![1.0; super::history_len(family)])
            .collect(),
        initial,
        reverse: if reads_reverse {
            family.reverse(layout)
        } else {
            vec![]
        },
        armed: vec![],
        whole_reference: vec![0; layout.chunks()],
        whole_intact: vec![0; layout.chunks()],
        unbroken: false,
        stamp: 0,
    }
}

/// Cells within reach, for estimates.
pub(super) fn neighbours(body: &Body, horizon: f64) -> f64 {
    let dim = body.flavour.dim();
    let ball = [2.0, std::f64::consts::PI, 4.0 / 3.0 * std::f64::consts::PI][dim - 1];
    let h = horizon * INCLUSIVE / body.spacing;
    (ball * h.powi(dim as i32)).min(
        body.x.len() as f64
            * if body.periodic.iter().any(|p| p.is_some()) {
                1e9
            } else {
                1.0
            },
    )
}
