//! Laws used from Rust: one written here, one read from a file. Each carries a wave along a bar, and the
//! program compares its speed with the theory.
//!
//! ```sh
//! cargo run --release --example law-in-rust
//! ```

use pdlang_macros::{include_model, model};
use pdlang_runtime::body::{Body, Flavour, Grid};
use pdlang_runtime::engine::{
    Breaking, Engine, Law, Precision, Settings, SetupError, State, Traversal,
};
use pdlang_runtime::kernel::CompiledLaw;

// Becomes `mod spring` with `static LAW`. Nobody wrote a force: it is derived from the energy W.
model! {
    model spring "Bond-based elastic solid"
      cite "Silling and Askari 2005, Comput. Struct. 83, 1526-1535, eq. 9"
    {
        param K : pressure > 0 "bulk modulus"
        let c = 2*dim^2*K_bb(K) / ball(x)
        energy W = c/4 * sum(x*s^2)
    }
}

// Becomes `mod lps`. The path starts at the folder of the Cargo.toml, and a change of the file is built again.
include_model!("../models/laws/lps.pd");

const SPACING: f64 = 1e-3; // [m]
const DENSITY: f64 = 7850.0; // [kg/m^3]
const BULK: f64 = 160e9; // steel, K and G [Pa]
const SHEAR: f64 = 79e9;

fn main() -> Result<(), SetupError> {
    // In a bar that cannot contract sideways c^2 = (K + 4 G/3)/rho. Bond-based laws fix G = 3 K/5.
    let theory = |shear: f64| ((BULK + 4.0 / 3.0 * shear) / DENSITY).sqrt();
    println!("law        measured   theory [m/s]");
    report(&spring::LAW, vec![BULK], theory(0.6 * BULK))?;
    // The last parameter is the critical stretch: no bond ever breaks.
    report(&lps::LAW, vec![BULK, SHEAR, f64::INFINITY], theory(SHEAR))
}

fn report(law: &'static CompiledLaw, params: Vec<f64>, theory: f64) -> Result<(), SetupError> {
    let law = Law::compiled(law, 1)?;
    let body = bar(1001);
    let mut engine = Engine::new(&body, law.clone(), settings(&law, params))?;
    let mut state = engine.state();

    // A smooth bump of displacement at rest: two waves leave it, half as high, one to each side.
    for (node, x) in body.x.iter().enumerate() {
        state.u[0][engine.slot(node)] = 1e-6 * (-(x[0] / 0.02).powi(2)).exp();
    }
    let dt = 0.4 * SPACING / theory;
    let steps = 800;
    verlet(&mut engine, &mut state, dt, steps);

    // The centre of the wave on the right moves at the speed of long waves, whatever dispersion does to its shape.
    let right = body.x.iter().enumerate().filter(|(_, x)| x[0] > 0.0);
    let (mut moment, mut total) = (0.0, 0.0);
    for (node, x) in right {
        let u = state.u[0][engine.slot(node)];
        moment += u * x[0];
        total += u;
    }
    println!(
        "{:8} {:10.2} {theory:8.2}",
        law.spec.law,
        moment / total / (dt * steps as f64)
    );
    Ok(())
}

/// A bar along x with its middle at 0, nodes on a regular grid: so the engine needs no neighbour lists.
fn bar(nodes: u32) -> Body {
    let start = -0.5 * SPACING * (nodes - 1) as f64;
    Body {
        flavour: Flavour::Slab,
        x: (0..nodes)
            .map(|i| [start + SPACING * i as f64, 0.0, 0.0])
            .collect(),
        volume: vec![SPACING; nodes as usize],
        material: vec![],
        regions: vec![],
        horizon: vec![],
        cross: 1.0,
        grid: Some(Grid {
            origin: [start, 0.0, 0.0],
            spacing: SPACING,
            shape: [nodes, 1, 1],
            cell: (0..nodes).map(|i| [i, 0, 0]).collect(),
        }),
        spacing: SPACING,
        periodic: [None; 3],
    }
}

fn settings(law: &Law, params: Vec<f64>) -> Settings {
    // Each law names its influence functions and brings a default.
    let influences = law.spec.influences.iter();
    Settings {
        materials: vec![params],
        influences: influences
            .filter_map(|i| Some((i.default.clone()?, vec![])))
            .collect(),
        horizon: vec![3.0 * SPACING],
        horizon_levels: 64,
        partial_volume: false,
        // Constants from the sum over the lattice instead of the integral: then the speed is exact.
        lattice_constants: true,
        without: vec![],
        traversal: Traversal::Auto,
        isa: None,
        precision: Precision::Double,
    }
}

/// Velocity Verlet: half a kick, a drift, forces, half a kick.
fn verlet(engine: &mut Engine, state: &mut State, dt: f64, steps: usize) {
    let kick = |engine: &Engine, state: &mut State| {
        for (v, f) in state.v[0].iter_mut().zip(&engine.force()[0]) {
            *v += 0.5 * dt * f / DENSITY;
        }
    };
    engine.forces(state, Breaking::Held);
    for _ in 0..steps {
        kick(engine, state);
        for (u, v) in state.u[0].iter_mut().zip(&state.v[0]) {
            *u += dt * v;
        }
        engine.forces(state, Breaking::Held);
        kick(engine, state);
    }
}
