//! Laws with a temperature against closed forms and the tables of the book that they come from.

use std::f64::consts::PI;
use std::path::Path;

use pdlang_models::language::Pdlang;
use pdlang_runtime::body::{Body, Flavour};
use pdlang_runtime::engine::{Breaking, Engine, Traversal};
use pdlang_runtime::observe::Observer;
use pdlang_runtime::scene::Scene;
use pdlang_runtime::simulate::{Simulation, StepRule};
use pdlang_tests::agreement::Question;
use pdlang_tests::{bodies, laws};

fn simulation(text: &str, folder: &str) -> Simulation {
    let scene = Scene::parse(text, &Path::new(folder).join("scene.toml"), &Pdlang);
    let scene = scene.unwrap_or_else(|e| panic!("{e}"));
    scene.simulation().unwrap_or_else(|e| panic!("{e}"))
}

fn read(scene: &str) -> String {
    std::fs::read_to_string(format!("scenes/{scene}.toml")).expect("the scene exists")
}

/// State-based laws look twice as far: what is mirrored is two horizons deep.
fn layers(scene: &str, law: &str) -> String {
    match law {
        "heat" | "thermo_pmb" => scene.to_string(),
        _ => scene.replace("3*dx", "6*dx"),
    }
}

fn temperature(simulation: &Simulation) -> Vec<f64> {
    let k = simulation.engine.state_slots("T").expect("there is T")[0];
    let slots = simulation.engine.slots();
    slots
        .iter()
        .map(|s| simulation.state.slots[k][*s as usize])
        .collect()
}

/// Madenci and Oterkus 2014, eq. 12.96, with t in its first term.
fn ramp(x: f64, t: f64) -> f64 {
    let (a, length, k, heat) = (500.0, 0.01, 233.0, 260.0 * 64.0);
    let term = |n: usize| {
        let n = n as f64;
        let sign = if n % 2.0 == 0.0 { 1.0 } else { -1.0 };
        let decay = (-k / heat * (n * PI / length).powi(2) * t).exp();
        sign / n.powi(3) * (n * PI * x / length).sin() * (1.0 - decay)
    };
    let sum: f64 = (1..4000).map(term).sum();
    a * x / length * t + 2.0 * a * length * length * heat / (k * PI.powi(3)) * sum
}

#[test]
fn a_slab_with_a_ramped_surface() {
    // The reference's own numbers, five digits.
    assert!((ramp(0.005, 0.0125) - 2.90182).abs() < 5e-6);
    assert!((ramp(0.009, 0.05) - 22.39823).abs() < 5e-6);
    // At the earlier time the transient still counts.
    let cases = [
        ("heat", 0.0125, 1e-4),
        ("heat", 0.002, 5e-4),
        ("heat_state", 0.0125, 1e-4),
    ];
    for (law, until, bound) in cases {
        let text = layers(&read("slab_ramp"), law)
            .replace("12.5 ms", &format!("{until}"))
            .replace("\"heat\"", &format!("\"{law}\""));
        let mut simulation = simulation(&text, "scenes");
        simulation.run(&mut ()).unwrap_or_else(|e| panic!("{e}"));
        let mut error = 0.0_f64;
        for (x, t) in simulation.body.x.iter().zip(temperature(&simulation)) {
            if x[0] > 0.0 && x[0] < 0.01 {
                error = error.max((t - ramp(x[0], until)).abs());
            }
        }
        let largest = 500.0 * until;
        println!(
            "{law}, t = {until} s: {:.2e} of the maximum",
            error / largest
        );
        assert!(error <= bound * largest, "{law}: {error} of {largest}");
    }
}

/// Temperature and displacement at x = 1 whenever fields are due.
#[derive(Default)]
struct AtOne(Vec<[f64; 3]>);

impl Observer for AtOne {
    fn fields(&mut self, sim: &mut Simulation) -> Result<(), String> {
        let t = temperature(sim);
        let at = |values: &dyn Fn(usize) -> f64| {
            let beside = |x: f64| sim.body.x.iter().position(|p| (p[0] - x).abs() < 1e-9);
            let half = sim.body.spacing / 2.0;
            let ends = [beside(1.0 - half), beside(1.0 + half)];
            ends.iter().map(|n| 0.5 * values(n.expect("a node"))).sum()
        };
        let u = |n: usize| sim.state.u[0][sim.engine.slot(n)] / 1e-3;
        self.0.push([sim.state.time, at(&|n| t[n]), at(&u)]);
        Ok(())
    }
}

