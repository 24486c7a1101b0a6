//! Chunks asleep: whole runs have the same bits with and without, for every law, flavour and traversal, on any number
//! of threads, with bonds breaking and a restart in the middle.

use std::path::Path;

use pdlang::assemble::Kinematics;
use pdlang_models::language::Pdlang;
use pdlang_models::registry;
use pdlang_runtime::body::{Body, Flavour};
use pdlang_runtime::engine::{Engine, Precision, State, Traversal};
use pdlang_runtime::observe::Schedule;
use pdlang_runtime::scene::Scene;
use pdlang_runtime::simulate::Simulation;
use pdlang_tests::agreement::{Question, spec_for};
use pdlang_tests::steps::{folder, reread, save, step};
use pdlang_tests::{bodies, laws};

fn strip(flavour: Flavour) -> Body {
    let shape = match flavour.dim() {
        1 => [400, 1, 1],
        2 => [120, 6, 1],
        _ => [90, 5, 3],
    };
    bodies::lattice(flavour, shape, false)
}

/// At rest but for the left end.
fn nudged(question: &Question, engine: &mut Engine) -> State {
    let mut state = question.state(engine);
    let u = bodies::deformation(&question.body, 6e-3, 5);
    for (node, x) in question.body.x.iter().enumerate() {
        if x[0] > 12.0 * bodies::DX {
            continue;
        }
        let slot = engine.slot(node);
        for (a, values) in state.u.iter_mut().enumerate() {
            values[slot] = u[node][a];
        }
        let stepped: Vec<usize> = engine.rates().map(|r| r.slot).collect();
        for k in stepped {
            if let Some(at) = engine.index(k, slot).filter(|_| engine.lives(k, slot)) {
                state.slots[k][at] += 1e-3 * u[node][0] / bodies::DX;
            }
        }
    }
    state
}

fn bits(engine: &mut Engine, state: &State) -> Vec<u64> {
    let rates: Vec<f64> = engine.rates().flat_map(|r| r.drive.to_vec()).collect();
    let energy = engine.energy(state).to_vec();
    let force = engine.force().iter().flatten();
    let all = force.chain(&rates).chain(&energy);
    all.map(|v| v.to_bits()).collect()
}

fn on<A: Send>(threads: usize, act: impl FnOnce() -> A + Send) -> A {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    pool.expect("a pool of threads").install(act)
}

/// The part of the evaluations that was left out.
fn compare(question: &Question, traversal: Traversal, file: &Path) -> f64 {
    println!("{traversal:?}");
    same(
        question,
        || question.engine(question.fastest(), traversal, None),
        file,
    )
}

/// The same for engines that are made alike.
fn same(question: &Question, engine: impl Fn() -> Engine, file: &Path) -> f64 {
    let (mut awake, mut asleep) = (engine(), engine());
    let mut states = [nudged(question, &mut awake), nudged(question, &mut asleep)];
    asleep.sleep(true);
    let (mut broken, mut slept) = (0, 0.0_f64);
    for n in 0..12 {
        if n == 6 {
            slept = slept.max(asleep.slept());
            asleep = engine();
            nudged(question, &mut asleep);
            asleep.sleep(true);
            save(file, &states[1]);
            states[1] = reread(file);
        }
        let [one, two] = &mut states;
        let with = step(&mut asleep, two);
        let without = step(&mut awake, one);
        broken += with;
        assert_eq!(with, without, "{question} step {n}");
        assert!(one == two, "{question} step {n}");
        assert!(
            bits(&mut awake, one) == bits(&mut asleep, two),
            "{question} step {n}"
        );
    }
    // A bar of few bonds may hold by chance.
    let may_hold = question.body.flavour.dim() == 1 || !has_limit(question);
    assert!(broken > 0 || may_hold, "{question}: nothing breaks");
    slept.max(asleep.slept())
}

fn has_limit(question: &Question) -> bool {
    let names = question.law.params.iter().map(|p| p.name.as_str());
    names.filter(|p| ["s0", "s1", "s2"].contains(p)).count() > 0
}

#[test]
fn every_law_has_the_same_bits_and_does_less() {
    let folder = folder("sleep");
    for name in registry::names() {
        let law = laws::law(name);
        let limits = law.params.iter().map(|p| p.name.as_str());
        let limits: Vec<(&str, f64)> = limits
            .filter(|p| ["s0", "s1", "s2"].contains(p))
            .map(|p| (p, 0.002))
            .collect();
        for (k, flavour) in laws::flavours(&law).into_iter().enumerate() {
            let question = Question::at_rest(&law, strip(flavour)).with(&limits);
            for traversal in [Traversal::Lattice, Traversal::Cloud] {
                let slept = on(1 + k % 2, || {
                    compare(&question, traversal, &folder.join("state"))
                });
                println!("{question} {traversal:?}: {slept:.3}");
                assert!(slept > 0.1, "{question} {traversal:?}: {slept}");
            }
        }
    }
    std::fs::remove_dir_all(&folder).expect("it was made here");
}

