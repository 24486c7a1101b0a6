//! One question, several answers: the same law, body and state given to the oracle, to the plain runner
//! and to the engine in all its forms.

mod answer;

use std::collections::{BTreeMap, HashSet};

pub use answer::{Answer, Difference, Scale};
use pdlang::assemble::Kinematics;
use pdlang::ir;
use pdlang::lower::stored_components;
use pdlang::oracle::{self, Oracle, Value};
use pdlang_models::registry;
pub use pdlang_models::verify::ask::{gather, per_node, spread};
use pdlang_runtime::body::Body;
use pdlang_runtime::engine::{self, Breaking, Engine, Isa, Precision, Traversal};
use pdlang_runtime::spec::{InfluenceFn, RateSpec, Spec};

use crate::{bodies, bridge, canaries, laws, naive, plain};

/// A law on a body in a state.
#[derive(Clone)]
pub struct Question<'a> {
    pub law: &'a ir::Law,
    pub body: Body,
    /// SI values, one per parameter.
    pub params: Vec<f64>,
    /// One per influence slot.
    pub influences: Vec<(ir::InfluenceFn, Vec<f64>)>,
    /// Horizon [m].
    pub horizon: f64,
    pub partial_volume: bool,
    pub lattice_constants: bool,
    /// Weights that are 1 instead of computed.
    pub without: Vec<String>,
    /// Displacements [m] one after another; histories are committed after each but the last.
    pub path: Vec<Vec<[f64; 3]>>,
    /// Velocities [m/s].
    pub v: Vec<[f64; 3]>,
    /// Time between two of the path [s].
    pub dt: f64,
    /// Fields of the law: components as they are stored, each per node.
    pub fields: Vec<Vec<Vec<f64>>>,
    pub broken: HashSet<(usize, usize)>,
    /// Increment of the tangent [m].
    pub du: Vec<[f64; 3]>,
}

/// The compiled form of a law, as the runtime reads it. Every stage of the compiler is checked, and that nothing gets
/// lost between the two.
pub fn spec(law: &ir::Law, dim: usize) -> Spec {
    spec_for(law, dim, Kinematics::General)
}

/// As [`spec`], for small displacements too.
pub fn spec_for(law: &ir::Law, dim: usize, kinematics: Kinematics) -> Spec {
    let made = pdlang::sound::compiled(law, dim, kinematics);
    let (spec, unsound) = made.expect("the law compiles");
    assert!(unsound.is_empty(), "{} in {dim}D: {unsound:#?}", law.name);
    let json = spec.json();
    let read: Spec =
        serde_json::from_str(&json).expect("the runtime reads what the compiler writes");
    let value = |text: &str| serde_json::from_str::<serde_json::Value>(text).expect("JSON");
    let again = serde_json::to_string(&read).expect("numbers are finite");
    assert_eq!(value(&json), value(&again), "{} in {dim}D", law.name);
    read
}

/// An influence function, as the runtime reads it.
pub fn influence(f: &ir::InfluenceFn) -> InfluenceFn {
    let f = pdlang::assemble::influence_fn(f);
    let text = serde_json::to_string(&f).expect("numbers are finite");
    serde_json::from_str(&text).expect("the runtime reads what the compiler writes")
}

/// Time step of the tests [s], a fraction of the usual relaxation time.
const STEP: f64 = 3e-7;

const ISAS: [Isa; 3] = [Isa::Scalar, Isa::Avx2, Isa::Avx512];

impl std::fmt::Display for Question<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let kind = match (&self.body.grid, self.body.periodic[0]) {
            (None, _) => "cloud",
            (_, Some(_)) => "periodic lattice",
            _ => "lattice",
        };
        let influence = self.influences.first().map_or("", |(f, _)| &f.name);
        write!(
            f,
            "{} {} {kind} {influence}",
            self.law.name,
            self.body.flavour.name()
        )
    }
}