/// Laplace transform of the problem, inverted; finite differences give the same to 2e-4. For couplings 0, 0.36 and
/// 1: (t, T, u) at x = 1.
const HEATED_END: [[[f64; 3]; 5]; 3] = [
    [
        [0.5, 0.24457, 0.01618],
        [1.0, 0.44875, 0.16696],
        [1.5, 0.54613, 0.10396],
        [2.0, 0.60539, -0.05873],
        [3.0, 0.67659, -0.34992],
    ],
    [
        [0.5, 0.24753, 0.01617],
        [1.0, 0.39543, 0.15347],
        [1.5, 0.47249, 0.09393],
        [2.0, 0.54038, -0.05030],
        [3.0, 0.62264, -0.30772],
    ],
    [
        [0.5, 0.25100, 0.01610],
        [1.0, 0.31367, 0.13246],
        [1.5, 0.36978, 0.07987],
        [2.0, 0.44922, -0.03723],
        [3.0, 0.54637, -0.24765],
    ],
];

#[test]
fn a_heated_end_of_a_coupled_bar() {
    for law in ["thermo_pmb", "thermo_lps"] {
        for (name, expected) in ["0", "36", "100"].iter().zip(HEATED_END) {
            // LPS as a bar: E = 1 whatever Poisson's ratio; here it is 1/4.
            let text = layers(&read(&format!("coupled_bar_{name}")), law)
                .replace("\"thermo_pmb\"", &format!("\"{law}\""))
                .replace(
                    "K = \"2/3\"",
                    if law == "thermo_lps" {
                        "K = \"2/3\"\nG = 0.4"
                    } else {
                        "K = \"2/3\""
                    },
                );
            let mut simulation = simulation(&text, "scenes");
            let mut seen = AtOne::default();
            simulation.run(&mut seen).unwrap_or_else(|e| panic!("{e}"));
            for e in expected {
                let got = seen
                    .0
                    .iter()
                    .find(|g| (g[0] - e[0]).abs() < 1e-9)
                    .expect("a due time");
                let error = [1, 2].map(|k| (got[k] - e[k]).abs());
                println!(
                    "{law} {name} t = {}: T {:.5} {:+.2} %, u {:.5} {:+.2} %",
                    e[0],
                    got[1],
                    100.0 * (got[1] / e[1] - 1.0),
                    got[2],
                    100.0 * (got[2] / e[2] - 1.0)
                );
                for k in [1, 2] {
                    assert!(
                        error[k - 1] <= 0.02 * e[k].abs(),
                        "{law} {name}: {got:?} is not {e:?}"
                    );
                }
            }
        }
    }
}

/// Two nodes that exchange heat: the difference decays with the rate 2 kappa omega V/(rho c_v).
#[test]
fn two_nodes_exchange_heat() {
    let (length, volume, horizon) = (1e-3, 2e-9, 1.5e-3_f64);
    for (name, flavour, micro) in [
        // Madenci and Oterkus 2014: 2k/(A delta^2), 6k/(pi h delta^3), 6k/(pi delta^4); A = h = 1 here.
        ("heat", Flavour::Bar, 2.0 / horizon.powi(2)),
        ("heat", Flavour::PlaneStress, 6.0 / (PI * horizon.powi(3))),
        ("heat", Flavour::Solid, 6.0 / (PI * horizon.powi(4))),
    ] {
        let law = laws::law(name);
        let body = Body {
            flavour,
            x: vec![[0.0; 3], [length, 0.0, 0.0]],
            volume: vec![volume; 2],
            material: vec![],
            regions: vec![],
            horizon: vec![],
            cross: 1.0,
            grid: None,
            spacing: length,
            periodic: [None; 3],
        };
        let mut question = Question::at_rest(&law, body);
        question.horizon = horizon;
        question.fields[0][0] = vec![300.0, 310.0];
        let mut engine = question.engine(question.fastest(), Traversal::Cloud, None);
        let mut state = question.state(&mut engine);
        engine.forces(&mut state, Breaking::Held);
        let rate = engine.rates().next().expect("a rate").drive;
        let expected = 1.4 * micro * 10.0 / length * volume / (2200.0 * 840.0);
        let got = [0, 1].map(|n| rate[engine.slot(n)]);
        assert!(
            (got[0] / expected - 1.0).abs() < 1e-14,
            "{got:?} {expected}"
        );
        assert_eq!(got[0], -got[1]);
    }
}

