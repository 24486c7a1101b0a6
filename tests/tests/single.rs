//! Sums over bonds in single precision: as near to those in double precision as seven digits are, wherever they may be;
//! everywhere else they are refused with the reason.

use pdlang::assemble::Kinematics;
use pdlang::ir::Law;
use pdlang_models::language::Pdlang;
use pdlang_models::registry::{self, CATALOGUE};
use pdlang_runtime::body::Flavour;
use pdlang_runtime::checkpoint;
use pdlang_runtime::engine::{
    self, Breaking, Engine, Isa, Precision, SetupError, State, Traversal,
};
use pdlang_runtime::scene::Scene;
use pdlang_runtime::simulate::Simulation;
use pdlang_tests::agreement::{Question, spec_for};
use pdlang_tests::{bodies, laws, steps};
use std::path::Path;

const STRAIN: f64 = 1e-3;
/// Largest difference of a force or a rate, in units of the largest.
fn near(law: &Law) -> f64 {
    match law.name.as_str() {
        // Inverses of shapes that broken bonds leave nearly flat.
        name if name.starts_with("correspondence") => 5e-5,
        // Values of the field are not small beside their differences.
        _ if !law.fields.is_empty() => 1e-4,
        _ => 2e-6,
    }
}

fn engine_of(
    q: &Question,
    law: engine::Law,
    traversal: Traversal,
    precision: Precision,
) -> Result<Engine, SetupError> {
    let mut settings = q.settings(traversal, None);
    settings.precision = precision;
    Engine::new(&q.body, law, settings)
}

/// Forces and rates.
fn answers(engine: &Engine) -> Vec<Vec<f64>> {
    let rates = engine.rates().map(|r| r.drive.to_vec());
    engine.force().iter().cloned().chain(rates).collect()
}

/// The largest difference of two numbers, by the largest of those expected.
fn apart(found: &[f64], expected: &[f64]) -> f64 {
    assert!(found.iter().all(|v| v.is_finite()));
    let largest = |v: f64, of: f64| v.max(of.abs());
    let pairs = found.iter().zip(expected).map(|(a, b)| a - b);
    match pairs.fold(0.0, largest) {
        0.0 => 0.0,
        most => most / expected.iter().copied().fold(0.0, largest),
    }
}

/// The largest difference of an answer, by the largest answer of its kind in all directions.
fn distance(found: &Engine, expected: &Engine) -> f64 {
    let kinds = |engine: &Engine| {
        let all = answers(engine);
        let (forces, rates) = all.split_at(engine.force().len());
        let forces = forces.concat();
        [vec![forces], rates.to_vec()].concat()
    };
    let (found, expected) = (kinds(found), kinds(expected));
    assert_eq!(found.len(), expected.len());
    let pairs = found.iter().zip(&expected);
    pairs.map(|(a, b)| apart(a, b)).fold(0.0, f64::max)
}

/// The law at a dimension in all forms that there are: tapes, and machine code where it is compiled in.
fn forms(q: &Question, kinematics: Kinematics) -> Vec<engine::Law> {
    let dim = q.body.flavour.dim();
    let entry = registry::find(&q.law.name).expect("a law of the catalogue");
    let compiled = match kinematics {
        Kinematics::General => entry.compiled(dim),
        Kinematics::Linearised => entry.compiled_linearised(dim),
    };
    let tapes = engine::Law::interpreted(spec_for(q.law, dim, kinematics));
    std::iter::once(tapes).chain(compiled).collect()
}

