//! What ran, how big it was, how long it took.

use super::{Row, left_out};
use crate::contact::Reaction;
use crate::simulate::{Simulation, Stopped};
use crate::spectrum::StableStep;
use serde::{Deserialize, Serialize};

/// The result of a run; `summary.json` holds it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    pub title: String,
    pub law: String,
    /// Whether the law was taken for small displacements.
    #[serde(default)]
    pub linearised: bool,
    pub flavour: String,
    pub nodes: usize,
    /// Each counted once.
    pub bonds: u64,
    /// [m]
    pub spacing: f64,
    /// The smallest of all nodes [m].
    pub horizon: f64,
    /// The largest of all nodes [m].
    pub reach: f64,
    /// How many different ones there are, and by how much rounding changed one, as a part of it.
    pub horizon_levels: usize,
    pub horizon_rounding: f64,
    /// Lanes of the chunks that hold no node, as a part of all.
    pub empty_lanes: f64,
    pub traversal: String,
    pub instruction_set: String,
    /// Whether the sweeps are machine code or interpreted.
    pub compiled: bool,
    pub threads: usize,
    pub bond_bytes: u64,
    pub node_bytes: u64,
    /// Constants of the law as used, in its own order (SI).
    pub constants: Vec<f64>,
    pub steps: u64,
    /// [s]
    pub time: f64,
    /// [s]
    pub dt: f64,
    pub stable: Option<StableStep>,
    /// Stages of the fields in a step; 0 without fields.
    pub stages: u32,
    pub timings: Timings,
    /// Wall time of a force evaluation per directed bond [ns].
    pub ns_per_bond: f64,
    pub last: Row,
    pub contact: Vec<Reaction>,
    /// The part of the force evaluations that was left out because nothing had changed there.
    pub slept: f64,
    /// What this run did not need and did not compute.
    pub left_out: Vec<String>,
    /// Set when the run stopped early.
    pub stopped: Option<String>,
}

/// Wall time by phase [s].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Timings {
    pub setup: f64,
    pub stable_step: f64,
    pub forces: f64,
    pub integration: f64,
    /// Steps of the fields, their rates included.
    pub fields: f64,
    pub contact: f64,
    pub energy: f64,
    pub output: f64,
    pub total: f64,
}

impl Summary {
    /// Of a simulation where it stands.
    pub fn of(sim: &Simulation, stopped: Option<&Stopped>) -> Summary {
        let report = sim.engine.report();
        let work = report.bonds as f64 * sim.evaluations as f64;
        Summary {
            title: sim.title.clone(),
            law: sim.spec.law.clone(),
            linearised: sim.spec.linearised,
            flavour: sim.body.flavour.name().to_string(),
            nodes: report.nodes,
            bonds: report.bonds as u64 / 2,
            spacing: sim.body.spacing,
            horizon: sim.horizon,
            reach: sim.reach,
            horizon_levels: sim.engine.grading().horizons.len(),
            horizon_rounding: sim.engine.grading().rounding,
            empty_lanes: report.empty_lanes,
            traversal: report.traversal.to_string(),
            instruction_set: format!("{:?}", report.isa).to_lowercase(),
            compiled: report.sweeps.iter().all(|(_, compiled)| *compiled),
            threads: rayon::current_num_threads(),
            bond_bytes: report.bond_bytes as u64,
            node_bytes: report.node_bytes as u64,
            constants: report.constants,
            steps: sim.state.step,
            time: sim.state.time,
            dt: sim.dt,
            stable: sim.stable.clone(),
            stages: sim.stages,
            timings: sim.timings,
            ns_per_bond: if work > 0.0 {
                1e9 * sim.timings.forces / work
            } else {
                0.0
            },
            last: sim.row.clone(),
            contact: sim.contact.reactions(),
            slept: sim.engine.slept(),
            left_out: left_out(sim),
            stopped: stopped.map(Stopped::to_string),
        }
    }
}
