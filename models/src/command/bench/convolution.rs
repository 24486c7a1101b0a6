//! `pdlang bench convolution`: sums over the bonds of a lattice by convolution and one by one, by horizon.

use clap::{ArgMatches, Command};
use pdlang_models::bench::scene;
use pdlang_models::registry;
use pdlang_runtime::body::Body;
use pdlang_runtime::engine::{Breaking, Engine, Isa, State, Traversal};
use serde_json::{Value, json};

use super::super::models::json_flag;
use super::super::run::threads;
use super::super::table::Table;
use super::super::{Failure, Outcome};
use super::{Best, number, one_thread, parameter, progress, rounded, warm};

const LAWS: [&str; 4] = [
    "pmb linearised",
    "lps linearised",
    "heat",
    "correspondence_stabilised",
];
/// In spacings.
const HORIZONS: [f64; 7] = [1.5, 2.0, 3.015, 4.0, 5.0, 6.0, 8.0];
/// Answers of the two are farther apart, relative to the largest, than rounding makes them.
const APART: f64 = 1e-9;

const COLUMNS: [&str; 12] = [
    "law",
    "horizon_dx",
    "nodes",
    "threads",
    "bonds_per_node",
    "lattice_ns_per_node",
    "convolution_ns_per_node",
    "ratio",
    "wall_ratio",
    "transforms",
    "lattice_bytes_per_node",
    "convolution_bytes_per_node",
];

pub fn command() -> Command {
    Command::new("convolution")
        .about("Time sums over bonds by convolution beside those one by one, for some horizons")
        .arg(number("size", 4, "50", "Nodes along an edge of the cube"))
        .arg(number(
            "repeats",
            1,
            "7",
            "Force evaluations of each in turn, of which the quickest counts",
        ))
        .arg(one_thread())
        .arg(json_flag())
        .after_help(
            "Per node and force evaluation: CPU time of all threads, and its ratio; `wall_ratio` is that of the time that\n\
             passes. Bytes are all of the engine and a state. No bond can break, and no node sleeps.",
        )
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    threads(matches)?;
    let count = |name: &str| matches.get_one::<u32>(name).copied().unwrap_or(1);
    let body = scene::body(count("size"));
    let bar = progress(LAWS.len() * HORIZONS.len());
    let mut table = Table::new(&COLUMNS);
    for law in LAWS {
        for horizon in HORIZONS {
            bar.set_message(format!("{law}, {horizon} dx"));
            let row = || row(law, &body, horizon, count("repeats"), count("threads"));
            // On a thread of the pool, as a run is.
            table.row(rayon::scope(|_| row())?);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    table.print(matches.get_flag("json"));
    Ok(())
}

fn row(law: &str, body: &Body, dx: f64, repeats: u32, threads: u32) -> Result<Vec<Value>, Failure> {
    let mut sides = [Traversal::Lattice, Traversal::Convolution]
        .map(|traversal| Side::new(law, body, dx, traversal));
    let [Ok(lattice), Ok(convolution)] = &mut sides else {
        let failed = sides.into_iter().find_map(Result::err);
        return Err(failed.unwrap_or_else(|| Failure::plain(law)));
    };
    for _ in 0..repeats {
        lattice.evaluate();
        convolution.evaluate();
    }
    let apart = lattice.distance(convolution);
    if apart.is_nan() || apart > APART {
        return Err(Failure::Run(format!(
            "error: {law} at {dx} dx by convolution and one by one differ by {apart:.1e} of the largest"
        )));
    }
    let nodes = body.x.len() as f64;
    let report = convolution.engine.report();
    let per_node = |side: &Side| rounded(side.best.cpu.as_nanos() as f64 / nodes);
    let bytes = |side: &Side| {
        let report = side.engine.report();
        ((report.node_bytes + report.bond_bytes) as f64 / nodes).round()
    };
    let ratio = |f: &dyn Fn(&Side) -> f64| rounded(f(convolution) / f(lattice));
    Ok(vec![
        json!(law),
        json!(dx),
        json!(body.x.len()),
        json!(threads),
        json!(rounded(report.bonds as f64 / nodes)),
        json!(per_node(lattice)),
        json!(per_node(convolution)),
        json!(ratio(&|side| side.best.cpu.as_secs_f64())),
        json!(ratio(&|side| side.best.wall.as_secs_f64())),
        json!(report.convolution.map(|c| c.transforms)),
        json!(bytes(lattice)),
        json!(bytes(convolution)),
    ])
}

struct Side {
    engine: Engine,
    state: State,
    best: Best,
}

impl Side {
    fn new(law: &str, body: &Body, dx: f64, traversal: Traversal) -> Result<Side, Failure> {
        let compiled = match law.strip_suffix(" linearised") {
            Some(law) => registry::find(law).and_then(|entry| entry.compiled_linearised(3)),
            None => registry::find(law).and_then(|entry| entry.compiled(3)),
        };
        let law = compiled.ok_or_else(|| Failure::plain(format!("{law} is not compiled")))?;
        let whole = |name: &str| match name {
            "s0" => f64::INFINITY,
            name => parameter(name),
        };
        let params = law.spec.params.iter().map(|p| whole(&p.name)).collect();
        let mut settings = scene::settings(&law, params, traversal, Isa::best());
        settings.horizon = vec![dx * scene::DX];
        let engine = Engine::new(body, law, settings).map_err(Failure::plain)?;
        let mut state = scene::displaced(&engine, body);
        warm(&engine, body, &mut state);
        let mut side = Side {
            engine,
            state,
            best: Best::NONE,
        };
        // The first one fetches the memory.
        side.evaluate();
        side.best = Best::NONE;
        Ok(side)
    }

    fn evaluate(&mut self) {
        let Side {
            engine,
            state,
            best,
        } = self;
        best.time(|| {
            engine.forces(state, Breaking::Held);
        });
    }

    /// Forces, or rates.
    fn answers(&self) -> Vec<&[f64]> {
        let forces = self.engine.force().iter().map(|f| &f[..]);
        forces.chain(self.engine.rates().map(|r| r.drive)).collect()
    }

    /// Largest difference of the answers, relative to the largest.
    fn distance(&self, other: &Side) -> f64 {
        let (mut apart, mut size) = (0.0_f64, 0.0_f64);
        for (a, b) in self.answers().into_iter().zip(other.answers()) {
            for (a, b) in a.iter().zip(b) {
                apart = apart.max((a - b).abs());
                size = size.max(a.abs());
            }
        }
        apart / size
    }
}
