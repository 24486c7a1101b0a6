//! The law `solid`: its surface corrections against numbers of another implementation, expansion without force, and
//! what its weights do.

use pdlang_runtime::body::{Body, Flavour};
use pdlang_runtime::engine::{Breaking, Engine, Precision, Traversal};
use pdlang_tests::agreement::Question;
use pdlang_tests::{bodies, laws};

fn at_rest(law: &pdlang::ir::Law, body: Body) -> Question<'_> {
    let mut question = Question::at_rest(law, body);
    (question.horizon, question.partial_volume) = (3.015 * question.body.spacing, true);
    question
}

/// Components of a node output.
fn output(question: &Question, name: &str) -> Vec<Vec<f64>> {
    let mut engine = question.engine(question.fastest(), Traversal::Auto, None);
    let mut state = question.state(&mut engine);
    engine.forces(&mut state, Breaking::Held);
    engine.energy(&state);
    engine.named(name).expect("an output of the law")
}

/// D and S of square lattices with a horizon of 3.015 spacings and partial volumes: computed once from the sums
/// of Madenci and Oterkus 2014, eq. 4.66-4.73, by a program that shares nothing with this one; to its digits.
#[test]
fn corrections_of_bulk_edge_and_corner() {
    let law = laws::law("solid");
    let lattice = |flavour: Flavour, n: u32| {
        let shape = std::array::from_fn(|a| if a < flavour.dim() { n } else { 1 });
        bodies::lattice(flavour, shape, false)
    };
    let near = |what: &str, found: f64, expected: f64, digit: f64| {
        println!("{what}: {found:.6}, expected {expected}");
        assert!((found - expected).abs() <= 0.51 * digit, "{what}: {found}");
    };
    let place = |body: &Body, x: [f64; 3]| bodies::node_at(body, x);

    let question = at_rest(&law, lattice(Flavour::PlaneStress, 15));
    let (d, s) = (output(&question, "D"), output(&question, "S"));
    let x = &question.body.x;
    let low = x.iter().fold([f64::MAX; 3], |m, x| {
        std::array::from_fn(|a| m[a].min(x[a]))
    });
    let middle: [f64; 3] = std::array::from_fn(|a| {
        low[a]
            + if a < 2 {
                7.0 * question.body.spacing
            } else {
                0.0
            }
    });
    let bulk = place(&question.body, middle);
    near("bulk, D", d[0][bulk], 1.15123, 1e-5);
    near("bulk, D", d[1][bulk], 1.15123, 1e-5);
    near("bulk, S", s[0][bulk], 1.16575, 1e-5);
    let edge = place(&question.body, [middle[0], low[1], low[2]]);
    near("edge, D_x", d[0][edge], 1.638, 1e-3);
    near("edge, D_y", d[1][edge], 2.302, 1e-3);
    near("edge, S", s[1][edge], 1.703, 1e-3);
    let corner = place(&question.body, low);
    near("corner, D", d[0][corner], 3.276, 1e-3);
    near("corner, S", s[0][corner], 2.682, 1e-3);

    let question = at_rest(&law, lattice(Flavour::Bar, 15));
    near("bar, D", output(&question, "D")[0][7], 1.1988, 1e-4);

    let question = at_rest(&law, lattice(Flavour::Solid, 9));
    let (d, s) = (output(&question, "D"), output(&question, "S"));
    let x = &question.body.x;
    let centre: [f64; 3] =
        std::array::from_fn(|a| x.iter().map(|x| x[a]).sum::<f64>() / x.len() as f64);
    let bulk = place(&question.body, centre);
    for a in 0..3 {
        near("3d, D", d[a][bulk], 1.1072, 1e-4);
        near("3d, S", s[a][bulk], 1.2353, 1e-4);
    }
}

/// Expansion of a body without forces: what of the coefficient is felt in the flavour.
fn expansion(flavour: Flavour) -> f64 {
    let nu = (3.0 * laws::K - 2.0 * laws::G) / (6.0 * laws::K + 2.0 * laws::G);
    match flavour {
        Flavour::Slab => (1.0 + nu) / (1.0 - nu),
        Flavour::PlaneStrain => 1.0 + nu,
        _ => 1.0,
    }
}

