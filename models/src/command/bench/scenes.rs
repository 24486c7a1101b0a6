//! `pdlang bench scenes`: what a step costs with and without each thing that a scene may leave out.

use std::path::Path;
use std::time::Duration;

use pdlang_models::bench::clock::cpu;
use pdlang_models::language::Pdlang;
use pdlang_runtime::engine::Law;
use pdlang_runtime::observe::{Observer, Outputs, Schedule};
use pdlang_runtime::scene::Scene;
use pdlang_runtime::simulate::Simulation;
use serde_json::{Value, json};

use super::super::Failure;
use super::super::run::wrong;
use super::rounded;

pub const COLUMNS: [&str; 6] = [
    "what",
    "law",
    "nodes",
    "with_ns_per_bond",
    "without_ns_per_bond",
    "ratio",
];

/// A scene of the table: a cube whose nodes all move, or a bar that is hit at one end.
#[derive(Clone, Default)]
struct Side {
    law: &'static str,
    /// Lines of [family], [material] and [time], and further sections.
    family: &'static str,
    material: &'static str,
    time: &'static str,
    more: &'static str,
    bar: bool,
    interpreted: bool,
    energy: bool,
    /// As if outputs showed all that the law names.
    shown: bool,
}

/// Something that a scene may leave out, with and without.
pub struct Case {
    what: &'static str,
    with: Side,
    without: Side,
}

const S0: &str = "s0 = 0.5";
const HALF: &str = "[[material.part]]\nregion = { box = { from = [0, 0, 0], to = [\"L/2\", \"W\", \"W\"] } }\nK = \"14.8 GPa\"";
/// In the middle of a face of the cube.
const SPHERE: &str = "[[indenter]]\nradius = \"L\"\ncenter = [\"-0.9*L\", \"W/2\", \"W/2\"]\nvelocity = [0, 0, 0]\ncontact = \"penalty\"\nstiffness = \"1e12 N/m^5\"";
const HEAT: &str = "alpha = 1e-5\nk = \"1 W/(m K)\"\ncv = \"840 J/(kg K)\"";
const HEAT_LINEARISED: &str =
    "alpha = 1e-5\nk = \"1 W/(m K)\"\ncv = \"840 J/(kg K)\"\nlinearised = true";

pub fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    let mut add = |what, with: &Side, without: &Side| {
        cases.push(Case {
            what,
            with: with.clone(),
            without: without.clone(),
        });
    };
    for law in ["pmb", "lps"] {
        let plain = Side {
            law,
            ..Side::default()
        };
        let material = |material| Side {
            material,
            ..plain.clone()
        };
        let family = |family| Side {
            family,
            ..plain.clone()
        };
        let more = |more| Side {
            more,
            ..plain.clone()
        };
        add("breaking, with masks", &material(S0), &plain);
        add("neighbour lists", &family("traversal = \"cloud\""), &plain);
        let linearised = "linearised = true";
        add("general kinematics", &plain, &material(linearised));
        let cloud = |material| Side {
            material,
            ..family("traversal = \"cloud\"")
        };
        add(
            "general kinematics of a cloud",
            &cloud(""),
            &cloud(linearised),
        );
        let convolved = Side {
            family: "traversal = \"convolution\"",
            ..material(linearised)
        };
        add("loops over bonds", &material(linearised), &convolved);
        let bar = |time| Side {
            bar: true,
            time,
            ..plain.clone()
        };
        add("nodes at rest", &bar("sleep = false"), &bar(""));
        let energy = Side {
            energy: true,
            ..plain.clone()
        };
        add("energy at every step", &energy, &plain);
        let volumes = family("partial_volume = true");
        add("volume correction", &volumes, &plain);
        add("contact", &more(SPHERE), &plain);
        let interpreted = Side {
            interpreted: true,
            ..plain.clone()
        };
        add("interpreter", &interpreted, &plain);
        add("a second material", &more(HALF), &plain);
        let graded = family("horizon = \"3.015*dx*(1 + 0.1*x/L)\"\nhorizon_levels = 8");
        add("eight horizons", &graded, &plain);
    }
    let of = |law, material| Side {
        law,
        material,
        ..Side::default()
    };
    let (pmb, lps) = (of("pmb", ""), of("lps", ""));
    add("heat", &of("thermo_pmb", HEAT), &pmb);
    add("heat", &of("thermo_lps", HEAT), &lps);
    for law in ["thermo_pmb", "thermo_lps"] {
        let general = Side {
            interpreted: true,
            ..of(law, HEAT)
        };
        let linearised = Side {
            material: HEAT_LINEARISED,
            ..general.clone()
        };
        add("general kinematics, interpreted", &general, &linearised);
    }
    let correspondence = of("correspondence_stabilised", "");
    let shown = Side {
        shown: true,
        ..correspondence.clone()
    };
    add("gradient and stress", &shown, &correspondence);
    add(
        "history",
        &of("lps_viscoelastic", "share = 0.5\ntau = \"1 us\""),
        &lps,
    );
    add("history", &of("lps_plastic", "tauy = \"1 GPa\""), &lps);
    let corrected = of("solid", "");
    add(
        "surface correction",
        &corrected,
        &of("solid", "Gd = 1\nGb = 1"),
    );
    cases
}

