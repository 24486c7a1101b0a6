//! Chunks asleep: what a sweep computes from the same bits is not computed again.
//!
//! The output of a sweep on a chunk is a function of its inputs: state at its nodes and at the other ends of their
//! bonds, bonds, histories, what earlier sweeps wrote. A chunk is *stirred* when its own state, bonds or histories
//! differ in a bit from those that the sweeps have seen, and stays so. Its *level* is the number of bonds to the
//! nearest stirred chunk; a sweep whose inputs lie up to `r` bonds away runs on the chunks of levels up to `r`, and on
//! all others its last output holds. Nothing here knows a law, and nobody has to say what was changed: every evaluation
//! compares the sleeping part of the state with what it was. When all is awake the comparison ends for good.
use super::program::Program;
use super::{Engine, Home, State};
use crate::layout::{Family, Layout};
use crate::spec::{SlotKind, Spec, Stage};
use crate::traverse::CHUNK;
use rayon::prelude::*;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Levels: never reached, and just found to differ.
const ASLEEP: u8 = u8::MAX;
const FOUND: u8 = u8::MAX - 1;
/// Chunks of a stretch at most, so that threads share them.
const STRETCH: usize = 64;
/// Where more than this part of all chunks stirs at once, the body moves as a whole.
const AT_ONCE: f64 = 0.5;

/// What a sweep has been run for on all chunks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Known {
    No,
    Held,
    Armed,
}

/// What the sweeps have seen.
#[derive(Debug)]
struct Seen {
    values: Vec<Vec<f64>>,
    dt: f64,
    /// Which histories, per family.
    memory: Vec<u64>,
    /// Whether the records of a cloud hold these displacements, or numbers in single precision this state.
    packed: bool,
}

/// Which chunks sleep.
#[derive(Debug)]
pub(super) struct Sleep {
    on: bool,
    /// Per sweep how many bonds away its inputs lie; `None`: it always runs on all chunks.
    rings: Vec<Option<u8>>,
    most: u8,
    /// State that some of these sweeps read.
    inputs: Vec<Home>,
    reads_dt: bool,
    seen: Option<Seen>,
    known: Vec<Known>,
    /// Whether the last run of a sweep was one on all chunks.
    whole: Vec<bool>,
    levels: Vec<u8>,
    /// Per level `r` the stretches of chunks of levels up to `r`.
    awake: Vec<Vec<Range<usize>>>,
    queue: Vec<u32>,
    /// Sweeps of the step stage times chunks: all, and those that were left out.
    pub all: u64,
    pub left_out: u64,
}

impl Sleep {
    pub fn new(spec: &Spec, programs: &[Program], homes: &[Home]) -> Sleep {
        let rings = rings(spec, programs);
        let covered = || programs.iter().zip(&rings).filter(|(_, r)| r.is_some());
        let slots = || covered().flat_map(|(p, _)| p.own.iter().chain(&p.nbr));
        let mut inputs: Vec<Home> = (0..spec.dim).map(Home::Displacement).collect();
        for &slot in slots() {
            let home = homes[slot];
            let is_state = matches!(home, Home::Velocity(_) | Home::State(_));
            if is_state && !inputs.contains(&home) {
                inputs.push(home);
            }
        }
        Sleep {
            on: false,
            most: rings.iter().flatten().copied().max().unwrap_or(0),
            inputs,
            reads_dt: slots().any(|&k| spec.slots[k].kind == SlotKind::TimeStep),
            seen: None,
            known: vec![Known::No; programs.len()],
            whole: vec![true; programs.len()],
            levels: vec![],
            awake: vec![],
            queue: vec![],
            rings,
            all: 0,
            left_out: 0,
        }
    }

    /// Whatever was seen no longer counts.
    pub fn forget(&mut self) {
        self.seen = None;
    }

    /// The stretches that sweep `k` has to run on; `None`: all chunks.
    pub fn stretches(&self, k: usize, armed: bool) -> Option<&[Range<usize>]> {
        let ring = self.rings[k]?;
        let enough = self.known[k] >= if armed { Known::Armed } else { Known::Held };
        (self.seen.is_some() && enough).then(|| &self.awake[ring as usize][..])
    }

    /// Sweep `k` has run where it had to. When that was everywhere, what later sweeps made of it is no longer known.
    pub fn ran(&mut self, k: usize, armed: bool) {
        self.whole[k] = self.stretches(k, armed).is_none();
        if self.whole[k] && self.rings[k].is_some() {
            self.known[k] = if armed { Known::Armed } else { Known::Held };
            self.known[k + 1..].fill(Known::No);
        }
    }

    /// The chunks of the last run of sweep `k`, which has just ended; `None`: all.
    pub fn of_last_run(&self, k: usize) -> Option<&[Range<usize>]> {
        let ring = self.rings[k].filter(|_| !self.whole[k])?;
        Some(&self.awake[ring as usize])
    }