/// Which laws may be summed in single precision as they are, and which of the others when they are linearised; how far
/// their forces are from those in double precision, on a lattice with holes and broken bonds.
#[test]
fn seven_digits_of_every_law_that_has_them() {
    let (mut as_they_are, mut linearised) = (vec![], vec![]);
    for entry in CATALOGUE {
        let law = laws::law(entry.name);
        let near = near(&law);
        let mut worst = [None::<f64>; 2];
        for flavour in laws::flavours(&law) {
            let question = Question::deformed(&law, bodies::carved(flavour, 1), STRAIN, 1);
            for (k, kinematics) in [Kinematics::General, Kinematics::Linearised]
                .into_iter()
                .enumerate()
            {
                if k == 1 && pdlang::assemble::spec(&law, flavour.dim(), kinematics).is_err() {
                    continue;
                }
                for form in forms(&question, kinematics) {
                    let made = |precision| {
                        engine_of(&question, form.clone(), Traversal::Lattice, precision)
                    };
                    let mut single = match made(Precision::Single) {
                        Err(SetupError::Precision(..)) => continue,
                        made => made.unwrap_or_else(|e| panic!("{question}: {e}")),
                    };
                    if Isa::best() == Isa::Scalar {
                        continue;
                    }
                    assert!(single.is_single());
                    let mut double =
                        made(Precision::Double).unwrap_or_else(|e| panic!("{question}: {e}"));
                    let states = [&mut single, &mut double].map(|engine| {
                        let mut state = question.state(engine);
                        engine.forces(&mut state, Breaking::Held);
                        state
                    });
                    let far = distance(&single, &double);
                    assert!(far < near, "{question} {kinematics:?}: {far:e}");
                    // What is not summed at every step is as it was.
                    let energy = single.energy(&states[0]);
                    let energy = apart(energy, double.energy(&states[1]));
                    assert!(energy < near, "{question} {kinematics:?}: {energy:e}");
                    worst[k] = Some(worst[k].unwrap_or(0.0).max(far));
                }
            }
        }
        let [general, linear] = worst.map(|w| w.map_or("-".into(), |w| format!("{w:.1e}")));
        println!("{}: {general} as it is, {linear} linearised", entry.name);
        match worst {
            [Some(w), _] if w > 0.0 => as_they_are.push(entry.name),
            [_, Some(w)] if w > 0.0 => linearised.push(entry.name),
            _ => {}
        }
    }
    if Isa::best() == Isa::Scalar {
        return;
    }
    let general = [
        "heat",
        "heat_state",
        "correspondence",
        "correspondence_stabilised",
        "correspondence_svk",
        "absorbing",
    ];
    assert_eq!(as_they_are, general);
    let linear = [
        "pmb",
        "gpmb",
        "lps",
        "lps_frozen",
        "thermo_pmb",
        "thermo_lps",
        "lamina",
        "laminate",
    ];
    assert_eq!(linearised, linear);
}

fn lps_linearised(q: &Question) -> engine::Law {
    forms(q, Kinematics::Linearised).pop().expect("a form")
}

/// A body that is moved as a whole has no force, to the last bit: also far from the origin.
#[test]
fn a_translation_has_no_force() {
    let law = laws::law("lps");
    let question = Question::at_rest(&law, bodies::lattice(Flavour::Solid, [5, 4, 4], false));
    let form = lps_linearised(&question);
    let mut engine =
        engine_of(&question, form, Traversal::Lattice, Precision::Single).expect("an engine");
    let mut state = engine.state();
    for (k, u) in state.u.iter_mut().enumerate() {
        u.fill(0.1 + k as f64 / 3.0);
    }
    engine.forces(&mut state, Breaking::Held);
    assert!(engine.force().iter().flatten().all(|f| *f == 0.0));
}

