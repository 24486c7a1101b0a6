//! The engine, asked about a body: interpreted tapes, vectors per node in the order of the body.

use pdlang::assemble;
use pdlang::ir::{self, Shape};
use pdlang_runtime::body::{Body, Flavour};
use pdlang_runtime::engine::{self, Breaking, Engine, Precision, Settings, State, Traversal};
use std::collections::HashSet;

use super::bodies;
use super::subject::Subject;
use crate::language;

/// A vector per node.
pub type Vectors = Vec<[f64; 3]>;

/// A law on a body in a state.
pub struct Case {
    pub body: Body,
    pub engine: Engine,
    pub state: State,
}

/// The flavour, as the runtime names it.
pub fn runtime_flavour(flavour: ir::Flavour) -> Flavour {
    match flavour {
        ir::Flavour::Bar => Flavour::Bar,
        ir::Flavour::Slab => Flavour::Slab,
        ir::Flavour::PlaneStress => Flavour::PlaneStress,
        ir::Flavour::PlaneStrain => Flavour::PlaneStrain,
        ir::Flavour::Solid => Flavour::Solid,
    }
}

/// The bodies of a subject: a box of a lattice with holes, and a cloud.
pub fn bodies_of(subject: &Subject, flavour: ir::Flavour) -> [Body; 2] {
    let flavour = runtime_flavour(flavour);
    [bodies::carved(flavour, 1), bodies::cloud(flavour, 2)].map(|body| sized(subject, body))
}

/// A body at the spacing of the subject.
pub fn sized(subject: &Subject, body: Body) -> Body {
    let factor = subject.spacing() / body.spacing;
    bodies::scaled(body, factor)
}

impl Case {
    /// At rest.
    ///
    /// # Errors
    /// Why the engine does not take the law or the body.
    pub fn new(subject: &Subject, flavour: ir::Flavour, body: Body) -> Result<Case, String> {
        Case::of_materials(subject, flavour, body, vec![subject.params.clone()])
    }

    /// With a set of parameters for every material.
    ///
    /// # Errors
    /// Why the engine does not take the law or the body.
    pub fn of_materials(
        subject: &Subject,
        flavour: ir::Flavour,
        body: Body,
        materials: Vec<Vec<f64>>,
    ) -> Result<Case, String> {
        let influence = |(f, values): &(ir::InfluenceFn, Vec<f64>)| {
            Ok((
                language::carried(&assemble::influence_fn(f))?,
                values.clone(),
            ))
        };
        let influences: Result<_, String> = subject.influences.iter().map(influence).collect();
        let settings = Settings {
            materials,
            influences: influences?,
            horizon: vec![body.spacing * subject.reach],
            horizon_levels: 64,
            partial_volume: subject.partial_volume,
            lattice_constants: subject.lattice_constants,
            without: Vec::new(),
            traversal: Traversal::Auto,
            isa: None,
            precision: Precision::Double,
        };
        let law: engine::Law = subject.compiled(flavour)?;
        let mut engine = Engine::new(&body, law, settings).map_err(|error| error.to_string())?;
        let mut state = engine.state();
        engine
            .settle(&mut state)
            .map_err(|_| "a field is set where it does not live")?;
        Ok(Case {
            body,
            engine,
            state,
        })
    }

    /// Breaks the bonds between pairs of nodes.
    pub fn cut(&mut self, pairs: &HashSet<(usize, usize)>) {
        let body = &self.body;
        let node = |x| bodies::node_at(body, x);
        self.engine
            .cut(&mut self.state, &|a, b| pairs.contains(&(node(a), node(b))));
    }

    pub fn displace(&mut self, u: &[[f64; 3]]) {
        spread(&self.engine, u, &mut self.state.u);
    }

    pub fn set_velocity(&mut self, v: &[[f64; 3]]) {
        spread(&self.engine, v, &mut self.state.v);
    }

    /// Sets a scalar field.
    pub fn set_field(&mut self, name: &str, value: impl Fn(usize) -> f64) {
        for slot in self.engine.state_slots(name).unwrap_or_default() {
            for node in 0..self.body.x.len() {
                if let Some(index) = self.engine.index(slot, self.engine.slot(node)) {
                    self.state.slots[slot][index] = value(node);
                }
            }
        }
    }

