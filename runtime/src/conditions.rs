//! Initial values, prescribed motion and loads, by region and expression.

use crate::body::Body;
use crate::engine::{Engine, State};
use crate::error::InputError;
use crate::shape::{Shape, tolerance};
use crate::spec::{Op, Tape};
use crate::tape::Function;

/// A function of the reference position and of time: `Var(0..=3)` of the tape are x, y, z [m] and t [s]; its
/// one output is in SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Expression {
    /// As the user wrote it.
    pub text: String,
    pub tape: Tape,
}

impl Expression {
    pub fn constant(value: f64) -> Expression {
        Expression {
            text: format!("{value}"),
            tape: Tape {
                ops: vec![Op::Lit(value)],
                outs: vec![0],
            },
        }
    }

    fn function(&self) -> Result<Function, InputError> {
        Function::new(&self.tape, 4).map_err(|e| {
            InputError::new(
                format!("`{}`: {e}", self.text),
                "write an expression in x, y, z and t",
            )
        })
    }

    fn reads(&self, variables: std::ops::Range<u32>) -> bool {
        self.tape
            .ops
            .iter()
            .any(|op| matches!(op, Op::Var(k) if variables.contains(k)))
    }
}

/// What a condition sets.
#[derive(Clone, Debug, PartialEq)]
pub enum Quantity {
    /// [m]
    Displacement,
    /// [m/s]
    Velocity,
    /// Body force density [N/m^3]; adds up where regions overlap. Not for initial values.
    Force,
    /// A field of the law, by name, in SI.
    Field(String),
}

/// Values by component; `None` leaves a component free.
///
/// As an initial value it is set once, at t = 0. As a condition it holds for all time: displacements,
/// velocities and fields are imposed exactly, forces are added. A held node is a velocity of 0 in every
/// component. Of two conditions on one component of one node the later in the list wins.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    pub region: Shape,
    pub quantity: Quantity,
    pub value: Vec<Option<Expression>>,
}

/// One component of a condition on the nodes where it acts.
struct Driver {
    /// User numbers and slots of the layout.
    nodes: Vec<u32>,
    slots: Vec<u32>,
    /// Component of the vector, or the state slot of a field component.
    component: usize,
    value: Value,
}

/// An expression, evaluated as rarely as it can be.
enum Value {
    /// Depends on the position at most: one number per node.
    Fixed(Vec<f64>),
    /// Depends on time alone.
    Uniform(Function),
    Moving(Function),
}

impl Driver {
    /// Calls `act(slot, value at t)` for every node.
    fn each(&self, body: &Body, t: f64, mut act: impl FnMut(usize, f64)) {
        match &self.value {
            Value::Fixed(values) => self
                .slots
                .iter()
                .zip(values)
                .for_each(|(&s, &v)| act(s as usize, v)),
            Value::Uniform(e) => {
                let v = at(e, [0.0; 3], t);
                self.slots.iter().for_each(|&s| act(s as usize, v));
            }
            Value::Moving(e) => {
                for (&node, &s) in self.nodes.iter().zip(&self.slots) {
                    act(s as usize, at(e, body.x[node as usize], t));
                }
            }
        }
    }

    fn retain(&mut self, keep: &[bool]) {
        let mut flags = self
            .nodes
            .iter()
            .map(|&n| keep[n as usize])
            .collect::<Vec<_>>()
            .into_iter();
        if let Value::Fixed(values) = &mut self.value {
            let mut flags = flags.clone();
            values.retain(|_| flags.next().unwrap_or(false));
        }
        let mut again = flags.clone();
        self.nodes.retain(|_| flags.next().unwrap_or(false));
        self.slots.retain(|_| again.next().unwrap_or(false));
    }
}

fn at(function: &Function, x: [f64; 3], t: f64) -> f64 {
    function.call(&[x[0], x[1], x[2], t])
}

/// The user numbers of the nodes in a region.
pub fn nodes_in(body: &Body, region: &Shape) -> Vec<u32> {
    let margin = tolerance(body.spacing);
    (0..body.x.len() as u32)
        .filter(|&i| region.contains(body.x[i as usize], margin))
        .collect()
}

