//! How far a run is: a bar with an estimate on a terminal, plain lines elsewhere.

use std::io::{IsTerminal, stderr};

use indicatif::{ProgressBar, ProgressStyle};
use pdlang_runtime::observe::{Observer, Row, Summary};
use pdlang_runtime::simulate::{Simulation, Stopped};

/// Shows progress on the error stream.
pub struct Progress {
    bar: Option<ProgressBar>,
    /// Tenths of the run that have been told, without a terminal.
    told: u64,
}

const STYLE: &str = "{bar:40} {pos}/{len} steps, {eta} left, {msg}";

impl Progress {
    pub fn new() -> Progress {
        let bar = stderr().is_terminal().then(|| ProgressBar::new(0));
        if let (Some(bar), Ok(style)) = (&bar, ProgressStyle::with_template(STYLE)) {
            bar.set_style(style);
        }
        Progress { bar, told: 0 }
    }

    fn close(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Progress {
    fn start(&mut self, sim: &mut Simulation) -> Result<(), String> {
        if let Some(bar) = &self.bar {
            bar.set_length(sim.steps);
            bar.set_position(sim.state.step);
            bar.reset_eta();
        }
        self.told = tenth(sim);
        Ok(())
    }

    fn step(&mut self, sim: &Simulation) {
        match &self.bar {
            Some(bar) => bar.set_position(sim.state.step),
            None if tenth(sim) > self.told => {
                self.told = tenth(sim);
                let (step, steps) = (sim.state.step, sim.steps);
                let broken = sim.row.broken;
                eprintln!(
                    "step {step} of {steps}, t = {:.4e} s, {broken} bonds broken",
                    sim.state.time
                );
            }
            None => {}
        }
    }

    fn row(&mut self, _: &Simulation, row: &Row) -> Result<(), String> {
        if let Some(bar) = &self.bar {
            bar.set_message(format!(
                "t = {:.4e} s, {} bonds broken",
                row.time, row.broken
            ));
        }
        Ok(())
    }

    fn finish(&mut self, _: &Simulation, _: &Summary) -> Result<(), String> {
        self.close();
        Ok(())
    }

    fn stopped(&mut self, _: &Simulation, _: &Stopped, _: &Summary) {
        self.close();
    }
}

fn tenth(sim: &Simulation) -> u64 {
    10 * sim.state.step / sim.steps.max(1)
}
