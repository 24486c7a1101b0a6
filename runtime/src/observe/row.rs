//! One row of the history.

use serde::{Deserialize, Serialize};

/// Totals of the body at an accepted step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Row {
    pub step: u64,
    /// [s]
    pub time: f64,
    /// [J]
    pub kinetic: f64,
    /// Sum of W V [J]; 0 for a law without energy.
    pub strain: f64,
    /// Work of prescribed motion and body forces since the start [J].
    pub work_conditions: f64,
    /// Work of the spheres on the body since the start [J].
    pub work_contact: f64,
    /// Energy that bonds took with them when they broke [J]: what is missing in the balance.
    pub lost: f64,
    /// Broken bonds, each counted once.
    pub broken: u64,
    /// Share of all bonds.
    pub broken_fraction: f64,
    /// [kg m/s]
    pub momentum: [f64; 3],
    /// About the origin [kg m^2/s].
    pub angular_momentum: [f64; 3],
    /// Total force on the spheres [N].
    pub contact_force: [f64; 3],
    /// Total impulse on the spheres [N s].
    pub contact_impulse: [f64; 3],
}