    /// Counts what a sweep over so many chunks leaves out.
    pub fn count(&mut self, k: usize, armed: bool, chunks: usize) {
        let awake = self.stretches(k, armed);
        let run = awake.map_or(chunks, |s| s.iter().map(Range::len).sum());
        self.all += chunks as u64;
        self.left_out += (chunks - run) as u64;
    }

    /// For so many slots, while chunks may sleep.
    pub fn bytes(&self, slots: usize) -> usize {
        let each = 8 * self.inputs.len() * slots + slots / CHUNK;
        if self.on { each } else { 0 }
    }

    /// The chunks whose state has changed, when all others were packed before.
    pub fn to_pack(&self) -> Option<&[Range<usize>]> {
        let packed = self.seen.as_ref().is_some_and(|seen| seen.packed);
        packed.then(|| &self.awake[0][..])
    }

    pub fn packed(&mut self) {
        if let Some(seen) = &mut self.seen {
            seen.packed = true;
        }
    }

    fn end(&mut self) {
        self.on = false;
        self.seen = None;
        (self.levels, self.awake, self.queue) = (vec![], vec![], vec![]);
    }

    fn list(&mut self) {
        for (ring, awake) in self.awake.iter_mut().enumerate() {
            awake.clear();
            let mut from = 0;
            while from < self.levels.len() {
                let runs = |level: &u8| *level as usize <= ring;
                let end = self.levels[from..].iter().take(STRETCH);
                let end = from + end.take_while(|level| runs(level)).count();
                if end > from {
                    awake.push(from..end);
                }
                from = end.max(from + 1);
            }
        }
    }
}

/// How many bonds away the inputs of every sweep lie that asks for nothing but the state. Families change in stirred
/// chunks only, and what is derived from them as well.
fn rings(spec: &Spec, programs: &[Program]) -> Vec<Option<u8>> {
    let mut of_slot = vec![0u8; spec.slots.len()];
    let mut written = vec![false; spec.slots.len()];
    let mut rings = vec![];
    for p in programs {
        let covered = matches!(p.stage, Stage::Step | Stage::Energy | Stage::Update);
        let own = p.own.iter().map(|&k| of_slot[k]);
        let nbr = p.nbr.iter().map(|&k| of_slot[k].saturating_add(1));
        let ring = own.chain(nbr).fold(u8::from(p.loops), u8::max);
        for &k in &p.out {
            // Two sweeps that write one slot would have to take turns.
            if std::mem::replace(&mut written[k], true) && covered || ring >= FOUND {
                return vec![None; programs.len()];
            }
            of_slot[k] = ring;
        }
        rings.push(covered.then_some(ring));
    }
    rings
}

impl Engine {
    /// Whether chunks in which nothing changes are left out of sweeps. The results have the same bits.
    pub fn sleep(&mut self, on: bool) {
        self.sleep.end();
        self.sleep.on = on && self.can_sleep();
    }

    /// Whether the sweeps of the law allow that.
    pub fn can_sleep(&self) -> bool {
        self.convolution.is_none() && self.sleep.rings.iter().any(Option::is_some)
    }

    /// Whether chunks may be asleep now.
    pub fn sleeps(&self) -> bool {
        self.sleep.on
    }

    /// The part of all force evaluations so far that was left out because nothing had changed.
    pub fn slept(&self) -> f64 {
        self.sleep.left_out as f64 / self.sleep.all.max(1) as f64
    }

    /// Finds what has changed since the sweeps last saw it.
    pub(super) fn stir(&mut self, s: &State) {
        if !self.sleep.on {
            return;
        }
        let memory = s.families.iter().map(|f| f.memory);
        let same = self.sleep.seen.as_ref().is_some_and(|seen| {
            (!self.sleep.reads_dt || seen.dt.to_bits() == s.dt.to_bits())
                && memory.clone().eq(seen.memory.iter().copied())
        });
        let same_bonds = || (self.bonds.iter().zip(&s.families)).all(|(b, f)| b.stamp == f.stamp);
        if !same || !same_bonds() {
            let input = |home: &Home| input(s, *home).to_vec();
            self.sleep.seen = Some(Seen {
                values: self.sleep.inputs.iter().map(input).collect(),
                dt: s.dt,
                memory: memory.collect(),
                packed: false,
            });
            self.sleep.known.fill(Known::No);
            self.sleep.levels = vec![ASLEEP; self.layout.chunks()];
            self.sleep.awake = vec![vec![]; self.sleep.most as usize + 1];
            return;
        }
        if self.find(s) {
            let levels = self.sleep.levels.iter_mut().enumerate();
            let found = levels.filter(|(_, level)| **level == FOUND);
            self.sleep.queue.extend(found.map(|(chunk, level)| {
                *level = 0;
                chunk as u32
            }));
            self.settle_levels();
        }
    }