/// Sets initial values in the order of the list.
///
/// Errors: a region without nodes, an unknown field, a wrong number of components, a value that is not finite.
pub fn set_initial(
    list: &[Condition],
    body: &Body,
    engine: &Engine,
    state: &mut State,
) -> Result<(), InputError> {
    for condition in list {
        for driver in drivers(condition, body, engine)? {
            let target = match &condition.quantity {
                Quantity::Displacement => &mut state.u[driver.component],
                Quantity::Velocity => &mut state.v[driver.component],
                Quantity::Field(_) => &mut state.slots[driver.component],
                Quantity::Force => {
                    return Err(InputError::new(
                        "a force density is given as an initial value",
                        "move it to the conditions; a pulse is an expression in t",
                    ));
                }
            };
            driver.each(body, 0.0, |s, v| target[s] = v);
        }
    }
    Ok(())
}

/// The conditions of a run, ready to be applied.
pub struct Conditions {
    displacement: Vec<Driver>,
    velocity: Vec<Driver>,
    force: Vec<Driver>,
    field: Vec<Driver>,
    /// Displacements of driven components before the drift, in the order of the drivers.
    before: Vec<f64>,
    /// Body force density, and the slots where it may differ from 0.
    pub loads: Loads,
    /// Work of the imposed motion and of the body forces so far [J].
    pub work: f64,
}

/// Forces on a few nodes [N/m^3], layout order.
#[derive(Default)]
pub struct Loads {
    pub density: Vec<Vec<f64>>,
    pub touched: Vec<u32>,
}

impl Loads {
    pub fn new(dim: usize, len: usize) -> Loads {
        Loads {
            density: vec![vec![0.0; len]; dim],
            touched: Vec::new(),
        }
    }

    /// Component `d` at slot `s`; loads that are never used hold no numbers.
    pub fn at(&self, d: usize, s: usize) -> f64 {
        self.density[d].get(s).copied().unwrap_or(0.0)
    }

    /// `v += factor * f` where there is a force.
    pub fn kick(&self, v: &mut [Vec<f64>], factor: f64) {
        for (v, f) in v.iter_mut().zip(&self.density) {
            self.touched
                .iter()
                .for_each(|&s| v[s as usize] += factor * f[s as usize]);
        }
    }

    /// Work of these forces along `dt * v` [J].
    pub fn work(&self, v: &[Vec<f64>], volume: &[f64], dt: f64) -> f64 {
        let slots = self.touched.iter().map(|&s| s as usize);
        slots
            .map(|s| {
                volume[s]
                    * (0..v.len())
                        .map(|d| self.density[d][s] * dt * v[d][s])
                        .sum::<f64>()
            })
            .sum()
    }
}

/// What the energy account of imposed motion needs to know about a step.
pub struct Balance<'a> {
    pub body: &'a Body,
    /// Internal force density, and the contact forces [N/m^3].
    pub force: &'a [Vec<f64>],
    pub contact: &'a Loads,
    pub volume: &'a [f64],
    pub density: f64,
    pub dt: f64,
}

impl Conditions {
    /// Finds the nodes of every condition and what each of them depends on.
    ///
    /// Errors as [`set_initial`].
    pub fn new(list: &[Condition], body: &Body, engine: &Engine) -> Result<Conditions, InputError> {
        let (mut displacement, mut velocity, mut force, mut field) =
            (vec![], vec![], vec![], vec![]);
        for condition in list {
            for driver in drivers(condition, body, engine)? {
                let later: &mut [&mut Vec<Driver>] = match condition.quantity {
                    Quantity::Force => &mut [],
                    Quantity::Field(_) => &mut [&mut field],
                    _ => &mut [&mut displacement, &mut velocity],
                };
                later
                    .iter_mut()
                    .for_each(|list| release(list, &driver, body.x.len()));
                match condition.quantity {
                    Quantity::Displacement => displacement.push(driver),
                    Quantity::Velocity => velocity.push(driver),
                    Quantity::Force => force.push(driver),
                    Quantity::Field(_) => field.push(driver),
                }
            }
        }
        let loads = loaded(&force, body.flavour.dim(), engine.len());
        Ok(Conditions {
            displacement,
            velocity,
            force,
            field,
            before: Vec::new(),
            loads,
            work: 0.0,
        })
    }

    /// Whether nothing is imposed and nothing loaded.
    pub fn is_free(&self) -> bool {
        [&self.displacement, &self.velocity, &self.force, &self.field]
            .iter()
            .all(|list| list.is_empty())
    }

