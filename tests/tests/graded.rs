//! Bodies in which every node has its own horizon: energies, momentum, waves, and the rounding to levels.

use std::path::Path;

use pdlang_models::language::Pdlang;
use pdlang_runtime::body::{Body, Flavour};
use pdlang_runtime::engine::{Breaking, Engine, Precision, Settings, Traversal};
use pdlang_runtime::scene::Scene;
use pdlang_runtime::simulate::Simulation;
use pdlang_tests::agreement::{Question, gather, influence, per_node, spread};
use pdlang_tests::bodies::{self, Random};
use pdlang_tests::laws;

fn settings(question: &Question, levels: usize) -> Settings {
    let chosen = question.influences.iter();
    Settings {
        materials: vec![question.params.clone()],
        influences: chosen
            .map(|(f, values)| (influence(f), values.clone()))
            .collect(),
        horizon: vec![question.horizon],
        horizon_levels: levels,
        partial_volume: false,
        lattice_constants: false,
        without: vec![],
        traversal: Traversal::Auto,
        isa: None,
        precision: Precision::Double,
    }
}

/// A cloud whose horizons are of chance, between 0.7 and 1.3 of the usual one.
fn by_chance<'a>(law: &'a pdlang::ir::Law, flavour: Flavour) -> Question<'a> {
    let mut question = Question::deformed(law, bodies::cloud(flavour, 3), 1e-2, 7);
    let mut random = Random(17);
    let nodes = question.body.x.len();
    let horizon = |_| question.horizon * (1.0 + 0.3 * random.signed());
    question.body.horizon = (0..nodes).map(horizon).collect();
    question
}

/// As many materials as there are nodes: each bond is of the average of its two horizons, forces are derivatives of the
/// energy and balance, compiled and interpreted.
#[test]
fn horizons_of_chance_keep_momentum_and_energy() {
    for name in ["pmb", "lps", "lps_frozen"] {
        let law = laws::law(name);
        for flavour in Flavour::ALL {
            let question = by_chance(&law, flavour);
            let body = &question.body;
            let engine = |compiled: bool| {
                let law = match compiled {
                    true => question.fastest(),
                    false => question.interpreted(),
                };
                Engine::new(body, law, settings(&question, 256)).expect("the body is valid")
            };
            let mut e = engine(true);
            assert_eq!(e.grading().horizons.len(), body.x.len());
            assert_eq!(e.grading().rounding, 0.0);
            let near = |i: usize, j: usize| {
                let r2: f64 = (0..3).map(|a| (body.x[i][a] - body.x[j][a]).powi(2)).sum();
                i != j && r2.sqrt() <= 0.5 * (body.horizon[i] + body.horizon[j])
            };
            let nodes = 0..body.x.len();
            let pairs = nodes.flat_map(|i| (0..body.x.len()).map(move |j| (i, j)));
            let bonds = pairs.filter(|&(i, j)| near(i, j)).count();
            assert_eq!(e.report().bonds, bonds, "{question}");

            let u = question.path.last().expect("a displacement");
            let mut state = e.state();
            spread(&e, u, &mut state.u);
            e.forces(&mut state, Breaking::Held);
            let force = gather(&e, e.force());
            let mut other = engine(false);
            let mut again = other.state();
            spread(&other, u, &mut again.u);
            other.forces(&mut again, Breaking::Held);
            assert_eq!(force, gather(&other, other.force()), "{question}");

            let mut work = 0.0;
            for a in 0..flavour.dim() {
                let (mut total, mut size) = (0.0, 0.0);
                for (i, f) in force.iter().enumerate() {
                    total += f[a] * body.volume[i];
                    size += (f[a] * body.volume[i]).abs();
                    work -= f[a] * question.du[i][a] * body.volume[i];
                }
                assert!(
                    total.abs() <= 1e-13 * size,
                    "{question}: {:e}",
                    total / size
                );
            }
            let mut energy = |h: f64| {
                let moved = u.iter().zip(&question.du);
                let moved = moved.map(|(u, d)| std::array::from_fn(|a| u[a] + h * d[a]));
                let mut state = e.state();
                spread(&e, &moved.collect::<Vec<_>>(), &mut state.u);
                e.forces(&mut state, Breaking::Held);
                let density = e.energy(&state).to_vec();
                let density = per_node(&e, &density);
                density
                    .iter()
                    .zip(&body.volume)
                    .map(|(w, v)| w * v)
                    .sum::<f64>()
            };
            let slope = (energy(1e-4) - energy(-1e-4)) / 2e-4;
            assert!(
                (slope - work).abs() <= 1e-6 * work.abs(),
                "{question}: {slope:e} {work:e}"
            );
        }
    }
}