impl Question<'_> {
    fn dim(&self) -> usize {
        self.body.flavour.dim()
    }

    fn ball(&self) -> oracle::Ball {
        if self.lattice_constants {
            bridge::lattice_sum(&self.body, self.horizon, self.partial_volume)
        } else {
            bridge::integral(&self.body)
        }
    }

    fn is_broken(&self, i: usize, j: usize) -> bool {
        self.broken.contains(&(i, j))
    }

    /// A law with its usual parameters and default influence functions on a body at rest.
    pub fn at_rest(law: &ir::Law, body: Body) -> Question<'_> {
        let nodes = body.x.len();
        Question {
            law,
            params: laws::params(law, &[]),
            influences: laws::default_influences(law),
            horizon: 2.2 * body.spacing,
            partial_volume: false,
            lattice_constants: false,
            without: Vec::new(),
            path: vec![vec![[0.0; 3]; nodes]],
            v: vec![[0.0; 3]; nodes],
            dt: 0.0,
            fields: at_rest(law, body.flavour.dim(), nodes),
            broken: HashSet::new(),
            du: vec![[0.0; 3]; nodes],
            body,
        }
    }

    /// The same law and body in a random state of about the stated strain, one bond in ten broken. A law with
    /// histories has gone through three steps before.
    pub fn deformed(law: &ir::Law, body: Body, strain: f64, seed: u64) -> Question<'_> {
        let mut random = bodies::Random(seed ^ 0x57A7E);
        let steps = if law.histories.is_empty() { 1 } else { 4 };
        let mut question = Question::at_rest(law, body);
        let body = &question.body;
        question.path = (0..steps)
            .map(|k| bodies::deformation(body, strain, seed + 1000 * k))
            .collect();
        question.dt = STEP;
        question.v = bodies::deformation(body, 1e3 * strain, seed + 7);
        question.du = bodies::deformation(body, strain, seed + 77);
        question.broken = bodies::broken_pairs(body, 0.1, seed);
        for (field, parts) in law.fields.iter().zip(&mut question.fields) {
            // Of the size of a temperature, or of whatever it is.
            let level = if field.unit.base[4] != 0 { 300.0 } else { 0.0 };
            for values in parts {
                values.fill_with(|| level + random.signed());
            }
        }
        question.partial_volume = seed % 2 == 1;
        question.confine();
        question
    }

    /// Of a law with fields on a part of the body: coefficients are zero on the left, other fields where they do not
    /// live.
    fn confine(&mut self) {
        let law = self.law;
        if law.fields.iter().all(|f| f.lives.is_none()) {
            return;
        }
        let nodes = self.body.x.len();
        let middle = self.body.x.iter().map(|x| x[0]).sum::<f64>() / nodes as f64;
        let rated = |k: usize| {
            let rate = |r: &ir::Response| matches!(r, ir::Response::Rate(f, _) if f.index() == k);
            law.responses.iter().any(rate)
        };
        for (_, parts) in self
            .fields
            .iter_mut()
            .enumerate()
            .filter(|(k, _)| !rated(*k))
        {
            for values in parts {
                let left = values.iter_mut().zip(&self.body.x);
                left.filter(|(_, x)| x[0] < middle)
                    .for_each(|(v, _)| *v = 0.0);
            }
        }
        let fields = 0..law.fields.len() as u32;
        let lives: Vec<Vec<bool>> = self.consult(|oracle, _, state| {
            let of = |k| oracle.lives(state, ir::FieldId(k)).expect("the state fits");
            fields.map(of).collect()
        });
        for (parts, lives) in self.fields.iter_mut().zip(&lives) {
            for values in parts {
                let gone = values.iter_mut().zip(lives);
                gone.filter(|(_, lives)| !**lives)
                    .for_each(|(v, _)| *v = 0.0);
            }
        }
    }

    /// Largest stretch of any bond, intact or not, in the last state of the path.
    pub fn largest_stretch(&self) -> f64 {
        let body = bridge::oracle_body(&self.body, self.horizon, false);
        let u = self.path.last().expect("a path has a last state");
        let stretch = |bond: &oracle::Bond| {
            let y = std::array::from_fn(|a| bond.xi[a] + u[bond.to][a] - u[bond.from][a]);
            (naive::norm(y) / bond.length() - 1.0).abs()
        };
        body.bonds.iter().map(stretch).fold(0.0, f64::max)
    }

    /// With other values for some parameters.
    pub fn with(mut self, given: &[(&str, f64)]) -> Self {
        self.params = laws::params(self.law, given);
        self
    }

    /// What the definitions say, and the size of their terms.
    pub fn oracle(&self) -> (Answer, Scale) {
        self.consult(|oracle, _, state| {
            let answer = answer_of(self.law, self.dim(), oracle, state, &self.du);
            let scale = Scale {
                force: oracle.force_scale(state).expect("the state fits"),
                energy: largest(&answer.energy),
                tangent: largest(answer.tangent.as_flattened()),
                rates: largest(&answer.rates.concat()),
                velocity: largest(state.v.as_flattened()),
            };
            (answer, scale)
        })
    }

    /// Force after the bonds that break before the force have broken, and the damage of every node: one minus
    /// the share of its neighbours' volume that is still bonded.
    pub fn oracle_broken(&self) -> (Vec<[f64; 3]>, Vec<f64>) {
        self.consult(|oracle, body, state| {
            for (family, bond) in oracle.breaks(state, false).expect("the state fits") {
                state.intact[family.index()][bond] = false;
            }
            let (mut all, mut left) = (vec![0.0; body.nodes.len()], vec![0.0; body.nodes.len()]);
            for (bond, intact) in body.bonds.iter().zip(&state.intact[0]) {
                let volume = body.nodes[bond.to].volume;
                all[bond.from] += volume;
                left[bond.from] += if *intact { volume } else { 0.0 };
            }
            let damage =
                |(all, left): (&f64, &f64)| if *all > 0.0 { 1.0 - left / all } else { 0.0 };
            let force = oracle.force(state).expect("the state fits");
            (force, all.iter().zip(&left).map(damage).collect())
        })
    }

    /// Asks the oracle about this question's state.
    pub fn consult<A>(
        &self,
        ask: impl FnOnce(&Oracle, &oracle::Body, &mut oracle::State) -> A,
    ) -> A {
        let body = bridge::oracle_body(&self.body, self.horizon, self.partial_volume);
        let settings = oracle::Settings {
            flavour: bridge::flavour(self.body.flavour),
            params: self.params.clone(),
            influences: self.influences.clone(),
            horizon: self.horizon,
            ball: self.ball(),
            without: self.without.clone(),
        };
        let oracle = Oracle::new(self.law, &body, &settings).expect("the law fits the body");
        let mut state = self.oracle_state(&oracle, &body);
        ask(&oracle, &body, &mut state)
    }

    fn oracle_state(&self, oracle: &Oracle, body: &oracle::Body) -> oracle::State {
        let mut state = oracle.state();
        state.v.clone_from(&self.v);
        state.dt = self.dt;
        for (k, field) in state.fields.iter_mut().enumerate() {
            let (shape, parts) = (self.law.fields[k].shape, &self.fields[k]);
            let at = |node: usize| parts.iter().map(|p| p[node]).collect::<Vec<f64>>();
            let nodes = 0..self.body.x.len();
            *field = nodes.map(|n| whole(shape, self.dim(), &at(n))).collect();
        }
        state.cut(body, |i, j| self.is_broken(i, j));
        for (k, u) in self.path.iter().enumerate() {
            state.u.clone_from(u);
            if k + 1 < self.path.len() {
                let broken = oracle.breaks(&state, true).expect("the state fits");
                state.histories = oracle.next_histories(&state).expect("the state fits");
                for (family, bond) in broken {
                    state.intact[family.index()][bond] = false;
                }
            }
        }
        state
    }

    /// The compiled tapes over an explicit bond list.
    pub fn plain(&self) -> Answer {
        let spec = spec(self.law, self.dim());
        let body = bridge::oracle_body(&self.body, self.horizon, self.partial_volume);
        let settings = plain::Settings {
            flavour: bridge::flavour(self.body.flavour),
            params: self.params.clone(),
            influences: self
                .influences
                .iter()
                .map(|(f, v)| (influence(f), v.clone()))
                .collect(),
            horizon: self.horizon,
            ball: self.ball(),
            without: self.without.clone(),
        };
        let mut runner = plain::Plain::new(&spec, &body, &settings);
        for (field, values) in spec.fields.iter().zip(&self.fields) {
            for (slot, values) in field.slots.iter().zip(values) {
                runner.slots[*slot as usize].clone_from(values);
            }
        }
        let mut state = oracle::State {
            u: Vec::new(),
            v: self.v.clone(),
            dt: self.dt,
            intact: vec![vec![true; body.bonds.len()]; spec.families.len()],
            fields: Vec::new(),
            histories: Vec::new(),
        };
        state.cut(&body, |i, j| self.is_broken(i, j));
        let mut answer = Answer::default();
        for (k, u) in self.path.iter().enumerate() {
            state.u.clone_from(u);
            answer.force = runner.force(&state);
            if k + 1 < self.path.len() {
                runner.commit(&state);
            }
        }
        answer.energy = runner.energy(&state);
        answer.tangent = runner.tangent(&state, &self.du);
        let rate = |r: &RateSpec| {
            let [q, drive] = [r.field, r.rate].map(|slot| &runner.slots[slot as usize]);
            let damped = |node: usize| {
                let damping = r.damping.map_or(0.0, |c| runner.slots[c as usize][node]);
                drive[node] - damping * q[node]
            };
            (r.field, (0..q.len()).map(damped).collect())
        };
        let rates: BTreeMap<u32, Vec<f64>> = spec.rates.iter().map(rate).collect();
        answer.rates = rates.into_values().collect();
        if !spec.after_step.is_empty() {
            runner.commit(&state);
            answer.velocity = runner.vectors(&spec.after_step);
        }
        answer
    }

    /// An engine for this question.
    pub fn engine(&self, law: engine::Law, traversal: Traversal, isa: Option<Isa>) -> Engine {
        let made = self.try_engine(law, traversal, isa);
        made.expect("the engine takes the question")
    }

    /// An engine, if it takes the question: a law may be too large.
    ///
    /// # Errors
    /// As [`Engine::new`].
    pub fn try_engine(
        &self,
        law: engine::Law,
        traversal: Traversal,
        isa: Option<Isa>,
    ) -> Result<Engine, engine::SetupError> {
        Engine::new(&self.body, law, self.settings(traversal, isa))
    }

    /// How an engine of this question is built.
    pub fn settings(&self, traversal: Traversal, isa: Option<Isa>) -> engine::Settings {
        engine::Settings {
            materials: vec![self.params.clone()],
            influences: self
                .influences
                .iter()
                .map(|(f, v)| (influence(f), v.clone()))
                .collect(),
            horizon: vec![self.horizon],
            horizon_levels: 64,
            partial_volume: self.partial_volume,
            lattice_constants: self.lattice_constants,
            without: self.without.clone(),
            traversal,
            isa,
            precision: Precision::Double,
        }
    }

    /// Calls `ask` with an engine of every form (tapes, and machine code where the law is compiled in), on every
    /// traversal that the body allows and every instruction set of this processor.
    pub fn everywhere(&self, mut ask: impl FnMut(&str, &mut Engine)) {
        for law in std::iter::once(self.interpreted()).chain(self.compiled()) {
            let form = if law.kernel.is_some() {
                "compiled"
            } else {
                "interpreted"
            };
            for traversal in [Traversal::Lattice, Traversal::Cloud] {
                if traversal == Traversal::Lattice && self.body.grid.is_none() {
                    continue;
                }
                for isa in ISAS.into_iter().filter(|isa| isa.available()) {
                    let mut engine = self.engine(law.clone(), traversal, Some(isa));
                    ask(&format!("{self} {form} {traversal:?} {isa:?}"), &mut engine);
                }
            }
        }
    }

    /// The law as machine code where it is compiled in, else as tapes.
    pub fn fastest(&self) -> engine::Law {
        self.compiled().unwrap_or_else(|| self.interpreted())
    }

    fn compiled(&self) -> Option<engine::Law> {
        let name = &self.law.name;
        let canary = || engine::Law::compiled(canaries::find(name)?, self.dim()).ok();
        registry::find(name).map_or_else(canary, |entry| entry.compiled(self.dim()))
    }

    /// The law as tapes.
    pub fn interpreted(&self) -> engine::Law {
        engine::Law::interpreted(spec(self.law, self.dim()))
    }

    /// The state of this question, with the histories of its path committed, for an engine of it, which from then on
    /// stores fields where they live alone.
    pub fn state(&self, engine: &mut Engine) -> engine::State {
        let mut state = engine.state();
        if !self.broken.is_empty() {
            let node = |x| bodies::node_at(&self.body, x);
            engine.cut(&mut state, &|a, b| self.is_broken(node(a), node(b)));
        }
        spread(engine, &self.v, &mut state.v);
        state.dt = self.dt;
        for (field, values) in self.law.fields.iter().zip(&self.fields) {
            let slots = engine.state_slots(&field.name);
            let slots = slots.expect("the law has this field");
            assert_eq!(slots.len(), values.len(), "{}", field.name);
            for (slot, values) in slots.into_iter().zip(values) {
                for (node, value) in values.iter().enumerate() {
                    // Settled before: where nothing is stored there is nothing to say.
                    if let Some(index) = engine.index(slot, engine.slot(node)) {
                        state.slots[slot][index] = *value;
                    }
                }
            }
        }
        engine
            .settle(&mut state)
            .expect("fields are zero where they do not live");
        for (k, u) in self.path.iter().enumerate() {
            spread(engine, u, &mut state.u);
            if k + 1 < self.path.len() {
                engine.forces(&mut state, Breaking::Held);
                engine.commit(&mut state);
            }
        }
        state
    }

    /// What an engine answers.
    pub fn ask(&self, engine: &mut Engine) -> Answer {
        let mut state = self.state(engine);
        engine.forces(&mut state, Breaking::Held);
        let mut answer = Answer {
            force: gather(engine, engine.force()),
            ..Answer::default()
        };
        let rates: BTreeMap<usize, Vec<f64>> = engine
            .rates()
            .map(|rate| {
                (
                    rate.slot,
                    engine.spread(rate.slot, &rate.whole(&state)).into_owned(),
                )
            })
            .map(|(slot, rate)| (slot, per_node(engine, &rate)))
            .collect();
        answer.rates = rates.into_values().collect();
        let energy = engine.energy(&state).to_vec();
        answer.energy = if energy.is_empty() {
            energy
        } else {
            per_node(engine, &energy)
        };
        let mut du = state.u.clone();
        spread(engine, &self.du, &mut du);
        let tangent = engine.tangent(&state, &du).to_vec();
        answer.tangent = gather(engine, &tangent);
        let mut trial = state.clone();
        answer.breaks = engine.forces(&mut trial, Breaking::Armed);
        if self.law.after_step.is_some() {
            engine.forces(&mut state, Breaking::Held);
            engine.commit(&mut state);
            answer.velocity = gather(engine, &state.v);
        }
        answer
    }
}

