//! The observer that writes into a directory:
//! `history.csv`, `fields.pvd` with `fields/*.vtu`, `pictures/*.png`, `checkpoints/*.ckpt`, `summary.json`.

use super::history::History;
use super::{Observer, Row, Summary, Values, picture, quantity, vtu};
use crate::checkpoint;
use crate::simulate::{Simulation, Stopped};
use std::path::{Path, PathBuf};

/// Writes a run's outputs. Anything that shows progress can be put beside it with [`Files::with`].
pub struct Files {
    dir: PathBuf,
    history: Option<History>,
    frames: Vec<(f64, String)>,
    beside: Option<Box<dyn Observer>>,
}

impl Files {
    pub fn new(dir: impl Into<PathBuf>) -> Files {
        Files {
            dir: dir.into(),
            history: None,
            frames: Vec::new(),
            beside: None,
        }
    }

    /// Another observer that sees everything first.
    pub fn with(mut self, observer: Box<dyn Observer>) -> Files {
        self.beside = Some(observer);
        self
    }

    fn place(&self, folder: &str, file: &str) -> Result<PathBuf, String> {
        let dir = self.dir.join(folder);
        std::fs::create_dir_all(&dir).map_err(|e| cannot(&dir, &e))?;
        Ok(dir.join(file))
    }

    fn summarise(&self, summary: &Summary) -> Result<(), String> {
        let path = self.place("", "summary.json")?;
        let text = serde_json::to_string_pretty(summary).map_err(|e| cannot(&path, &e))?;
        checkpoint::replace(&path, (text + "\n").as_bytes()).map_err(|e| cannot(&path, &e))
    }

    fn beside(
        &mut self,
        mut act: impl FnMut(&mut dyn Observer) -> Result<(), String>,
    ) -> Result<(), String> {
        match self.beside.as_deref_mut() {
            Some(observer) => act(observer),
            None => Ok(()),
        }
    }
}

fn cannot(path: &Path, error: &dyn std::fmt::Display) -> String {
    format!("cannot write {}: {error}", path.display())
}

impl Observer for Files {
    fn start(&mut self, sim: &mut Simulation) -> Result<(), String> {
        self.beside(|o| o.start(sim))?;
        let path = self.place("", "history.csv")?;
        if sim.outputs.history != super::Schedule::Never {
            let columns = Row::columns_of(sim);
            let history = History::create(&path, &columns, sim.state.step);
            self.history = Some(history.map_err(|e| cannot(&path, &e))?);
        }
        if sim.state.step > 0 {
            self.frames = vtu::frames_before(&self.dir.join("fields.pvd"), sim.state.time);
        }
        Ok(())
    }

    fn step(&mut self, sim: &Simulation) {
        if let Some(o) = self.beside.as_deref_mut() {
            o.step(sim);
        }
    }

    fn row(&mut self, sim: &Simulation, row: &Row) -> Result<(), String> {
        self.beside(|o| o.row(sim, row))?;
        let path = self.dir.join("history.csv");
        self.history
            .as_mut()
            .map_or(Ok(()), |h| h.write(row))
            .map_err(|e| cannot(&path, &e))
    }

    fn fields(&mut self, sim: &mut Simulation) -> Result<(), String> {
        self.beside(|o| o.fields(sim))?;
        let file = format!("fields-{:09}.vtu", sim.state.step);
        let path = self.place("fields", &file)?;
        let names = sim.outputs.quantities.clone();
        let values: Vec<Values> = names
            .iter()
            .map(|n| quantity(sim, n))
            .collect::<Result<_, _>>()
            .map_err(|e| e.to_string())?;
        vtu::write(&path, sim.state.time, &sim.body.x, &values).map_err(|e| cannot(&path, &e))?;
        self.frames.push((sim.state.time, format!("fields/{file}")));
        let path = self.dir.join("fields.pvd");
        vtu::series(&path, &self.frames).map_err(|e| cannot(&path, &e))
    }

    fn pictures(&mut self, sim: &mut Simulation) -> Result<(), String> {
        self.beside(|o| o.pictures(sim))?;
        for view in sim.outputs.views.clone() {
            let path = self.place(
                "pictures",
                &format!("{}-{:09}.png", view.name, sim.state.step),
            )?;
            let image = picture::draw(sim, &view).map_err(|e| e.to_string())?;
            image.save(&path).map_err(|e| cannot(&path, &e))?;
        }
        Ok(())
    }

    fn checkpoint(&mut self, sim: &Simulation) -> Result<Option<PathBuf>, String> {
        let path = self.place("checkpoints", &format!("step-{:09}.ckpt", sim.state.step))?;
        checkpoint::write(&path, sim.identity, &sim.snapshot()).map_err(|e| cannot(&path, &e))?;
        Ok(Some(path))
    }

    fn finish(&mut self, sim: &Simulation, summary: &Summary) -> Result<(), String> {
        self.beside(|o| o.finish(sim, summary))?;
        self.summarise(summary)
    }

    fn stopped(&mut self, sim: &Simulation, why: &Stopped, summary: &Summary) {
        if let Some(o) = self.beside.as_deref_mut() {
            o.stopped(sim, why, summary);
        }
        // The reason has been given to the caller; a summary that cannot be written must not hide it.
        let _ = self.summarise(summary);
    }
}