/// A wave in a bar after some hundred steps of the simplest kind.
#[test]
fn a_wave_stays_where_it_is_in_double_precision() {
    let law = laws::law("pmb");
    let question = Question::at_rest(&law, bodies::lattice(Flavour::Bar, [200, 1, 1], false));
    let form = forms(&question, Kinematics::Linearised)
        .pop()
        .expect("a form");
    let run = |precision| {
        let mut engine =
            engine_of(&question, form.clone(), Traversal::Lattice, precision).expect("an engine");
        let mut state: State = engine.state();
        for (node, x) in question.body.x.iter().enumerate() {
            let from = (x[0] - 100.0 * bodies::DX) / (8.0 * bodies::DX);
            state.u[0][engine.slot(node)] = 1e-3 * bodies::DX * (-from * from).exp();
        }
        // A hundredth of the force of the first step would move a node by its displacement in so much time.
        engine.forces(&mut state, Breaking::Held);
        let stiffest = engine.force()[0]
            .iter()
            .fold(0.0_f64, |m, f| m.max(f.abs()));
        let step2 = 1e-2 * 1e-3 * bodies::DX / stiffest;
        let mut v = vec![0.0; engine.len()];
        for _ in 0..400 {
            engine.forces(&mut state, Breaking::Held);
            for ((u, v), f) in state.u[0].iter_mut().zip(&mut v).zip(&engine.force()[0]) {
                *v += f * step2;
                *u += *v;
            }
        }
        let order = (0..question.body.x.len()).map(|node| state.u[0][engine.slot(node)]);
        order.collect::<Vec<_>>()
    };
    let (single, double) = (run(Precision::Single), run(Precision::Double));
    let largest = double.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
    let first = 1e-3 * bodies::DX;
    assert!(
        largest < 0.6 * first,
        "the hump has become two: {largest:e}"
    );
    let far = apart(&single, &double);
    assert!(far < 1e-5, "{far:e}");
}

/// How far a step may go is asked in double precision: differences of single rates would shorten it.
#[test]
fn the_step_is_that_of_double_precision() {
    let [single, double] = heat_in_both();
    assert_eq!(single.engine.is_single(), Isa::best() != Isa::Scalar);
    assert_eq!(single.stable, double.stable);
    // The rates of the first step are single again.
    let rates = |s: &Simulation| answers(&s.engine);
    assert_eq!(rates(&single) == rates(&double), Isa::best() == Isa::Scalar);
}

/// A scene in single and in double precision.
fn heat_in_both() -> [Simulation; 2] {
    let text = std::fs::read_to_string("../examples/heat-around-cracks.toml").expect("an example");
    let text = text.replace("\"0.1 mm\"\nthickness", "\"0.5 mm\"\nthickness");
    let single = text.replace("[family]", "[family]\nprecision = \"single\"");
    assert_ne!(single, text);
    [single, text].map(|text| {
        let scene = Scene::parse(&text, Path::new("scene.toml"), &Pdlang).expect("a scene");
        scene.simulation().expect("a simulation")
    })
}

/// A run goes on in the precision in which it began, or not at all.
#[test]
fn a_checkpoint_knows_its_precision() {
    let folder = steps::folder("single");
    let file = folder.join("start");
    let [mut single, mut double] = heat_in_both();
    checkpoint::write(&file, single.identity, &single.snapshot()).expect("a checkpoint");
    single
        .resume(&file)
        .expect("the precision of the checkpoint");
    match double.resume(&file) {
        Ok(()) => assert_eq!(Isa::best(), Isa::Scalar),
        Err(e) => assert!(
            e.to_string().contains("another traversal, precision"),
            "{e}"
        ),
    }
    std::fs::remove_dir_all(&folder).expect("it was made here");
}

/// One sweep sums, several sum.
#[test]
fn a_plan_names_the_sweeps() {
    let plan = |law: &str, more: &str| {
        let text = format!(
            r#"
[body]
flavour = "plane_stress"
spacing = "1 mm"
thickness = "1 mm"
shape = {{ box = {{ from = [0, 0], to = ["20 mm", "20 mm"] }} }}
[family]
horizon = "3.015 dx"
precision = "single"
[material]
model = "{law}"
linearised = true
density = "2200 kg/m^3"
K = "15 GPa"
{more}
[time]
until = "1 us"
"#
        );
        let scene = Scene::parse(&text, Path::new("scene.toml"), &Pdlang).expect("a scene");
        scene
            .simulation()
            .expect("a simulation")
            .left_out()
            .join("\n")
    };
    if Isa::best() == Isa::Scalar {
        return;
    }
    let (one, two) = (plan("pmb", ""), plan("lps", "G = \"9 GPa\""));
    assert!(one.contains("`force` sums bonds in single"), "{one}");
    assert!(two.contains("`, `force` sum bonds in single"), "{two}");
}

