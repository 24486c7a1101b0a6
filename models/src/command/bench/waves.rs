//! `pdlang bench waves`: layers and matching boundaries beside each other, as tables and as curves for `docs/waves.md`.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::{Arg, ArgMatches, Command, value_parser};
use pdlang_models::accuracy::leaving::{Damping, End, Packet, USUAL, Wave};
use pdlang_models::accuracy::{Case, figure};
use pdlang_models::bench::clock::cpu;
use pdlang_runtime::observe::Outputs;
use plotters::coord::Shift;
use plotters::prelude::*;
use serde_json::{Value, json};

use super::super::models::json_flag;
use super::super::run::threads;
use super::super::table::Table;
use super::super::{Failure, Outcome, input_error};
use super::{one_thread, progress};

/// Points of a curve of energies.
const SAMPLES: u32 = 60;
const ANGLES: [f64; 7] = [0.0, 15.0, 30.0, 45.0, 60.0, 70.0, 75.0];
const LENGTHS: [f64; 6] = [6.0, 10.0, 20.0, 40.0, 80.0, 160.0];
/// Of the length of waves against the angle [spacings].
const LENGTH: f64 = 20.0;
const COLUMNS: [&str; 6] = ["case", "end", "left", "nodes", "step", "bytes"];
/// The case of what a node of a layer costs.
const NODE: &str = "layer";
/// Title of the curves against length.
const STRAIGHT: &str = "longitudinal, straight on";
const STEPS: u64 = 200;
const REPEATS: usize = 5;

/// What reflects in the tables against angle and length.
fn ends() -> Vec<(String, End)> {
    let mut all = vec![("matching, order 1".to_string(), End::Matching(1))];
    for planes in [10, 20, 40] {
        all.push((format!("{planes} planes"), End::Layer(planes, USUAL)));
    }
    let quadratic = Damping {
        rate: 14.0,
        profile: "quadratic",
        ..USUAL
    };
    all.push(("20 planes, quadratic".into(), End::Layer(20, quadratic)));
    all
}

pub fn command() -> Command {
    Command::new("waves")
        .about("Compare absorbing layers and matching boundaries: what comes back, nodes spent, time of a step")
        .arg(
            Arg::new("only")
                .long("only")
                .value_name("TEXT")
                .help("Cases with this in their names: \"all angles\", \"transverse, 45\""),
        )
        .arg(
            Arg::new("plot")
                .long("plot")
                .value_name("FOLDER")
                .value_parser(value_parser!(PathBuf))
                .help("Also draws waves-energy.svg, waves-angle.svg and waves-length.svg there"),
        )
        .arg(one_thread())
        .arg(json_flag())
        .after_help(
            "Three waves: energy left inside at the end over that of the start, nodes of the end over those inside, CPU time of a\n\
             step and bytes of node arrays over those of the interior alone. Packets: amplitude that comes back over that of the packet. A few minutes.",
        )
}

/// A curve of a chart.
struct Series {
    name: String,
    points: Vec<(f64, f64)>,
}

/// Curves that share their axes.
struct Chart {
    title: String,
    x: &'static str,
    y: &'static str,
    series: Vec<Series>,
    /// Whether curves leave the lower left corner to the legend, and not the lower right one.
    falls: bool,
}

impl Chart {
    fn is_a_curve(&self) -> bool {
        self.series.iter().any(|s| s.points.len() > 1)
    }
}

/// Packets of which a curve is asked for.
struct Curve {
    title: &'static str,
    x: &'static str,
    packets: Vec<(f64, Packet)>,
}

fn curves() -> [Curve; 3] {
    let against_angle = |title, transverse: bool| Curve {
        title,
        x: "angle [degrees]",
        packets: ANGLES
            .map(|a| (a, Packet::of(transverse, a, LENGTH)))
            .into(),
    };
    [
        against_angle("longitudinal", false),
        against_angle("transverse", true),
        Curve {
            title: STRAIGHT,
            x: "wave length / spacing",
            packets: LENGTHS.map(|l| (l, Packet::of(false, 0.0, l))).into(),
        },
    ]
}

fn packet_name(title: &str, at: f64) -> String {
    format!("{title}, {at}")
}

/// What `--only` leaves.
struct Asked {
    waves: Vec<Wave>,
    node: bool,
    curves: [Curve; 3],
}