/// Whatever the weights and whatever bonds are broken, so that every single bond is without force.
#[test]
fn a_body_of_one_temperature_expands_without_force() {
    let law = laws::law("solid");
    let (alpha, temperature) = (1e-3, 20.0);
    for flavour in Flavour::ALL {
        for (seed, body) in [
            (1, bodies::carved(flavour, 1)),
            (2, bodies::cloud(flavour, 2)),
        ] {
            let mut question = Question::deformed(&law, body, 1e-2, seed).with(&[("alpha", alpha)]);
            let scale = question
                .consult(|oracle, _, state| oracle.force_scale(state))
                .expect("a force");
            let stretch = alpha * temperature * expansion(flavour);
            let moved = |x: &[f64; 3]| x.map(|c| stretch * c);
            question.path = vec![question.body.x.iter().map(moved).collect()];
            question.fields = vec![vec![vec![temperature; question.body.x.len()]]];
            for without in [vec![], vec!["Gd"], vec!["Gd", "Gb"]] {
                question.without = without.iter().map(|w| w.to_string()).collect();
                question.everywhere(|what, engine| {
                    let force = question.ask(engine).force;
                    let worst = force.iter().flatten().fold(0.0_f64, |m, f| m.max(f.abs()));
                    assert!(worst <= 1e-12 * scale, "{what}: {:e}", worst / scale);
                });
            }
        }
    }
}

/// With weights a patch beside a surface is as stiff as the bulk; without, it is softer. And a weight that is set
/// to 1 changes numbers only: machine code, tapes and the oracle agree on every choice.
#[test]
fn weights_are_data() {
    for name in ["solid", "corrected"] {
        let law = laws::law(name);
        let names: Vec<String> = law.weights.iter().map(|w| w.name.clone()).collect();
        for flavour in Flavour::ALL {
            let mut question = Question::deformed(&law, bodies::carved(flavour, 3), 1e-2, 5);
            let mut forces = Vec::new();
            for chosen in 0..4 {
                let off = names
                    .iter()
                    .enumerate()
                    .filter(|(k, _)| chosen >> k & 1 == 1);
                question.without = off.map(|(_, name)| name.clone()).collect();
                let (expected, scale) = question.oracle();
                let plain = question.plain();
                let gap = plain.difference(&expected, &scale).worst();
                assert!(gap < 1e-12, "{question} plain: {gap:e}");
                question.everywhere(|what, engine| {
                    let gap = question.ask(engine).difference(&expected, &scale).worst();
                    assert!(
                        gap < 1e-12,
                        "{what} without {:?}: {gap:e}",
                        question.without
                    );
                });
                forces.push(expected.force);
            }
            // In the bond-based limit of one dimension `solid` has no dilatation to correct.
            let differ = |a: usize, b: usize| forces[a] != forces[b];
            assert!(
                differ(0, 2) && differ(0, 3),
                "{question}: `{}` does nothing",
                names[1]
            );
            assert!(
                differ(0, 1) || flavour.dim() == 1 && name == "solid",
                "{question}: `{}` does nothing",
                names[0]
            );
        }
    }
}

/// A weight that no law has is refused.
#[test]
fn unknown_weights_are_refused() {
    let law = laws::law("solid");
    let mut question = Question::at_rest(&law, bodies::carved(Flavour::Bar, 1));
    question.without = vec!["Gx".into()];
    let settings = pdlang_runtime::engine::Settings {
        materials: vec![question.params.clone()],
        influences: vec![],
        horizon: vec![question.horizon],
        horizon_levels: 64,
        partial_volume: false,
        lattice_constants: false,
        without: question.without.clone(),
        traversal: Traversal::Auto,
        isa: None,
        precision: Precision::Double,
    };
    let error = Engine::new(&question.body, question.interpreted(), settings).unwrap_err();
    assert!(error.to_string().contains("no weight `Gx`"), "{error}");
}

/// A plate in plane stress, stretched as a whole by a uniform gradient: with corrections its energy is nearer to
/// the one of the local theory than without.
#[test]
fn a_corrected_plate_has_nearly_the_energy_of_the_local_theory() {
    let law = laws::law("solid");
    let body = bodies::lattice(Flavour::PlaneStress, [12, 12, 1], false);
    let mut question = at_rest(&law, body);
    let strain = 1e-4;
    let moved = |x: &[f64; 3]| [strain * x[0], 0.0, 0.0];
    question.path = vec![question.body.x.iter().map(moved).collect()];
    let local = {
        let (k, g) = (laws::K, laws::G);
        let modulus = 9.0 * k * g / (3.0 * k + 4.0 * g);
        (modulus + g) / 2.0 * strain * strain
    };
    let mean = |question: &Question| {
        let (answer, _) = question.oracle();
        answer.energy.iter().sum::<f64>() / answer.energy.len() as f64 / local
    };
    let corrected = mean(&question);
    question.without = vec!["Gd".into(), "Gb".into()];
    let plain = mean(&question);
    println!("energy over that of the local theory: corrected {corrected:.4}, not {plain:.4}");
    assert!((corrected - 1.0).abs() < 0.05, "{corrected}");
    assert!(plain < 0.8, "{plain}");
}
