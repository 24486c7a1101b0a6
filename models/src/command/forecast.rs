//! How long a run will take: measured on its own first steps, and on one of everything that it writes.

use std::path::PathBuf;
use std::time::{Duration, Instant};

use pdlang_runtime::observe::{Files, Observer, Outputs, Row, Schedule, Timings};
use pdlang_runtime::simulate::Simulation;
use serde_json::{Value, json};

/// Time for the first steps [s]; one goes in any case, whatever it takes.
const STEPS: f64 = 0.5;
/// A row of the history is taken so often meanwhile.
const ROWS: u64 = 5;

/// So many of something, and what one costs [s].
#[derive(Clone, Copy, Debug, Default)]
pub struct Share {
    pub count: u64,
    pub each: f64,
}

impl Share {
    fn seconds(self) -> f64 {
        self.count as f64 * self.each
    }
}

/// What a run will take, all nodes awake.
#[derive(Clone, Copy, Debug, Default)]
pub struct Forecast {
    /// Reading the scene and building the simulation, as it was [s].
    pub setup: f64,
    /// Wall time of a force evaluation [s], a part of a step.
    pub force: f64,
    pub steps: Share,
    pub rows: Share,
    pub fields: Share,
    pub pictures: Share,
    pub checkpoints: Share,
}

impl Forecast {
    pub fn seconds(&self) -> f64 {
        let shares = self.shares().into_iter();
        self.setup + shares.map(|(_, s)| s.seconds()).sum::<f64>()
    }

    fn shares(&self) -> [(&'static str, Share); 5] {
        [
            ("steps", self.steps),
            ("rows", self.rows),
            ("fields", self.fields),
            ("pictures", self.pictures),
            ("checkpoints", self.checkpoints),
        ]
    }

    /// `about 20.1 s: set-up 0.51, 685 steps 12.3, ..`
    pub fn text(&self) -> String {
        let shares = self.shares().into_iter().filter(|(_, s)| s.count > 0);
        let one = |(name, s): (&str, Share)| format!(", {} {name} {:.2}", s.count, s.seconds());
        format!(
            "about {}: set-up {:.2}{}",
            duration(self.seconds()),
            self.setup,
            shares.map(one).collect::<String>()
        )
    }

    pub fn json(&self) -> Value {
        let shares = self.shares().into_iter();
        let one = |(name, s): (&str, Share)| {
            (
                name.to_string(),
                json!({ "count": s.count, "seconds": s.seconds() }),
            )
        };
        let mut map: serde_json::Map<_, _> = shares.map(one).collect();
        map.insert("setup".into(), json!(self.setup));
        Value::Object(map)
    }
}

/// Goes some steps of the simulation, which is of no use afterwards.
pub fn forecast(simulation: &mut Simulation, setup: f64) -> Forecast {
    let outputs = std::mem::take(&mut simulation.outputs);
    let mut result = Forecast {
        setup,
        steps: Share {
            count: simulation.steps.saturating_sub(simulation.state.step) + 1,
            each: 0.0,
        },
        ..counted(simulation, &outputs)
    };
    // How long nodes stay at rest is not known: the first steps would find nearly all of them so.
    simulation.engine.sleep(false);
    simulation.outputs.history = Schedule::Steps(ROWS);
    let mut watch = Watch::new();
    // However it ends: what was measured until then counts.
    let _ = simulation.run(&mut watch);
    watch.tell(&mut result);
    simulation.outputs = outputs;
    written(simulation, &mut result);
    result
}

fn counted(simulation: &Simulation, outputs: &Outputs) -> Forecast {
    let (first, last) = (simulation.state.step, simulation.steps);
    let count = |schedule: &Schedule| {
        let due = |step: &u64| {
            let time = simulation.state.time + (step - first) as f64 * simulation.dt;
            schedule.due(*step, time, simulation.dt, *step == last)
        };
        Share {
            count: (first..=last).filter(due).count() as u64,
            each: 0.0,
        }
    };
    Forecast {
        rows: count(&outputs.history),
        fields: count(&outputs.fields),
        pictures: count(&outputs.pictures),
        checkpoints: count(&outputs.checkpoints),
        ..Forecast::default()
    }
}

/// Watches the first steps and ends them.
struct Watch {
    began: Instant,
    /// After every step: when, the account of the phases, the rows so far.
    marks: Vec<(Duration, Timings, u64)>,
    rows: u64,
}

impl Watch {
    fn new() -> Watch {
        Watch {
            began: Instant::now(),
            marks: Vec::new(),
            rows: 0,
        }
    }

    fn tell(&self, result: &mut Forecast) {
        let (Some(first), Some(last)) = (self.marks.first(), self.marks.last()) else {
            return;
        };
        // The first evaluation also fetches the memory; of a single one nothing better is known.
        let steps = (self.marks.len() - 1).max(1) as f64;
        let from = match self.marks.len() {
            1 => (Duration::ZERO, Timings::default(), 0),
            _ => *first,
        };
        let wall = (last.0 - from.0).as_secs_f64();
        let other = |t: &Timings| t.energy + t.output + t.stable_step;
        let other = match self.marks.len() {
            1 => last.1.energy + last.1.output,
            _ => other(&last.1) - other(&from.1),
        };
        result.steps.each = (wall - other).max(0.0) / steps;
        result.force = (last.1.forces - from.1.forces) / steps;
        result.rows.each = match last.2 - from.2 {
            0 => last.1.energy / last.2.max(1) as f64,
            rows => (last.1.energy - from.1.energy) / rows as f64,
        };
    }
}

impl Observer for Watch {
    fn row(&mut self, _: &Simulation, _: &Row) -> Result<(), String> {
        self.rows += 1;
        Ok(())
    }

    fn step(&mut self, sim: &Simulation) {
        let now = self.began.elapsed();
        self.marks.push((now, sim.timings, self.rows));
        if now.as_secs_f64() > STEPS {
            sim.interrupt
                .store(true, std::sync::atomic::Ordering::Relaxed);
        }
    }
}

/// One of each output, into a folder that is removed again; where none can be made, outputs count as nothing.
fn written(simulation: &mut Simulation, result: &mut Forecast) {
    // What is all zero is written in no time.
    let spacing = simulation.body.spacing;
    let state = &mut simulation.state;
    for values in state.u.iter_mut().chain(&mut state.v) {
        for (k, value) in values.iter_mut().enumerate() {
            *value += 1e-3 * spacing * (k as f64 * 0.618).sin();
        }
    }
    let folder = folder();
    let mut files = Files::new(&folder);
    if files.start(simulation).is_ok() {
        let mut time = |share: &mut Share, act: &mut dyn FnMut(&mut Files, &mut Simulation)| {
            let began = Instant::now();
            if share.count > 0 {
                act(&mut files, simulation);
                share.each = began.elapsed().as_secs_f64();
            }
        };
        time(&mut result.fields, &mut |f, s| drop(f.fields(s)));
        time(&mut result.pictures, &mut |f, s| drop(f.pictures(s)));
        time(&mut result.checkpoints, &mut |f, s| drop(f.checkpoint(s)));
    }
    let _ = std::fs::remove_dir_all(&folder);
}

fn folder() -> PathBuf {
    std::env::temp_dir().join(format!("pdlang-plan-{}", std::process::id()))
}

fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 1.0 => format!("{:.0} ms", s * 1e3),
        s if s < 120.0 => format!("{s:.1} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s => format!("{:.1} h", s / 3600.0),
    }
}