/// What sums in single precision read is rounded again where something was stirred, and nowhere else.
#[test]
fn single_precision_has_the_same_bits_and_does_less() {
    let folder = folder("sleep-single");
    let lattice = |flavour, periodic| match flavour {
        Flavour::Bar => bodies::lattice(flavour, [400, 1, 1], periodic),
        _ => bodies::lattice(flavour, [90, 16, 1], periodic),
    };
    for (name, kinematics) in [
        ("pmb", Kinematics::Linearised),
        ("lps", Kinematics::Linearised),
        ("thermo_lps", Kinematics::Linearised),
        ("correspondence", Kinematics::General),
        ("heat_state", Kinematics::General),
    ] {
        let law = laws::law(name);
        let limits = law.params.iter().filter(|p| p.name == "s0");
        let limits: Vec<(&str, f64)> = limits.map(|p| (&*p.name, 0.002)).collect();
        let flavours = laws::flavours(&law);
        for (&flavour, periodic) in flavours.iter().flat_map(|f| [(f, false), (f, true)]) {
            if flavour == Flavour::Solid {
                continue;
            }
            let question = Question::at_rest(&law, lattice(flavour, periodic)).with(&limits);
            let spec = spec_for(&law, flavour.dim(), kinematics);
            let made = || {
                let mut settings = question.settings(Traversal::Lattice, None);
                settings.precision = Precision::Single;
                let law = pdlang_runtime::engine::Law::interpreted(spec.clone());
                Engine::new(&question.body, law, settings).expect("an engine")
            };
            let slept = same(&question, made, &folder.join("state"));
            assert!(slept > 0.1, "{question}: {slept}");
        }
    }
    std::fs::remove_dir_all(&folder).expect("it was made here");
}

/// A sphere on the end of a bar that is held on the other side: contact, conditions, loads, breaking.
fn impact(model: &str, traversal: &str) -> Simulation {
    let text = format!(
        r#"
[body]
flavour = "3d"
spacing = "1 mm"
shape = {{ box = {{ from = [0, 0, 0], to = ["60 mm", "6 mm", "6 mm"] }} }}
[family]
horizon = "3.015 dx"
traversal = "{traversal}"
[material]
model = "{model}"
density = "2200 kg/m^3"
K = "14.9 GPa"
{}
s0 = 5e-4
[[indenter]]
radius = "5 mm"
center = ["-5.2 mm", "3 mm", "3 mm"]
velocity = ["100 m/s", 0, 0]
contact = "penalty"
stiffness = "1e17 N/m^5"
[[condition]]
region = {{ box = {{ from = ["57 mm", 0, 0], to = ["60 mm", "6 mm", "6 mm"] }} }}
velocity = [0, 0, 0]
[[condition]]
region = {{ box = {{ from = ["40 mm", 0, 0], to = ["42 mm", "6 mm", "6 mm"] }} }}
body_force = [0, 0, "1e9 [N/m^3] * max(0, t/1e-6 [s] - 4)"]
[time]
steps = 60
"#,
        if model == "lps" {
            "G = \"8.94 GPa\""
        } else {
            ""
        }
    );
    let scene = Scene::parse(&text, Path::new("impact.toml"), &Pdlang);
    let scene = scene.unwrap_or_else(|e| panic!("{e}"));
    let mut simulation = scene.simulation().unwrap_or_else(|e| panic!("{e}"));
    simulation.outputs.history = Schedule::Steps(7);
    simulation
}

#[test]
fn an_impact_has_the_same_bits_and_does_less() {
    for model in ["pmb", "lps"] {
        for traversal in ["lattice", "cloud"] {
            let run = |sleep: bool, threads: usize| {
                on(threads, || {
                    let mut simulation = impact(model, traversal);
                    assert!(simulation.engine.sleeps());
                    simulation.engine.sleep(sleep);
                    let summary = simulation.run(&mut ()).expect("it runs");
                    (simulation.state, summary)
                })
            };
            let (without, all) = run(false, 1);
            assert!(all.last.broken > 0 && all.slept == 0.0);
            for threads in [1, 2] {
                let (with, less) = run(true, threads);
                assert!(with == without, "{model} {traversal} {threads}");
                assert_eq!(less.last, all.last, "{model} {traversal} {threads}");
                println!("{model} {traversal}: {:.3} left out", less.slept);
                assert!(less.slept > 0.1, "{model} {traversal}: {}", less.slept);
            }
        }
    }
}

