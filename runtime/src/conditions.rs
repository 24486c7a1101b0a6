//! Initial values, prescribed motion and loads, by region and expression.

mod drivers;
mod loads;
mod matched;
mod mirror;
mod smoothed;

use drivers::{Driver, drivers, fixed, holding, release};
pub use loads::Loads;
use loads::loaded;
use matched::Boundaries;

use crate::body::Body;
use crate::density::Density;
use crate::engine::{Engine, State};
use crate::error::{About, InputError};
use crate::matching::Face;
use crate::shape::{Shape, tolerance};
use crate::spec::{Op, Stepped, Tape};
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

    pub(crate) fn function(&self) -> Result<Function, InputError> {
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
    /// Continues the body beyond a plane: values follow the mirror images of the nodes. Displacements and fields only.
    pub mirror: Option<Mirror>,
    /// Time after which it no longer holds [s]; infinite: it always does. Not for initial values.
    pub until: f64,
}

/// A plane, and how a quantity continues beyond it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// [m]
    pub point: [f64; 3],
    /// Any length but 0.
    pub normal: [f64; 3],
    pub parity: Parity,
}

/// How a value continues beyond a plane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parity {
    /// Twice the expression at the plane minus the value of the image: on the plane the expression holds.
    Odd,
    /// The value of the image plus the expression at the node itself: 0 stands for insulation and symmetry.
    Even,
}

/// The last of a list that sets a field at a node.
pub(crate) fn who_sets(
    list: &[Condition],
    field: &str,
    x: [f64; 3],
    spacing: f64,
) -> Option<usize> {
    let sets = |c: &Condition| {
        matches!(&c.quantity, Quantity::Field(name) if name == field)
            && c.region.contains(x, tolerance(spacing))
    };
    list.iter().rposition(sets)
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
    for (k, condition) in list.iter().enumerate() {
        let drivers = drivers(condition, body, engine).map_err(|e| e.about(About::Initial(k)))?;
        for driver in drivers {
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
            driver.impose(body, 0.0, target);
        }
    }
    Ok(())
}

/// The conditions of a run, ready to be applied.
pub struct Conditions {
    displacement: Vec<Driver>,
    velocity: Vec<Driver>,
    /// Displacements that follow mirror images; they come last.
    mirrored: Vec<Driver>,
    /// Displacements that follow the waves which leave; they come behind what is prescribed.
    matched: Boundaries,
    force: Vec<Driver>,
    /// Those that follow mirror images come last.
    field: Vec<Driver>,
    /// Of the fields at half steps.
    half: Vec<Driver>,
    /// Displacements of driven components before the drift, in the order of the drivers.
    before: Vec<f64>,
    /// Body force density, and the slots where it may differ from 0.
    pub loads: Loads,
    /// Work of the imposed motion and of the body forces so far [J].
    pub work: f64,
    /// What has left through matching boundaries so far: the work that is done at their nodes, turned in sign [J].
    pub left: f64,
}

/// What the energy account of imposed motion needs to know about a step.
pub struct Balance<'a> {
    pub body: &'a Body,
    /// Internal force density, and the contact forces [N/m^3].
    pub force: &'a [Vec<f64>],
    pub contact: &'a Loads,
    pub volume: &'a [f64],
    pub density: &'a Density,
    pub dt: f64,
}

impl Balance<'_> {
    /// Kinetic energy of a component of some nodes [J].
    fn kinetic(&self, state: &State, component: usize, slots: &[u32]) -> f64 {
        let v = &state.v[component];
        let of = |s: usize| 0.5 * self.density.at(s) * self.volume[s] * v[s].powi(2);
        slots.iter().map(|s| of(*s as usize)).sum()
    }

    /// Half of the work that all forces do on a component of some nodes in a step [J].
    fn power(&self, state: &State, loads: &Loads, component: usize, slots: &[u32]) -> f64 {
        let (force, v) = (self.force.get(component), &state.v[component]);
        let of = |s: usize| {
            let force = force.map_or(0.0, |f| f[s])
                + self.contact.at(component, s)
                + loads.at(component, s);
            0.5 * self.volume[s] * force * self.dt * v[s]
        };
        slots.iter().map(|s| of(*s as usize)).sum()
    }
}