const BLOCK: &str = r#"
[body]
flavour = "plane_stress"
spacing = "1 mm"
thickness = "1 mm"
shape = { difference = [
    { box = { from = [0, 0], to = ["30 mm", "20 mm"] } },
    { disc = { center = ["9 mm", "8 mm"], radius = "4 mm" } },
] }

[family]
horizon = "3.015 dx"

[material]
model = "heat"
k = 45
density = 7800
cv = 460

[[crack]]
segment = { from = ["20 mm", 0], to = ["20 mm", "14 mm"] }

[[initial]]
T = "293 + 40*sin(300*x)*cos(170*y)"

[time]
until = "2 s"

[output]
every = "never"
"#;

/// What flows out of one node flows into another, at every stage of every step.
#[test]
fn an_insulated_body_keeps_its_heat() {
    for law in ["heat", "heat_state"] {
        let text = BLOCK
            .replace("\"heat\"", &format!("\"{law}\""))
            .replace("until = \"2 s\"", "until = \"60 s\"");
        let mut simulation = simulation(&text, "scenes");
        simulation.run(&mut ()).unwrap_or_else(|e| panic!("{e}"));
        let volume: f64 = simulation.body.volume.iter().sum();
        let field = &simulation.row.fields[0];
        let start = |x: &[f64; 3]| 293.0 + 40.0 * (300.0 * x[0]).sin() * (170.0 * x[1]).cos();
        let nodes = simulation.body.x.iter().zip(&simulation.body.volume);
        let before: f64 = nodes.map(|(x, v)| start(x) * v).sum();
        let change = (field.total - before) / before;
        println!(
            "{law}: {} steps, change {change:.1e}, {:.3} to {:.3}",
            simulation.steps, field.min, field.max
        );
        assert!(
            change.abs() < 2e-15 * simulation.steps as f64,
            "{law}: {change:e}"
        );
        assert!((field.mean - field.total / volume).abs() < 1e-12 * field.mean);
        assert!(field.max - field.min < 60.0 && field.min > 253.0);
    }
}

/// A source in a part of the body and a flux through its edge: the heat that came in is there.
#[test]
fn sources_add_what_they_say() {
    // 2e6 W/m^3 on 100 mm^3, and 1e4 W/m^2 through a row of 20 mm: spread over a cell's width.
    let text = format!(
        "{}\n{}",
        BLOCK,
        r#"
[[condition]]
region = { box = { from = ["22 mm", 0], to = ["27 mm", "20 mm"] } }
source = "2e6 [W/m^3] * t/(1 [s])"

[[condition]]
region = { box = { from = [0, 0], to = ["1 mm", "20 mm"] } }
source = "1e4 [W/m^2] / dx"
"#
    );
    let mut simulation = simulation(&text, "scenes");
    let before = {
        let t = temperature(&simulation);
        t.iter()
            .zip(&simulation.body.volume)
            .map(|(t, v)| t * v)
            .sum::<f64>()
    };
    simulation.run(&mut ()).unwrap_or_else(|e| panic!("{e}"));
    let after = simulation.row.fields[0].total;
    let joule = (after - before) * 7800.0 * 460.0;
    // integral of t from 0 to 2 is 2; 2 s of 1e4 W/m^2 on 20 mm^2.
    let expected = 2.0 * 2e6 * 100e-9 + 2.0 * 1e4 * 20e-6;
    assert!((joule / expected - 1.0).abs() < 1e-9, "{joule} {expected}");
}

