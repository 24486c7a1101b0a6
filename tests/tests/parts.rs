//! Fields that live on a part of the body: stored there alone, and every bit as if they were on all of it.

use std::path::{Path, PathBuf};

use pdlang_models::language::Pdlang;
use pdlang_runtime::checkpoint;
use pdlang_runtime::scene::Scene;
use pdlang_runtime::simulate::Simulation;

fn simulation(text: &str) -> Simulation {
    let scene = Scene::parse(text, Path::new("scenes/scene.toml"), &Pdlang);
    let scene = scene.unwrap_or_else(|e| panic!("{e}"));
    scene.simulation().unwrap_or_else(|e| panic!("{e}"))
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("pdlang-parts-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a place for temporary files");
    folder
}

/// A law as it is, and without the words that say where its fields live.
fn twins(text: &str, folder: &Path) -> [PathBuf; 2] {
    let bare = |line: &str| match (
        line.trim().starts_with("field "),
        line.split_once(" where "),
    ) {
        (true, Some((field, rest))) => {
            let (_, words) = rest.split_once('"').expect("a description");
            format!("{field} \"{words}\n")
        }
        _ => format!("{line}\n"),
    };
    let bare: String = text.lines().map(bare).collect();
    assert!(text.contains("where phi.x > 0 ") || text.contains("where norm(phi) > 0 "));
    assert!(!bare.contains(" > 0  \""), "{bare}");
    [("with", text), ("without", &bare)].map(|(name, text)| {
        let path = folder.join(format!("{name}.pd"));
        std::fs::write(&path, text).expect("the file can be written");
        path
    })
}

const LAWS: [(&str, &str, &str); 2] = [
    (
        "absorbing",
        include_str!("../../models/laws/absorbing.pd"),
        "E = 1\nnu = 0.25\ndensity = 1",
    ),
    (
        "layered",
        include_str!("../fixtures/laws/layered.pd"),
        "K = 1\ntau = 0.5\ndensity = 1",
    ),
];

/// A body of size 1, damped where the first coordinate is above 0.7; more than a bar lacks a corner.
fn scene(flavour: &str, law: &str, params: &str, traversal: &str) -> String {
    let (dx, cross, zeros, shape) = match flavour {
        "bar" => (
            0.02,
            "cross_section = 1",
            "",
            "{ box = { from = [0], to = [1] } }",
        ),
        "3d" => (
            0.05,
            "",
            ", 0, 0",
            "{ difference = [{ box = { from = [0, 0, 0], to = [1, 0.4, 0.4] } }, \
             { box = { from = [0.8, 0.2, 0], to = [1, 0.4, 0.4] } }] }",
        ),
        _ => (
            0.05,
            "thickness = 1",
            ", 0",
            "{ difference = [{ box = { from = [0, 0], to = [1, 1] } }, \
             { box = { from = [0.8, 0.7], to = [1, 1] } }] }",
        ),
    };
    format!(
        "[body]\nflavour = \"{flavour}\"\nspacing = {dx}\n{cross}\nshape = {shape}\n\
         [family]\nhorizon = \"2.2 dx\"\ntraversal = \"{traversal}\"\n\
         [material]\nmodel = \"{law}\"\n{params}\n\
         [[initial]]\ndisplacement = [\"exp(-50*(x - 0.6)^2)/100\"{zeros}]\n\
         phi = [\"select(x > 0.7, 5, 0)\"{zeros}]\n\
         [time]\nsteps = 6\ndt = 0.005\n"
    )
}

/// Displacements, velocities and all fields, in user order.
fn bits(s: &Simulation) -> Vec<Vec<u64>> {
    let user = |values: &[f64]| {
        let slots = s.engine.slots().iter();
        slots.map(|k| values[*k as usize].to_bits()).collect()
    };
    let fields = s.engine.field_components().into_iter();
    let fields = fields.map(|(_, _, k)| s.engine.spread(k, &s.state.slots[k]));
    let motion = s.state.u.iter().chain(&s.state.v).map(|v| user(v));
    motion.chain(fields.map(|v| user(&v))).collect()
}

