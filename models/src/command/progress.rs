//! Watching a run: files on disk, and how far it is.

use std::io::{IsTerminal, stderr};
use std::path::{Path, PathBuf};

use indicatif::{ProgressBar, ProgressStyle};
use pdlang_runtime::observe::{Files, Observer, Row, Summary};
use pdlang_runtime::simulate::{Simulation, Stopped};

/// Writes files and shows progress: a bar with an estimate on a terminal, plain lines elsewhere.
pub struct Watch {
    files: Files,
    bar: Option<ProgressBar>,
    /// Tenths of the run that have been told, without a terminal.
    told: u64,
}

const STYLE: &str = "{bar:40} {pos}/{len} steps, {eta} left, {msg}";

impl Watch {
    /// # Errors
    /// When the folder cannot be written.
    pub fn new(out: &Path) -> Result<Watch, String> {
        let files = Files::new(out)?;
        let bar = stderr().is_terminal().then(|| ProgressBar::new(0));
        if let (Some(bar), Ok(style)) = (&bar, ProgressStyle::with_template(STYLE)) {
            bar.set_style(style);
        }
        Ok(Watch { files, bar, told: 0 })
    }

    fn close(&self) {
        if let Some(bar) = &self.bar {
            bar.finish_and_clear();
        }
    }
}

impl Observer for Watch {
    fn start(&mut self, sim: &mut Simulation) -> Result<(), String> {
        if let Some(bar) = &self.bar {
            bar.set_length(sim.steps);
            bar.set_position(sim.state.step);
            bar.reset_eta();
        }
        self.told = tenth(sim);
        self.files.start(sim)
    }

    fn step(&mut self, sim: &Simulation) {
        match &self.bar {
            Some(bar) => bar.set_position(sim.state.step),
            None if tenth(sim) > self.told => {
                self.told = tenth(sim);
                let row = &sim.row;
                eprintln!(
                    "step {} of {}, t = {:.4e} s, {} bonds broken",
                    sim.state.step, sim.steps, sim.state.time, row.broken
                );
            }
            None => {}
        }
        self.files.step(sim);
    }

    fn row(&mut self, sim: &Simulation, row: &Row) -> Result<(), String> {
        if let Some(bar) = &self.bar {
            bar.set_message(format!("t = {:.4e} s, {} bonds broken", row.time, row.broken));
        }
        self.files.row(sim, row)
    }

    fn fields(&mut self, sim: &mut Simulation) -> Result<(), String> {
        self.files.fields(sim)
    }

    fn pictures(&mut self, sim: &mut Simulation) -> Result<(), String> {
        self.files.pictures(sim)
    }

    fn checkpoint(&mut self, sim: &Simulation) -> Result<Option<PathBuf>, String> {
        self.files.checkpoint(sim)
    }

    fn finish(&mut self, sim: &Simulation, summary: &Summary) -> Result<(), String> {
        self.close();
        self.files.finish(sim, summary)
    }

    fn stopped(&mut self, sim: &Simulation, why: &Stopped) {
        self.close();
        self.files.stopped(sim, why);
    }
}

fn tenth(sim: &Simulation) -> u64 {
    10 * sim.state.step / sim.steps.max(1)
}
