//! `pdlang plan`: what a run would compute and what not, its memory and its time.

use std::path::PathBuf;
use std::time::Instant;

use clap::{ArgMatches, Command};
use pdlang_runtime::engine::{Breaking, Traversal};
use pdlang_runtime::observe::{Item, inventory};
use pdlang_runtime::scene::Scene;
use pdlang_runtime::simulate::Simulation;
use serde_json::{Value, json};

use super::forecast::forecast;
use super::models::json_flag;
use super::run::{read, scene_argument, threads, threads_argument, wrong};
use super::{Outcome, statement};

pub fn command() -> Command {
    Command::new("plan")
        .about("Say what a scene would compute, what is left out, its memory and its time")
        .arg(scene_argument())
        .arg(threads_argument())
        .arg(json_flag())
        .after_help(
            "Builds the body, goes its first steps for half a second and writes one of each output into a temporary\n\
             folder. The time is that of all nodes awake: where many stay at rest for long, a run takes less.",
        )
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    threads(matches)?;
    let path = matches
        .get_one::<PathBuf>("scene")
        .cloned()
        .unwrap_or_default();
    let began = Instant::now();
    let scene = read(&path)?;
    let mut simulation = scene.simulation().map_err(wrong)?;
    simulation.keep_outputs();
    let mut plan = statement::of(&scene, &mut simulation);
    let setup = began.elapsed().as_secs_f64();
    let (needed, left_out): (Vec<Item>, Vec<Item>) =
        inventory(&simulation).into_iter().partition(|i| i.needed);
    let report = simulation.engine.report();
    let bonds = report.bonds.max(1);
    // On a thread of the pool, as a run is.
    let time = rayon::scope(|_| forecast(&mut simulation, setup));
    let ns = time.force * 1e9 / bonds as f64;
    plan.add("families", format!("found in {:.2} s", report.search));
    plan.add(
        "speed",
        format!(
            "{ns:.2} ns per bond, {:.3} ms per force evaluation",
            time.force * 1e3
        ),
    );
    if let Some(faster) = rayon::scope(|_| faster(&scene, &mut simulation)) {
        plan.add("faster", faster);
    }
    plan.add("time", time.text());
    if matches.get_flag("json") {
        let told = |items: &[Item]| -> Vec<String> { items.iter().map(Item::to_string).collect() };
        let mut map = plan.json();
        map.insert("needed".into(), json!(told(&needed)));
        map.insert("left_out".into(), json!(told(&left_out)));
        map.insert("seconds".into(), json!(time.seconds()));
        map.insert("forecast".into(), time.json());
        map.insert("ns_per_bond".into(), json!(ns));
        println!("{:#}", Value::Object(map));
    } else {
        print!("{}", plan.text());
        for (name, items) in [("computed", needed), ("left out", left_out)] {
            println!("  {name}");
            items.iter().for_each(|item| println!("    {item}"));
        }
    }
    Ok(())
}

/// Part of the time of a lattice above which a convolution is not worth a word.
const WORTH: f64 = 0.8;

/// A convolution in the place of the bonds of a lattice, where the scene allows one and it takes less time: both are
/// tried.
fn faster(scene: &Scene, simulation: &mut Simulation) -> Option<String> {
    let report = simulation.engine.report();
    if report.traversal != "lattice" || report.materials > 1 || simulation.engine.can_break() {
        return None;
    }
    // A second simulation beside the first, with transforms of its own.
    let room = |free: u64| free > 8 * (report.node_bytes + report.bond_bytes) as u64;
    if !pdlang_runtime::carve::available_memory().is_none_or(room) {
        return None;
    }
    let mut other = scene.clone();
    other.family.traversal = Traversal::Convolution;
    let mut other = other.simulation().ok()?;
    other.keep_outputs();
    let [bonds, convolved] = [simulation, &mut other].map(|sim| {
        sim.engine.sleep(false);
        let evaluation = |_| {
            let began = Instant::now();
            sim.engine.forces(&mut sim.state, Breaking::Held);
            began.elapsed().as_secs_f64()
        };
        (0..EVALUATIONS)
            .map(evaluation)
            .fold(f64::INFINITY, f64::min)
    });
    let more = other
        .engine
        .report()
        .node_bytes
        .saturating_sub(report.node_bytes);
    (convolved < WORTH * bonds).then(|| {
        format!(
            "a convolution takes {:.2} of the time of a force evaluation, and {} more: traversal = \"convolution\" in [family]",
            convolved / bonds,
            statement::bytes(more as u64)
        )
    })
}

/// Of which the quickest counts.
const EVALUATIONS: u32 = 4;
