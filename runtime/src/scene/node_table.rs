//! A table of all nodes, so that any other code can be compared node by node.

use std::fmt::Write;
use std::path::Path;

use crate::engine::Breaking;
use crate::simulate::Simulation;

/// Writes CSV: reference position [m], displacement [m], velocity [m/s], force density [N/m^3] and, where
/// the law has an energy, its density [J/m^3], with 17 digits, in the order of the body's nodes.
///
/// # Errors
/// When the file cannot be written.
pub fn write(simulation: &mut Simulation, path: &Path) -> std::io::Result<()> {
    std::fs::write(path, text(simulation))
}

/// The table as text.
pub fn text(simulation: &mut Simulation) -> String {
    let Simulation {
        body,
        engine,
        state,
        ..
    } = simulation;
    let dim = body.flavour.dim();
    // What broke in the last step is broken: the forces are those of the state, evaluated without change.
    engine.forces(state, Breaking::Held);
    let energy = match engine.spec().energy {
        Some(_) => engine.energy(state).to_vec(),
        None => Vec::new(),
    };
    let force = engine.force();
    let mut table = heading(dim, !energy.is_empty());
    for (node, x) in body.x.iter().enumerate() {
        let slot = engine.slot(node);
        let mut cells: Vec<f64> = x[..dim].to_vec();
        for arrays in [&state.u[..], &state.v[..], force] {
            cells.extend(arrays.iter().map(|a| a[slot]));
        }
        cells.extend(energy.get(slot));
        let cells: Vec<String> = cells.iter().map(|c| format!("{c:.16e}")).collect();
        let _ = writeln!(table, "{}", cells.join(","));
    }
    table
}

fn heading(dim: usize, energy: bool) -> String {
    let axes = &["x", "y", "z"][..dim];
    let mut names: Vec<String> = Vec::new();
    for prefix in ["", "u", "v", "f"] {
        names.extend(axes.iter().map(|a| format!("{prefix}{a}")));
    }
    if energy {
        names.push("W".into());
    }
    format!("{}\n", names.join(","))
}