    /// Marks the chunks that differ from what was seen; whether there are any.
    fn find(&mut self, s: &State) -> bool {
        let mut levels = std::mem::take(&mut self.sleep.levels);
        let any = AtomicBool::new(false);
        let block = |(b, levels): (usize, &mut [u8])| {
            for (k, level) in levels.iter_mut().enumerate() {
                if *level != 0 && self.differs(s, b * 512 + k) {
                    *level = FOUND;
                    any.store(true, Ordering::Relaxed);
                }
            }
        };
        if levels.len() > 512 && rayon::current_num_threads() > 1 {
            levels.par_chunks_mut(512).enumerate().for_each(block);
        } else {
            levels.chunks_mut(512).enumerate().for_each(block);
        }
        self.sleep.levels = levels;
        any.into_inner()
    }

    fn differs(&self, s: &State, chunk: usize) -> bool {
        let Some(seen) = &self.sleep.seen else {
            return true;
        };
        let base = self.layout.base[chunk] as usize;
        let mut inputs = self.sleep.inputs.iter().zip(&seen.values);
        inputs.any(|(home, seen)| {
            let at = match *home {
                Home::State(k) => self.index(k, base),
                _ => Some(base),
            };
            let now = input(s, *home);
            at.is_some_and(|at| {
                let pairs = now[at..at + CHUNK].iter().zip(&seen[at..at + CHUNK]);
                pairs.fold(0, |bits, (a, b)| bits | (a.to_bits() ^ b.to_bits())) != 0
            })
        })
    }

    /// Wakes chunks whose bonds have changed.
    pub(super) fn wake(&mut self, chunks: &[u32]) {
        if self.sleep.seen.is_none() {
            return;
        }
        for &chunk in chunks {
            let level = &mut self.sleep.levels[chunk as usize];
            if std::mem::replace(level, 0) != 0 {
                self.sleep.queue.push(chunk);
            }
        }
        self.settle_levels();
    }

    /// After an update: chunks whose histories it changed are awake from now on. Everywhere else both buffers hold the
    /// same, also where it did not run, and may be swapped.
    pub(super) fn wake_by_histories(&mut self, s: &State) {
        if self.sleep.seen.is_none() {
            return;
        }
        let mut changed = vec![];
        for (k, p) in self.programs.iter().enumerate() {
            let Some(ring) = self.sleep.rings[k].filter(|_| p.stage == Stage::Update) else {
                continue;
            };
            let ran = if self.sleep.whole[k] { ASLEEP } else { ring };
            let (family, next) = (&self.families[p.family], &self.bonds[p.family].next);
            for (&h, _) in p.history.iter().zip(&p.writes).filter(|w| *w.1) {
                let (old, new) = (&s.families[p.family].history[h], &next[h]);
                let differs = |chunk: &u32| {
                    let rows = family.rows(*chunk as usize);
                    let cells = rows.start * CHUNK..rows.end * CHUNK;
                    let mut pairs = old[cells.clone()].iter().zip(&new[cells]);
                    pairs.any(|(a, b)| a.to_bits() != b.to_bits())
                };
                let chunks = 0..self.layout.chunks() as u32;
                let around = chunks.filter(|c| (1..=ran).contains(&self.sleep.levels[*c as usize]));
                changed.extend(around.filter(differs));
            }
        }
        self.wake(&changed);
    }

    /// Histories were swapped: what the engine has seen is what the state now has.
    pub(super) fn remember(&mut self, s: &mut State) {
        for (family, state) in s.families.iter_mut().enumerate() {
            if state.history.is_empty() {
                continue;
            }
            state.remember();
            if let Some(seen) = &mut self.sleep.seen {
                seen.memory[family] = state.memory;
            }
        }
    }

    /// Levels of what lies around the stirred chunks of the queue, and the stretches.
    fn settle_levels(&mut self) {
        let sleep = &mut self.sleep;
        if sleep.queue.is_empty() {
            return;
        }
        let at_once = sleep.queue.len() as f64 > AT_ONCE * sleep.levels.len() as f64;
        if !at_once {
            let mut next = 0;
            while let Some(&chunk) = sleep.queue.get(next) {
                let level = sleep.levels[chunk as usize] + 1;
                if level <= sleep.most {
                    let (levels, queue) = (&mut sleep.levels, &mut sleep.queue);
                    around(&self.families[0], &self.layout, chunk as usize, |other| {
                        if levels[other] > level {
                            levels[other] = level;
                            queue.push(other as u32);
                        }
                    });
                }
                next += 1;
            }
            sleep.queue.clear();
        }
        // Loops over bonds have inputs at least one bond away.
        if at_once || sleep.levels.iter().all(|level| *level <= sleep.most.min(1)) {
            sleep.end();
        } else {
            sleep.list();
        }
    }
}

/// Chunks at the other ends of the bonds of a chunk; the whole horizon is symmetric: who reads me is whom I read.
fn around(family: &Family, layout: &Layout, chunk: usize, mut visit: impl FnMut(usize)) {
    family.for_each(layout, chunk, |m| visit(layout.place(m.other).0));
}

fn input(s: &State, home: Home) -> &[f64] {
    match home {
        Home::Displacement(a) => &s.u[a],
        Home::Velocity(a) => &s.v[a],
        Home::State(k) => &s.slots[k],
        Home::Position(_) | Home::Array(_) => &[],
    }
}
