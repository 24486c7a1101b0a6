//! One row of the history.

use crate::integrate::total;
use crate::language::{Exponents, dimension};
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
    /// Sum of W V [J]; nothing for a law without energy.
    pub strain: Option<f64>,
    /// Work of prescribed motion and body forces since the start [J].
    pub work_conditions: f64,
    /// Work of the spheres on the body since the start [J].
    pub work_contact: f64,
    /// What has left through matching boundaries since the start [J].
    pub left: f64,
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
    /// One per field component of the law.
    pub fields: Vec<FieldRow>,
}

/// A field component over the body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FieldRow {
    /// Name in the law, and a number where there are several components.
    pub name: String,
    /// SI, as `K` or `W/m^3`; empty for a number.
    pub unit: String,
    pub min: f64,
    /// Weighted with the volumes.
    pub mean: f64,
    pub max: f64,
    /// Sum of value times volume [unit m^3]: what an insulated body conserves.
    pub total: f64,
}

impl Row {
    /// Kinetic energy, with the strain energy of a law that has one [J].
    pub(crate) fn energy(&self) -> f64 {
        self.kinetic + self.strain.unwrap_or_default()
    }

    /// The columns of `history.csv` that every law has, in order; those of the fields follow.
    pub const COLUMNS: [&str; 22] = [
        "step",
        "time_s",
        "kinetic_J",
        "strain_J",
        "work_conditions_J",
        "work_contact_J",
        "left_J",
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

    /// All columns of `history.csv`.
    pub fn columns(&self) -> Vec<String> {
        let mut names: Vec<String> = Row::COLUMNS.map(String::from).to_vec();
        for f in &self.fields {
            let unit = f.unit.replace(' ', "_").replace('^', "");
            let one = |what: &str| match unit.is_empty() {
                true => format!("{}_{what}", f.name),
                false => format!("{}_{what}_{unit}", f.name),
            };
            names.extend(["min", "mean", "max"].map(one));
            names.push(one("total") + "_m3");
        }
        names
    }

    /// The values in the order of [`Row::columns`], empty where there is none; numbers in the shortest form that reads back to the same bits.
    pub fn values(&self) -> Vec<String> {
        let mut out = vec![self.step.to_string(), format!("{:e}", self.time)];
        let energies = [
            Some(self.kinetic),
            self.strain,
            Some(self.work_conditions),
            Some(self.work_contact),
            Some(self.left),
            Some(self.lost),
        ];
        let written = |v: &Option<f64>| v.map_or(String::new(), |v| format!("{v:e}"));
        out.extend(energies.iter().map(written));
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
        for f in &self.fields {
            out.extend([f.min, f.mean, f.max, f.total].map(|v| format!("{v:e}")));
        }
        out
    }

    /// All columns of a simulation's `history.csv`.
    pub(crate) fn columns_of(sim: &Simulation) -> Vec<String> {
        let row = Row {
            fields: fields(sim),
            ..Row::default()
        };
        row.columns()
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
            left: sim.conditions.left,
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
            fields: fields(sim),
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

/// Smallest, mean, largest value and total of every field component, in user order.
fn fields(sim: &Simulation) -> Vec<FieldRow> {
    let (slots, volume) = (sim.engine.slots(), &sim.body.volume);
    let whole = total(volume.len(), |node| [volume[node]])[0];
    let row = |(name, unit, slot): (String, Exponents, usize)| {
        let values = sim.engine.spread(slot, &sim.state.slots[slot]);
        let at = |node: usize| values[slots[node] as usize];
        let [sum] = total(volume.len(), |node| [at(node) * volume[node]]);
        let nodes = 0..volume.len();
        FieldRow {
            name,
            unit: si_unit(unit),
            min: nodes.clone().map(at).fold(f64::INFINITY, f64::min),
            mean: sum / whole,
            max: nodes.map(at).fold(f64::NEG_INFINITY, f64::max),
            total: sum,
        }
    };
    let components = sim.engine.field_components();
    components.into_iter().map(row).collect()
}

/// A unit in the seven base units, from doubled exponents: `kg m^-1 s^-1`; heat has its own name.
pub(super) fn si_unit(exponents: Exponents) -> String {
    if exponents == dimension::POWER_DENSITY {
        return "W/m^3".into();
    }
    let names = ["m", "kg", "s", "A", "K", "mol", "cd"];
    let factor = |k: usize| match exponents[k] {
        0 => None,
        2 => Some(names[k].to_string()),
        n if n % 2 == 0 => Some(format!("{}^{}", names[k], n / 2)),
        n => Some(format!("{}^{:.1}", names[k], f64::from(n) / 2.0)),
    };
    // Mass first, as is usual.
    let order = [1, 0, 2, 3, 4, 5, 6];
    order
        .into_iter()
        .filter_map(factor)
        .collect::<Vec<_>>()
        .join(" ")
}

/// Kinetic energy, momentum, angular momentum, in user order.
fn motion(sim: &Simulation) -> [f64; 7] {
    if sim.spec.force.is_empty() {
        return [0.0; 7];
    }
    let (slots, state) = (sim.engine.slots(), &sim.state);
    total(sim.body.x.len(), |node| {
        let s = slots[node] as usize;
        let (mut y, mut v) = (sim.body.x[node], [0.0; 3]);
        for d in 0..state.u.len() {
            y[d] += state.u[d][s];
            v[d] = state.v[d][s];
        }
        let m = sim.density.at(s) * sim.body.volume[node];
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
fn strain(sim: &mut Simulation) -> Option<f64> {
    sim.spec.energy?;
    let w = sim.engine.energy(&sim.state).to_vec();
    let (volume, slots) = (&sim.body.volume, sim.engine.slots());
    let [sum] = total(
        volume.len(),
        |node| [w[slots[node] as usize] * volume[node]],
    );
    Some(sum)
}
