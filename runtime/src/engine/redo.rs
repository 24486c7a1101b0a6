//! After bonds have broken: what depends on families is made right again, where it changed.
//!
//! A sweep that breaks bonds has used family-stage values (a weighted volume, say) of the families as they were.
//! For the chunks that changed, and for those that read changed values at the other end of a bond, the family
//! stage and the step sweeps up to the breaking one run again, this time with bonds held.
use super::program::Program;
use super::{Engine, State};
use crate::spec::Stage;
use crate::traverse::CHUNK;

/// Work space and what can be known in advance.
#[derive(Debug)]
pub(super) struct Redo {
    /// Family-stage or earlier step sweeps exist.
    needed: bool,
    rewritten: Vec<bool>,
    dirty: Vec<bool>,
    list: Vec<u32>,
}

impl Redo {
    pub fn new(programs: &[Program], slots: usize, chunks: usize) -> Redo {
        let killer = programs.iter().rposition(|p| p.kills);
        let before = |p: &Program| matches!(p.stage, Stage::Family | Stage::Step);
        let needed = killer.is_some_and(|k| programs[..k].iter().any(before));
        Redo {
            needed,
            rewritten: vec![false; slots],
            dirty: vec![false; chunks],
            list: Vec::with_capacity(chunks),
        }
    }
}

impl Engine {
    /// Brings what was derived from the families up to date with the bonds of `s`.
    pub(super) fn family_stage(&mut self, s: &State) {
        if self
            .bonds
            .iter()
            .zip(&s.families)
            .all(|(b, f)| b.stamp == f.stamp)
        {
            return;
        }
        self.refresh_whole(s);
        self.run_stage(Stage::Family, s);
    }

    pub(super) fn refresh_whole(&mut self, s: &State) {
        for f in 0..self.families.len() {
            for chunk in 0..self.layout.chunks() {
                let reference = self.is_whole(f, chunk, &self.families[f].present);
                let intact = reference && self.is_whole(f, chunk, &s.families[f].intact);
                self.bonds[f].whole_reference[chunk] = reference as u8;
                self.bonds[f].whole_intact[chunk] = intact as u8;
            }
            self.bonds[f].unbroken = self.families[f].present == s.families[f].intact;
            self.bonds[f].stamp = s.families[f].stamp;
        }
    }

    fn is_whole(&self, f: usize, chunk: usize, bits: &[u8]) -> bool {
        self.layout.nodes[chunk] == 0xFF
            && bits[self.families[f].rows(chunk)]
                .iter()
                .all(|&b| b == 0xFF)
    }

    /// Counts what sweep `k` broke and repairs what was derived from it.
    pub(super) fn after_breaking(&mut self, k: usize, s: &mut State) -> usize {
        let family = self.programs[k].family;
        let mut total = 0;
        self.redo.list.clear();
        for (chunk, broken) in self.broken.iter_mut().enumerate() {
            if *broken > 0 {
                total += *broken as usize;
                *broken = 0;
                self.redo.list.push(chunk as u32);
                self.bonds[family].whole_intact[chunk] = 0;
            }
        }
        if total > 0 {
            s.families[family].touch();
            self.bonds[family].stamp = s.families[family].stamp;
            if self.redo.needed {
                self.repeat(k, s);
            }
            let list = std::mem::take(&mut self.redo.list);
            self.wake(&list);
            self.redo.list = list;
        }
        total
    }

    /// Repeats family sweeps and, for bonds that break before the force, step sweeps up to `killer`.
    fn repeat(&mut self, killer: usize, s: &State) {
        self.redo.rewritten.fill(false);
        self.redo.dirty.fill(false);
        for n in 0..self.redo.list.len() {
            self.redo.dirty[self.redo.list[n] as usize] = true;
        }
        for k in 0..=killer {
            let stage = self.programs[k].stage;
            let repeats = stage == Stage::Family
                || stage == Stage::Step && !self.programs[killer].kills_after;
            if !repeats || self.programs[k].unread || !self.is_stale(k, killer) {
                continue;
            }
            if self.programs[k]
                .nbr
                .iter()
                .any(|&slot| self.redo.rewritten[slot])
            {
                self.grow();
            }
            let list = std::mem::take(&mut self.redo.list);
            self.run_some(k, s, &list);
            self.redo.list = list;
            for n in 0..self.programs[k].out.len() {
                self.redo.rewritten[self.programs[k].out[n]] = true;
            }
        }
    }

    /// True if the broken bonds change what sweep `k` computes. The breaking sweep itself has not counted them.
    fn is_stale(&self, k: usize, killer: usize) -> bool {
        let p = &self.programs[k];
        let reads = p
            .own
            .iter()
            .chain(&p.nbr)
            .any(|&slot| self.redo.rewritten[slot]);
        let sums =
            k != killer && !p.reference && p.family == self.programs[killer].family && p.loops;
        reads || sums
    }

    /// Adds the chunks of all neighbours. The whole horizon is symmetric: who reads me is whom I read.
    fn grow(&mut self) {
        let family = &self.families[0];
        let redo = &mut self.redo;
        for n in 0..redo.list.len() {
            let chunk = redo.list[n] as usize;
            for row in family.rows(chunk) {
                for lane in 0..CHUNK {
                    if family.present[row] >> lane & 1 == 0 {
                        continue;
                    }
                    let (other, _) =
                        self.layout
                            .place(family.other(&self.layout, chunk, row, lane));
                    if !std::mem::replace(&mut redo.dirty[other], true) {
                        redo.list.push(other as u32);
                    }
                }
            }
        }
    }
}
