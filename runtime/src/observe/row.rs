//! One row of the history.

use crate::integrate::total;
use crate::simulate::Simulation;
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

impl Row {
    /// The columns of `history.csv`, in order.
    pub const COLUMNS: [&str; 21] = [
        "step",
        "time_s",
        "kinetic_J",
        "strain_J",
        "work_conditions_J",
        "work_contact_J",
        "lost_J",
        "broken_bonds",
        "broken_fraction",
        "momentum_x_Ns",
        "momentum_y_Ns",
        "momentum_z_Ns",
        "angular_momentum_x_Nms",
        "angular_momentum_y_Nms",
        "angular_momentum_z_Nms",
        "contact_force_x_N",
        "contact_force_y_N",
        "contact_force_z_N",
        "contact_impulse_x_Ns",
        "contact_impulse_y_Ns",
        "contact_impulse_z_Ns",
    ];

    /// The values in the order of [`Row::COLUMNS`]; numbers in the shortest form that reads back to the same bits.
    pub fn values(&self) -> Vec<String> {
        let mut out = vec![self.step.to_string(), format!("{:e}", self.time)];
        let energies = [
            self.kinetic,
            self.strain,
            self.work_conditions,
            self.work_contact,
            self.lost,
        ];
        out.extend(energies.iter().map(|v| format!("{v:e}")));
        out.push(self.broken.to_string());
        let vectors = [
            self.momentum,
            self.angular_momentum,
            self.contact_force,
            self.contact_impulse,
        ];
        out.extend(
            std::iter::once(&self.broken_fraction)
                .chain(vectors.iter().flatten())
                .map(|v| format!("{v:e}")),
        );
        out
    }

    /// Totals at the accepted step of a simulation; `lost` is left 0.
    pub(crate) fn of(sim: &mut Simulation) -> Row {
        let bonds = sim.bonds;
        let [kinetic, p0, p1, p2, l0, l1, l2] = motion(sim);
        let mut row = Row {
            step: sim.state.step,
            time: sim.state.time,
            kinetic,
            strain: strain(sim),
            work_conditions: sim.conditions.work,
            work_contact: sim.contact.work(),
            lost: 0.0,
            broken: sim.broken / 2,
            broken_fraction: if bonds > 0 {
                sim.broken as f64 / bonds as f64
            } else {
                0.0
            },
            momentum: [p0, p1, p2],
            angular_momentum: [l0, l1, l2],
            contact_force: [0.0; 3],
            contact_impulse: [0.0; 3],
        };
        for reaction in sim.contact.reactions() {
            for d in 0..3 {
                row.contact_force[d] += reaction.force[d];
                row.contact_impulse[d] += reaction.impulse[d];
            }
        }
        row
    }
}

/// Kinetic energy, momentum, angular momentum, in user order.
fn motion(sim: &Simulation) -> [f64; 7] {
    let (slots, state) = (sim.engine.slots(), &sim.state);
    total(sim.body.x.len(), |node| {
        let s = slots[node] as usize;
        let (mut y, mut v) = (sim.body.x[node], [0.0; 3]);
        for d in 0..state.u.len() {
            y[d] += state.u[d][s];
            v[d] = state.v[d][s];
        }
        let m = sim.density * sim.body.volume[node];
        let square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
        let l = [
            y[1] * v[2] - y[2] * v[1],
            y[2] * v[0] - y[0] * v[2],
            y[0] * v[1] - y[1] * v[0],
        ];
        [
            0.5 * m * square,
            m * v[0],
            m * v[1],
            m * v[2],
            m * l[0],
            m * l[1],
            m * l[2],
        ]
    })
}

/// Sum of W V; the energy sweep runs only here and where energy is an output.
fn strain(sim: &mut Simulation) -> f64 {
    if sim.spec.energy.is_none() {
        return 0.0;
    }
    let w = sim.engine.energy(&sim.state).to_vec();
    let (volume, slots) = (&sim.body.volume, sim.engine.slots());
    total(
        volume.len(),
        |node| [w[slots[node] as usize] * volume[node]],
    )[0]
}
