//! `pdlang plan`: what a run would compute and what not, its memory and its time.

use std::path::PathBuf;
use std::time::Instant;

use clap::{ArgMatches, Command};
use pdlang_runtime::engine::{Breaking, Need};
use pdlang_runtime::observe::left_out;
use pdlang_runtime::simulate::Simulation;
use serde_json::{Value, json};

use super::models::json_flag;
use super::run::{read, scene_argument, threads, threads_argument, wrong};
use super::{Outcome, statement};

/// Longest time that the calibration may take [s].
const CALIBRATION: f64 = 1.0;

pub fn command() -> Command {
    Command::new("plan")
        .about("Say what a scene would compute, what is left out, its memory and its time")
        .arg(scene_argument())
        .arg(threads_argument())
        .arg(json_flag())
        .after_help("Builds the body and times its forces for up to a second; writes nothing.")
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    threads(matches)?;
    let path = matches
        .get_one::<PathBuf>("scene")
        .cloned()
        .unwrap_or_default();
    let scene = read(&path)?;
    let mut simulation = scene.simulation().map_err(wrong)?;
    let mut plan = statement::of(&scene, &simulation);
    // An evaluation that repeats another one would find everything asleep.
    simulation.engine.sleep(false);
    // On a thread of the pool, as a run is.
    let per_force = rayon::scope(|_| seconds(&mut simulation, Need::All));
    // A step of the fields asks for their rates at every stage, the first of which the forces may have brought.
    let stages = f64::from(simulation.stages);
    let per_step = match simulation.stages {
        0 => per_force,
        _ => per_force + stages * rayon::scope(|_| seconds(&mut simulation, Need::Rates)),
    };
    let report = simulation.engine.report();
    let ns = per_force * 1e9 / report.bonds.max(1) as f64;
    let evaluations = simulation.steps.saturating_sub(simulation.state.step) + 1;
    let total = per_step * evaluations as f64;
    plan.add(
        "speed",
        format!(
            "{ns:.2} ns per bond, {:.3} ms per force evaluation",
            per_force * 1e3
        ),
    );
    plan.add(
        "time",
        format!(
            "about {} for {evaluations} force evaluations{}, without outputs",
            duration(total),
            if simulation.stages > 0 {
                " and the stages of the fields"
            } else {
                ""
            }
        ),
    );
    let left_out = left_out(&simulation);
    if matches.get_flag("json") {
        let mut map = plan.json();
        map.insert("left_out".into(), json!(left_out));
        map.insert("seconds".into(), json!(total));
        map.insert("ns_per_bond".into(), json!(ns));
        println!("{:#}", Value::Object(map));
    } else {
        print!("{}", plan.text());
        println!("  left out");
        left_out.iter().for_each(|what| println!("    {what}"));
    }
    Ok(())
}

/// The quickest of as many evaluations as fit; none of them changes anything.
fn seconds(simulation: &mut Simulation, need: Need) -> f64 {
    let mut state = simulation.state.clone();
    let start = Instant::now();
    let mut best = f64::INFINITY;
    while best.is_infinite() || start.elapsed().as_secs_f64() + best < CALIBRATION {
        let before = Instant::now();
        let engine = &mut simulation.engine;
        engine.evaluate(&mut state, Breaking::Held, need);
        best = best.min(before.elapsed().as_secs_f64());
    }
    best
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s if s < 120.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
