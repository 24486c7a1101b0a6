//! Quantities of the body that can be written, by name.

use super::row::si_unit;
use crate::error::InputError;
use crate::simulate::Simulation;

/// A quantity on every node, user order; one array per component.
#[derive(Clone, Debug, PartialEq)]
pub struct Values {
    /// A name as the user wrote it.
    pub name: String,
    /// SI; empty for a number, and where the law does not say.
    pub unit: String,
    pub components: Vec<Vec<f64>>,
}

/// Names that every simulation knows, with units.
const BUILT_IN: [(&str, &str); 7] = [
    ("displacement", "m"),
    ("velocity", "m/s"),
    ("force", "N/m^3"),
    ("position", "m"),
    ("damage", ""),
    ("energy", "J/m^3"),
    ("volume", "m^3"),
];

/// Refuses names that mean nothing here, with those that do.
pub fn check(sim: &Simulation, name: &str) -> Result<(), InputError> {
    let (base, component) = split(name);
    let known = known(sim);
    let Some(count) = known.iter().find(|(n, _)| n == base).map(|(_, c)| *c) else {
        let names: Vec<&str> = known.iter().map(|(n, _)| n.as_str()).collect();
        return Err(InputError::new(
            format!("there is no quantity `{name}` to write"),
            format!("choose from {}", names.join(", ")),
        ));
    };
    match component {
        Some(c) if c >= count => Err(InputError::new(
            format!("`{base}` has {count} component(s), so there is no `{name}`"),
            "components are .x, .y, .z up to the dimension of the body",
        )),
        _ => Ok(()),
    }
}

/// Evaluates a quantity at an accepted step.
///
/// Errors: a name that [`check`] refuses.
pub fn quantity(sim: &mut Simulation, name: &str) -> Result<Values, InputError> {
    check(sim, name)?;
    let (base, component) = split(name);
    let mut components = all(sim, base);
    if let Some(c) = component {
        components = components.into_iter().skip(c).take(1).collect();
    }
    let field = sim.spec.fields.iter().find(|f| f.name == base);
    let unit = match BUILT_IN.iter().find(|(n, _)| *n == base) {
        Some((_, unit)) => unit.to_string(),
        None => field.map_or_else(String::new, |f| si_unit(f.exponents)),
    };
    Ok(Values {
        name: name.to_string(),
        unit,
        components,
    })
}

impl Values {
    /// One number per node: the value itself, or the magnitude of a vector.
    pub fn scalar(&self) -> Vec<f64> {
        if let [only] = self.components.as_slice() {
            return only.clone();
        }
        let n = self.components.first().map_or(0, Vec::len);
        (0..n)
            .map(|i| {
                self.components
                    .iter()
                    .map(|c| c[i] * c[i])
                    .sum::<f64>()
                    .sqrt()
            })
            .collect()
    }
}

/// `velocity.z` is component 2 of `velocity`.
fn split(name: &str) -> (&str, Option<usize>) {
    match name.rsplit_once('.') {
        Some((base, "x")) => (base, Some(0)),
        Some((base, "y")) => (base, Some(1)),
        Some((base, "z")) => (base, Some(2)),
        _ => (name, None),
    }
}

/// Names and their numbers of components.
fn known(sim: &Simulation) -> Vec<(String, usize)> {
    let dim = sim.body.flavour.dim();
    let vector = |name: &str| matches!(name, "displacement" | "velocity" | "force" | "position");
    let exists = |name: &str| match name {
        "displacement" | "velocity" | "force" => !sim.spec.force.is_empty(),
        "energy" => sim.spec.energy.is_some(),
        _ => true,
    };
    let built_in = BUILT_IN.iter().filter(|(n, _)| exists(n));
    let mut names: Vec<(String, usize)> = built_in
        .map(|(n, _)| (n.to_string(), if vector(n) { dim } else { 1 }))
        .collect();
    names.extend(
        sim.spec
            .fields
            .iter()
            .map(|f| (f.name.clone(), f.slots.len())),
    );
    names.extend(
        sim.spec
            .named
            .iter()
            .map(|(n, slots)| (n.clone(), slots.len())),
    );
    names
}

fn all(sim: &mut Simulation, base: &str) -> Vec<Vec<f64>> {
    let energy = if base == "energy" {
        sim.engine.energy(&sim.state).to_vec()
    } else {
        Vec::new()
    };
    let user = |layout: &[f64]| {
        sim.engine
            .slots()
            .iter()
            .map(|&s| layout[s as usize])
            .collect::<Vec<f64>>()
    };
    let each = |arrays: &[Vec<f64>]| arrays.iter().map(|a| user(a)).collect::<Vec<_>>();
    match base {
        "displacement" => each(&sim.state.u),
        "velocity" => each(&sim.state.v),
        "force" => each(sim.engine.force()),
        "position" => {
            let mut y = each(&sim.state.u);
            for (d, y) in y.iter_mut().enumerate() {
                y.iter_mut().zip(&sim.body.x).for_each(|(y, x)| *y += x[d]);
            }
            y
        }
        "damage" => vec![sim.engine.damage(&sim.state)],
        "energy" => vec![user(&energy)],
        "volume" => vec![sim.body.volume.clone()],
        _ => match sim.engine.state_slots(base) {
            Some(slots) => slots
                .into_iter()
                .map(|k| user(&sim.state.slots[k]))
                .collect(),
            None => sim.engine.named(base).unwrap_or_default(),
        },
    }
}
