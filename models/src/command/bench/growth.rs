//! `pdlang bench growth`: what a bond costs in bodies of other sizes, horizons, dimensions and shapes.

use std::path::Path;
use std::time::{Duration, Instant};

use clap::{Arg, ArgMatches, Command, value_parser};
use pdlang_models::bench::clock::cpu;
use pdlang_models::bench::scene::{self, DX};
use pdlang_models::registry;
use pdlang_runtime::body::Body;
use pdlang_runtime::engine::{Breaking, Isa, Traversal};
use plotters::coord::Shift;
use plotters::prelude::*;
use serde_json::{Value, json};

use super::super::models::json_flag;
use super::super::run::threads;
use super::super::table::Table;
use super::super::{Failure, Outcome, input_error};
use super::{Best, one_thread, parameter, progress, rounded};

const LAWS: [&str; 2] = ["pmb", "lps"];
/// Of the other cases, in spacings.
const HORIZON: f64 = 3.015;
const HORIZONS: [f64; 7] = [1.5, 2.0, 3.015, 4.0, 5.0, 6.0, 8.0];
/// Cases beyond this multiple of the median of their law and traversal are marked.
const CLIFF: f64 = 2.0;

const COLUMNS: [&str; 12] = [
    "law",
    "case",
    "dimension",
    "traversal",
    "nodes",
    "bonds",
    "horizon_dx",
    "setup_seconds",
    "setup_cpu_seconds",
    "ns_per_bond",
    "bytes_per_bond",
    "to_median",
];

pub fn command() -> Command {
    Command::new("growth")
        .about("Time force evaluations against the number of nodes, the horizon and the shape of a body")
        .arg(
            Arg::new("nodes")
                .long("nodes")
                .value_name("N")
                .value_parser(value_parser!(u64).range(1_000..=20_000_000))
                .default_value("1000000")
                .help("Largest number of nodes; clouds have at most a tenth"),
        )
        .arg(
            Arg::new("plot")
                .long("plot")
                .value_name("FILE.svg")
                .value_parser(value_parser!(std::path::PathBuf))
                .help("Also draws the times against nodes and horizon"),
        )
        .arg(
            Arg::new("seconds")
                .long("seconds")
                .value_name("T")
                .value_parser(value_parser!(f64))
                .default_value("0.3")
                .help("Evaluations of one case are repeated for so long; the quickest counts"),
        )
        .arg(one_thread())
        .arg(json_flag())
        .after_help(
            "`ns_per_bond`: CPU time of all threads per directed bond of an evaluation, the least of some. `to_median`: that, in\n\
             medians of the same law and traversal. Bodies: cubes, squares and rows of growing numbers of nodes; cubes\n\
             of at most 27,000 with other horizons; thin, holed and round bodies; jittered and graded clouds.",
        )
}

/// A body, how it is walked, and with which horizon [m].
struct Case {
    name: &'static str,
    body: Body,
    traversal: Traversal,
    horizon: f64,
}

struct Measured {
    law: &'static str,
    case: &'static str,
    dim: usize,
    traversal: &'static str,
    nodes: usize,
    bonds: usize,
    horizon: f64,
    /// Time that passes, and CPU time of all threads [s].
    setup: [f64; 2],
    ns_per_bond: f64,
    bytes_per_bond: f64,
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    threads(matches)?;
    let seconds = matches.get_one::<f64>("seconds").copied().unwrap_or(0.0);
    let patience = Duration::try_from_secs_f64(seconds)
        .map_err(|_| input_error("`--seconds` is not a time", "give a positive number"))?;
    let most = matches.get_one::<u64>("nodes").copied().unwrap_or(1_000);
    let plans = plans(most);
    let bar = progress(LAWS.len() * plans.len());
    let mut rows = vec![];
    for plan in &plans {
        let case = plan();
        for law in LAWS {
            bar.set_message(format!("{law}, {}, {} nodes", case.name, case.body.x.len()));
            rows.push(rayon::scope(|_| measure(law, &case, patience))?);
            bar.inc(1);
        }
    }
    bar.finish_and_clear();
    let mut table = Table::new(&COLUMNS);
    for row in &rows {
        table.row(cells(row, &rows));
    }
    table.print(matches.get_flag("json"));
    if !matches.get_flag("json") {
        remark(&rows);
    }
    match matches.get_one::<std::path::PathBuf>("plot") {
        Some(path) => draw(path, &rows)
            .map_err(|why| Failure::plain(format!("cannot draw {}: {why}", path.display()))),
        None => Ok(()),
    }
}

