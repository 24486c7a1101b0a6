//! Memory: an estimate before anything is allocated, and a report afterwards.
use super::geometry::Geometry;
use super::parts::PartReport;
use super::program::Program;
use super::setup::neighbours;
use super::{Engine, Isa, Settings, SetupError};
use crate::body::Body;
use crate::layout::plan_lattice;
use crate::spec::Spec;
use crate::traverse::CHUNK;

/// What an engine is made of.
#[derive(Clone, Debug)]
pub struct Report {
    pub nodes: usize,
    /// Directed bonds of the whole horizon.
    pub bonds: usize,
    /// `lattice` or `cloud`.
    pub traversal: &'static str,
    pub isa: Isa,
    /// (name, compiled rather than interpreted)
    pub sweeps: Vec<(String, bool)>,
    /// Masks, neighbour lists, geometry, histories.
    pub bond_bytes: usize,
    /// Node arrays of the engine and of one state.
    pub node_bytes: usize,
    /// Fields that live on a part of the body.
    pub parts: Vec<PartReport>,
    /// Lanes of the chunks that hold no node, as a part of all; each material and horizon begins a chunk.
    pub empty_lanes: f64,
    /// Constants of the law at the nodes of the first material, by position.
    pub constants: Vec<f64>,
}

impl Engine {
    pub fn report(&self) -> Report {
        let bytes = |v: &[Vec<f64>]| v.iter().map(|v| 8 * v.len()).sum::<usize>();
        let mut bond_bytes = bytes(&self.streams);
        for geometry in &self.geometry {
            if let Geometry::Table { values, records } = geometry {
                bond_bytes += 8 * (values.len() + records.len());
            }
        }
        for (f, b) in self.families.iter().zip(&self.bonds) {
            bond_bytes += f.bytes()
                + f.present.len()
                + 2 * bytes(&b.next)
                + bytes(&b.weights)
                + 4 * b.reverse.len()
                + b.armed.len();
        }
        let state: usize = (0..self.state_slots).map(|k| self.stored(k)).sum();
        Report {
            nodes: self.layout.slot.len(),
            bonds: self.families[0].bonds,
            traversal: if self.lattice { "lattice" } else { "cloud" },
            isa: self.isa,
            sweeps: self
                .programs
                .iter()
                .map(|p| (p.name.clone(), p.compiled))
                .collect(),
            bond_bytes,
            node_bytes: self.layout.bytes()
                + 32 * (self.x_records.len() + self.u_records.len())
                + bytes(&self.arrays)
                + self.parts.bytes()
                + self.sleep.bytes()
                + 8 * (2 * self.spec.dim * self.layout.len + state),
            parts: self.part_reports(),
            empty_lanes: 1.0
                - self.layout.slot.len() as f64 / (CHUNK * self.layout.chunks()) as f64,
            constants: self.constants(0).to_vec(),
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
    let per_node = 8.0 * (spec.slots.len() + 6 * spec.dim + 6) as f64;
    let (slots, bonds, per_bond) = match &body.grid {
        Some(grid) if lattice => {
            let plan = plan_lattice(body, grid, s.reach(), s.materials.len());
            let family = neighbours(body, s.reach());
            (plan.len as f64, (plan.chunks * CHUNK) as f64 * family, 0.5)
        }
        _ => {
            let n = body.x.len() as f64;
            let geometry: usize = programs.iter().map(|p| p.geometry.outs.len()).sum();
            let bonds = match s.horizon[..] {
                [horizon] => n * neighbours(body, horizon),
                _ => {
                    let each: Vec<f64> = s.horizon.iter().map(|h| neighbours(body, *h)).collect();
                    body.material.iter().map(|m| each[*m as usize]).sum()
                }
            };
            (n, bonds, 4.5 + 8.0 * geometry as f64)
        }
    };
    let weights = spec.weights.len() as f64;
    slots * per_node
        + bonds * families * (per_bond + 24.0 * histories + 4.0 * reverse)
        + bonds * 16.0 * weights
}

/// Free memory [bytes], where the system says so.
fn available() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find(|l| l.starts_with("MemAvailable:"))?;
    line.split_whitespace()
        .nth(1)?
        .parse::<u64>()
        .ok()
        .map(|kb| kb * 1024)
}
