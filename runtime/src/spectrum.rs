//! The stable time step from the largest eigenvalue of the body itself.

use serde::{Deserialize, Serialize};

/// A time step and where it comes from.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StableStep {
    /// Upper estimate of the largest angular frequency [rad/s]; 0 for a law without momentum.
    pub omega: f64,
    /// Upper estimate of the fastest rate of a field [1/s]; 0 without fields.
    pub rate: f64,
    /// Share of `omega` squared that contact may add [rad^2/s^2].
    pub contact: f64,
    /// Applications of the tangent that it took.
    pub applications: usize,
    /// `safety` times the limit [s].
    pub dt: f64,
    pub safety: f64,
}
