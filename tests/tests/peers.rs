//! The engine against LAMMPS, CabanaPD and Peridigm: forces under a given displacement, and motion.

use pdlang_runtime::body::{Body, Flavour, Grid};
use pdlang_runtime::engine::{Breaking, Engine, Traversal};
use pdlang_tests::agreement::{Question, gather, per_node, spread};
use pdlang_tests::block::{self, *};
use pdlang_tests::laws;
use pdlang_tests::reference::Table;

fn body() -> Body {
    let cells = CELLS as u32;
    let cell = |n: u32| [n % cells, n / cells % cells, n / cells / cells];
    let grid = Grid {
        origin: [0.0; 3],
        spacing: DX,
        shape: [cells; 3],
        cell: (0..cells.pow(3)).map(cell).collect(),
    };
    Body {
        flavour: Flavour::Solid,
        x: positions(),
        volume: vec![VOLUME; CELLS.pow(3)],
        material: vec![],
        regions: vec![],
        horizon: vec![],
        cross: 1.0,
        grid: Some(grid),
        spacing: DX,
        periodic: [None; 3],
    }
}

/// Velocity Verlet from rest with an engine; returns the displacements at the end.
fn verlet(engine: &mut Engine, u: &[[f64; 3]], steps: usize) -> Vec<[f64; 3]> {
    let mut state = engine.state();
    spread(engine, u, &mut state.u);
    engine.forces(&mut state, Breaking::Held);
    for _ in 0..steps {
        kick(engine, &mut state.v);
        for (u, v) in state.u.iter_mut().zip(&state.v) {
            for (u, v) in u.iter_mut().zip(v) {
                *u += DT * v;
            }
        }
        engine.forces(&mut state, Breaking::Held);
        kick(engine, &mut state.v);
    }
    gather(engine, &state.u)
}

fn kick(engine: &Engine, v: &mut [Vec<f64>]) {
    for (v, f) in v.iter_mut().zip(engine.force()) {
        for (v, f) in v.iter_mut().zip(f) {
            *v += 0.5 * DT * f / RHO;
        }
    }
}

struct Peer {
    law: &'static str,
    influence: Option<&'static str>,
    /// Partial volumes, and the file of the steps 0 and 100 without its number.
    partial_volume: bool,
    data: &'static str,
    displacements: fn(&Table) -> Vec<[f64; 3]>,
}

fn cabanapd_displacements(table: &Table) -> Vec<[f64; 3]> {
    table.vectors(["ux", "uy", "uz"])
}

impl Peer {
    /// Forces to 1e-12 of the largest, in every form of the engine; displacements after 100 steps to 1e-11 of the
    /// amplitude, on both traversals.
    fn compare(&self) {
        let law = laws::law(self.law);
        let mut question = Question::at_rest(&law, body()).with(&[("K", K), ("G", G)]);
        question.horizon = DELTA;
        question.partial_volume = self.partial_volume;
        if let Some(influence) = self.influence {
            question.influences = vec![laws::influence(influence)];
        }
        let start = Table::read(&format!("{}.0", self.data)).expect("reference data");
        let end = Table::read(&format!("{}.100", self.data)).expect("reference data");
        let u = (self.displacements)(&start);
        question.everywhere(|what, engine| {
            let mut state = engine.state();
            spread(engine, &u, &mut state.u);
            engine.forces(&mut state, Breaking::Held);
            let force = gather(engine, engine.force());
            let error = relative_error(&force, &start.vectors(["fx", "fy", "fz"]));
            println!("{}, {what}: force {error:.1e}", self.data);
            assert!(error <= 1e-12, "{what}: force {error:e}");
        });
        for traversal in [Traversal::Lattice, Traversal::Cloud] {
            let mut engine = question.engine(question.fastest(), traversal, None);
            let moved = verlet(&mut engine, &u, 100);
            let drift = block::largest_difference(&moved, &(self.displacements)(&end)) / AMPLITUDE;
            println!("{}, {traversal:?}: displacement {drift:.1e}", self.data);
            assert!(drift <= 1e-11, "{traversal:?}: displacement {drift:e}");
        }
    }
}

#[test]
fn pmb_of_lammps() {
    Peer {
        law: "pmb",
        influence: None,
        partial_volume: true,
        data: "lammps/pmb_wave",
        displacements: lammps_displacements,
    }
    .compare();
}

#[test]
fn lps_of_lammps() {
    Peer {
        law: "lps_frozen",
        influence: Some("1/x"),
        partial_volume: true,
        data: "lammps/lps_wave",
        displacements: lammps_displacements,
    }
    .compare();
}

#[test]
fn pmb_of_cabanapd() {
    Peer {
        law: "pmb",
        influence: None,
        partial_volume: false,
        data: "cabanapd/pmb",
        displacements: cabanapd_displacements,
    }
    .compare();
}

#[test]
fn lps_of_cabanapd_with_influence_one() {
    Peer {
        law: "lps",
        influence: Some("constant"),
        partial_volume: false,
        data: "cabanapd/lps_infl0",
        displacements: cabanapd_displacements,
    }
    .compare();
}

#[test]
fn lps_of_cabanapd_with_influence_one_over_r() {
    Peer {
        law: "lps",
        influence: Some("1/x"),
        partial_volume: false,
        data: "cabanapd/lps_infl1",
        displacements: cabanapd_displacements,
    }
    .compare();
}