fn finished(text: &str) -> Simulation {
    let mut simulation = simulation(text);
    simulation.run(&mut ()).unwrap_or_else(|e| panic!("{e}"));
    simulation
}

/// Numbers of a field in the state.
fn stored(s: &Simulation, field: &str) -> Vec<usize> {
    let slots = s.engine.state_slots(field).expect("the field");
    slots.into_iter().map(|k| s.state.slots[k].len()).collect()
}

#[test]
fn where_a_field_is_stored_changes_no_bit() {
    for (name, text, params) in LAWS {
        let folder = folder(name);
        let laws = twins(text, &folder);
        for flavour in ["bar", "plane_strain", "3d"] {
            for traversal in ["lattice", "cloud"] {
                let run = |law: &Path| {
                    let law = law.to_string_lossy();
                    finished(&scene(flavour, &law, params, traversal))
                };
                let [with, without] = [run(&laws[0]), run(&laws[1])];
                let what = format!("{name} {flavour} {traversal}");
                let (a, b) = (bits(&with), bits(&without));
                let moved = |k: &u64| f64::from_bits(*k) != 0.0;
                assert!(
                    a.iter()
                        .all(|values| values.iter().any(moved) || flavour != "bar"),
                    "{what}"
                );
                assert!(a == b, "{what}");
                if name == "absorbing" {
                    let compiled = finished(&scene(flavour, name, params, traversal));
                    assert!(bits(&compiled) == b, "{what}: compiled");
                }
                let all = with.engine.len();
                let (alone, everywhere) = match name {
                    "absorbing" => (vec!["lost", "drag"], vec!["phi"]),
                    _ => (vec!["sink", "lag", "eaten"], vec!["phi", "far"]),
                };
                for field in alone {
                    assert!(
                        stored(&with, field).iter().all(|n| *n < all),
                        "{what} {field}"
                    );
                    assert!(
                        stored(&without, field).iter().all(|n| *n == all),
                        "{what} {field}"
                    );
                }
                for field in everywhere {
                    assert!(
                        stored(&with, field).iter().all(|n| *n == all),
                        "{what} {field}"
                    );
                }
                let report = with.engine.report();
                let layer = with.body.x.iter().filter(|x| x[0] > 0.7).count();
                assert!(report.parts.iter().all(|p| p.nodes == layer), "{what}");
                let bytes = without.engine.report().node_bytes;
                assert!(report.node_bytes < bytes, "{what}");
            }
        }
        std::fs::remove_dir_all(&folder).expect("it was made here");
    }
}

/// A checkpoint has what the state has, and does not fit where the fields live elsewhere. (That a resumed run has the same
/// bits is tested in `absorbing.rs`.)
#[test]
fn a_checkpoint_holds_the_part_alone() {
    let folder = folder("checkpoint");
    for (name, text, params) in LAWS {
        let [law, _] = twins(text, &folder);
        let text = scene("plane_strain", &law.to_string_lossy(), params, "auto");
        let whole = finished(&text);
        let half = finished(&text.replace("steps = 6", "steps = 3"));
        let file = folder.join(format!("{name}.ck"));
        checkpoint::write(&file, half.identity, &half.snapshot()).expect("a checkpoint");
        let read = checkpoint::read(&file, half.identity).expect("a checkpoint");
        assert_eq!(read.state, half.state, "{name}");
        assert!(whole.engine.fits(&read.state), "{name}");
        let elsewhere = finished(&text.replace("x > 0.7", "x > 0.2"));
        assert!(!elsewhere.engine.fits(&read.state), "{name}");
    }
    std::fs::remove_dir_all(&folder).expect("it was made here");
}

/// On a body where nothing is damped there is nothing to store.
#[test]
fn a_part_may_be_empty_or_all() {
    let (_, _, params) = LAWS[0];
    let text = scene("plane_strain", "absorbing", params, "auto");
    let none = finished(&text.replace("x > 0.7", "x > 7"));
    assert_eq!(stored(&none, "lost"), [0; 4]);
    let all = finished(&text.replace("x > 0.7", "x > -1"));
    assert!(stored(&all, "lost").iter().all(|n| *n >= all.body.x.len()));
}