/// Fields that are zero.
fn at_rest(law: &ir::Law, dim: usize, nodes: usize) -> Vec<Vec<Vec<f64>>> {
    let parts = |f: &ir::Field| stored_components(f.shape, dim);
    let fields = law.fields.iter();
    fields.map(|f| vec![vec![0.0; nodes]; parts(f)]).collect()
}

/// A value from the components that are stored of it.
fn whole(shape: ir::Shape, dim: usize, parts: &[f64]) -> Value<f64> {
    let mut parts = parts.iter().copied();
    let mut next = || parts.next().expect("a value per component");
    match shape {
        ir::Shape::Scalar | ir::Shape::Boolean => Value::Scalar(next()),
        ir::Shape::Vector => {
            let mut v = [0.0; 3];
            v[..dim].fill_with(next);
            Value::Vector(v)
        }
        ir::Shape::Symmetric | ir::Shape::Tensor => {
            let mut t = [[0.0; 3]; 3];
            for r in 0..dim {
                for c in 0..dim {
                    t[r][c] = match shape == ir::Shape::Symmetric && c < r {
                        true => t[c][r],
                        false => next(),
                    };
                }
            }
            Value::Tensor(t)
        }
    }
}

fn answer_of(
    law: &ir::Law,
    dim: usize,
    oracle: &Oracle,
    state: &oracle::State,
    du: &[[f64; 3]],
) -> Answer {
    let rates = oracle.rates(state).expect("the state fits");
    let rates: BTreeMap<ir::FieldId, Vec<Value<f64>>> = rates.into_iter().collect();
    let components = |(field, values): (&ir::FieldId, &Vec<Value<f64>>)| {
        let symmetric = law.fields[field.index()].shape == ir::Shape::Symmetric;
        let nodes: Vec<Vec<f64>> = values
            .iter()
            .map(|v| plain::components(v, dim, symmetric))
            .collect();
        let count = nodes.first().map_or(0, Vec::len);
        let one = |k: usize| nodes.iter().map(|n| n[k]).collect::<Vec<f64>>();
        (0..count).map(one).collect::<Vec<_>>()
    };
    let breaks = |after| oracle.breaks(state, after).expect("the state fits").len();
    Answer {
        force: oracle.force(state).expect("the state fits"),
        energy: oracle.energy(state).expect("the state fits"),
        tangent: oracle.tangent(state, du).expect("the state fits"),
        rates: rates.iter().flat_map(components).collect(),
        velocity: match law.after_step {
            Some(_) => oracle.next_velocities(state).expect("the state fits"),
            None => Vec::new(),
        },
        breaks: breaks(false) + breaks(true),
    }
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| m.max(v.abs()))
}