/// Bonds break, and the block moves and loses force, as in LAMMPS: its critical stretch grows with compression
/// (alpha = 0.25), and a bond that breaks still acts in that step.
#[test]
fn fracture_of_lammps() {
    let law = laws::law("pmb_compression");
    let mut question =
        Question::at_rest(&law, body()).with(&[("K", K), ("s00", 0.003), ("alpha", 0.25)]);
    (question.horizon, question.partial_volume) = (DELTA, true);
    let table = |step: usize| Table::read(&format!("lammps/pmb_frac.{step}")).expect("data");
    for traversal in [Traversal::Lattice, Traversal::Cloud] {
        let mut engine = question.engine(question.fastest(), traversal, None);
        let mut state = engine.state();
        spread(&engine, &lammps_displacements(&table(0)), &mut state.u);
        for step in 0..=100 {
            engine.forces(&mut state, Breaking::Armed);
            if step > 0 {
                kick(&engine, &mut state.v);
            }
            engine.commit(&mut state);
            if [0, 20, 100].contains(&step) {
                let expected = table(step);
                let u = lammps_displacements(&expected);
                let drift = block::largest_difference(&gather(&engine, &state.u), &u) / AMPLITUDE;
                let force = gather(&engine, engine.force());
                let error = relative_error(&force, &expected.vectors(["fx", "fy", "fz"]));
                println!("{traversal:?}, step {step}: displacement {drift:.1e}, force {error:.1e}");
                assert!(drift <= 1e-11, "{traversal:?}: displacement {drift:e}");
                assert!(error <= 1e-11, "{traversal:?}: force {error:e}");
                let damage = engine.damage(&state);
                close("damage", &damage, &expected.column("damage"));
            }
            kick(&engine, &mut state.v);
            for (u, v) in state.u.iter_mut().zip(&state.v) {
                u.iter_mut().zip(v).for_each(|(u, v)| *u += DT * v);
            }
        }
    }
}

/// Energies of CabanaPD, and the dilatation of LAMMPS, whose LPS energy is not to be compared.
#[test]
fn energies_and_dilatation() {
    for (name, influence, data) in [
        ("pmb", None, "cabanapd/pmb.0"),
        ("lps", Some("constant"), "cabanapd/lps_infl0.0"),
        ("lps", Some("1/x"), "cabanapd/lps_infl1.0"),
    ] {
        let law = laws::law(name);
        let mut question = Question::at_rest(&law, body()).with(&[("K", K), ("G", G)]);
        question.horizon = DELTA;
        question.influences = influence.map(laws::influence).into_iter().collect();
        let table = Table::read(data).expect("reference data");
        let mut engine = question.engine(question.interpreted(), Traversal::Auto, None);
        let mut state = engine.state();
        spread(&engine, &cabanapd_displacements(&table), &mut state.u);
        engine.forces(&mut state, Breaking::Held);
        let energy = engine.energy(&state).to_vec();
        close(data, &per_node(&engine, &energy), &table.column("energy"));
    }
    let law = laws::law("lps_frozen");
    let mut question = Question::at_rest(&law, body()).with(&[("K", K), ("G", G)]);
    (question.horizon, question.partial_volume) = (DELTA, true);
    let table = Table::read("lammps/lps_wave.0").expect("reference data");
    let mut engine = question.engine(question.interpreted(), Traversal::Auto, None);
    let mut state = engine.state();
    spread(&engine, &lammps_displacements(&table), &mut state.u);
    engine.forces(&mut state, Breaking::Held);
    engine.energy(&state);
    let theta = engine.named("theta").expect("the law names its dilatation");
    close("lammps/lps_wave.0", &theta[0], &table.column("theta"));
}

fn close(what: &str, got: &[f64], expected: &[f64]) {
    let size = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let gap = got
        .iter()
        .zip(expected)
        .fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    assert!(gap <= 1e-12 * size, "{what}: {:e}", gap / size);
}

/// Peridigm's correspondence solid moves its stress by rates, from the velocities of the block at rest: in its first
/// evaluation that is the strain of one step. What its rotation adds is of the order of that strain squared.
#[test]
fn correspondence_of_peridigm() {
    let law = laws::law("correspondence");
    let (e, nu) = (
        9.0 * K * G / (3.0 * K + G),
        (3.0 * K - 2.0 * G) / (6.0 * K + 2.0 * G),
    );
    let mut question = Question::at_rest(&law, body()).with(&[("E", e), ("nu", nu)]);
    question.horizon = DELTA;
    let start = Table::read("peridigm/nosb.0").expect("reference data");
    let u: Vec<[f64; 3]> = (start.vectors(["vx", "vy", "vz"]).iter())
        .map(|v| v.map(|v| DT * v))
        .collect();
    question.path = vec![u];
    question.everywhere(|what, engine| {
        let force = question.ask(engine).force;
        let error = relative_error(&force, &start.vectors(["fx", "fy", "fz"]));
        println!("peridigm/nosb, {what}: force {error:.1e}");
        assert!(error <= 1e-9, "{what}: force {error:e}");
    });
}

/// Its hourglass force after 50 steps, which is another one than that of `correspondence_stabilised`. At the start, where
/// nothing is displaced, it has none.
#[test]
fn hourglass_force_of_peridigm() {
    let law = laws::law("littlewood");
    let mut question = Question::at_rest(&law, body()).with(&[("K", K), ("h", 0.1)]);
    question.horizon = DELTA;
    let later = Table::read("peridigm/nosb.50").expect("reference data");
    question.path = vec![later.vectors(["ux", "uy", "uz"])];
    question.everywhere(|what, engine| {
        let force = question.ask(engine).force;
        let error = relative_error(&force, &later.vectors(["hx", "hy", "hz"]));
        println!("peridigm/nosb, {what}: hourglass force {error:.1e}");
        assert!(error <= 1e-11, "{what}: hourglass force {error:e}");
    });
}