    /// Imposes displacements and fields at the start.
    pub fn start(&self, body: &Body, state: &mut State) {
        for driver in &self.displacement {
            driver.each(body, state.time, |s, v| state.u[driver.component][s] = v);
        }
        self.impose_fields(body, state);
    }

    /// Body forces at time `t`.
    pub fn load(&mut self, body: &Body, t: f64) {
        for f in &mut self.loads.density {
            self.loads.touched.iter().for_each(|&s| f[s as usize] = 0.0);
        }
        for driver in &self.force {
            let f = &mut self.loads.density[driver.component];
            driver.each(body, t, |s, v| f[s] += v);
        }
    }

    /// Before the drift: remembers where driven components are.
    pub fn before_drift(&mut self, state: &State, balance: &Balance) {
        self.before.clear();
        let (mut work, volume) = (0.0, balance.volume);
        for driver in self.displacement.iter().chain(&self.velocity) {
            let (u, v) = (&state.u[driver.component], &state.v[driver.component]);
            for &s in &driver.slots {
                self.before.push(u[s as usize]);
                work -= 0.5 * balance.density * volume[s as usize] * v[s as usize].powi(2);
            }
        }
        self.work += work;
    }

    /// After the drift to `state.time`: puts driven components where they belong; their velocities become
    /// those that lead there. Returns the largest motion of a driven component in this step [m].
    pub fn after_drift(&mut self, state: &mut State, balance: &Balance) -> f64 {
        let (time, dt) = (state.time, balance.dt);
        let mut before = self.before.iter();
        let mut largest = 0.0_f64;
        for driver in &self.displacement {
            let (u, v) = (
                &mut state.u[driver.component],
                &mut state.v[driver.component],
            );
            driver.each(balance.body, time, |s, value| {
                let old = *before.next().unwrap_or(&value);
                u[s] = value;
                v[s] = (value - old) / dt;
                largest = largest.max((value - old).abs());
            });
        }
        for driver in &self.velocity {
            let (u, v) = (
                &mut state.u[driver.component],
                &mut state.v[driver.component],
            );
            // The velocity in the middle of the step integrates to second order.
            driver.each(balance.body, time - 0.5 * dt, |s, value| {
                u[s] = before.next().unwrap_or(&u[s]) + dt * value;
                v[s] = value;
                largest = largest.max((dt * value).abs());
            });
        }
        self.impose_fields(balance.body, state);
        self.account(state, balance);
        largest
    }

    /// After the last half kick at `state.time`: imposes velocities.
    pub fn after_kick(&mut self, state: &mut State, balance: &Balance) {
        self.impose_velocities(balance.body, state, balance.dt);
        let mut work = 0.0;
        for driver in self.displacement.iter().chain(&self.velocity) {
            let v = &state.v[driver.component];
            for &s in &driver.slots {
                work += 0.5 * balance.density * balance.volume[s as usize] * v[s as usize].powi(2);
            }
        }
        self.work += work;
    }

    /// Half of a step's work along `dt * v`, with the forces at one of its ends: what the body forces do, and
    /// what imposed motion must do against all other forces. Called once at each end, `state.v` being the
    /// velocity of the middle both times.
    pub fn account(&mut self, state: &State, balance: &Balance) {
        let mut work = 0.5 * self.loads.work(&state.v, balance.volume, balance.dt);
        for driver in self.displacement.iter().chain(&self.velocity) {
            let d = driver.component;
            for &s in &driver.slots {
                let s = s as usize;
                let other = balance.force.get(d).map_or(0.0, |f| f[s])
                    + balance.contact.at(d, s)
                    + self.loads.at(d, s);
                work -= 0.5 * balance.volume[s] * other * balance.dt * state.v[d][s];
            }
        }
        self.work += work;
    }

    /// Calls `act` with every slot whose motion is imposed, in any component.
    pub fn driven(&self, mut act: impl FnMut(usize)) {
        for driver in self.displacement.iter().chain(&self.velocity) {
            driver.slots.iter().for_each(|&s| act(s as usize));
        }
    }

    fn impose_fields(&self, body: &Body, state: &mut State) {
        for driver in &self.field {
            let slot = &mut state.slots[driver.component];
            driver.each(body, state.time, |s, v| slot[s] = v);
        }
    }

