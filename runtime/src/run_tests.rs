//! Runs of small bodies, from a setup to the end; what they share.
use crate::body::Flavour;
use crate::carve::{Anchor, Carve, carve};
use crate::conditions::{Condition, Expression, Mirror, Parity, Quantity};
use crate::contact::{ContactLaw, Indenter};
use crate::engine::{Law, Precision, Settings, Traversal};
use crate::observe::{Files, Observer, Outputs, Picture, Row, Schedule, View};
use crate::shape::Shape;
use crate::simulate::{End, Setup, Simulation, StepRule};
use crate::spec::{Op, Tape};
use std::path::PathBuf;

#[path = "run_tests/contact.rs"]
mod contact;
#[path = "run_tests/faults.rs"]
mod faults;
#[path = "run_tests/fields.rs"]
mod fields;
#[path = "run_tests/law.rs"]
mod law;
#[path = "run_tests/motion.rs"]
mod motion;
#[path = "run_tests/outputs.rs"]
mod outputs;
#[path = "run_tests/restart.rs"]
mod restart;

/// A block of n x m x l nodes with spacing 1 and bonds of length 1 (c = 1); critical stretch as given.
pub(crate) fn block(cells: [f64; 3], flavour: Flavour, s0: f64) -> Setup {
    let body = carve(&Carve {
        shape: Shape::Box {
            from: [0.0; 3],
            to: cells,
        },
        flavour,
        spacing: 1.0,
        anchor: Anchor::CellCentres,
        cross: 1.0,
        periodic: [false; 3],
        tolerance: None,
        memory: None,
    });
    Setup {
        title: "block".into(),
        body: body.unwrap(),
        law: Law::interpreted(law::pmb(flavour.dim())),
        settings: Settings {
            materials: vec![vec![1.0, s0]],
            influences: vec![],
            horizon: vec![1.5],
            horizon_levels: 64,
            partial_volume: false,
            lattice_constants: false,
            without: vec![],
            traversal: Traversal::Auto,
            isa: None,
            precision: Precision::Double,
        },
        density: vec![1.0],
        initial: vec![],
        conditions: vec![],
        cracks: vec![],
        no_fail: vec![],
        indenters: vec![],
        matching: vec![],
        step: StepRule::Fixed(0.1),
        end: End::Steps(10),
        outputs: Outputs {
            history: Schedule::Steps(1),
            ..Outputs::default()
        },
    }
}

fn set(region: Shape, quantity: Quantity, value: Vec<Option<Expression>>) -> Condition {
    Condition {
        region,
        quantity,
        value,
        mirror: None,
        until: f64::INFINITY,
    }
}

fn numbers(values: &[f64]) -> Vec<Option<Expression>> {
    values
        .iter()
        .map(|v| Some(Expression::constant(*v)))
        .collect()
}

/// `scale * sin(rate * variable)`.
fn sine(variable: u32, rate: f64, scale: f64) -> Option<Expression> {
    let ops = vec![
        Op::Var(variable),
        Op::Lit(rate),
        Op::Mul(0, 1),
        Op::Sin(2),
        Op::Lit(scale),
        Op::Mul(3, 4),
    ];
    Some(Expression {
        text: "sine".into(),
        tape: Tape { ops, outs: vec![5] },
    })
}

fn scratch(name: &str) -> PathBuf {
    let dir = std::env::temp_dir().join(format!("pdlang-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&dir);
    dir
}

/// Keeps the rows.
#[derive(Default)]
struct Rows(Vec<Row>);

impl Observer for Rows {
    fn row(&mut self, _: &Simulation, row: &Row) -> Result<(), String> {
        self.0.push(row.clone());
        Ok(())
    }
}

/// A plate that a sphere hits from above; bonds break.
fn impact(law: ContactLaw) -> Setup {
    let mut setup = block([9.0, 9.0, 3.0], Flavour::Solid, 0.05);
    setup.indenters = vec![Indenter {
        center: [4.5, 4.5, 6.5],
        velocity: [0.0, 0.0, -0.3],
        radius: 3.0,
        law,
    }];
    setup.step = StepRule::Stable { safety: 0.5 };
    setup.end = End::Steps(60);
    setup.outputs.checkpoints = Schedule::Steps(25);
    setup
}

/// The same heat problem once more.
fn again(setup: &Setup) -> Setup {
    Setup {
        title: setup.title.clone(),
        body: setup.body.clone(),
        law: setup.law.clone(),
        settings: setup.settings.clone(),
        initial: setup.initial.clone(),
        conditions: setup.conditions.clone(),
        cracks: setup.cracks.clone(),
        no_fail: setup.no_fail.clone(),
        indenters: setup.indenters.clone(),
        matching: setup.matching.clone(),
        outputs: setup.outputs.clone(),
        density: setup.density.clone(),
        ..*setup
    }
}