impl Side {
    fn text(&self, size: u32) -> String {
        let (length, width) = match self.bar {
            true => (size * 4, size / 2),
            false => (size, size),
        };
        let horizon = match self.family.contains("horizon =") {
            true => "",
            false => "horizon = \"3.015 dx\"",
        };
        let moduli = match self.law {
            "pmb" | "thermo_pmb" => "K = \"14.9 GPa\"",
            "correspondence_stabilised" => "E = \"15.9 GPa\"\nnu = 0.32",
            _ => "K = \"14.9 GPa\"\nG = \"6 GPa\"",
        };
        let motion = match self.bar {
            true => {
                "[[condition]]\nregion = { box = { from = [0, 0, 0], to = [\"2*dx\", \"W\", \"W\"] } }\nvelocity = [\"0.1 m/s\", 0, 0]"
            }
            false => "[[initial]]\nvelocity = [\"10 [1/s]*x\", \"5 [1/s]*y\", \"3 [1/s]*z\"]",
        };
        let Side {
            law,
            family,
            material,
            time,
            more,
            ..
        } = self;
        format!(
            "[let]\nL = \"{length} mm\"\nW = \"{width} mm\"\n\
             [body]\nflavour = \"3d\"\nspacing = \"1 mm\"\nshape = {{ box = {{ from = [0, 0, 0], to = [\"L\", \"W\", \"W\"] }} }}\n\
             [family]\n{horizon}\n{family}\n\
             [material]\nmodel = \"{law}\"\ndensity = \"2200 kg/m^3\"\n{moduli}\n{material}\n\
             {more}\n{motion}\n\
             [time]\ndt = \"25 ns\"\nsteps = 1000000\n{time}\n"
        )
    }

    fn simulation(&self, size: u32) -> Result<Simulation, Failure> {
        let scene = Scene::parse(&self.text(size), Path::new("bench.toml"), &Pdlang);
        let mut scene = scene.map_err(wrong)?;
        if self.interpreted {
            scene.material.law = Law::interpreted(scene.material.law.spec.clone());
        }
        let mut simulation = scene.simulation().map_err(wrong)?;
        let every = |wanted| if wanted { 1 } else { u64::MAX };
        simulation.outputs = Outputs {
            history: Schedule::Steps(every(self.energy)),
            ..Outputs::default()
        };
        if !self.shown {
            simulation.keep_outputs();
        }
        Ok(simulation)
    }

    /// CPU time of a step [ns] per directed bond: all steps but the first, and but the last with its row.
    fn time(&self, size: u32, steps: u32) -> Result<f64, Failure> {
        let mut simulation = self.simulation(size)?;
        simulation.steps = u64::from(steps) + 2;
        let mut marks = Marks(Vec::new());
        simulation
            .run(&mut marks)
            .map_err(|stopped| Failure::Run(format!("error: {} {stopped}", self.law)))?;
        let bonds = simulation.engine.report().bonds.max(1) as f64;
        let (first, last) = (marks.0[0], marks.0[steps as usize]);
        Ok((last - first).as_nanos() as f64 / f64::from(steps) / bonds)
    }
}

struct Marks(Vec<Duration>);

impl Observer for Marks {
    fn step(&mut self, _: &Simulation) {
        self.0.push(cpu());
    }
}

impl Case {
    pub fn name(&self) -> String {
        format!("{}, {}", self.what, self.with.law)
    }

    /// The quickest of so many runs of each, one after the other in turn.
    pub fn row(&self, size: u32, steps: u32, repeats: u32) -> Result<Vec<Value>, Failure> {
        let (mut with, mut without) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..repeats {
            with = with.min(self.with.time(size, steps)?);
            without = without.min(self.without.time(size, steps)?);
        }
        let nodes = self.with.simulation(size)?.body.x.len();
        Ok(vec![
            json!(self.what),
            json!(self.with.law),
            json!(nodes),
            json!(rounded(with)),
            json!(rounded(without)),
            json!(rounded(with / without)),
        ])
    }
}
