//! What a run says about itself: before it starts, and when it is done.

use pdlang_models::constants;
use pdlang_models::language::Pdlang;
use pdlang_runtime::engine::{PartReport, Traversal};
use pdlang_runtime::language::{Exponents, Language, dimension};
use pdlang_runtime::observe::{Schedule, Summary};
use pdlang_runtime::scene::{Influence, Scene, implied};
use pdlang_runtime::simulate::{End, Simulation, StepRule};
use serde_json::{Map, Value};

/// How a law becomes two to four times as fast.
const COMPILE: &str = "name the file in pdlang_macros::include_model!(\"..\") in a Rust program, or put it into models/laws and models/src/registry.rs and build again";

/// The same of a law for small displacements.
const COMPILE_LINEARISED: &str = "name the file in pdlang_macros::include_model!(linearised \"..\") in a Rust program, or put it into `linearised` of models/src/registry.rs and build again";

/// Share of its time that the fastest wave of a field is given, below which a word is worth it.
const STILL: f64 = 0.01;

/// Part of empty lanes that is worth a word.
const WASTE: f64 = 0.05;

/// Named lines under a title.
pub struct Statement {
    title: String,
    lines: Vec<(&'static str, String)>,
}

impl Statement {
    pub fn add(&mut self, name: &'static str, text: impl Into<String>) {
        self.lines.push((name, text.into()));
    }

    pub fn text(&self) -> String {
        let line = |(name, text): &(&str, String)| format!("  {name:<10} {text}\n");
        format!(
            "{}\n{}",
            self.title,
            self.lines.iter().map(line).collect::<String>()
        )
    }

