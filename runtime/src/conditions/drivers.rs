//! What a condition comes to once the nodes of its region are known: one driver for every component that it sets.

use super::mirror::{Reflected, images};
use super::{Balance, Condition, Expression, Parity, Quantity, name, nodes_in};
use crate::body::Body;
use crate::engine::{Engine, State};
use crate::error::InputError;
use crate::tape::Function;

/// One component of a condition on the nodes where it acts.
pub(super) struct Driver {
    /// User numbers, and positions in the array of the component: slots of the layout, unless a field is stored on a
    /// part of the body.
    pub nodes: Vec<u32>,
    pub slots: Vec<u32>,
    /// Component of the vector, or the state slot of a field component.
    pub component: usize,
    value: Value,
    pub mirror: Option<Images>,
    /// [s]
    pub until: f64,
}

/// Mirror images of a driver's nodes.
pub(super) struct Images {
    /// Positions of the images, and where the expression is evaluated.
    slots: Vec<u32>,
    places: Vec<[f64; 3]>,
    parity: Parity,
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
    /// Whether it holds at a time, or in a step that ends then, up to rounding.
    fn holds(&self, t: f64) -> bool {
        t <= self.until * (1.0 + 1e-9)
    }

    /// Calls `act(position in the lists, slot, expression at t)` for every node.
    pub fn each(&self, body: &Body, t: f64, mut act: impl FnMut(usize, usize, f64)) {
        let place = |k: usize| match &self.mirror {
            Some(images) => images.places[k],
            None => body.x[self.nodes[k] as usize],
        };
        let uniform = match &self.value {
            Value::Uniform(e) => at(e, [0.0; 3], t),
            _ => 0.0,
        };
        for (k, &s) in self.slots.iter().enumerate() {
            let value = match &self.value {
                Value::Fixed(values) => values[k],
                Value::Uniform(_) => uniform,
                Value::Moving(e) => at(e, place(k), t),
            };
            act(k, s as usize, value);
        }
    }

    /// Sets the quantity to the expression at `t`, or to what its mirror images make of it.
    pub fn impose(&self, body: &Body, t: f64, values: &mut [f64]) {
        self.each(body, t, |k, s, v| values[s] = self.continued(k, v, values));
    }

    /// Puts components where they belong at `state.time`; their velocities become those that led there from
    /// where they were `before`. Returns the largest motion [m].
    pub fn place(
        &self,
        state: &mut State,
        balance: &Balance,
        before: &mut impl Iterator<Item = f64>,
    ) -> f64 {
        let (u, v) = (&mut state.u[self.component], &mut state.v[self.component]);
        let mut largest = 0.0_f64;
        self.each(balance.body, state.time, |k, s, value| {
            let value = self.continued(k, value, u);
            let old = before.next().unwrap_or(value);
            u[s] = value;
            v[s] = (value - old) / balance.dt;
            largest = largest.max((value - old).abs());
        });
        largest
    }

    pub fn continued(&self, k: usize, v: f64, values: &[f64]) -> f64 {
        match &self.mirror {
            None => v,
            Some(images) => {
                let image = values[images.slots[k] as usize];
                match images.parity {
                    Parity::Odd => 2.0 * v - image,
                    Parity::Even => image + v,
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
        if let Some(images) = &mut self.mirror {
            let (mut one, mut two) = (flags.clone(), flags.clone());
            images.slots.retain(|_| one.next().unwrap_or(false));
            images.places.retain(|_| two.next().unwrap_or(false));
        }
        let mut again = flags.clone();
        self.nodes.retain(|_| flags.next().unwrap_or(false));
        self.slots.retain(|_| again.next().unwrap_or(false));
    }
}

fn at(function: &Function, x: [f64; 3], t: f64) -> f64 {
    function.call(&[x[0], x[1], x[2], t])
}

/// Those that hold at `t`, or in a step that ends then.
pub(super) fn holding(list: &[Driver], t: f64) -> impl Iterator<Item = &Driver> {
    list.iter().filter(move |d| d.holds(t))
}

/// Takes the nodes of `later` away from the earlier drivers of the same component.
pub(super) fn release(earlier: &mut [Driver], later: &Driver, nodes: usize) {
    let mut keep = vec![true; nodes];
    later.nodes.iter().for_each(|&n| keep[n as usize] = false);
    earlier
        .iter_mut()
        .filter(|d| d.component == later.component)
        .for_each(|d| d.retain(&keep));
}

pub(super) fn drivers(
    condition: &Condition,
    body: &Body,
    engine: &Engine,
) -> Result<Vec<Driver>, InputError> {
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
    let images = match &condition.mirror {
        Some(mirror) => Some(images(mirror, condition, &nodes, body)?),
        None => None,
    };
    let parts = components.into_iter().zip(&condition.value);
    parts
        .filter_map(|(c, e)| {
            e.as_ref().map(|e| {
                let (nodes, images) = (&nodes, images.as_ref());
                let driver = driver(&condition.quantity, c, e, (nodes, images), body, engine)?;
                Ok(Driver {
                    until: condition.until,
                    ..driver
                })
            })
        })
        .collect()
}

fn driver(
    quantity: &Quantity,
    component: usize,
    e: &Expression,
    (nodes, images): (&[u32], Option<&Reflected>),
    body: &Body,
    engine: &Engine,
) -> Result<Driver, InputError> {
    let function = e.function()?;
    let place = |k: usize| images.map_or(body.x[nodes[k] as usize], |i| i.places[k]);
    let values: Vec<f64> = (0..nodes.len())
        .map(|k| at(&function, place(k), 0.0))
        .collect();
    if let Some(k) = values.iter().position(|v| !v.is_finite()) {
        let x = place(k);
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
    let of = |nodes: &[u32]| -> Result<Vec<u32>, InputError> {
        let of_node = |n: &u32| stored_at(quantity, component, *n as usize, body, engine);
        nodes.iter().map(of_node).collect()
    };
    let mirror = match images {
        None => None,
        Some(images) => Some(Images {
            slots: of(&images.nodes)?,
            places: images.places.clone(),
            parity: images.parity,
        }),
    };
    Ok(Driver {
        nodes: nodes.to_vec(),
        slots: of(nodes)?,
        component,
        value,
        mirror,
        until: f64::INFINITY,
    })
}

/// Position of a node in the array of a component.
fn stored_at(
    quantity: &Quantity,
    component: usize,
    node: usize,
    body: &Body,
    engine: &Engine,
) -> Result<u32, InputError> {
    let slot = engine.slot(node);
    let Quantity::Field(name) = quantity else {
        return Ok(slot as u32);
    };
    let index = engine.index(component, slot);
    index
        .filter(|_| engine.lives(component, slot))
        .map(|index| index as u32)
        .ok_or_else(|| {
            let (x, condition) = (body.x[node], engine.lives_where(name).unwrap_or_default());
            InputError::new(
                format!(
                    "a condition on the field `{name}` reaches node {node} ({:e}, {:e}, {:e}) m, where it does not live",
                    x[0], x[1], x[2]
                ),
                format!("keep to nodes where `{condition}`"),
            )
        })
}

/// Refuses to change what says where other fields live.
pub(super) fn fixed(quantity: &Quantity, engine: &Engine) -> Result<(), InputError> {
    let Quantity::Field(name) = quantity else {
        return Ok(());
    };
    match engine.decided_by(name) {
        None => Ok(()),
        Some(other) => Err(InputError::new(
            format!(
                "the field `{name}` says where the field `{other}` lives, and so stays as it is"
            ),
            "set it under [[initial]]",
        )),
    }
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