/// Horizons of nodes are what the same horizons of materials are.
#[test]
fn nodes_with_two_horizons_are_two_parts() {
    let law = laws::law("lps");
    let question = Question::deformed(&law, bodies::carved(Flavour::PlaneStrain, 3), 1e-2, 7);
    let two = [0.8, 1.2].map(|h| h * question.horizon);
    let of = |i: usize| i.is_multiple_of(3) as usize;
    let forces = |body: &Body, settings: Settings| {
        let mut e = Engine::new(body, question.fastest(), settings).expect("valid");
        let mut s = e.state();
        spread(&e, question.path.last().expect("a displacement"), &mut s.u);
        e.forces(&mut s, Breaking::Held);
        gather(&e, e.force())
    };
    let nodes = 0..question.body.x.len();
    let parts = Body {
        material: nodes.clone().map(|i| of(i) as u8).collect(),
        ..question.body.clone()
    };
    let both = Settings {
        materials: vec![question.params.clone(); 2],
        horizon: two.to_vec(),
        ..settings(&question, 64)
    };
    let by_part = forces(&parts, both);
    let own = Body {
        horizon: nodes.map(|i| two[of(i)]).collect(),
        ..question.body.clone()
    };
    assert_eq!(by_part, forces(&own, settings(&question, 64)));
    // One horizon for all, as every node's own, is no grading.
    let all = |h: f64| Body {
        horizon: vec![h; question.body.x.len()],
        ..question.body.clone()
    };
    let usual = forces(&question.body, settings(&question, 64));
    assert_eq!(
        usual,
        forces(&all(question.horizon), settings(&question, 64))
    );
    let error = Engine::new(&all(-1.0), question.fastest(), settings(&question, 64));
    let error = error.expect_err("no horizon is negative").to_string();
    assert!(error.contains("node 0 has the horizon -1"), "{error}");
}

fn simulation(text: &str) -> Simulation {
    let scene = Scene::parse(text, Path::new("graded.toml"), &Pdlang);
    let made = scene.and_then(|scene| scene.simulation());
    made.unwrap_or_else(|e| panic!("{e}"))
}

/// In one dimension, with a horizon `delta + 2 a x`, a stretched body has -ln(1 - a^2)/a^2 times the energy density of one
/// with the same horizon everywhere: a bond to x + r has the horizon delta(x) + a r and exists where r <= delta(x)/(1 - a),
/// and the bond constant goes with its inverse square, so that both sides add to
/// int_0^{1/(1-a)} t/(1 + a t)^2 dt + int_0^{1/(1+a)} t/(1 - a t)^2 dt = -ln(1 - a^2)/a^2 = 1 + a^2/2 + ...
#[test]
fn a_stretched_bar_of_growing_horizon_has_its_energy() {
    let energy = |slope: f64, levels: usize| {
        let mut s = simulation(&format!(
            r#"
            [body]
            flavour = "bar"
            spacing = 1
            cross_section = 1
            shape = {{ box = {{ from = [0], to = [4000] }} }}
            [family]
            horizon = "max(min(200.5 + {slope}*(x - 2000), 320), 100)"
            horizon_levels = {levels}
            [material]
            model = "pmb"
            density = 1
            K = 1
            [[initial]]
            displacement = ["1e-3*x"]
            [time]
            steps = 0
            "#
        ));
        s.engine.forces(&mut s.state, Breaking::Held);
        let energy = s.engine.energy(&s.state).to_vec();
        let energy = per_node(&s.engine, &energy);
        let inner = &energy[1500..2500];
        let rounding = s.engine.grading().rounding;
        (inner.iter().sum::<f64>() / inner.len() as f64, rounding)
    };
    let (uniform, _) = energy(1e-12, 1);
    for a in [0.02, 0.05] {
        let expected = -(1.0_f64 - a * a).ln() / (a * a);
        for (levels, allowed) in [(256, 2.5e-4), (64, 1e-3)] {
            let (found, rounding) = energy(2.0 * a, levels);
            let off = found / uniform - expected;
            println!(
                "a = {a}, {levels} levels, rounding {rounding:.1e}: {found:.6e} off {off:+.1e}"
            );
            assert!(off.abs() < allowed, "{a} {levels}: {off:e}");
        }
    }
}

