//! Plain steps of motion, fields, breaking and memory, and states that go through a file.

use std::path::{Path, PathBuf};

use pdlang_runtime::checkpoint::{self, Clock, Identity, Snapshot};
use pdlang_runtime::engine::{Breaking, Engine, State};

const IDENTITY: Identity = Identity {
    scene: 1,
    layout: 2,
};
/// [s]
const DT: f64 = 5e-8;

/// One step; the directed bonds that broke.
pub fn step(engine: &mut Engine, state: &mut State) -> usize {
    let broken = engine.forces(state, Breaking::Armed) + engine.commit(state);
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
    broken
}

/// Writes a state as a checkpoint.
pub fn save(file: &Path, state: &State) {
    let snapshot = Snapshot {
        state: state.clone(),
        clock: Clock::default(),
        stable: None,
        stages: 1,
        broken: 0,
        broken_at_measure: 0,
        initial_energy: 0.0,
        work: 0.0,
        left: 0.0,
        reactions: vec![],
    };
    checkpoint::write(file, IDENTITY, &snapshot).expect("the file can be written");
}

/// Reads it again.
pub fn reread(file: &Path) -> State {
    checkpoint::read(file, IDENTITY)
        .expect("a checkpoint")
        .state
}

/// A folder for the files of a test, which removes it.
pub fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("pdlang-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a place for temporary files");
    folder
}