    /// Zeros of a law whose forces cancel, so that nothing is left to compute.
    pub fn force(&mut self) -> Vectors {
        self.engine.forces(&mut self.state, Breaking::Held);
        self.filled(gather(&self.engine, self.engine.force()))
    }

    fn filled(&self, vectors: Vectors) -> Vectors {
        match vectors.is_empty() {
            true => vec![[0.0; 3]; self.body.x.len()],
            false => vectors,
        }
    }

    /// Strain energy density; empty for a law without energy. After [`Case::force`].
    pub fn energy(&mut self) -> Vec<f64> {
        let energy = self.engine.energy(&self.state).to_vec();
        if energy.is_empty() {
            return energy;
        }
        per_node(&self.engine, &energy)
    }

    /// Strain energy of the body.
    pub fn total_energy(&mut self) -> f64 {
        self.force();
        let energy = self.energy();
        energy
            .iter()
            .zip(&self.body.volume)
            .map(|(w, v)| w * v)
            .sum()
    }

    /// Change of the force along an increment. After [`Case::force`].
    pub fn tangent(&mut self, du: &[[f64; 3]]) -> Vectors {
        let mut increment = self.state.u.clone();
        spread(&self.engine, du, &mut increment);
        let tangent = self.engine.tangent(&self.state, &increment).to_vec();
        self.filled(gather(&self.engine, &tangent))
    }

    /// The rate of a scalar field.
    pub fn rate(&mut self, name: &str) -> Vec<f64> {
        self.engine.forces(&mut self.state, Breaking::Held);
        let slots = self.engine.state_slots(name).unwrap_or_default();
        let rate = self.engine.rates().find(|rate| slots.contains(&rate.slot));
        let Some(rate) = rate else {
            return vec![0.0; self.body.x.len()];
        };
        let whole = rate.whole(&self.state);
        per_node(&self.engine, &self.engine.spread(rate.slot, &whole))
    }
}

/// Scalar fields of a law with a unit, and whether they have a rate.
pub fn scalar_fields(law: &ir::Law, unit: [i16; 5]) -> Vec<(usize, &ir::Field, bool)> {
    let rated = |k: usize| {
        let rate = |r: &ir::Response| matches!(r, ir::Response::Rate(f, _) if f.index() == k);
        law.responses.iter().any(rate)
    };
    let fields = law.fields.iter().enumerate();
    fields
        .filter(|(_, f)| f.shape == Shape::Scalar && super::subject::has_unit(&f.unit, unit))
        .map(|(k, f)| (k, f, rated(k)))
        .collect()
}

/// Vectors per node into arrays per direction in layout order.
pub fn spread(engine: &Engine, values: &[[f64; 3]], to: &mut [Vec<f64>]) {
    for (node, value) in values.iter().enumerate() {
        for (a, array) in to.iter_mut().enumerate() {
            array[engine.slot(node)] = value[a];
        }
    }
}

/// Arrays per direction in layout order into vectors per node; empty without arrays.
pub fn gather(engine: &Engine, arrays: &[Vec<f64>]) -> Vectors {
    if arrays.is_empty() {
        return Vec::new();
    }
    let at = |slot: &u32| {
        std::array::from_fn(|a| arrays.get(a).map_or(0.0, |array| array[*slot as usize]))
    };
    engine.slots().iter().map(at).collect()
}

/// One array in layout order into one value per node.
pub fn per_node(engine: &Engine, array: &[f64]) -> Vec<f64> {
    engine
        .slots()
        .iter()
        .map(|slot| array[*slot as usize])
        .collect()
}

/// Largest magnitude of a component; infinite where one is no number.
pub fn largest(values: &[f64]) -> f64 {
    let size = |v: &f64| {
        if v.is_finite() {
            v.abs()
        } else {
            f64::INFINITY
        }
    };
    values.iter().map(size).fold(0.0, f64::max)
}

/// Largest difference over a scale; 0 where both are the same, 0 over 0 too.
pub fn relative(a: &[f64], b: &[f64], scale: f64) -> f64 {
    let gap = a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>();
    let worst = largest(&gap);
    if worst == 0.0 { 0.0 } else { worst / scale }
}