/// A pulse that is long against all horizons runs from a horizon of 12 into one of 3, and hardly anything comes back.
#[test]
fn a_wave_crosses_from_a_coarse_horizon_to_a_fine_one() {
    let mut s = simulation(
        r#"
        [body]
        flavour = "slab"
        spacing = 1
        cross_section = 1
        shape = { box = { from = [0], to = [1600] } }
        [family]
        horizon = "3.5 + 9*min(max((900 - x)/200, 0), 1)"
        [material]
        model = "pmb"
        density = 1
        K = 1
        constants = "lattice"
        [[initial]]
        region = { box = { from = [0], to = [700] } }
        displacement = ["exp(-((x - 400)/50)^2)"]
        [time]
        until = 480
        safety = 0.5
        "#,
    );
    assert!(s.engine.grading().horizons.len() > 20);
    s.run(&mut ()).unwrap_or_else(|e| panic!("{e}"));
    let u = per_node(&s.engine, &s.state.u[0]);
    let total: f64 = per_node(&s.engine, &s.state.v[0]).iter().sum();
    let peak = |from: f64, to: f64| {
        let inside = s
            .body
            .x
            .iter()
            .zip(&u)
            .filter(|(x, _)| x[0] > from && x[0] < to);
        inside.fold(0.0_f64, |m, (_, u)| if u.abs() > m.abs() { *u } else { m })
    };
    // c = sqrt(9/5): half of the pulse is at 400 + 644 = 1044, the other half has been reflected at the free end.
    let through = peak(950.0, 1300.0);
    let x = s.body.x.iter().zip(&u).max_by(|a, b| a.1.total_cmp(b.1));
    println!(
        "through {through:.5}, momentum {total:.1e}, {:?}",
        x.map(|x| x.0[0])
    );
    assert!((through - 0.5).abs() < 5e-3, "{through}");
}

/// The column `delta` of a point file, and what `plan` and the summary say.
#[test]
fn a_point_file_gives_every_node_its_horizon() {
    let folder = std::env::temp_dir().join(format!("pdlang-graded-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    // Spacing that grows by 4 % from node to node; three of them are the horizon.
    let (mut x, mut h, mut rows) = (0.0, 1.0, String::from("x,volume,delta\n"));
    let mut delta = Vec::new();
    for _ in 0..100 {
        delta.push(3.2 * h);
        rows += &format!("{},{h},{}\n", x + 0.5 * h, 3.2 * h);
        x += h;
        h *= 1.04;
    }
    std::fs::write(folder.join("bar.csv"), rows).expect("a file");
    let text = r#"
        [body]
        flavour = "bar"
        spacing = 1
        cross_section = 1
        points = "bar.csv"
        [family]
        horizon = { column = "delta" }
        [material]
        model = "pmb"
        density = 1
        K = 1
        [time]
        steps = 0
        "#;
    let made = |levels: &str| {
        let text = text.replace("[material]", &format!("{levels}\n[material]"));
        let scene = Scene::parse(&text, &folder.join("scene.toml"), &Pdlang);
        scene
            .and_then(|s| s.simulation())
            .unwrap_or_else(|e| panic!("{e}"))
    };
    let exact = made("horizon_levels = 100");
    assert_eq!(exact.body.horizon, delta);
    assert_eq!(exact.engine.grading().horizons, delta);
    assert_eq!((exact.horizon, exact.reach), (delta[0], delta[99]));
    let rounded = made("");
    let grading = rounded.engine.grading();
    assert_eq!(grading.horizons.len(), 64);
    let half_a_step = 1.04_f64.powf(99.0 / 63.0 / 2.0) - 1.0;
    assert!(grading.rounding <= half_a_step * 1.001 && grading.rounding > 0.5 * half_a_step);
    std::fs::remove_dir_all(&folder).expect("it was made here");
}
