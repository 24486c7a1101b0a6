//! Memory: an estimate before anything is allocated, and a report afterwards.
use super::geometry::{Geometry, Kept, streams_of_bonds};
use super::parts::PartReport;
use super::program::Program;
use super::records;
use super::setup::neighbours;
use super::{ConvolutionReport, Engine, Isa, Settings, SetupError, single};
use crate::body::Body;
use crate::layout::{Shape, plan_lattice};
use crate::spec::{Spec, Stage};
use crate::traverse::CHUNK;

/// What an engine is made of.
#[derive(Clone, Debug)]
pub struct Report {
    pub nodes: usize,
    /// Directed bonds of the whole horizon.
    pub bonds: usize,
    /// Laying out the nodes and finding their families [s].
    pub search: f64,
    /// `lattice`, `cloud` or `convolution`.
    pub traversal: &'static str,
    pub isa: Isa,
    /// Sweeps that sum in single precision.
    pub single: Vec<String>,
    /// (name, compiled rather than interpreted)
    pub sweeps: Vec<(String, bool)>,
    /// Those of the same in detail.
    pub work: Vec<SweepReport>,
    /// Numbers that belong to a kind of bond on a lattice, to a bond in a cloud; how many kinds there are.
    pub geometry: usize,
    pub kinds: usize,
    /// Neighbour lists of the whole horizon [bytes per bond]; the part of the chunks in which rows lead from eight nodes side
    /// by side to eight nodes side by side. Zero on a lattice.
    pub lists: f64,
    pub runs: f64,
    /// Materials with horizons of their own.
    pub materials: usize,
    /// The part of the chunks in which all bonds of eight nodes are present and intact: sweeps that break no bonds
    /// run without masks there.
    pub whole: f64,
    /// Masks, neighbour lists, geometry, histories.
    pub bond_bytes: usize,
    /// Node arrays of the engine and of one state.
    pub node_bytes: usize,
    /// Fields that live on a part of the body.
    pub parts: Vec<PartReport>,
    /// Lanes of the chunks that hold no node, as a part of all; each material and horizon begins a chunk.
    pub empty_lanes: f64,
    /// Sums over bonds that are convolutions.
    pub convolution: Option<ConvolutionReport>,
    /// Constants of the law at the nodes of the first material, by position.
    pub constants: Vec<f64>,
}

/// What a sweep does.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SweepReport {
    pub name: String,
    pub stage: Stage,
    /// Has bonds to go through, and may break some.
    pub loops: bool,
    pub breaks: bool,
    /// Values that it reads at the other end of a bond, besides displacements.
    pub far: usize,
    /// Whether a force, a rate, an energy, a history or another sweep reads what it writes.
    pub read: bool,
    /// False where nothing is read at all, with [`Engine::keep_named`].
    pub runs: bool,
}

impl Engine {
    /// Whether a bond can break, with the parameters at hand.
    pub fn can_break(&self) -> bool {
        self.programs.iter().any(|p| p.kills)
    }

    fn work(&self) -> Vec<SweepReport> {
        let asked = self.asked();
        let one = |(k, p): (usize, &Program)| {
            let later = |slot: &usize| {
                let mut later = self.programs[k + 1..].iter();
                later.any(|q| q.own.contains(slot) || q.nbr.contains(slot))
            };
            SweepReport {
                name: p.name.clone(),
                stage: p.stage,
                loops: p.loops,
                breaks: p.kills,
                far: p.nbr.len(),
                runs: !p.unread,
                read: p.kills
                    || p.writes.contains(&true)
                    || p.out.iter().any(|slot| asked.contains(slot) || later(slot)),
            }
        };
        self.programs.iter().enumerate().map(one).collect()
    }

