//! Bonds that break: which ones, what is left of the force, and that nothing else changes.

use pdlang_runtime::body::Flavour;
use pdlang_runtime::engine::{Breaking, Traversal};
use pdlang_tests::agreement::{Question, gather};
use pdlang_tests::{block, bodies, laws};

/// At strains of 1e-2 some bonds exceed this and some do not.
const CRITICAL: f64 = 0.003;
/// The same for the families of a law that names several.
const LIMITS: [(&str, f64); 3] = [("s0", CRITICAL), ("s1", 1.5 * CRITICAL), ("s2", CRITICAL)];

fn each_question(names: &[&str], mut ask: impl FnMut(&Question)) {
    for name in names {
        let law = laws::law(name);
        for flavour in laws::flavours(&law) {
            for body in [bodies::carved(flavour, 3), bodies::cloud(flavour, 4)] {
                ask(&Question::deformed(&law, body, 1e-2, 12).with(&LIMITS));
            }
        }
    }
}

const BREAKABLE: [&str; 11] = [
    "pmb",
    "gpmb",
    "lps",
    "lps_frozen",
    "lps_plastic",
    "lps_viscoelastic",
    "lamina",
    "correspondence",
    "correspondence_stabilised",
    "correspondence_svk",
    "bond_memory",
];

/// The weighted volume of `lps` follows at once; that of `lps_frozen` does not.
#[test]
fn the_force_after_breaking_is_that_of_the_bonds_that_are_left() {
    let mut in_all = 0;
    each_question(&BREAKABLE, |question| {
        let (expected, scale) = question.oracle();
        let (left, damage) = question.oracle_broken();
        in_all += expected.breaks;
        question.everywhere(|what, engine| {
            let mut state = question.state(engine);
            let broken = engine.forces(&mut state, Breaking::Armed);
            assert_eq!(broken, expected.breaks, "{what}");
            let error = block::largest_difference(&gather(engine, engine.force()), &left);
            assert!(
                error <= 1e-13 * scale.force,
                "{what}: {:e}",
                error / scale.force
            );
            for (got, expected) in engine.damage(&state).iter().zip(&damage) {
                assert!(
                    (got - expected).abs() <= 1e-14,
                    "{what}: damage {got}, not {expected}"
                );
            }
        });
    });
    assert!(in_all > 1000, "only {in_all} bonds broke");
}

#[test]
fn a_held_evaluation_changes_no_bit_and_a_second_armed_one_breaks_nothing() {
    let mut in_all = 0;
    each_question(&["lps", "bond_memory"], |question| {
        question.everywhere(|what, engine| {
            let mut state = question.state(engine);
            let before = state.clone();
            assert_eq!(engine.forces(&mut state, Breaking::Held), 0, "{what}");
            assert!(
                state == before,
                "{what}: a held evaluation changed the state"
            );
            in_all += engine.forces(&mut state, Breaking::Armed);
            let force = gather(engine, engine.force());
            let after = state.clone();
            assert_eq!(engine.forces(&mut state, Breaking::Armed), 0, "{what}");
            assert!(
                state == after,
                "{what}: an armed evaluation broke bonds twice"
            );
            assert_eq!(gather(engine, engine.force()), force, "{what}");
        });
    });
    assert!(in_all > 1000, "only {in_all} bonds broke");
}

#[test]
fn bonds_of_protected_nodes_hold() {
    let law = laws::law("pmb");
    let body = bodies::carved(Flavour::PlaneStress, 3);
    let question = Question::deformed(&law, body, 1e-2, 12).with(&[("s0", CRITICAL)]);
    question.everywhere(|what, engine| {
        let all = vec![true; question.body.x.len()];
        engine.no_fail(&all);
        let mut state = question.state(engine);
        assert_eq!(engine.forces(&mut state, Breaking::Armed), 0, "{what}");
        let first: Vec<bool> = (0..all.len()).map(|node| node < all.len() / 2).collect();
        engine.no_fail(&first);
        engine.forces(&mut state, Breaking::Armed);
        let before = question.state(engine);
        let (bonds_before, bonds_after) = (engine.damage(&before), engine.damage(&state));
        for node in 0..all.len() / 2 {
            assert_eq!(bonds_before[node], bonds_after[node], "{what}: node {node}");
        }
        assert!(bonds_before != bonds_after, "{what}: nothing broke");
    });
}

/// A node that lost every bond contributes nothing, and nothing becomes NaN.
#[test]
fn a_node_without_bonds_is_left_alone() {
    for name in BREAKABLE {
        let law = laws::law(name);
        let flavour = *laws::flavours(&law).last().expect("it serves one");
        let body = bodies::carved(flavour, 5);
        let mut question = Question::deformed(&law, body, 1e-2, 21);
        let nodes = question.body.x.len();
        question
            .broken
            .extend((0..nodes).flat_map(|j| [(7, j), (j, 7)]));
        let (expected, scale) = question.oracle();
        question.everywhere(|what, engine| {
            let answer = question.ask(engine);
            assert_eq!(answer.force[7], [0.0; 3], "{what}");
            let worst = answer.difference(&expected, &scale).worst();
            assert!(worst <= 2e-13, "{what}: {worst:e}");
        });
    }
}

/// One bond, or two along a line, leave a shape tensor without inverse: such a node answers with nothing.
#[test]
fn a_singular_shape_tensor_is_no_tensor() {
    let law = laws::law("correspondence");
    let body = bodies::lattice(Flavour::PlaneStress, [11, 5, 1], false);
    let mut question = Question::deformed(&law, body, 1e-2, 22);
    // Node 24 sits in the middle; only its bonds along x are left.
    let row = |node: usize| node / 11;
    let others = (0..55).filter(|j| row(*j) != row(24));
    question.broken = others.flat_map(|j| [(24, j), (j, 24)]).collect();
    let (expected, scale) = question.oracle();
    assert!(expected.force.as_flattened().iter().all(|c| c.is_finite()));
    question.everywhere(|what, engine| {
        let worst = question.ask(engine).difference(&expected, &scale).worst();
        assert!(worst <= 1e-13, "{what}: {worst:e}");
    });
}

/// Infinite limits are found in the tapes: then nothing is tested, and the bits are those of the law that tests.
#[test]
fn a_limit_that_no_bond_reaches_is_not_tested() {
    for name in BREAKABLE {
        let law = laws::law(name);
        let names = law.params.iter().map(|p| p.name.as_str());
        let limits: Vec<&str> = names.filter(|p| ["s0", "s1", "s2"].contains(p)).collect();
        let with =
            |value: f64| -> Vec<(&str, f64)> { limits.iter().map(|p| (*p, value)).collect() };
        for flavour in laws::flavours(&law) {
            for body in [bodies::carved(flavour, 3), bodies::cloud(flavour, 4)] {
                let ask = |value: f64| {
                    let question =
                        Question::deformed(&law, body.clone(), 1e-2, 12).with(&with(value));
                    let traversal = Traversal::Auto;
                    let mut engine = question.engine(question.fastest(), traversal, None);
                    let mut state = question.state(&mut engine);
                    assert_eq!(
                        engine.forces(&mut state, Breaking::Armed),
                        0,
                        "{question} {value}"
                    );
                    (engine.can_break(), gather(&engine, engine.force()))
                };
                let (tests, force) = ask(1e3);
                let (not, same) = ask(f64::INFINITY);
                assert!(tests && !not, "{name} {}", flavour.name());
                assert!(force == same, "{name} {}", flavour.name());
            }
        }
    }
}
