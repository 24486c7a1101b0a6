//! `pdlang bench kernels`: what a bond costs in the catalogue's kernels, beside loops written by hand. `pdlang bench scenes`
//! is in a file of its own,
//! as the others are.

mod accuracy;
mod convolution;
mod curves;
mod growth;
mod scenes;
mod waves;

use std::io::{IsTerminal, stderr};
use std::time::Duration;

use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgMatches, Command, value_parser};
use indicatif::{ProgressBar, ProgressStyle};
use pdlang_models::bench::clock::cpu;
use pdlang_models::bench::scene;
use pdlang_models::bench::twin::{Elastic, Sums, Twin};
use pdlang_models::registry;
use pdlang_runtime::body::Body;
use pdlang_runtime::engine::{Breaking, Engine, Isa, Precision, SetupError, State, Traversal};
use serde_json::{Value, json};

use super::models::json_flag;
use super::run::{threads, threads_argument};
use super::table::Table;
use super::{Failure, Outcome, input_error};

/// Far above any stretch of the scene: bonds are tested, none breaks.
const S0: f64 = 0.5;
/// Forces of a kernel and of its twin are farther apart than rounding makes them.
const APART: f64 = 1e-9;
/// Of the nodes of a jittered cloud, in every direction, in spacings.
const JITTER: f64 = 0.2;

const LAWS: [&str; 6] = [
    "pmb",
    "pmb linearised",
    "lps",
    "lps linearised",
    "heat",
    "correspondence_stabilised",
];
const COLUMNS: [&str; 12] = [
    "law",
    "body",
    "dimension",
    "traversal",
    "isa",
    "precision",
    "threads",
    "ns_per_bond",
    "twin_ns_per_bond",
    "wall_ns_per_bond",
    "bytes_per_bond",
    "error",
];

/// Threads of what is timed: one, unless more are asked for.
fn one_thread() -> Arg {
    threads_argument()
        .default_value("1")
        .help("Number of threads")
}

pub fn command() -> Command {
    let kernels = Command::new("kernels")
        .about("Time the kernels of some laws on a cube of nodes with the horizon 3.015 dx")
        .arg(number("size", 4, "50", "Nodes along an edge of the cube"))
        .arg(number("repeats", 1, "15", "Force evaluations, of which the quickest counts"))
        .arg(
            Arg::new("law")
                .long("law")
                .value_name("NAME")
                .value_parser(PossibleValuesParser::new(LAWS))
                .help("One of the laws alone"),
        )
        .arg(
            threads_argument()
                .default_value("1")
                .help("Number of threads; twins run on one only"),
        )
        .arg(
            Arg::new("isa")
                .long("isa")
                .value_name("NAME")
                .value_parser(PossibleValuesParser::new(Isa::ALL.map(Isa::name)))
                .help("Instruction set [default: the best that the processor has]"),
        )
        .arg(
            Arg::new("precision")
                .long("precision")
                .value_name("NAME")
                .value_parser(["double", "single"])
                .default_value("double")
                .help("`single`: the lattice in both, in turn, for the laws that have it"),
        )
        .arg(json_flag())
        .after_help(
            "Per directed bond and force evaluation: CPU time of all threads (`ns_per_bond`), that of the same sums\n\
             written by hand for one thread of AVX-512 (`twin_ns_per_bond`), time that passes (`wall_ns_per_bond`)\n\
             and memory beside that of the nodes (`bytes_per_bond`). Bodies: a lattice, the same walked as a cloud,\n\
             and one whose nodes are moved by up to 0.2 dx in every direction. `error`: the largest difference of a force or rate\n\
             in single precision, by the largest force or rate.",
        );
    let scenes = Command::new("scenes")
        .about("Time a step with and without each thing that a scene may leave out")
        .arg(number("size", 4, "24", "Nodes along an edge of the cube"))
        .arg(number("steps", 1, "20", "Steps of a run"))
        .arg(number("repeats", 1, "3", "Runs of either side, of which the quickest counts"))
        .arg(one_thread())
        .arg(json_flag())
        .after_help(
            "CPU time per directed bond and step of whole runs without files, with the thing and without it, in turn:\n\
             a cube of nodes with the horizon 3.015 dx that all move; `nodes at rest` in a bar that is hit at one end.",
        );
    Command::new("bench")
        .about("Measure speed and accuracy")
        .subcommand_required(true)
        .arg_required_else_help(true)
        .disable_help_subcommand(true)
        .subcommand(kernels)
        .subcommand(scenes)
        .subcommand(convolution::command())
        .subcommand(growth::command())
        .subcommand(accuracy::command())
        .subcommand(waves::command())
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    match matches.subcommand() {
        Some(("kernels", matches)) => kernels(matches),
        Some(("scenes", matches)) => compare_scenes(matches),
        Some(("convolution", matches)) => convolution::execute(matches),
        Some(("growth", matches)) => growth::execute(matches),
        Some(("accuracy", matches)) => accuracy::execute(matches),
        Some(("waves", matches)) => waves::execute(matches),
        // The parser has refused everything else.
        _ => Ok(()),
    }
}

