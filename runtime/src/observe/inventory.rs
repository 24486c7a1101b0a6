//! What a run computes and what not, each with the reason: read from what the engine does, not from what it is for.

use super::Schedule;
use crate::engine::{Precision, Report, SweepReport};
use crate::simulate::{Simulation, StepRule};
use crate::spec::Stage;

/// Something that a run may do without.
#[derive(Clone, Debug, PartialEq)]
pub struct Item {
    pub what: &'static str,
    pub needed: bool,
    pub why: String,
}

impl std::fmt::Display for Item {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {}", self.what, self.why)
    }
}

/// What a simulation does not need and therefore does not compute.
pub fn left_out(sim: &Simulation) -> Vec<String> {
    let all = inventory(sim).into_iter();
    all.filter(|i| !i.needed).map(|i| i.to_string()).collect()
}

/// Everything that a run may do without, and whether this one does.
pub fn inventory(sim: &Simulation) -> Vec<Item> {
    let report = sim.engine.report();
    let mut list = List(vec![]);
    mechanics(&mut list, sim, &report);
    bonds(&mut list, sim, &report);
    surroundings(&mut list, sim, &report);
    passes(&mut list, sim, &report);
    outputs(&mut list, sim);
    list.0
}

struct List(Vec<Item>);

impl List {
    fn add(&mut self, what: &'static str, needed: bool, why: impl Into<String>) {
        self.0.push(Item {
            what,
            needed,
            why: why.into(),
        });
    }

    /// With one reason where it is needed and another where it is not.
    fn either(&mut self, what: &'static str, needed: bool, yes: &str, no: &str) {
        self.add(what, needed, if needed { yes } else { no });
    }
}

fn names<'a>(sweeps: impl Iterator<Item = &'a SweepReport>) -> String {
    let names: Vec<String> = sweeps.map(|s| format!("`{}`", s.name)).collect();
    names.join(", ")
}

fn percent(part: f64) -> String {
    format!("{:.1} %", 100.0 * part)
}

/// Motion, breaking, fields, histories.
fn mechanics(list: &mut List, sim: &Simulation, report: &Report) {
    let spec = &sim.spec;
    list.either(
        "motion",
        !spec.force.is_empty(),
        "the law has a force",
        "the law has no force",
    );
    if !spec.force.is_empty() {
        list.either(
            "general kinematics",
            !spec.linearised,
            "bonds turn and stretch as far as they are moved",
            "the law is linearised: directions and lengths are those of the reference",
        );
    }
    let single: Vec<String> = report.single.iter().map(|s| format!("`{s}`")).collect();
    if !single.is_empty() {
        let why = format!(
            "{} {} bonds in single precision; what is stored and integrated is in double",
            single.join(", "),
            if single.len() == 1 { "sums" } else { "sum" }
        );
        list.add("double precision", false, why);
    } else if sim.precision == Precision::Single {
        let why = "asked for is single precision, which takes AVX2: this processor has none, or the scene leaves it out";
        list.add("double precision", true, why);
    }
    let step = || report.work.iter().filter(|s| s.stage == Stage::Step);
    let breaking = report.work.iter().filter(|s| s.breaks);
    match (sim.engine.can_break(), spec.breaks) {
        (true, _) => {
            let mut why = format!(
                "{} tests every bond, and reads and writes its mask",
                names(breaking)
            );
            if sim.held > 0 {
                let nodes = if sim.held == 1 { "node" } else { "nodes" };
                why += &format!("; bonds with an end in one of {} {nodes} hold", sim.held);
            }
            list.add("breaking", true, why);
        }
        (false, true) => list.add(
            "breaking",
            false,
            "with these parameters no bond reaches its limit; nothing is tested",
        ),
        (false, false) => list.add("breaking", false, "the law cannot break"),
    }
    let pure = step().filter(|s| s.loops && !s.breaks).collect::<Vec<_>>();
    if !pure.is_empty() && report.convolution.is_none() {
        let why = format!(
            "{} of the chunks have all their bonds at the start: {} reads none there",
            percent(report.whole),
            names(pure.into_iter())
        );
        list.add("masks of whole families", report.whole < 1.0, why);
    }
    let family = || report.work.iter().filter(|s| s.stage == Stage::Family);
    if family().next().is_some() {
        let why = match sim.engine.can_break() {
            true => format!("{} runs again where bonds broke", names(family())),
            false => format!("{} has run once", names(family())),
        };
        list.add("sums over families", sim.engine.can_break(), why);
    }
    let fields: Vec<&str> = spec.fields.iter().map(|f| f.name.as_str()).collect();
    match (fields.is_empty(), spec.rates.is_empty()) {
        (true, _) => list.add("field rates", false, "the law has no field"),
        (_, true) => list.add("field rates", false, "all fields are coefficients"),
        _ => list.add(
            "field rates",
            true,
            format!("of {}, {} stages a step", fields.join(", "), sim.stages),
        ),
    }
    let memories: Vec<&str> = spec.histories.iter().map(|h| h.name.as_str()).collect();
    match memories.is_empty() {
        true => list.add("history", false, "the law remembers nothing"),
        false => list.add(
            "history",
            true,
            format!("{}, written once a step", memories.join(", ")),
        ),
    }
}

