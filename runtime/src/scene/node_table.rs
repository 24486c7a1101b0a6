//! A table of all nodes, so that any other code can be compared node by node.

use std::borrow::Cow;
use std::fmt::Write;
use std::path::Path;

use crate::engine::Breaking;
use crate::simulate::Simulation;

const AXES: [&str; 3] = ["x", "y", "z"];

/// Writes CSV: reference position [m]; where the law has a force, displacement [m], velocity [m/s] and force density
/// [N/m^3]; where it has an energy, its density [J/m^3]; its fields, and their rates per second. 17 digits, in the order
/// of the body's nodes.
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
    let fields = engine.field_components();
    let everywhere = |(_, _, slot): &(String, _, usize)| engine.spread(*slot, &state.slots[*slot]);
    let values: Vec<Cow<[f64]>> = fields.iter().map(everywhere).collect();
    let mut columns: Vec<(String, &[f64])> = Vec::new();
    if !engine.spec().force.is_empty() {
        for (prefix, arrays) in [("u", &state.u[..]), ("v", &state.v), ("f", engine.force())] {
            let axes = AXES.iter().zip(arrays);
            columns.extend(axes.map(|(axis, a)| (format!("{prefix}{axis}"), &a[..])));
        }
    }
    if !energy.is_empty() {
        columns.push(("W".into(), &energy));
    }
    for ((name, ..), values) in fields.iter().zip(&values) {
        columns.push((name.clone(), values));
    }
    let rates = engine.rates();
    let rates = rates.map(|r| (r.slot, engine.spread(r.slot, &r.whole(state)).into_owned()));
    let rates: Vec<(usize, Vec<f64>)> = rates.collect();
    for (slot, rate) in &rates {
        let name = fields.iter().find(|f| f.2 == *slot);
        columns.push((
            name.map_or_else(String::new, |n| format!("{}_rate", n.0)),
            rate,
        ));
    }
    let names: Vec<&str> = AXES[..dim]
        .iter()
        .copied()
        .chain(columns.iter().map(|c| c.0.as_str()))
        .collect();
    let mut table = names.join(",") + "\n";
    for (node, x) in body.x.iter().enumerate() {
        let slot = engine.slot(node);
        let values = columns.iter().map(|c| c.1[slot]);
        let cells = x[..dim].iter().copied().chain(values);
        let cells: Vec<String> = cells.map(|c| format!("{c:.16e}")).collect();
        let _ = writeln!(table, "{}", cells.join(","));
    }
    table
}