impl Asked {
    fn new(matches: &ArgMatches) -> Result<Asked, Failure> {
        let only = matches.get_one::<String>("only");
        let is = |case: &str| only.is_none_or(|only| case.contains(only.as_str()));
        let mut asked = Asked {
            waves: Wave::ALL.to_vec(),
            node: is(NODE),
            curves: curves(),
        };
        asked.waves.retain(|wave| is(wave.name()));
        for curve in &mut asked.curves {
            (curve.packets).retain(|(at, _)| is(&packet_name(curve.title, *at)));
        }
        if asked.cases() > 0 || asked.node {
            return Ok(asked);
        }
        let waves = Wave::ALL.map(|wave| format!("\"{}\"", wave.name()));
        Err(input_error(
            format!("there is no case `{}`", only.map_or("", String::as_str)),
            format!(
                "give a part of a name: {}, \"{NODE}\", \"transverse, 45\" (degrees), \"{STRAIGHT}, 20\" (spacings)",
                waves.join(", ")
            ),
        ))
    }

    /// Steps of the progress bar.
    fn cases(&self) -> usize {
        let packets: usize = self.curves.iter().map(|c| c.packets.len()).sum();
        self.waves.len() * End::ALL.len() + packets
    }
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    threads(matches)?;
    let asked = Asked::new(matches)?;
    let json = matches.get_flag("json");
    let bar = progress(asked.cases());
    let failed = |why: String| Failure::Run(format!("error: {why}"));
    let mut table = Table::new(&COLUMNS);
    let mut energies = Vec::new();
    for wave in &asked.waves {
        energies.push(three(*wave, &mut table, json, &bar).map_err(failed)?);
    }
    if asked.node {
        let node = of_a_node().map_err(failed)?;
        let name = "a node with damping over one without";
        table.row(row(
            json,
            NODE,
            name,
            &[f64::NAN, f64::NAN, node[0], node[1]],
        ));
    }
    let mut reflections = Vec::new();
    for curve in &asked.curves {
        reflections.push(reflected(curve, &mut table, json, &bar).map_err(failed)?);
    }
    bar.finish_and_clear();
    table.print(json);
    let Some(folder) = matches.get_one::<PathBuf>("plot") else {
        return Ok(());
    };
    std::fs::create_dir_all(folder)
        .map_err(|why| Failure::plain(format!("cannot make {}: {why}", folder.display())))?;
    for (name, charts, log) in [
        ("waves-energy.svg", &energies[..], false),
        ("waves-angle.svg", &reflections[..2], false),
        ("waves-length.svg", &reflections[2..], true),
    ] {
        let charts: Vec<&Chart> = charts.iter().filter(|chart| chart.is_a_curve()).collect();
        if charts.is_empty() {
            continue;
        }
        let path = folder.join(name);
        draw(&path, &charts, log)
            .map_err(|why| Failure::plain(format!("cannot draw {}: {why}", path.display())))?;
    }
    Ok(())
}

/// Energies left of a wave, and what its ends cost.
fn three(
    wave: Wave,
    table: &mut Table,
    json: bool,
    bar: &indicatif::ProgressBar,
) -> Result<Chart, String> {
    let of = |end: End| wave.case(end).and_then(|(case, _)| cost(&case));
    let plain = of(End::Free)?;
    let mut series = Vec::new();
    for end in End::ALL {
        bar.set_message(format!("{}, {}", wave.name(), end.name()));
        let points = wave.energies(end, SAMPLES)?;
        let left = points.last().map_or(f64::NAN, |p| p.1);
        let nodes = wave.spent(end)?;
        let cost = of(end)?;
        table.row(row(
            json,
            wave.name(),
            &end.name(),
            &[left, nodes, cost[0] / plain[0], cost[1] / plain[1]],
        ));
        series.push(Series {
            name: end.name(),
            points,
        });
        bar.inc(1);
    }
    Ok(Chart {
        title: wave.name().into(),
        x: "time / that of the run",
        y: "energy inside / that of the start",
        series,
        falls: true,
    })
}

fn row(json: bool, case: &str, end: &str, values: &[f64]) -> Vec<Value> {
    let number = |v: &f64| match json {
        _ if v.is_nan() => json!(""),
        true => json!(v),
        false => Value::String(figure(*v)),
    };
    let mut row = vec![json!(case), json!(end)];
    row.extend(values.iter().map(number));
    row.resize(COLUMNS.len(), json!(""));
    row
}

fn reflected(
    curve: &Curve,
    table: &mut Table,
    json: bool,
    bar: &indicatif::ProgressBar,
) -> Result<Chart, String> {
    let ends = ends();
    let mut series: Vec<Series> = ends
        .iter()
        .map(|(name, _)| Series {
            name: name.clone(),
            points: Vec::new(),
        })
        .collect();
    for (at, packet) in &curve.packets {
        let name = packet_name(curve.title, *at);
        bar.set_message(name.clone());
        let of: Vec<End> = ends.iter().map(|(_, end)| *end).collect();
        let found = packet.reflections(&of)?;
        for ((series, value), (end, _)) in series.iter_mut().zip(found).zip(&ends) {
            table.row(row(json, &name, end, &[value]));
            series.points.push((*at, value));
        }
        bar.inc(1);
    }
    Ok(Chart {
        title: curve.title.into(),
        x: curve.x,
        y: "amplitude that comes back",
        series,
        falls: false,
    })
}