impl Conditions {
    /// Finds the nodes of every condition and what each of them depends on, for runs that start with the bonds of `state`.
    ///
    /// Errors as [`set_initial`].
    pub fn new(
        list: &[Condition],
        faces: &[Face],
        body: &Body,
        engine: &Engine,
        state: &State,
    ) -> Result<Conditions, InputError> {
        let (mut displacement, mut velocity, mut mirrored) = (vec![], vec![], vec![]);
        let (mut force, mut field) = (vec![], vec![]);
        for (k, condition) in list.iter().enumerate() {
            let drivers = fixed(&condition.quantity, engine)
                .and_then(|()| drivers(condition, body, engine))
                .map_err(|e| e.about(About::Condition(k)))?;
            for driver in drivers {
                let later: &mut [&mut Vec<Driver>] = match condition.quantity {
                    Quantity::Force => &mut [],
                    Quantity::Field(_) => &mut [&mut field],
                    _ => &mut [&mut displacement, &mut velocity, &mut mirrored],
                };
                later
                    .iter_mut()
                    .for_each(|list| release(list, &driver, body.x.len()));
                match condition.quantity {
                    Quantity::Displacement if condition.mirror.is_some() => mirrored.push(driver),
                    Quantity::Displacement => displacement.push(driver),
                    Quantity::Velocity => velocity.push(driver),
                    Quantity::Force => force.push(driver),
                    Quantity::Field(_) => field.push(driver),
                }
            }
        }
        field.sort_by_key(|d: &Driver| d.mirror.is_some());
        let at_half = |slot: usize| {
            engine
                .rates()
                .any(|r| r.slot == slot && r.stepped == Stepped::Half)
        };
        let (half, field) = field.into_iter().partition(|d| at_half(d.component));
        let driven: [&[Driver]; 3] = [&displacement, &velocity, &mirrored];
        let matched = Boundaries::new(faces, body, engine, state, &driven)?;
        let loads = loaded(&force, body.flavour.dim(), engine.len());
        Ok(Conditions {
            displacement,
            velocity,
            mirrored,
            matched,
            force,
            field,
            half,
            before: Vec::new(),
            loads,
            work: 0.0,
            left: 0.0,
        })
    }

    /// Whether nothing is imposed and nothing loaded.
    pub fn is_free(&self) -> bool {
        self.motion(f64::NEG_INFINITY).next().is_none()
            && self.matched.0.is_empty()
            && self.force.is_empty()
            && self.field.is_empty()
            && self.half.is_empty()
    }

    /// Drivers of the motion in the step that ends at `t`, each after those that it follows.
    fn motion(&self, t: f64) -> impl Iterator<Item = &Driver> {
        let lists = [&self.displacement, &self.velocity, &self.mirrored];
        lists.into_iter().flat_map(move |l| holding(l, t))
    }

    /// Imposes displacements and fields at the start.
    pub fn start(&self, body: &Body, state: &mut State) {
        for driver in self.displacement.iter().chain(&self.mirrored) {
            driver.impose(body, state.time, &mut state.u[driver.component]);
        }
        self.impose_fields(body, state.time, &mut state.slots);
        self.impose_half_fields(body, state.time, &mut state.slots);
    }

    /// Body forces at time `t`.
    pub fn load(&mut self, body: &Body, t: f64) {
        for f in &mut self.loads.density {
            self.loads.touched.iter().for_each(|&s| f[s as usize] = 0.0);
        }
        for driver in holding(&self.force, t) {
            let f = &mut self.loads.density[driver.component];
            driver.each(body, t, |_, s, v| f[s] += v);
        }
    }

    /// Before the drift: remembers where driven components are.
    pub fn before_drift(&mut self, state: &State, balance: &Balance) {
        let mut before = std::mem::take(&mut self.before);
        before.clear();
        let mut work = 0.0;
        for driver in self.motion(state.time + balance.dt) {
            let u = &state.u[driver.component];
            before.extend(driver.slots.iter().map(|s| u[*s as usize]));
            work -= balance.kinetic(state, driver.component, &driver.slots);
        }
        self.before = before;
        self.work += work;
        for m in &self.matched.0 {
            self.left += balance.kinetic(state, m.component, &m.slots);
        }
        self.matched.before_drift(state, balance.dt);
        self.matched.hold(state);
    }

    /// Before the drift from `state.time`: driven components get the velocities that lead where they belong.
    pub fn steer(&self, state: &mut State, balance: &Balance) {
        let (t, dt) = (state.time, balance.dt);
        for driver in holding(&self.displacement, t + dt) {
            let (u, v) = (&state.u[driver.component], &mut state.v[driver.component]);
            driver.each(balance.body, t + dt, |_, s, value| {
                v[s] = (value - u[s]) / dt
            });
        }
        for driver in holding(&self.velocity, t + dt) {
            driver.impose(balance.body, t + 0.5 * dt, &mut state.v[driver.component]);
        }
        self.matched.steer(state);
        self.impose_mirrored_velocities(balance.body, (t, t + dt), t + dt, state);
    }