    /// Velocities of driven components at `state.time`; those of prescribed displacements are central differences.
    pub fn impose_velocities(&self, body: &Body, state: &mut State, dt: f64) {
        for driver in self.displacement.iter().filter(|_| dt > 0.0) {
            let v = &mut state.v[driver.component];
            driver.each(body, state.time + 0.5 * dt, |s, value| v[s] = value);
            driver.each(body, state.time - 0.5 * dt, |s, value| {
                v[s] = (v[s] - value) / dt
            });
        }
        for driver in &self.velocity {
            let v = &mut state.v[driver.component];
            driver.each(body, state.time, |s, value| v[s] = value);
        }
    }
}

fn loaded(force: &[Driver], dim: usize, len: usize) -> Loads {
    let mut loads = Loads::new(dim, if force.is_empty() { 0 } else { len });
    loads.touched = force.iter().flat_map(|d| d.slots.iter().copied()).collect();
    loads.touched.sort_unstable();
    loads.touched.dedup();
    loads
}

/// Takes the nodes of `later` away from the earlier drivers of the same component.
fn release(earlier: &mut [Driver], later: &Driver, nodes: usize) {
    let mut keep = vec![true; nodes];
    later.nodes.iter().for_each(|&n| keep[n as usize] = false);
    earlier
        .iter_mut()
        .filter(|d| d.component == later.component)
        .for_each(|d| d.retain(&keep));
}

fn drivers(condition: &Condition, body: &Body, engine: &Engine) -> Result<Vec<Driver>, InputError> {
    condition.region.check()?;
    let nodes = nodes_in(body, &condition.region);
    if nodes.is_empty() {
        return Err(InputError::new(
            format!(
                "the region of a condition on the {} holds no node",
                name(&condition.quantity)
            ),
            "move or enlarge the region; nodes on its boundary count",
        ));
    }
    let components = components(&condition.quantity, body, engine)?;
    if condition.value.len() != components.len() {
        return Err(InputError::new(
            format!(
                "a condition on the {} has {} components instead of {}",
                name(&condition.quantity),
                condition.value.len(),
                components.len()
            ),
            "give one value per direction of the body; leave a component free by name",
        ));
    }
    let parts = components.into_iter().zip(&condition.value);
    parts
        .filter_map(|(c, e)| {
            e.as_ref()
                .map(|e| driver(c, e, &nodes, body, engine.slots()))
        })
        .collect()
}

fn driver(
    component: usize,
    e: &Expression,
    nodes: &[u32],
    body: &Body,
    slots: &[u32],
) -> Result<Driver, InputError> {
    let function = e.function()?;
    let values: Vec<f64> = nodes
        .iter()
        .map(|&n| at(&function, body.x[n as usize], 0.0))
        .collect();
    if let Some(k) = values.iter().position(|v| !v.is_finite()) {
        let x = body.x[nodes[k] as usize];
        return Err(InputError::new(
            format!(
                "`{}` is {} at node {} ({:e}, {:e}, {:e}) m, t = 0",
                e.text, values[k], nodes[k], x[0], x[1], x[2]
            ),
            "give an expression that is finite on the whole region",
        ));
    }
    let value = match (e.reads(3..4), e.reads(0..3)) {
        (false, _) => Value::Fixed(values),
        (true, false) => Value::Uniform(function),
        (true, true) => Value::Moving(function),
    };
    let slots = nodes.iter().map(|&n| slots[n as usize]).collect();
    Ok(Driver {
        nodes: nodes.to_vec(),
        slots,
        component,
        value,
    })
}

fn components(quantity: &Quantity, body: &Body, engine: &Engine) -> Result<Vec<usize>, InputError> {
    let Quantity::Field(name) = quantity else {
        return Ok((0..body.flavour.dim()).collect());
    };
    let fields = &engine.spec().fields;
    let known = fields.iter().any(|f| f.name == *name);
    engine.state_slots(name).filter(|_| known).ok_or_else(|| {
        let names: Vec<&str> = fields.iter().map(|f| f.name.as_str()).collect();
        InputError::new(
            format!("the law `{}` has no field `{name}`", engine.spec().law),
            if names.is_empty() {
                "it has no fields".into()
            } else {
                format!("its fields: {}", names.join(", "))
            },
        )
    })
}

fn name(quantity: &Quantity) -> &str {
    match quantity {
        Quantity::Displacement => "displacement",
        Quantity::Velocity => "velocity",
        Quantity::Force => "force density",
        Quantity::Field(name) => name,
    }
}
