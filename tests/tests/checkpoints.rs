//! A checkpoint in the middle of a run: for every law of the catalogue, flavour and traversal a fresh engine goes on
//! from the file to the same bits, with bonds breaking and histories growing before and after.

use std::path::Path;

use pdlang_models::registry;
use pdlang_runtime::checkpoint::{self, Clock, Identity, Snapshot};
use pdlang_runtime::engine::{Breaking, Engine, State, Traversal};
use pdlang_tests::agreement::{Question, gather};
use pdlang_tests::{bodies, laws};

const IDENTITY: Identity = Identity {
    scene: 1,
    layout: 2,
};
/// [s]
const DT: f64 = 5e-8;

#[test]
fn every_law_goes_on_to_the_same_bits() {
    let folder = tempfile("checkpoints");
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
                let mut broken = steps(&mut whole, &mut state);
                let file = folder.join(format!("{name} {} {traversal:?}", flavour.name()));
                save(&file, &state);
                broken += steps(&mut whole, &mut state);
                let mut fresh = engine();
                question.state(&mut fresh);
                let mut resumed = checkpoint::read(&file, IDENTITY)
                    .expect("a checkpoint")
                    .state;
                steps(&mut fresh, &mut resumed);
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

fn tempfile(name: &str) -> std::path::PathBuf {
    let folder = std::env::temp_dir().join(format!("pdlang-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a place for temporary files");
    folder
}

fn save(file: &Path, state: &State) {
    let snapshot = Snapshot {
        state: state.clone(),
        clock: Clock::default(),
        stable: None,
        stages: 1,
        broken: 0,
        broken_at_measure: 0,
        initial_energy: 0.0,
        work: 0.0,
        reactions: vec![],
    };
    checkpoint::write(file, IDENTITY, &snapshot).expect("the file can be written");
}

/// Three steps of motion, fields, breaking and memory; the directed bonds that broke.
fn steps(engine: &mut Engine, state: &mut State) -> usize {
    let mut broken = 0;
    for _ in 0..3 {
        broken += engine.forces(state, Breaking::Armed);
        broken += engine.commit(state);
        for (v, f) in state.v.iter_mut().zip(engine.force()) {
            v.iter_mut().zip(f).for_each(|(v, f)| *v += DT * f / 2200.0);
        }
        for rate in engine.rates() {
            let whole = rate.whole(state);
            let field = state.slots[rate.slot].iter_mut();
            field.zip(whole).for_each(|(q, rate)| *q += DT * rate);
        }
        for (u, v) in state.u.iter_mut().zip(&state.v) {
            u.iter_mut().zip(v).for_each(|(u, v)| *u += DT * v);
        }
    }
    broken
}