    /// After the drift to `state.time`: puts driven components where they belong; their velocities become
    /// those that lead there. Returns the largest motion of a driven component in this step [m].
    pub fn after_drift(&mut self, state: &mut State, balance: &Balance) -> f64 {
        let (time, dt) = (state.time, balance.dt);
        let mut before = self.before.iter().copied();
        let mut largest = 0.0_f64;
        for driver in holding(&self.displacement, time) {
            largest = largest.max(driver.place(state, balance, &mut before));
        }
        for driver in holding(&self.velocity, time) {
            let (u, v) = (
                &mut state.u[driver.component],
                &mut state.v[driver.component],
            );
            // The velocity in the middle of the step integrates to second order.
            driver.each(balance.body, time - 0.5 * dt, |_, s, value| {
                u[s] = before.next().unwrap_or(u[s]) + dt * value;
                v[s] = value;
                largest = largest.max((dt * value).abs());
            });
        }
        largest = largest.max(self.matched.after_drift(state, dt));
        for driver in holding(&self.mirrored, time) {
            largest = largest.max(driver.place(state, balance, &mut before));
        }
        self.impose_fields(balance.body, time, &mut state.slots);
        self.account(state, balance);
        largest
    }

    /// Before the last half kick, which leaves the nodes of matching boundaries alone.
    pub fn before_kick(&mut self, state: &State, dt: f64) {
        self.matched.before_kick(state, dt);
    }

    /// Gives the nodes of matching boundaries back their velocities.
    pub fn hold_matched(&self, state: &mut State) {
        self.matched.steer(state);
    }

    /// After the last half kick at `state.time`: imposes velocities.
    pub fn after_kick(&mut self, state: &mut State, balance: &Balance) {
        self.matched.steer(state);
        self.impose_velocities(balance.body, state, balance.dt);
        let mut work = 0.0;
        for driver in self.motion(state.time) {
            work += balance.kinetic(state, driver.component, &driver.slots);
        }
        self.work += work;
        for m in &self.matched.0 {
            self.left -= balance.kinetic(state, m.component, &m.slots);
        }
        self.left += self.matched.smooth(state, balance);
    }

    /// Half of a step's work along `dt * v`, with the forces at one of its ends: what the body forces do, and
    /// what imposed motion must do against all other forces. Called once at each end, `state.time` being that of the
    /// second and `state.v` the velocity of the middle both times.
    pub fn account(&mut self, state: &State, balance: &Balance) {
        let mut work = 0.5 * self.loads.work(&state.v, balance.volume, balance.dt);
        for driver in self.motion(state.time) {
            work -= balance.power(state, &self.loads, driver.component, &driver.slots);
        }
        self.work += work;
        for m in &self.matched.0 {
            self.left += balance.power(state, &self.loads, m.component, &m.slots);
        }
    }

    /// Calls `act` with every slot whose motion is imposed, in any component.
    pub fn driven(&self, mut act: impl FnMut(usize)) {
        // Those that are to be free one day are so for a sphere.
        let motion = self.motion(f64::INFINITY).map(|d| &d.slots);
        let matched = self.matched.0.iter().map(|m| &m.slots);
        motion
            .chain(matched)
            .flatten()
            .for_each(|&s| act(s as usize));
    }

    /// Imposes fields at half steps at time `t`.
    pub fn impose_half_fields(&self, body: &Body, t: f64, slots: &mut [Vec<f64>]) {
        for driver in holding(&self.half, t) {
            driver.impose(body, t, &mut slots[driver.component]);
        }
    }

    /// Imposes the other fields at time `t`.
    pub fn impose_fields(&self, body: &Body, t: f64, slots: &mut [Vec<f64>]) {
        for driver in holding(&self.field, t) {
            driver.impose(body, t, &mut slots[driver.component]);
        }
    }

    /// Velocities of driven components at `state.time`; those of prescribed displacements are central differences.
    pub fn impose_velocities(&self, body: &Body, state: &mut State, dt: f64) {
        let t = state.time;
        for driver in holding(&self.displacement, t).filter(|_| dt > 0.0) {
            let v = &mut state.v[driver.component];
            driver.each(body, t + 0.5 * dt, |_, s, value| v[s] = value);
            driver.each(body, t - 0.5 * dt, |_, s, value| v[s] = (v[s] - value) / dt);
        }
        for driver in holding(&self.velocity, t) {
            driver.impose(body, t, &mut state.v[driver.component]);
        }
        let around = (t - 0.5 * dt, t + 0.5 * dt);
        self.impose_mirrored_velocities(body, around, t, state);
    }

    /// Velocities that follow mirror images, the expression changing as it does from one time to another.
    fn impose_mirrored_velocities(
        &self,
        body: &Body,
        (from, to): (f64, f64),
        t: f64,
        state: &mut State,
    ) {
        for driver in holding(&self.mirrored, t).filter(|_| to > from) {
            let v = &mut state.v[driver.component];
            driver.each(body, to, |_, s, value| v[s] = value);
            driver.each(body, from, |k, s, value| {
                v[s] = driver.continued(k, (v[s] - value) / (to - from), v);
            });
        }
    }
}

fn name(quantity: &Quantity) -> &str {
    match quantity {
        Quantity::Displacement => "displacement",
        Quantity::Velocity => "velocity",
        Quantity::Force => "force density",
        Quantity::Field(name) => name,
    }
}