    pub fn report(&self) -> Report {
        let bytes = |v: &[Vec<f64>]| v.iter().map(|v| 8 * v.len()).sum::<usize>();
        let mut bond_bytes: usize = self.streams.iter().map(Kept::bytes).sum();
        for geometry in (self.geometry.iter()).chain(self.rounded.tables.iter().flatten()) {
            if let Geometry::Table { values, records } = geometry {
                bond_bytes += 8 * (values.len() + records.len());
            }
        }
        for (k, (f, b)) in self.families.iter().zip(&self.bonds).enumerate() {
            // A state that breaks none has the masks of the family.
            bond_bytes += f.bytes()
                + f.present.len() * usize::from(self.breaks(k))
                + 2 * bytes(&b.next)
                + bytes(&b.weights)
                + 4 * b.reverse.len()
                + b.armed.len();
        }
        let step = |k: &usize| self.programs[*k].stage == Stage::Step;
        let (mut geometry, mut kinds) = (self.streams.iter().filter(|s| s.differs()).count(), 0);
        if let Shape::Stencil(stencil) = &self.families[0].shape {
            let steps = (0..self.programs.len()).filter(step);
            geometry = steps.map(|k| self.programs[k].geometry.outs.len()).sum();
            kinds = stencil.kinds.len();
        }
        let whole = self.bonds[0].whole_intact.iter();
        let whole = whole.filter(|w| **w != 0).count();
        let (lists, runs) = self.families[0].lists();
        let convolution = self.convolution.as_ref();
        let convolution = convolution.map(|c| c.report(&self.programs));
        let state: usize = (0..self.state_slots).map(|k| self.stored(k)).sum();
        Report {
            nodes: self.layout.slot.len(),
            bonds: self.families[0].bonds,
            search: self.search.as_secs_f64(),
            traversal: match (self.lattice, &convolution) {
                (true, Some(_)) => "convolution",
                (true, None) => "lattice",
                (false, _) => "cloud",
            },
            isa: self.isa,
            single: (self.programs.iter().filter(|p| p.single.is_some()))
                .map(|p| p.name.clone())
                .collect(),
            sweeps: self
                .programs
                .iter()
                .map(|p| (p.name.clone(), p.compiled))
                .collect(),
            work: self.work(),
            geometry,
            kinds,
            lists,
            runs,
            materials: self.layout.parts.len().max(1),
            whole: whole as f64 / self.layout.chunks().max(1) as f64,
            bond_bytes,
            node_bytes: self.layout.bytes()
                + self.record_bytes()
                + self.rounded.bytes()
                + bytes(&self.arrays)
                + self.parts.bytes()
                + self.sleep.bytes(self.layout.len)
                + convolution.as_ref().map_or(0, |c| c.bytes)
                + 8 * (2 * self.spec.dim * self.layout.len + state),
            parts: self.part_reports(),
            empty_lanes: 1.0
                - self.layout.slot.len() as f64 / (CHUNK * self.layout.chunks()) as f64,
            constants: self.constants(0).to_vec(),
            convolution,
        }
    }
}

/// Refuses a body that does not fit.
pub(super) fn check(
    spec: &Spec,
    programs: &[Program],
    body: &Body,
    s: &Settings,
    lattice: bool,
) -> Result<(), SetupError> {
    let needed = estimate(spec, programs, body, s, lattice);
    match available() {
        Some(available) if needed > available as f64 => Err(SetupError::Memory {
            needed: needed as u64,
            available,
        }),
        _ => Ok(()),
    }
}

/// Bytes of the engine and two states (a run holds a checkpoint now and then).
fn estimate(spec: &Spec, programs: &[Program], body: &Body, s: &Settings, lattice: bool) -> f64 {
    let histories = spec.histories.iter().filter(|h| h.bond).count() as f64;
    let reverse = programs.iter().any(|p| p.reads_reverse) as u8 as f64;
    let families = spec.families.len() as f64;
    let mut per_node = 8.0 * (spec.slots.len() + 6 * spec.dim + 6) as f64;
    per_node += single::bytes_per_node(spec, programs) as f64;
    let (slots, bonds, per_bond) = match &body.grid {
        Some(grid) if lattice => {
            let plan = plan_lattice(body, grid, s.reach(), s.materials.len());
            let family = neighbours(body, s.reach());
            (plan.len as f64, (plan.chunks * CHUNK) as f64 * family, 0.5)
        }
        _ => {
            let n = body.x.len() as f64;
            // Lanes of runs that lack a bond, in a body that only nearly is a lattice.
            let lanes = if body.grid.is_some() { 1.1 } else { 1.4 };
            let streams = streams_of_bonds(spec, programs, s.materials.len());
            let bonds = match s.horizon[..] {
                [horizon] => n * neighbours(body, horizon),
                _ => {
                    let each: Vec<f64> = s.horizon.iter().map(|h| neighbours(body, *h)).collect();
                    body.material.iter().map(|m| each[*m as usize]).sum()
                }
            };
            per_node += 32.0 * records::per_node(spec, programs) as f64;
            (n, lanes * bonds, 4.5 + 8.0 * streams as f64)
        }
    };
    let weights = spec.weights.len() as f64;
    slots * per_node
        + bonds * families * (per_bond + 24.0 * histories + 4.0 * reverse)
        + bonds * 16.0 * weights
}

/// Free memory [bytes], where the system says so.
pub(super) fn available() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|l| l.starts_with("MemAvailable:"))?;
    line.split_whitespace()
        .nth(1)?
        .parse::<u64>()
        .ok()
        .map(|kb| kb * 1024)
}