    pub fn json(&self) -> Map<String, Value> {
        let mut map = Map::new();
        map.insert("title".into(), self.title.as_str().into());
        map.extend(
            self.lines
                .iter()
                .map(|(n, t)| (n.replace(' ', "_"), t.as_str().into())),
        );
        map
    }
}

/// A horizon of more spacings than anybody means.
const LONG: f64 = 12.0;

/// Law, body, traversal, memory, constants, step.
pub fn of(scene: &Scene, simulation: &mut Simulation) -> Statement {
    let mut s = Statement {
        title: scene.title.clone(),
        lines: Vec::new(),
    };
    let spec = &scene.material.law.spec;
    let form = if spec.linearised { ", linearised" } else { "" };
    s.add("law", format!("{}: {}{form}", spec.law, spec.title));
    s.add("from", spec.cites.join("; "));
    for (k, shown) in parameters(scene).into_iter().enumerate() {
        let label = match k {
            0 => "parameters",
            _ => "part",
        };
        s.add(label, shown);
    }
    for (slot, influence) in spec.influences.iter().zip(&scene.material.influences) {
        s.add("influence", format!("{} = {}", slot.name, call(influence)));
    }
    body(&mut s, scene, simulation);
    let implied = implied::modulus(scene);
    constants(&mut s, scene, implied);
    // Of a step that the scene gives, nobody else asks for the limit.
    let limit = match scene.step {
        StepRule::Fixed(_) if scene.end != End::Steps(0) => simulation.limit(),
        _ => f64::INFINITY,
    };
    s.add("time step", step(scene, simulation, limit));
    for warning in warnings(scene, simulation, limit) {
        s.add("warning", warning);
    }
    s
}

/// What is allowed and seldom meant.
fn warnings(scene: &Scene, simulation: &Simulation, limit: f64) -> Vec<String> {
    let mut list = Vec::new();
    if simulation.dt > limit {
        list.push(format!(
            "the time step is {:.3} times the limit of this body, {limit:.4e} s: the run will go unstable; \
             leave `dt` out of [time] for a stable one",
            simulation.dt / limit
        ));
    }
    if let Some(stable) = &simulation.stable {
        let lasts = simulation.steps as f64 * simulation.dt;
        let share = stable.rate * lasts;
        if stable.omega > 0.0 && share > 0.0 && share < STILL {
            list.push(format!(
                "the fields hardly change in this run: even the shortest of their waves takes {:.1e} s, {:.0e} steps of the motion, and the \
                 run lasts {lasts:.1e} s; a law of fields alone, `heat` for instance, takes steps of its own",
                1.0 / stable.rate,
                1.0 / (stable.rate * simulation.dt)
            ));
        }
    }
    let (horizon, dx) = (scene.family.horizon.constant(), simulation.body.spacing);
    let convolved = scene.family.traversal == Traversal::Convolution;
    if let Some(horizon) = horizon.filter(|h| *h > LONG * dx && !convolved) {
        list.push(format!(
            "the horizon of {horizon} m is {:.1} spacings: three are usual, horizon = \"3 dx\"",
            horizon / dx
        ));
    }
    list
}

/// Density and parameters of every material, the one outside of all parts first.
fn parameters(scene: &Scene) -> Vec<String> {
    let material = &scene.material;
    let law = &material.law.spec;
    let is_parameter = law.params.iter().any(|p| p.name == "density");
    let shown = |(density, params): (Option<f64>, Vec<f64>)| {
        let pairs = law.params.iter().zip(params);
        let mut shown: Vec<String> = pairs
            .map(|(p, v)| format!("{} = {}", p.name, with_unit(v, p.exponents)))
            .collect();
        if let Some(density) = density.filter(|_| !is_parameter) {
            shown.push(format!("density = {density} kg/m^3"));
        }
        shown.join(", ")
    };
    material.sets().into_iter().map(shown).collect()
}

fn with_unit(value: f64, unit: Exponents) -> String {
    match unit {
        dimension::NUMBER => value.to_string(),
        _ => format!("{value} {}", Pdlang.unit_name(unit)),
    }
}

fn call(influence: &Influence) -> String {
    let Influence {
        function, values, ..
    } = influence;
    let pairs = function.params.iter().zip(values);
    let arguments: Vec<String> = pairs
        .map(|(p, v)| format!("{} = {}", p.name, with_unit(*v, p.exponents)))
        .collect();
    match arguments.is_empty() {
        true => function.name.clone(),
        false => format!("{}({})", function.name, arguments.join(", ")),
    }
}

fn body(s: &mut Statement, scene: &Scene, simulation: &Simulation) {
    let report = simulation.engine.report();
    let body = &simulation.body;
    s.add(
        "body",
        format!(
            "{} nodes, {}, spacing {} m",
            grouped(report.nodes as u64),
            body.flavour.name(),
            body.spacing
        ),
    );
    let horizons = &simulation.engine.grading().horizons;
    let horizon = match scene.family.horizon.constant() {
        Some(h) => format!("{h:.6e} m = {:.6} dx", h / body.spacing),
        None => "by node".into(),
    };
    let own = scene.material.parts.iter().enumerate();
    let own = own.filter_map(|(k, part)| {
        let own = match part.horizon.as_ref()?.constant() {
            Some(h) => format!("{h:.6e} m"),
            None => "by node".into(),
        };
        Some(format!(", {own} in part {}", k + 1))
    });
    let volumes = if scene.family.partial_volume {
        "partial volumes"
    } else {
        "full volumes"
    };
    s.add(
        "bonds",
        format!(
            "{}, horizon {horizon}{}, {volumes}",
            grouped(report.bonds as u64 / 2),
            own.collect::<String>()
        ),
    );
    if let ([first, .., last], false) = (&horizons[..], body.horizon.is_empty()) {
        let levels = horizons.len();
        let rounded = match simulation.engine.grading().rounding {
            0.0 => "as given".to_string(),
            r => format!("rounded by up to {:.2} %", 100.0 * r),
        };
        s.add(
            "horizons",
            format!("{levels} levels from {first:.6e} m to {last:.6e} m, {rounded}"),
        );
    }
    if !body.horizon.is_empty() && report.empty_lanes > WASTE {
        let share = 100.0 * report.empty_lanes;
        s.add(
            "waste",
            format!("{share:.0} % of the lanes hold no node: fewer `horizon_levels` fill them"),
        );
    }
    let compiled = report
        .sweeps
        .iter()
        .filter(|(_, compiled)| *compiled)
        .count();
    let how = match report.sweeps.len() {
        n if n == compiled => "compiled".to_string(),
        _ if compiled == 0 => "interpreted".to_string(),
        n => format!("{compiled} of {n} sweeps compiled"),
    };
    s.add(
        "kernel",
        format!(
            "{} traversal, {}{}, {how}",
            report.traversal,
            report.isa.name(),
            match report.single.is_empty() {
                true => "",
                false => ", single precision",
            }
        ),
    );
    if compiled == 0 && report.convolution.is_none() {
        let how = match simulation.spec.linearised {
            true => COMPILE_LINEARISED,
            false => COMPILE,
        };
        s.add("to compile", how);
    }
    s.add(
        "memory",
        format!(
            "{} for nodes, {} for bonds, {} for the body, its loads and its fields on their way{}",
            bytes(report.node_bytes as u64),
            bytes(report.bond_bytes as u64),
            bytes(simulation.other_bytes() as u64),
            match simulation.outputs.checkpoints {
                Schedule::Never => "",
                _ => "; a checkpoint copies the state",
            }
        ),
    );
    let part = |part: &PartReport| {
        format!(
            "{} on {} of {} nodes, where {}: {}",
            part.fields.join(", "),
            grouped(part.nodes as u64),
            grouped(report.nodes as u64),
            part.condition,
            bytes(part.bytes as u64)
        )
    };
    let parts: Vec<String> = report.parts.iter().map(part).collect();
    if !parts.is_empty() {
        s.add("fields", parts.join("; "));
    }
}

fn constants(s: &mut Statement, scene: &Scene, implied: Option<f64>) {
    let how = if scene.material.lattice_constants {
        "sums over a full lattice family"
    } else {
        "integrals over the horizon"
    };
    let shown: Vec<String> = constants::of(scene)
        .iter()
        .map(|(name, value)| format!("{name} = {value:.8e}"))
        .collect();
    if !shown.is_empty() {
        s.add("constants", format!("{} (from {how})", shown.join(", ")));
    }
    if let Some(modulus) = implied {
        s.add(
            "implied",
            format!("modulus of the lattice against expansion {modulus:.6e} Pa"),
        );
    }
}

fn step(scene: &Scene, simulation: &Simulation, limit: f64) -> String {
    let until = match scene.end {
        End::Steps(0) => return "none: the forces are evaluated once".into(),
        End::Steps(n) => format!("{n} steps, to {:.6e} s", n as f64 * simulation.dt),
        End::Time(t) => format!("{} steps, to {t:.6e} s", simulation.steps),
    };
    let why = match (scene.step, &simulation.stable) {
        (StepRule::Stable { safety }, Some(stable)) => {
            let fastest = [
                (stable.omega, "omega", "rad/s"),
                (stable.rate, "rate", "1/s"),
            ];
            let shown: Vec<String> = fastest
                .iter()
                .filter(|(value, ..)| *value > 0.0)
                .map(|(value, name, unit)| format!("{name} = {value:.4e} {unit}"))
                .collect();
            format!("{safety} of the limit of this body ({})", shown.join(", "))
        }
        _ if limit.is_finite() => {
            format!(
                "as given, {:.3} of the limit of this body",
                simulation.dt / limit
            )
        }
        _ => "as given".into(),
    };
    let stages = match simulation.stages {
        0 => String::new(),
        n => format!(", {n} stages of the fields each"),
    };
    format!("{:.6e} s, {why}{stages}; {until}", simulation.dt)
}

/// What came out.
pub fn result(summary: &Summary, breaks: bool) -> String {
    let t = &summary.timings;
    let row = &summary.last;
    let fields = match summary.stages {
        0 => String::new(),
        _ => format!(", fields {:.2}", t.fields),
    };
    let mut text = format!(
        "done       {} steps in {:.2} s ({:.2} ns per bond): forces {:.2}{fields}, integration {:.2}, energy {:.2}, output {:.2}\n",
        summary.steps, t.total, summary.ns_per_bond, t.forces, t.integration, t.energy, t.output,
    );
    if breaks {
        text += &format!(
            "broken     {} bonds ({:.4} %)\n",
            grouped(row.broken),
            100.0 * row.broken_fraction,
        );
    }
    for f in row.fields.iter().filter(|f| f.min != 0.0 || f.max != 0.0) {
        text += &format!(
            "{:<10} {:.6e} to {:.6e} {}, mean {:.6e}\n",
            f.name, f.min, f.max, f.unit, f.mean
        );
    }
    text
}

/// 103110 as `103,110`.
pub fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut shown = String::new();
    for (k, digit) in digits.chars().enumerate() {
        if k > 0 && (digits.len() - k).is_multiple_of(3) {
            shown.push(',');
        }
        shown.push(digit);
    }
    shown
}

pub fn bytes(n: u64) -> String {
    match n {
        0..10_000 => format!("{n} B"),
        10_000..10_000_000 => format!("{:.1} kB", n as f64 / 1e3),
        10_000_000..10_000_000_000 => format!("{:.1} MB", n as f64 / 1e6),
        _ => format!("{:.1} GB", n as f64 / 1e9),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn large_numbers_are_grouped() {
        assert_eq!(grouped(7), "7");
        assert_eq!(grouped(103_110), "103,110");
        assert_eq!(grouped(1_000), "1,000");
        assert_eq!(bytes(25_000_000), "25.0 MB");
    }
}