/// Free thermal expansion is free of force, on every node and in every flavour: u = a T x, where a is larger than
/// alpha by what cannot expand out of the line or the plane.
#[test]
fn uniform_expansion_is_free_of_stress() {
    for name in ["thermo_pmb", "thermo_lps"] {
        let law = laws::law(name);
        let nu = match name {
            "thermo_pmb" => 0.25,
            _ => (3.0 * laws::K - 2.0 * laws::G) / (6.0 * laws::K + 2.0 * laws::G),
        };
        for flavour in Flavour::ALL {
            let body = bodies::cloud(flavour, 3);
            let (alpha, t) = (1e-5, 70.0);
            let a = alpha
                * match flavour {
                    Flavour::Slab => (1.0 + nu) / (1.0 - nu),
                    Flavour::PlaneStrain => 1.0 + nu,
                    _ => 1.0,
                };
            let mut question = Question::at_rest(&law, body).with(&[("alpha", alpha)]);
            question.fields[0][0].fill(t);
            let mut engine = question.engine(question.fastest(), Traversal::Cloud, None);
            let force = |question: &Question, engine: &mut Engine| {
                let mut state = question.state(engine);
                engine.forces(&mut state, Breaking::Held);
                let all = engine.force().iter().flatten();
                all.fold(0.0_f64, |m, f| m.max(f.abs()))
            };
            let held = force(&question, &mut engine);
            let nodes = question.body.x.iter();
            question.path[0] = nodes.map(|x| x.map(|c| a * t * c)).collect();
            let free = force(&question, &mut engine);
            assert!(
                held > 0.0 && free < 1e-9 * held,
                "{name} {flavour:?}: {free:e} of {held:e}"
            );
        }
    }
}

/// Halving the step of the coupled bar divides its error by four, or nearly so: the number of stages changes too.
#[test]
fn the_coupled_step_is_of_second_order() {
    let text = read("coupled_bar_100");
    // Smooth heating, so that nothing but the order of the scheme shows.
    let text = text
        .replace("min(t/0.25, 1)", "sin(3*t)^4")
        .replace("until = 3", "until = 1.6");
    let end = |dt: f64| {
        let text = text.replace("dt = 0.01", &format!("dt = {dt}"));
        let mut simulation = simulation(&text, "scenes");
        assert_eq!(simulation.rule, StepRule::Fixed(dt));
        simulation.run(&mut ()).unwrap_or_else(|e| panic!("{e}"));
        let slots = simulation.engine.slots();
        let u = |s: &u32| simulation.state.u[0][*s as usize];
        (
            temperature(&simulation),
            slots.iter().map(u).collect::<Vec<f64>>(),
        )
    };
    let exact = end(0.016 / 32.0);
    let gap = |a: &[f64], b: &[f64]| {
        a.iter()
            .zip(b)
            .fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()))
    };
    let (coarse, fine) = (end(0.016), end(0.008));
    let orders = [
        gap(&coarse.0, &exact.0) / gap(&fine.0, &exact.0),
        gap(&coarse.1, &exact.1) / gap(&fine.1, &exact.1),
    ];
    println!("errors fall by {orders:.2?}");
    assert!(orders.iter().all(|o| (3.2..5.0).contains(o)), "{orders:?}");
}

/// Heat of deformation stiffens what moves too fast to be conducted away: the step that is chosen counts it, to the
/// last percent, and the limit of the same bar without it is too long.
#[test]
fn the_stable_step_counts_heat_of_deformation() {
    let text = |t0: f64, step: &str| {
        format!(
            r#"
[body]
flavour = "bar"
spacing = 0.025
cross_section = 1
shape = {{ box = {{ from = [0], to = [5] }} }}

[family]
horizon = "3.015 dx"
partial_volume = true

[material]
model = "thermo_pmb"
density = 1
K = "2/3"
alpha = 1e-3
k = 1e-6
cv = 1
T0 = {t0}

[[initial]]
velocity = ["1e-4*(sin(7*x) + sin(37*x) + sin(60*x) + sin(91*x))"]

[time]
steps = 3000
{step}

[output]
every = "never"
"#
        )
    };
    let largest = |mut simulation: Simulation| {
        let ran = simulation.run(&mut ());
        let speed = simulation.state.v[0]
            .iter()
            .fold(0.0_f64, |m, v| m.max(v.abs()));
        (ran.is_ok(), speed)
    };
    let cold = simulation(&text(0.0, "safety = 1.0"), "scenes");
    let hot = simulation(&text(1e7, "safety = 1.0"), "scenes");
    println!("steps {:e} s and {:e} s", cold.dt, hot.dt);
    assert!(hot.dt < 0.7 * cold.dt);
    let step = format!("dt = {}", 1.04 * hot.dt);
    assert!(largest(cold).1 < 1e-3);
    assert!(largest(hot).1 < 1e-3);
    let (ran, speed) = largest(simulation(&text(1e7, &step), "scenes"));
    assert!(!ran || speed > 1.0, "{speed:e}");
}