/// CPU time of some steps, the least of several runs [s], and bytes of the node arrays.
fn cost(case: &Case) -> Result<[f64; 2], String> {
    let text = case.text();
    let start = text.find("until = ").ok_or("the scene has no end")?;
    let stop = start + text[start..].find('\n').unwrap_or(0);
    let case = case.with(&text[start..stop], &format!("steps = {STEPS}"))?;
    let (mut best, mut bytes) = (Duration::MAX, 0);
    for _ in 0..REPEATS {
        let mut simulation = case.simulation()?;
        simulation.outputs = Outputs::default();
        simulation.keep_outputs();
        bytes = simulation.engine.report().node_bytes;
        let before = cpu();
        simulation.run(&mut ()).map_err(|why| why.to_string())?;
        best = best.min(cpu() - before);
    }
    Ok([best.as_secs_f64(), bytes as f64])
}

/// Time and bytes of a node of a layer over those of one without damping.
fn of_a_node() -> Result<[f64; 2], String> {
    let (case, _) = Wave::Square.case(End::Free)?;
    let case = case.with("model = \"correspondence\"", "model = \"absorbing\"")?;
    let damped = case.with("[[initial]]", "[[initial]]\nphi = [1, 1]")?;
    let (without, with) = (cost(&case)?, cost(&damped)?);
    Ok([with[0] / without[0], with[1] / without[1]])
}

/// Charts side by side, their curves over a logarithmic axis of what comes back.
fn draw(path: &Path, charts: &[&Chart], log: bool) -> Result<(), Box<dyn Error>> {
    let each = if charts.len() == 1 { 620 } else { 460 };
    let root = SVGBackend::new(path, (each * charts.len() as u32, 430)).into_drawing_area();
    root.fill(&WHITE)?;
    let areas = root.split_evenly((1, charts.len()));
    for (area, chart) in areas.iter().zip(charts) {
        one(area, chart, log)?;
    }
    root.present()?;
    Ok(())
}

fn one(
    area: &DrawingArea<SVGBackend<'_>, Shift>,
    chart: &Chart,
    log: bool,
) -> Result<(), Box<dyn Error>> {
    let scaled = |x: f64| if log { x.log10() } else { x };
    let points = || chart.series.iter().flat_map(|s| &s.points);
    let most = points().map(|p| scaled(p.0)).fold(0.0, f64::max);
    let first = points().map(|p| scaled(p.0)).fold(f64::INFINITY, f64::min);
    let floor = points()
        .map(|p| p.1)
        .fold(1.0, f64::min)
        .max(1e-9)
        .log10()
        .floor();
    let mut context = ChartBuilder::on(area)
        .margin(12)
        .caption(&chart.title, ("sans-serif", 15))
        .x_label_area_size(42)
        .y_label_area_size(56)
        .build_cartesian_2d(first..most, floor..0.4)?;
    context
        .configure_mesh()
        .x_desc(chart.x)
        .y_desc(chart.y)
        .max_light_lines(0)
        .y_labels((1.0 - floor) as usize)
        .x_label_formatter(&|x| match log {
            true => format!("{:.0}", 10_f64.powf(*x)),
            false => format!("{}", (x * 100.0).round() / 100.0),
        })
        .y_label_formatter(&|y| match (y - y.round()).abs() < 1e-9 && *y <= 0.0 {
            true => format!("1e{}", y.round()),
            false => String::new(),
        })
        .draw()?;
    for (k, series) in chart.series.iter().enumerate() {
        let color = Palette99::pick(k).to_rgba();
        let placed = series
            .points
            .iter()
            .map(|p| (scaled(p.0), p.1.max(1e-12).log10().max(floor)));
        let line = LineSeries::new(placed, color.stroke_width(2));
        let dots = if series.points.len() < 20 { 3 } else { 0 };
        context
            .draw_series(line.point_size(dots))?
            .label(&series.name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 16, y)], color));
    }
    context
        .configure_series_labels()
        .position(match chart.falls {
            true => SeriesLabelPosition::LowerLeft,
            false => SeriesLabelPosition::LowerRight,
        })
        .background_style(WHITE)
        .border_style(BLACK)
        .draw()?;
    Ok(())
}
