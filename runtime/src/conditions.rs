//! Initial values, prescribed motion and loads, by region and expression.

use crate::shape::Shape;
use crate::spec::{Op, Tape};

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