fn number(name: &'static str, least: i64, usual: &'static str, help: &'static str) -> Arg {
    Arg::new(name)
        .long(name)
        .value_name("N")
        .value_parser(value_parser!(u32).range(least..=10_000))
        .default_value(usual)
        .help(help)
}

fn compare_scenes(matches: &ArgMatches) -> Outcome {
    threads(matches)?;
    let [size, steps, repeats] =
        ["size", "steps", "repeats"].map(|name| matches.get_one::<u32>(name).copied().unwrap_or(1));
    let cases = scenes::cases();
    let bar = progress(cases.len());
    let mut table = Table::new(&scenes::COLUMNS);
    for case in cases {
        bar.set_message(case.name());
        table.row(rayon::scope(|_| case.row(size, steps, repeats))?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    table.print(matches.get_flag("json"));
    Ok(())
}

/// What the command line says.
struct Options {
    repeats: u32,
    threads: u32,
    isa: Isa,
    single: bool,
    /// One law is asked for.
    alone: bool,
}

fn kernels(matches: &ArgMatches) -> Outcome {
    threads(matches)?;
    let number = |name: &str| matches.get_one::<u32>(name).copied().unwrap_or(1);
    let options = Options {
        repeats: number("repeats"),
        threads: number("threads"),
        isa: instruction_set(matches)?,
        single: matches
            .get_one::<String>("precision")
            .is_some_and(|p| p == "single"),
        alone: matches.contains_id("law"),
    };
    if options.single && options.isa == Isa::Scalar {
        let what = "single precision takes AVX2";
        return Err(input_error(what, "leave `--isa` or `--precision` out"));
    }
    let n = number("size");
    let lattice = scene::body(n);
    let jittered = scene::jittered(n, JITTER);
    let bodies = [
        ("lattice", &lattice, Traversal::Lattice),
        ("cloud", &lattice, Traversal::Cloud),
        ("jittered", &jittered, Traversal::Cloud),
    ];
    let only = matches.get_one::<String>("law");
    let chosen = |law: &&str| only.is_none_or(|only| only == law);
    let laws: Vec<&str> = LAWS.into_iter().filter(chosen).collect();
    let bodies = if options.single {
        &bodies[..1]
    } else {
        &bodies[..]
    };
    let bar = progress(laws.len() * bodies.len());
    let mut table = Table::new(&COLUMNS);
    for law in laws {
        for (name, body, traversal) in bodies {
            bar.set_message(format!("{law}, {name}"));
            // On a thread of the pool, as a run is.
            let rows = rayon::scope(|_| rows(law, name, body, *traversal, &options))?;
            rows.into_iter().for_each(|row| table.row(row));
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    table.print(matches.get_flag("json"));
    Ok(())
}

fn instruction_set(matches: &ArgMatches) -> Result<Isa, Failure> {
    let name = matches.get_one::<String>("isa");
    let named = name.and_then(|name| Isa::ALL.into_iter().find(|isa| isa.name() == name));
    let isa = named.unwrap_or_else(Isa::best);
    match isa.available() {
        true => Ok(isa),
        false => Err(input_error(
            format!("this processor does not have {}", isa.name()),
            format!("leave `--isa` out for {}", Isa::best().name()),
        )),
    }
}

/// A bar on a terminal, nothing elsewhere.
fn progress(rows: usize) -> ProgressBar {
    if !stderr().is_terminal() {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::new(rows as u64);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len}, {msg}") {
        bar.set_style(style);
    }
    bar
}

/// The quickest evaluation.
struct Best {
    cpu: Duration,
    wall: Duration,
}

impl Best {
    const NONE: Best = Best {
        cpu: Duration::MAX,
        wall: Duration::MAX,
    };

    fn time(&mut self, act: impl FnOnce()) {
        let (wall, before) = (std::time::Instant::now(), cpu());
        act();
        self.cpu = self.cpu.min(cpu() - before);
        self.wall = self.wall.min(wall.elapsed());
    }
}

/// A kernel on a body, and what its evaluations took.
struct Case {
    engine: Engine,
    state: State,
    best: Best,
}

impl Case {
    fn new(
        law: &str,
        body: &Body,
        settings: (Traversal, Precision),
        o: &Options,
    ) -> Result<Result<Case, SetupError>, Failure> {
        let mut engine = match engine(law, body, settings, o.isa)? {
            Ok(engine) => engine,
            Err(e) => return Ok(Err(e)),
        };
        // As in a run whose outputs show nothing of the law's own.
        engine.keep_named(&|_| false);
        let mut state = scene::displaced(&engine, body);
        warm(&engine, body, &mut state);
        // Also what a step takes from families: the weighted volume.
        engine.forces(&mut state, Breaking::Armed);
        let best = Best::NONE;
        Ok(Ok(Case {
            engine,
            state,
            best,
        }))
    }

    fn time(&mut self) {
        let Case {
            engine,
            state,
            best,
        } = self;
        best.time(|| {
            engine.forces(state, Breaking::Armed);
        });
    }

    /// Forces and rates.
    fn answers(&self) -> Vec<&[f64]> {
        let forces = self.engine.force().iter().map(Vec::as_slice);
        forces
            .chain(self.engine.rates().map(|rate| rate.drive))
            .collect()
    }

    /// The largest difference of an answer, by the largest answer of its kind.
    fn distance(&self, other: &Case) -> f64 {
        let pairs = self.answers().into_iter().zip(other.answers());
        let one = |(a, b): (&[f64], &[f64])| {
            let largest = b.iter().fold(0.0_f64, |most, b| most.max(b.abs()));
            let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
            apart.fold(0.0, f64::max) / largest
        };
        pairs.map(one).fold(0.0, f64::max)
    }
}

/// One row, or one in each precision; none where the law has no single precision.
fn rows(
    law: &str,
    name: &str,
    body: &Body,
    traversal: Traversal,
    o: &Options,
) -> Result<Vec<Vec<Value>>, Failure> {
    let case = |precision| Case::new(law, body, (traversal, precision), o);
    let mut double = case(Precision::Double)?.map_err(Failure::plain)?;
    if o.single {
        let mut single = match case(Precision::Single)? {
            Ok(single) => single,
            Err(SetupError::Precision(..)) if !o.alone => return Ok(vec![]),
            Err(e) => return Err(Failure::plain(e)),
        };
        for _ in 0..o.repeats {
            double.time();
            single.time();
        }
        let error = single.distance(&double);
        return Ok(vec![
            row((law, name), &double, None, None, o),
            row((law, name), &single, None, Some(error), o),
        ]);
    }
    let alone = o.isa == Isa::Avx512 && o.threads == 1;
    let sums = sums(law, &double.engine).filter(|_| alone);
    let mut twin = sums.and_then(|sums| Twin::new(body, &sums, S0, &double.engine, &double.state));
    let mut by_hand = Best::NONE;
    for _ in 0..o.repeats {
        double.time();
        if let Some(twin) = &mut twin {
            by_hand.time(|| twin.run());
        }
    }
    let apart = twin
        .as_ref()
        .map_or(0.0, |twin| twin.distance(&double.engine));
    if apart.is_nan() || apart > APART {
        return Err(Failure::Run(format!(
            "error: {law} and its twin on the {name} differ by {apart:.1e} of the largest force"
        )));
    }
    let by_hand = twin.map(|_| by_hand.cpu);
    Ok(vec![row((law, name), &double, by_hand, None, o)])
}

fn row(
    (law, name): (&str, &str),
    case: &Case,
    by_hand: Option<Duration>,
    error: Option<f64>,
    o: &Options,
) -> Vec<Value> {
    let report = case.engine.report();
    let per_bond = |time: Duration| rounded(time.as_nanos() as f64 / report.bonds as f64);
    vec![
        json!(law),
        json!(name),
        json!(case.engine.spec().dim),
        json!(report.traversal),
        json!(report.isa.name()),
        json!(if error.is_some() { "f32" } else { "f64" }),
        json!(o.threads),
        json!(per_bond(case.best.cpu)),
        json!(by_hand.map(per_bond)),
        json!(per_bond(case.best.wall)),
        json!(rounded(report.bond_bytes as f64 / report.bonds as f64)),
        json!(error),
    ]
}

fn rounded(value: f64) -> f64 {
    (value * 1e3).round() / 1e3
}

fn engine(
    law: &str,
    body: &Body,
    (traversal, precision): (Traversal, Precision),
    isa: Isa,
) -> Result<Result<Engine, SetupError>, Failure> {
    let compiled = match law.strip_suffix(" linearised") {
        Some(law) => registry::find(law).and_then(|entry| entry.compiled_linearised(3)),
        None => registry::find(law).and_then(|entry| entry.compiled(3)),
    };
    let law = compiled.ok_or_else(|| Failure::plain(format!("{law} is not compiled")))?;
    let params = law.spec.params.iter().map(|p| parameter(&p.name)).collect();
    let mut settings = scene::settings(&law, params, traversal, isa);
    settings.precision = precision;
    Ok(Engine::new(body, law, settings))
}

/// By the names that the laws have for them: glass, in SI.
fn parameter(name: &str) -> f64 {
    match name {
        "K" => scene::K,
        "G" => scene::G,
        "E" => 9.0 * scene::K * scene::G / (3.0 * scene::K + scene::G),
        "nu" => (3.0 * scene::K - 2.0 * scene::G) / (6.0 * scene::K + 2.0 * scene::G),
        "s0" => S0,
        "density" => 2440.0,
        "cv" => 840.0,
        // Conductivity, factor of the stabilisation.
        _ => 1.0,
    }
}

/// Temperatures that differ from bond to bond.
fn warm(engine: &Engine, body: &Body, state: &mut State) {
    for slot in engine.state_slots("T").unwrap_or_default() {
        for (i, x) in body.x.iter().enumerate() {
            state.slots[slot][engine.slot(i)] = scene::displacement(*x, 0) / scene::DX;
        }
    }
}

/// The sums of the laws that have a twin, after their forces were evaluated.
fn sums(law: &str, engine: &Engine) -> Option<Sums> {
    match law {
        "pmb" => Some(Sums::Pmb(scene::pmb_params(S0)[0])),
        "lps" => {
            let m = engine.named("m")?.swap_remove(0);
            let bulk = 3.0 * scene::K - 5.0 * scene::G;
            let of = |f: &dyn Fn(f64) -> f64| m.iter().map(|m| f(*m)).collect();
            Some(Sums::Lps([
                of(&|m| 15.0 * scene::G / m),
                of(&|m| 3.0 * bulk / m / m),
            ]))
        }
        "heat" => Some(Sums::Heat {
            // 6 k/(pi delta^4), with k = 1 W/(m K).
            c: 6.0 / (std::f64::consts::PI * scene::HORIZON.powi(4)),
            storage: 1.0 / (parameter("density") * parameter("cv")),
        }),
        "correspondence_stabilised" => Some(Sums::Correspondence(Elastic {
            lambda: scene::K - 2.0 / 3.0 * scene::G,
            mu: scene::G,
            penalty: 18.0 * scene::K / (std::f64::consts::PI * scene::HORIZON.powi(5)),
        })),
        _ => None,
    }
}
