//! A checkpoint in the middle of a run: for every law of the catalogue, flavour and traversal a fresh engine goes on
//! from the file to the same bits, with bonds breaking and histories growing before and after.

use pdlang_models::registry;
use pdlang_runtime::engine::{Breaking, Engine, State, Traversal};
use pdlang_tests::agreement::{Question, gather};
use pdlang_tests::{bodies, laws, steps};

#[test]
fn every_law_goes_on_to_the_same_bits() {
    let folder = steps::folder("checkpoints");
    for name in registry::names() {
        let law = laws::law(name);
        let limits = law.params.iter().map(|p| p.name.as_str());
        let limits: Vec<(&str, f64)> = limits
            .filter(|p| ["s0", "s1", "s2"].contains(p))
            .map(|p| (p, 0.002))
            .collect();
        for flavour in laws::flavours(&law) {
            let body = bodies::carved(flavour, 5);
            let question = Question::deformed(&law, body, 6e-3, 5).with(&limits);
            for traversal in [Traversal::Lattice, Traversal::Cloud] {
                let engine = || question.engine(question.fastest(), traversal, None);
                let mut whole = engine();
                let mut state = question.state(&mut whole);
                let mut broken = three(&mut whole, &mut state);
                let file = folder.join(format!("{name} {} {traversal:?}", flavour.name()));
                steps::save(&file, &state);
                broken += three(&mut whole, &mut state);
                let mut fresh = engine();
                question.state(&mut fresh);
                let mut resumed = steps::reread(&file);
                three(&mut fresh, &mut resumed);
                assert!(state == resumed, "{question} {traversal:?}");
                let answers = [(&mut whole, &mut state), (&mut fresh, &mut resumed)];
                let [one, two] = answers.map(|(engine, state)| {
                    engine.forces(state, Breaking::Held);
                    let energy = engine.energy(state).to_vec();
                    (gather(engine, engine.force()), energy)
                });
                assert!(one == two, "{question} {traversal:?}");
                let moves = one.0.iter().flatten().any(|f| *f != 0.0);
                assert!(
                    moves || !law.fields.is_empty(),
                    "{question}: nothing to compare"
                );
                // A bar of few bonds may hold by chance.
                assert!(
                    broken > 0 || limits.is_empty() || flavour.dim() == 1,
                    "{question} {traversal:?}: nothing breaks"
                );
            }
        }
    }
    std::fs::remove_dir_all(&folder).expect("it was made here");
}

/// Three steps; the directed bonds that broke.
fn three(engine: &mut Engine, state: &mut State) -> usize {
    (0..3).map(|_| steps::step(engine, state)).sum()
}
