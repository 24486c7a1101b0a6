//! Engines on bodies of several materials, and where those are.

use pdlang_runtime::body::Body;
use pdlang_runtime::engine::{Engine, Isa, Law, Precision, Settings, State, Traversal};
use pdlang_runtime::shape::Shape;
use pdlang_runtime::spec::InfluenceSpec;

use crate::agreement::{Question, influence, spread};
use crate::laws;

/// With the horizon of the question everywhere.
pub fn engine(question: &Question, body: &Body, law: Law, materials: &[Vec<f64>]) -> Engine {
    graded(question, body, law, materials, &[1.0])
}

/// `horizons`: of every material, in those of the question.
pub fn graded(
    question: &Question,
    body: &Body,
    law: Law,
    materials: &[Vec<f64>],
    horizons: &[f64],
) -> Engine {
    walked(
        question,
        body,
        law,
        materials,
        horizons,
        (Traversal::Auto, Isa::Scalar),
    )
}

/// As [`graded`], in the traversal and with the instructions that are asked for.
pub fn walked(
    question: &Question,
    body: &Body,
    law: Law,
    materials: &[Vec<f64>],
    horizons: &[f64],
    (traversal, isa): (Traversal, Isa),
) -> Engine {
    let chosen = |i: &InfluenceSpec| i.default.clone().map(|f| (f, vec![]));
    let constant = |i: &InfluenceSpec| {
        let (f, values) = laws::influence("constant");
        chosen(i).unwrap_or((influence(&f), values))
    };
    let settings = Settings {
        materials: materials.to_vec(),
        influences: law.spec.influences.iter().map(constant).collect(),
        horizon: horizons.iter().map(|h| h * question.horizon).collect(),
        horizon_levels: 64,
        partial_volume: false,
        lattice_constants: false,
        without: vec![],
        traversal,
        isa: Some(isa),
        precision: Precision::Double,
    };
    Engine::new(body, law, settings).expect("the body is valid")
}

/// Displaced by `u`, in the order of the user.
pub fn state(engine: &Engine, u: &[[f64; 3]]) -> State {
    let mut state = engine.state();
    spread(engine, u, &mut state.u);
    state
}

/// All points with a larger x.
pub fn beyond(x: f64) -> Shape {
    let all = f64::INFINITY;
    Shape::Box {
        from: [x, -all, -all],
        to: [all; 3],
    }
}