/// Fields in the middle of a step, at half steps and on a part of the body, histories, breaking: all ways in which a run
/// asks for a part of the sweeps.
#[test]
fn runs_with_fields_and_histories_have_the_same_bits() {
    let elastic = "K = \"10 GPa\"\nG = \"6 GPa\"\ns0 = 2e-3";
    let heat = "k = \"1 W/(m K)\"\ncv = \"840 J/(kg K)\"";
    let left = "region = { box = { from = [0, 0], to = [\"4 mm\", \"8 mm\"] } }";
    let push = format!("[[condition]]\n{left}\nvelocity = [\"-30 m/s\", \"3 m/s\"]\n");
    let warm = format!("[[condition]]\n{left}\nT = \"300 [K]\"\n");
    let rim = "[[initial]]\nphi = [\"select(x > 0.15, 1e5, 0)\", 0]\n";
    let both = format!("{elastic}\nalpha = 1e-5\n{heat}");
    let plastic = format!("{elastic}\ntauy = \"5 MPa\"");
    let viscous = format!("{elastic}\nshare = 0.5\ntau = \"1 us\"");
    let cases = [
        ("heat", heat.to_string(), warm.clone()),
        ("heat_state", heat.to_string(), warm.clone()),
        ("thermo_lps", both, push.clone() + &warm),
        ("lps_plastic", plastic, push.clone()),
        ("lps_viscoelastic", viscous, push.clone()),
        ("absorbing", "E = \"10 GPa\"\nnu = 0.25".into(), push + rim),
    ];
    for (model, params, more) in cases {
        for traversal in ["lattice", "cloud"] {
            let text = format!(
                "[body]\nflavour = \"plane_strain\"\nspacing = \"1 mm\"\nthickness = \"1 mm\"\nshape = {{ box = {{ from = [0, 0], to = [\"200 mm\", \"8 mm\"] }} }}\n\
                 [family]\nhorizon = \"3.015 dx\"\ntraversal = \"{traversal}\"\n\
                 [material]\nmodel = \"{model}\"\ndensity = \"2200 kg/m^3\"\n{params}\n{more}[time]\nsteps = 40\n"
            );
            let run = |sleep: bool| {
                let scene = Scene::parse(&text, Path::new("strip.toml"), &Pdlang);
                let scene = scene.unwrap_or_else(|e| panic!("{e}"));
                let mut simulation = scene.simulation().unwrap_or_else(|e| panic!("{e}"));
                simulation.engine.sleep(sleep);
                simulation.outputs.history = Schedule::Steps(3);
                let summary = simulation.run(&mut ()).unwrap_or_else(|e| panic!("{e}"));
                (simulation.state, summary)
            };
            let ((with, less), (without, all)) = (run(true), run(false));
            println!(
                "{model} {traversal}: {:.3}, {} broken",
                less.slept, less.last.broken
            );
            assert!(
                with == without && less.last == all.last,
                "{model} {traversal}"
            );
            assert!(
                less.slept > 0.02 && all.slept == 0.0,
                "{model} {traversal}: {}",
                less.slept
            );
        }
    }
}

/// The scene says so, and that is not another scene: a checkpoint serves both.
#[test]
fn a_scene_may_keep_all_awake() {
    let text = |sleep: &str| {
        format!(
            "[body]\nflavour = \"bar\"\nspacing = \"1 mm\"\ncross_section = \"1 mm^2\"\nshape = {{ box = {{ from = [0], to = [\"1 m\"] }} }}\n\
             [family]\nhorizon = \"3 dx\"\n[material]\nmodel = \"pmb\"\ndensity = \"1 g/cm^3\"\nK = \"1 GPa\"\n\
             [time]\nsteps = 3\n{sleep}"
        )
    };
    let simulation = |sleep: &str| {
        let scene = Scene::parse(&text(sleep), Path::new("bar.toml"), &Pdlang);
        let scene = scene.unwrap_or_else(|e| panic!("{e}"));
        scene.simulation().unwrap_or_else(|e| panic!("{e}"))
    };
    let (with, without) = (simulation(""), simulation("sleep = false\n"));
    assert!(with.engine.sleeps() && !without.engine.sleeps());
    assert!(with.identity == without.identity);
}