/// Chunks that two materials share, an odd chunk at the end of a row, broken bonds, lanes of one chunk and of two.
#[test]
fn materials_and_widths_of_lanes_make_no_difference() {
    for (name, kinematics) in [
        ("pmb", Kinematics::Linearised),
        ("lps", Kinematics::Linearised),
        ("correspondence", Kinematics::General),
        ("heat_state", Kinematics::General),
    ] {
        let law = laws::law(name);
        for flavour in laws::flavours(&law) {
            let sides = [[37, 1, 1], [37, 6, 1], [37, 5, 3]][flavour.dim() - 1];
            let body = bodies::lattice(flavour, sides, false);
            let mut question = Question::deformed(&law, body, STRAIN, 2);
            let x = question.body.x.iter();
            question.body.material = x
                .map(|x| u8::from(x[0] > 11.0 * bodies::DX && x[1] < 4.0 * bodies::DX))
                .collect();
            let stiffer: Vec<f64> = question.params.iter().map(|p| 1.2 * p).collect();
            let answer = |form: &engine::Law, precision, isa| {
                let mut settings = question.settings(Traversal::Lattice, Some(isa));
                settings.precision = precision;
                settings.materials.push(stiffer.clone());
                let engine = Engine::new(&question.body, form.clone(), settings);
                let mut engine = engine.unwrap_or_else(|e| panic!("{question}: {e}"));
                let mut state = question.state(&mut engine);
                engine.forces(&mut state, Breaking::Held);
                engine
            };
            for form in forms(&question, kinematics) {
                let double = answer(&form, Precision::Double, Isa::Scalar);
                for isa in [Isa::Avx2, Isa::Avx512] {
                    if isa.available() {
                        let far = distance(&answer(&form, Precision::Single, isa), &double);
                        assert!(far > 0.0 && far < near(&law), "{question} {isa:?}: {far:e}");
                    }
                }
            }
        }
    }
}

fn refusal(q: &Question, law: engine::Law, traversal: Traversal) -> String {
    match engine_of(q, law, traversal, Precision::Single) {
        Err(e @ SetupError::Precision(..)) => e.to_string(),
        other => panic!("{:?}", other.map(|_| "an engine")),
    }
}

#[test]
fn what_loses_digits_is_refused() {
    let law = laws::law("lps");
    let question = Question::at_rest(&law, bodies::lattice(Flavour::Solid, [5, 4, 4], false));
    let general = forms(&question, Kinematics::General).remove(0);
    let linear = lps_linearised(&question);
    let why = refusal(&question, general, Traversal::Lattice);
    assert!(
        why.contains("adds what moves to what stays") && why.contains("linearised = true"),
        "{why}"
    );
    let why = refusal(&question, linear.clone(), Traversal::Cloud);
    assert!(why.contains("walked as a cloud"), "{why}");
    let why = refusal(&question, linear.clone(), Traversal::Convolution);
    assert!(why.contains("convolution"), "{why}");
    if Isa::best() == Isa::Scalar {
        return;
    }
    // A body so small that its weighted volumes [m^5] are no numbers of single precision.
    let why = refusal(&scaled(&question, 1e-6), linear, Traversal::Lattice);
    assert!(why.contains("single precision cannot multiply"), "{why}");
}

/// The same question of a smaller body.
fn scaled<'a>(question: &Question<'a>, size: f64) -> Question<'a> {
    let mut small = question.clone();
    small.horizon *= size;
    small.body.spacing *= size;
    let volume = size.powi(small.body.flavour.dim() as i32);
    small.body.volume.iter_mut().for_each(|v| *v *= volume);
    small.body.x.iter_mut().flatten().for_each(|x| *x *= size);
    if let Some(grid) = &mut small.body.grid {
        grid.spacing *= size;
        grid.origin = grid.origin.map(|x| x * size);
    }
    small
}
