//! Quantities of the body that can be written, by name.

use super::row::si_unit;
use crate::error::InputError;
use crate::simulate::Simulation;
use crate::spec::{SlotKind, Spec, Stage};

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
    let (base, axes) = split(name);
    let known = known(sim);
    let Some(count) = known.iter().find(|(n, _)| n == base).map(|(_, c)| *c) else {
        let names: Vec<&str> = known.iter().map(|(n, _)| n.as_str()).collect();
        return Err(InputError::new(
            format!("there is no quantity `{name}` to write"),
            format!("choose from {}", names.join(", ")),
        ));
    };
    if sim.engine.left_out().any(|left_out| left_out == base) {
        return Err(InputError::new(
            format!("`{base}` was left out, as no output of the scene shows it"),
            "name it in [output], or do not call `Simulation::keep_outputs`",
        ));
    }
    let dim = sim.body.flavour.dim();
    match axes {
        Some(axes) if component(axes, count, dim).is_none() => Err(InputError::new(
            format!("`{base}` has {count} component(s), so there is no `{name}`"),
            "components are .x, .y, .z up to the dimension of the body, of tensors .xx, .xy and so on",
        )),
        _ => Ok(()),
    }
}

/// Evaluates a quantity at an accepted step.
///
/// Errors: a name that [`check`] refuses.
pub fn quantity(sim: &mut Simulation, name: &str) -> Result<Values, InputError> {
    check(sim, name)?;
    let (base, axes) = split(name);
    let mut components = all(sim, base);
    let (count, dim) = (components.len(), sim.body.flavour.dim());
    if let Some(c) = axes.and_then(|axes| component(axes, count, dim)) {
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

/// `velocity.z` is the component `z` of `velocity`.
pub(crate) fn split(name: &str) -> (&str, Option<&str>) {
    let axis = |letter: char| "xyz".contains(letter);
    match name.rsplit_once('.') {
        Some((base, axes)) if matches!(axes.len(), 1 | 2) && axes.chars().all(axis) => {
            (base, Some(axes))
        }
        _ => (name, None),
    }
}

/// The position of a component among as many: of a vector, of a tensor row by row, or of the upper half of a
/// symmetric one.
fn component(axes: &str, count: usize, dim: usize) -> Option<usize> {
    let place: Vec<usize> = axes.chars().filter_map(|a| "xyz".find(a)).collect();
    let inside = place.iter().all(|a| *a < dim);
    match *place.as_slice() {
        [a] if inside && a < count && count <= dim => Some(a),
        [r, c] if inside && count == dim * dim => Some(r * dim + c),
        [r, c] if inside && count == dim * (dim + 1) / 2 => {
            let (r, c) = (r.min(c), r.max(c));
            Some(r * dim - r * (r + 1) / 2 + c)
        }
        _ => None,
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

/// Whether it is a named value that no step needs: the sweeps of the energy form it.
fn with_energy(spec: &Spec, name: &str) -> bool {
    let late = |slot: &u32| spec.slots[*slot as usize].kind == SlotKind::Computed(Stage::Energy);
    (spec.named.iter()).any(|(n, slots)| n == name && slots.iter().any(late))
}

fn all(sim: &mut Simulation, base: &str) -> Vec<Vec<f64>> {
    let energy = match base == "energy" || with_energy(&sim.spec, base) {
        true => sim.engine.energy(&sim.state).to_vec(),
        false => Vec::new(),
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
                .map(|k| user(&sim.engine.spread(k, &sim.state.slots[k])))
                .collect(),
            None => sim.engine.named(base).unwrap_or_default(),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::component;

    #[test]
    fn components_by_their_letters() {
        assert_eq!(component("z", 3, 3), Some(2));
        assert_eq!(component("z", 2, 2), None);
        assert_eq!(component("yx", 4, 2), Some(2));
        assert_eq!(component("yx", 3, 2), Some(1));
        assert_eq!(component("zy", 6, 3), Some(4));
        assert_eq!(component("zz", 6, 3), Some(5));
        assert_eq!(component("x", 4, 2), None);
        assert_eq!(component("x", 1, 1), Some(0));
    }
}
