//! `pdlang run`: a scene from its text to its files.

use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use clap::{Arg, ArgMatches, Command, value_parser};
use pdlang_models::language::Pdlang;
use pdlang_runtime::observe::Files;
use pdlang_runtime::scene::{Problems, Scene, node_table};
use pdlang_runtime::simulate::{Simulation, Stopped};

use super::progress::Progress;
use super::statement;
use super::{Failure, INTERRUPTED, Outcome, color, input_error};

pub fn command() -> Command {
    Command::new("run")
        .about("Run a scene and write its fields, history, summary and pictures")
        .arg(scene_argument())
        .arg(
            Arg::new("out")
                .long("out")
                .value_name("DIR")
                .value_parser(value_parser!(PathBuf))
                .help("Folder for the results [default: out/<name of the scene>]"),
        )
        .arg(threads_argument())
        .arg(
            Arg::new("resume")
                .long("resume")
                .value_name("FILE")
                .value_parser(value_parser!(PathBuf))
                .help("Go on from a checkpoint of the same scene"),
        )
        .after_help(
            "Writes fields/*.vtu with fields.pvd, history.csv, summary.json, pictures as PNG, and checkpoints\n\
             where the scene asks for them. A scene with `steps = 0` evaluates the forces once and writes nodes.csv.\n\
             Ctrl-C stops the run at the end of its step with a checkpoint; a second one stops it at once.",
        )
}

/// The scene, as every command takes it that reads one.
pub fn scene_argument() -> Arg {
    Arg::new("scene")
        .value_name("SCENE.toml")
        .value_parser(value_parser!(PathBuf))
        .help("Scene file")
        .required(true)
}

pub fn threads_argument() -> Arg {
    Arg::new("threads")
        .long("threads")
        .value_name("N")
        .value_parser(value_parser!(u32).range(1..=4096))
        .help("Number of threads [default: one per core]; the results do not depend on it")
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    threads(matches)?;
    let path = matches
        .get_one::<PathBuf>("scene")
        .cloned()
        .unwrap_or_default();
    let scene = read(&path)?;
    let mut simulation = scene.simulation().map_err(wrong)?;
    if let Some(checkpoint) = matches.get_one::<PathBuf>("resume") {
        simulation
            .resume(checkpoint)
            .map_err(|e| input_error(e.what, e.remedy))?;
    }
    let out = matches
        .get_one::<PathBuf>("out")
        .cloned()
        .unwrap_or_else(|| Path::new("out").join(&scene.name));
    simulation.keep_outputs();
    print!("{}", statement::of(&scene, &mut simulation).text());
    println!("  {:<10} {}", "output", out.display());
    // On a thread of the pool: from outside of it every parallel loop would be a message there and back.
    rayon::scope(|_| go(&path, &scene, &mut simulation, &out))
}

/// Sets the number of threads for the whole process.
pub fn threads(matches: &ArgMatches) -> Outcome {
    let Some(&n) = matches.get_one::<u32>("threads") else {
        return Ok(());
    };
    rayon::ThreadPoolBuilder::new()
        .num_threads(n as usize)
        .build_global()
        .map_err(|e| Failure::plain(format!("cannot start {n} threads: {e}")))
}

pub fn read(path: &Path) -> Result<Scene, Failure> {
    Scene::read(path, &Pdlang).map_err(wrong)
}

pub fn wrong(problems: Problems) -> Failure {
    Failure::Input(problems.render(color()))
}

fn go(path: &Path, scene: &Scene, simulation: &mut Simulation, out: &Path) -> Outcome {
    stop_on_ctrl_c(simulation)?;
    let mut files = Files::new(out).with(Box::new(Progress::new()));
    let summary = simulation
        .run(&mut files)
        .map_err(|stopped| failure(&stopped, path, out))?;
    if scene.node_table {
        let path = out.join("nodes.csv");
        node_table::write(simulation, &path)
            .map_err(|e| Failure::Run(format!("error: cannot write {}: {e}", path.display())))?;
    }
    let breaks = scene.material.law.spec.breaks;
    print!("{}", statement::result(&summary, breaks));
    Ok(())
}

/// From here on the first Ctrl-C ends the run at the end of its step, the second one at once.
fn stop_on_ctrl_c(simulation: &Simulation) -> Outcome {
    let interrupt = simulation.interrupt.clone();
    ctrlc::set_handler(move || {
        if interrupt.swap(true, Ordering::Relaxed) {
            std::process::exit(INTERRUPTED.into());
        }
    })
    .map_err(|e| Failure::plain(format!("cannot listen to Ctrl-C: {e}")))
}

fn failure(stopped: &Stopped, scene: &Path, out: &Path) -> Failure {
    if !stopped.interrupted {
        return Failure::Run(format!("error: {stopped}"));
    }
    let how = match &stopped.checkpoint {
        Some(checkpoint) => format!(
            "go on with `pdlang run {} --out {} --resume {}`",
            scene.display(),
            out.display(),
            checkpoint.display()
        ),
        None => "there is nothing to go on from".into(),
    };
    let (step, time, why) = (stopped.step, stopped.time, &stopped.reason);
    Failure::Interrupted(format!(
        "{why} after step {step} (t = {time:.6e} s)\n  = help: {how}"
    ))
}