/// What the loops over bonds read.
fn bonds(list: &mut List, sim: &Simulation, report: &Report) {
    let lattice = report.traversal != "cloud";
    if let Some(c) = &report.convolution {
        let size: Vec<String> = c.size.iter().map(usize::to_string).collect();
        let names: Vec<String> = c.sweeps.iter().map(|s| format!("`{s}`")).collect();
        let why = format!(
            "{} sums by convolution, {} transforms of {} cells an evaluation; energies are sums over bonds",
            names.join(", "),
            c.transforms,
            size.join(" x ")
        );
        list.add("loops over bonds", false, why);
    }
    let why = match lattice {
        true => "a neighbour is a step on the lattice".into(),
        false => format!(
            "{:.1} bytes a bond: {:.0} % of the chunks lead to eight nodes side by side",
            report.lists,
            100.0 * report.runs
        ),
    };
    list.add("neighbour lists", !lattice, why);
    let (numbers, kinds) = (report.geometry, report.kinds);
    let why = match (lattice, numbers) {
        (true, _) => format!("{numbers} numbers for each of {kinds} kinds of bonds"),
        (false, 0) => "the same for all bonds".into(),
        (false, 1) => "a number a bond, computed once and read at every step".into(),
        _ => format!("{numbers} numbers a bond, computed once and read at every step"),
    };
    let needed = !lattice && numbers > 0;
    list.add("reference values of single bonds", needed, why);
    let loops = || {
        let step = report.work.iter().filter(|s| s.stage == Stage::Step);
        step.filter(|s| s.loops)
    };
    let far: usize = loops().map(|s| s.far).sum();
    let why = match far {
        0 => format!("{} reads displacements alone there", names(loops())),
        n => format!("{n} in {}", names(loops().filter(|s| s.far > 0))),
    };
    list.add("values of the other end", far > 0, why);
    list.either(
        "materials",
        report.materials > 1,
        "chunks of one material each, bonds between two have their own constants",
        "one set of constants",
    );
    let partial = sim.partial_volume;
    list.either(
        "volume correction",
        partial,
        "part of the weight of a bond, computed once",
        "neighbours count with their whole volume",
    );
    if sim.spec.weights.is_empty() {
        list.add("surface correction", false, "the law has none");
    }
    for w in &sim.spec.weights {
        let why = match sim.without.contains(&w.name) {
            true => format!(
                "the scene sets `{}` to 1; its ones are read from memory",
                w.name
            ),
            false => format!("`{}`, computed once, 8 bytes a bond", w.name),
        };
        list.add("surface correction", true, why);
    }
}

/// What acts on the body.
fn surroundings(list: &mut List, sim: &Simulation, report: &Report) {
    list.either(
        "contact",
        !sim.indenters.is_empty(),
        "spheres look at the nodes near them",
        "there are no spheres",
    );
    list.either(
        "conditions",
        !sim.conditions.is_free(),
        "on the nodes of their regions",
        "no node has any",
    );
    for face in &sim.faces {
        list.add("matching boundary", true, face.to_string());
    }
    let engine = &sim.engine;
    let why = match (engine.sleeps(), engine.can_sleep()) {
        (true, _) => {
            "left out until something reaches them, to the same bits; until then they are compared"
        }
        (false, true) => "the scene keeps them awake, or all move from the start",
        (false, false) if report.convolution.is_some() => "a convolution has all nodes at once",
        (false, false) => "sweeps of the law write over each other",
    };
    list.add("nodes at rest", !engine.sleeps(), why);
}

/// Sweeps and measurements.
fn passes(list: &mut List, sim: &Simulation, report: &Report) {
    let step = || report.work.iter().filter(|s| s.stage == Stage::Step);
    let unread = || step().filter(|s| !s.read && s.runs);
    match unread().next() {
        Some(_) => {
            let why = format!("of {}, only for outputs", names(unread()));
            list.add("results that nothing else reads", true, why);
        }
        None => list.add(
            "results that nothing else reads",
            false,
            format!("each of {} is read", names(step().filter(|s| s.runs))),
        ),
    }
    let left_out: Vec<String> = sim.engine.left_out().map(|n| format!("`{n}`")).collect();
    if !left_out.is_empty() {
        let why = format!("{}: no file and no picture shows them", left_out.join(", "));
        list.add("quantities of the law for outputs", false, why);
    }
    match sim.rule {
        StepRule::Fixed(_) => list.add("stable step", false, "the scene gives one"),
        StepRule::Stable { .. } => {
            let again = sim.engine.can_break() && !sim.spec.pairwise;
            let why = match again {
                true => "at the start, and whenever another 2 % of the bonds have broken",
                false => "at the start only",
            };
            list.add("stable step", again, why);
        }
    }
    let energy = sim.spec.energy.is_some();
    let every = sim.outputs.history == Schedule::Steps(1);
    match (energy, every) {
        (false, _) => list.add(
            "strain energy",
            false,
            "the law has none; its cells in the history stay empty",
        ),
        (true, true) => list.add("strain energy", true, "every step has a row of the history"),
        (true, false) => list.add(
            "strain energy",
            false,
            "between the rows of the history and the outputs that show it",
        ),
    }
}

fn outputs(list: &mut List, sim: &Simulation) {
    let o = &sim.outputs;
    let asked = [
        ("field files", &o.fields),
        ("pictures", &o.pictures),
        ("checkpoints", &o.checkpoints),
    ];
    for (what, schedule) in asked {
        let needed = *schedule != Schedule::Never;
        list.either(what, needed, "on the steps that are due", "never due");
    }
}