/// Bodies are made one after the other, so that only one is in memory.
fn plans(most: u64) -> Vec<Box<dyn Fn() -> Case>> {
    let mut plans: Vec<Box<dyn Fn() -> Case>> = vec![];
    let mut add = |name, traversal, horizon: f64, body: Box<dyn Fn() -> Body>| {
        plans.push(Box::new(move || Case {
            name,
            body: body(),
            traversal,
            horizon: horizon * DX,
        }));
    };
    let mut n = 1_000;
    while n <= most {
        let edge = move |dim: f64| (n as f64).powf(1.0 / dim).round() as u32;
        let (cube, square) = (edge(3.0), edge(2.0));
        let lattice = Traversal::Lattice;
        add(
            "cube",
            lattice,
            HORIZON,
            Box::new(move || scene::body(cube)),
        );
        add(
            "square",
            lattice,
            HORIZON,
            Box::new(move || scene::lattice(2, [square, square, 1], |_| true)),
        );
        if n <= 100_000 {
            add(
                "row",
                lattice,
                HORIZON,
                Box::new(move || scene::lattice(1, [n as u32, 1, 1], |_| true)),
            );
        }
        if n <= most / 10 {
            add(
                "jittered",
                Traversal::Cloud,
                HORIZON,
                Box::new(move || scene::jittered(cube, 0.2)),
            );
        }
        n *= 10;
    }
    let e = ((most as f64).cbrt().round() as u32).min(30);
    for horizon in HORIZONS {
        add(
            "cube",
            Traversal::Lattice,
            horizon,
            Box::new(move || scene::body(e)),
        );
        add(
            "jittered",
            Traversal::Cloud,
            horizon,
            Box::new(move || scene::jittered(e, 0.2)),
        );
    }
    // About e^3 nodes each.
    let (all, wide) = (e * e * e, e * 5 / 4);
    let across = |layers: u32| f64::from(all / layers).sqrt() as u32;
    for traversal in [Traversal::Lattice, Traversal::Cloud] {
        let mut shape = |name, shape: [u32; 3], keep: fn([u32; 3], u32) -> bool| {
            let body = move || scene::lattice(3, shape, |cell| keep(cell, shape[0]));
            add(name, traversal, HORIZON, Box::new(body));
        };
        shape("sheet", [across(1), across(1), 1], |_, _| true);
        shape("two layers", [across(2), across(2), 2], |_, _| true);
        shape("rod", [all / 9, 3, 3], |_, _| true);
        shape("standing rod", [3, 3, all / 9], |_, _| true);
        shape("holes", [wide; 3], |[i, j, _], _| i % 8 > 2 || j % 8 > 2);
        shape("sponge", [wide; 3], |[i, j, k], _| {
            (i * 7 + j * 13 + k * 29) % 2 == 0
        });
        shape("ball", [wide; 3], |cell, wide| {
            let from_center = |c: &u32| (2.0 * f64::from(*c) - f64::from(wide - 1)).powi(2);
            cell.iter().map(from_center).sum::<f64>() < f64::from(wide * wide)
        });
    }
    add(
        "graded",
        Traversal::Cloud,
        HORIZON,
        Box::new(move || scene::graded(e)),
    );
    plans
}

fn measure(law: &'static str, case: &Case, patience: Duration) -> Result<Measured, Failure> {
    let dim = case.body.flavour.dim();
    let compiled = registry::find(law).and_then(|entry| entry.compiled(dim));
    let compiled = compiled.ok_or_else(|| Failure::plain(format!("{law} is not compiled")))?;
    let params = compiled.spec.params.iter().map(|p| parameter(&p.name));
    let mut settings = scene::settings(&compiled, params.collect(), case.traversal, Isa::best());
    settings.horizon = vec![case.horizon];
    let (began, before) = (Instant::now(), cpu());
    let mut engine = pdlang_runtime::engine::Engine::new(&case.body, compiled, settings)
        .map_err(Failure::plain)?;
    let (setup, setup_cpu) = (began.elapsed(), cpu() - before);
    // As in a run whose outputs show nothing of the law's own.
    engine.keep_named(&|_| false);
    let mut state = scene::displaced(&engine, &case.body);
    engine.forces(&mut state, Breaking::Armed);
    let (began, mut best) = (Instant::now(), Best::NONE);
    while best.wall == Duration::MAX || began.elapsed() < patience {
        best.time(|| {
            engine.forces(&mut state, Breaking::Armed);
        });
    }
    let report = engine.report();
    let bonds = report.bonds.max(1) as f64;
    Ok(Measured {
        law,
        case: case.name,
        dim,
        traversal: report.traversal,
        nodes: case.body.x.len(),
        bonds: report.bonds,
        horizon: rounded(case.horizon / DX),
        setup: [setup, setup_cpu].map(|t| t.as_secs_f64()),
        ns_per_bond: best.cpu.as_secs_f64() * 1e9 / bonds,
        bytes_per_bond: report.bond_bytes as f64 / bonds,
    })
}

