//! What ran, how big it was, how long it took.

use super::Row;
use crate::contact::Reaction;
use crate::spectrum::StableStep;
use serde::{Deserialize, Serialize};

/// The result of a run; `summary.json` holds it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    pub title: String,
    pub law: String,
    pub flavour: String,
    pub nodes: usize,
    /// Each counted once.
    pub bonds: u64,
    /// [m]
    pub spacing: f64,
    /// [m]
    pub horizon: f64,
    pub traversal: String,
    pub instruction_set: String,
    /// Whether the sweeps are machine code or interpreted.
    pub compiled: bool,
    pub threads: usize,
    pub bond_bytes: u64,
    pub node_bytes: u64,
    /// Constants of the law as used: name and value.
    pub constants: Vec<(String, f64)>,
    pub steps: u64,
    /// [s]
    pub time: f64,
    /// [s]
    pub dt: f64,
    pub stable: Option<StableStep>,
    pub timings: Timings,
    /// Wall time of a force evaluation per directed bond [ns].
    pub ns_per_bond: f64,
    pub last: Row,
    pub contact: Vec<Reaction>,
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
    pub contact: f64,
    pub energy: f64,
    pub output: f64,
    pub total: f64,
}
