//! The scene of every kernel measurement: a cubic lattice of n^3 nodes, horizon 3.015 dx. It is the same to the bit
//! wherever it is made.
use pdlang_runtime::body::{Body, Flavour, Grid};
use pdlang_runtime::engine::{Engine, Isa, Law, Precision, Settings, SetupError, State, Traversal};
use pdlang_runtime::spec::InfluenceSpec;

/// Lattice constant [m], horizon [m].
pub const DX: f64 = 5e-4;
pub const HORIZON: f64 = 3.015 * DX;

/// Bulk and shear modulus [Pa].
pub const K: f64 = 14.9e9;
pub const G: f64 = 6e9;

/// PMB: c [N/m^6], critical stretch; c = 18 K / (pi delta^4).
pub fn pmb_params(s0: f64) -> Vec<f64> {
    vec![18.0 * K / (std::f64::consts::PI * HORIZON.powi(4)), s0]
}

/// LPS: 3K - 5G, 15 G [Pa], critical stretch.
pub fn lps_params(s0: f64) -> Vec<f64> {
    vec![3.0 * K - 5.0 * G, 15.0 * G, s0]
}

pub fn body(n: u32) -> Body {
    lattice(3, [n; 3], |_| true)
}

/// The cells of a box that `keep` names: a square lattice in two dimensions, a row in one.
pub fn lattice(dim: i32, shape: [u32; 3], keep: impl Fn([u32; 3]) -> bool) -> Body {
    let mut cell = vec![];
    for k in 0..shape[2] {
        for j in 0..shape[1] {
            for i in 0..shape[0] {
                if keep([i, j, k]) {
                    cell.push([i, j, k]);
                }
            }
        }
    }
    Body {
        flavour: [Flavour::Bar, Flavour::PlaneStrain, Flavour::Solid][dim as usize - 1],
        x: cell.iter().map(|c| c.map(|c| c as f64 * DX)).collect(),
        volume: vec![DX.powi(dim); cell.len()],
        material: vec![],
        regions: vec![],
        horizon: vec![],
        cross: 1.0,
        grid: Some(Grid {
            origin: [0.0; 3],
            spacing: DX,
            shape,
            cell,
        }),
        spacing: DX,
        periodic: [None; 3],
    }
}

/// The same without a grid, every node moved by up to `amplitude` spacings in each direction.
pub fn jittered(n: u32, amplitude: f64) -> Body {
    let mut body = body(n);
    body.grid = None;
    for (node, x) in body.x.iter_mut().enumerate() {
        for (a, x) in x.iter_mut().enumerate() {
            *x += amplitude * DX * signed(3 * node as u64 + a as u64);
        }
    }
    body
}

/// n^3 nodes whose spacing grows threefold along x, as do their horizons.
pub fn graded(n: u32) -> Body {
    let mut body = jittered(n, 0.0);
    let stretch = |x: f64| x + x * x / (f64::from(n) * DX);
    for (x, volume) in body.x.iter_mut().zip(&mut body.volume) {
        let spacing = DX + 2.0 * x[0] / f64::from(n);
        body.horizon.push(HORIZON / DX * spacing);
        *volume *= spacing / DX;
        x[0] = stretch(x[0]);
    }
    body
}

/// In [-1, 1), of chance (SplitMix64: Steele, Lea and Flood 2014).
fn signed(seed: u64) -> f64 {
    let mut z = (seed + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

/// The law on the scene, with the default influence functions of the law.
///
/// # Errors
/// As [`Engine::new`]; a scene too large for the memory is one.
pub fn engine(
    body: &Body,
    law: Law,
    params: Vec<f64>,
    traversal: Traversal,
    isa: Isa,
) -> Result<Engine, SetupError> {
    let settings = settings(&law, params, traversal, isa);
    Engine::new(body, law, settings)
}

/// What the scene has besides its body.
pub fn settings(law: &Law, params: Vec<f64>, traversal: Traversal, isa: Isa) -> Settings {
    let influence = |i: &InfluenceSpec| i.default.clone().map(|default| (default, vec![]));
    Settings {
        materials: vec![params],
        influences: law.spec.influences.iter().filter_map(influence).collect(),
        horizon: vec![HORIZON],
        horizon_levels: 64,
        partial_volume: true,
        lattice_constants: false,
        without: vec![],
        traversal,
        isa: Some(isa),
        precision: Precision::Double,
    }
}

/// A smooth displacement of about 1e-2 dx with some noise, so that no two bonds are alike.
pub fn displacement(x: [f64; 3], a: usize) -> f64 {
    let [p, q, r] = x.map(|c| c / (50.0 * DX) * 7.0);
    let wave = [
        (p + 0.3 * q).sin() * r.cos(),
        (q - r).sin(),
        (0.5 * p).cos() * (q + r).sin(),
    ][a];
    let noise = ((x[0] * 7.3 + x[1] * 3.1 + x[2] * 5.7) / DX * 12.9898 + a as f64).sin();
    1e-2 * DX * (wave + 0.1 * noise)
}

/// The state of an engine under [`displacement`].
pub fn displaced(e: &Engine, body: &Body) -> State {
    let mut s = e.state();
    for (i, x) in body.x.iter().enumerate() {
        for (a, u) in s.u.iter_mut().enumerate() {
            u[e.slot(i)] = displacement(*x, a);
        }
    }
    s
}