/// Time per bond in medians of the same law and traversal.
fn to_median(row: &Measured, rows: &[Measured]) -> f64 {
    let alike = rows
        .iter()
        .filter(|r| r.law == row.law && r.traversal == row.traversal);
    let mut times: Vec<f64> = alike.map(|r| r.ns_per_bond).collect();
    times.sort_by(f64::total_cmp);
    row.ns_per_bond / times[times.len() / 2]
}

fn cells(row: &Measured, rows: &[Measured]) -> Vec<Value> {
    vec![
        json!(row.law),
        json!(row.case),
        json!(row.dim),
        json!(row.traversal),
        json!(row.nodes),
        json!(row.bonds),
        json!(row.horizon),
        json!(rounded(row.setup[0])),
        json!(rounded(row.setup[1])),
        json!(rounded(row.ns_per_bond)),
        json!(rounded(row.bytes_per_bond)),
        json!(rounded(to_median(row, rows))),
    ]
}

fn remark(rows: &[Measured]) {
    let far = rows.iter().filter(|r| to_median(r, rows) > CLIFF).count();
    println!(
        "\n{far} of {} are more than {CLIFF} medians of their law and traversal.",
        rows.len()
    );
}

/// Two charts side by side: time per bond of cubes and their jittered kin against nodes, and against the horizon.
fn draw(path: &Path, rows: &[Measured]) -> Result<(), Box<dyn std::error::Error>> {
    let root = SVGBackend::new(path, (1080, 460)).into_drawing_area();
    root.fill(&WHITE)?;
    let (left, right) = root.split_horizontally(540);
    let solid = |r: &&Measured| ["cube", "jittered"].contains(&r.case);
    let nodes = |r: &&Measured| solid(r) && r.horizon == HORIZON;
    let sizes = rows.iter().filter(|r| solid(r) && r.horizon != HORIZON);
    let size = sizes.map(|r| r.nodes).max();
    let horizon = |r: &&Measured| solid(r) && Some(r.nodes) == size;
    let grown = series(rows.iter().filter(nodes), |r| (r.nodes as f64).log10());
    let spread = series(rows.iter().filter(horizon), |r| r.horizon);
    chart(&left, "nodes", &|n| power(*n), &grown)?;
    chart(&right, "horizon / spacing", &|h| format!("{h}"), &spread)?;
    root.present()?;
    Ok(())
}

/// A tick of a logarithmic axis; only whole powers have one.
fn power(n: f64) -> String {
    match (n - n.round()).abs() < 1e-9 {
        true => format!("1e{}", n.round()),
        false => String::new(),
    }
}

/// A name and its points.
type Series = (String, Vec<(f64, f64)>);

fn series<'a>(rows: impl Iterator<Item = &'a Measured>, x: fn(&Measured) -> f64) -> Vec<Series> {
    let mut all: Vec<Series> = vec![];
    for row in rows {
        let name = format!("{}, {}", row.law, row.case);
        let point = (x(row), row.ns_per_bond);
        match all.iter_mut().find(|(n, _)| *n == name) {
            Some((_, points)) => points.push(point),
            None => all.push((name, vec![point])),
        }
    }
    all.iter_mut()
        .for_each(|(_, points)| points.sort_by(|a, b| a.0.total_cmp(&b.0)));
    all
}

fn chart(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    label: &str,
    tick: &dyn Fn(&f64) -> String,
    all: &[Series],
) -> Result<(), Box<dyn std::error::Error>> {
    let points = || all.iter().flat_map(|(_, points)| points);
    let ends = |start: (f64, f64), v: f64| (start.0.min(v), start.1.max(v));
    let (low, high) = points().map(|p| p.0).fold((f64::INFINITY, 0.0), ends);
    let top = points().map(|p| p.1).fold(0.0, f64::max);
    let room = 0.05 * (high - low).max(1.0);
    let mut chart = ChartBuilder::on(area)
        .margin(14)
        .x_label_area_size(42)
        .y_label_area_size(52)
        .build_cartesian_2d(low - room..high + room, 0.0..1.3 * top)?;
    chart
        .configure_mesh()
        .x_desc(label)
        .y_desc("ns per directed bond")
        .max_light_lines(0)
        .x_label_formatter(tick)
        .draw()?;
    for (k, (name, points)) in all.iter().enumerate() {
        let color = Palette99::pick(k).to_rgba();
        chart
            .draw_series(LineSeries::new(points.iter().copied(), color).point_size(3))?
            .label(name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], color));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .background_style(WHITE)
        .border_style(BLACK)
        .draw()?;
    Ok(())
}
