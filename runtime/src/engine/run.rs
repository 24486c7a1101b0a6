//! Running sweeps: addresses into a call, chunks over threads.
use super::geometry::Geometry;
use super::{Engine, Home, State};
use crate::kernel::Run;
use crate::lane::Record;
use crate::layout::Shape;
use crate::spec::{SlotKind, Stage};
use crate::traverse::{CHUNK, Call, MAX_GEOMETRY, MAX_HISTORIES, MAX_RECORDS, MAX_SLOTS, Stream};
use rayon::prelude::*;
use std::ops::Range;
use std::ptr::{null, null_mut};
use std::sync::Arc;

/// Rows of a task: tens of microseconds, so that handing it out costs nothing.
const ROWS_PER_TASK: usize = 8192;
const ALL: u8 = 0xFF;
const NOTHING: u8 = 0;

impl Engine {
    pub(super) fn run_stage(&mut self, stage: Stage, s: &State) {
        for k in 0..self.programs.len() {
            if self.programs[k].stage == stage && !self.programs[k].unread {
                self.run_all(k, s);
            }
        }
    }

    /// A pure run over the whole body.
    pub(super) fn run_all(&mut self, k: usize, s: &State) {
        if self.convolve(k, s) {
            return;
        }
        let call = self.call(k, s);
        let (p, bonds) = (&self.programs[k], &self.bonds[self.programs[k].family]);
        let whole = if p.reference {
            &bonds.whole_reference
        } else {
            &bonds.whole_intact
        };
        self.over_chunks(k, &call, whole, false);
        self.sleep.ran(k, false);
        self.refresh_outputs(k);
    }

    /// A run that breaks bonds: always with masks.
    pub(super) fn run_armed(&mut self, k: usize, s: &mut State) {
        let mut call = self.call(k, s);
        let family = self.programs[k].family;
        let bonds = &self.bonds[family];
        if bonds.armed.is_empty() {
            call.armed = &ALL;
        } else {
            (call.armed, call.armed_step) = (bonds.armed.as_ptr(), 1);
        }
        call.broken = self.broken.as_mut_ptr();
        call.bits = Arc::make_mut(&mut s.families[family].intact).as_mut_ptr();
        self.over_chunks(k, &call, &[], true);
        self.sleep.ran(k, true);
        self.refresh_outputs(k);
    }

    /// A pure run over some chunks.
    pub(super) fn run_some(&mut self, k: usize, s: &State, chunks: &[u32]) {
        let call = self.call(k, s);
        let (this, p) = (&*self, &self.programs[k]);
        // SAFETY: as in `over_chunks`.
        let one =
            |&c: &u32| unsafe { this.run_chunks(p, &call, &[], (c as usize, c as usize + 1)) };
        if chunks.len() >= 256 && rayon::current_num_threads() > 1 {
            chunks.par_iter().with_min_len(64).for_each(one);
        } else {
            chunks.iter().for_each(one);
        }
        self.refresh_ghosts_of_outputs(k);
        self.round_outputs(k, Some(chunks));
    }

    /// `whole`: one byte per chunk, 1 where the instance without masks may run; empty: nowhere.
    fn over_chunks(&self, k: usize, call: &Call, whole: &[u8], armed: bool) {
        let (p, chunks) = (&self.programs[k], self.layout.chunks());
        let rows = self.families[p.family].present.len() / chunks.max(1);
        let grain = (ROWS_PER_TASK / (rows + 8)).clamp(1, 512);
        let tasks = chunks.div_ceil(grain);
        if let Some(awake) = self.sleep.stretches(k, armed) {
            // SAFETY: as below.
            let one = |r: &Range<usize>| unsafe {
                self.run_chunks(p, call, whole, (r.start, r.end));
            };
            if awake.len() > 1 && rayon::current_num_threads() > 1 {
                awake.par_iter().for_each(one);
            } else {
                awake.iter().for_each(one);
            }
            return;
        }
        // SAFETY: the instances were chosen for this processor and this traversal.
        let task = |t: usize| unsafe {
            let from = t * grain;
            self.run_chunks(p, call, whole, (from, (from + grain).min(chunks)))
        };
        if tasks > 1 && rayon::current_num_threads() > 1 {
            (0..tasks).into_par_iter().for_each(task);
        } else {
            (0..tasks).for_each(task);
        }
    }

    /// What a sweep reads and writes.
    pub(super) fn call(&mut self, k: usize, s: &State) -> Call {
        self.round_state(k, s);
        let p = &self.programs[k];
        let (family, bonds) = (&self.families[p.family], &self.bonds[p.family]);
        let state = &s.families[p.family];
        let mut call = Call {
            u: [null(); 3],
            u_records: self.u_records.as_ptr(),
            x_records: self.x_records.as_ptr(),
            own: [null(); MAX_SLOTS],
            nbr: [null(); MAX_SLOTS],
            nbr_records: [null(); MAX_RECORDS],
            out: [null_mut(); MAX_SLOTS],
            constants: self.constants.as_ptr(),
            constants_at: self.constants_at.as_ptr(),
            base: self.layout.base.as_ptr(),
            nodes: self.layout.nodes.as_ptr(),
            first: family.first.as_ptr(),
            last: if p.loops {
                family.last.as_ptr()
            } else {
                family.first.as_ptr()
            },
            // Never written in a pure run: nothing is armed.
            bits: if p.reference {
                family.present.as_ptr()
            } else {
                state.intact.as_ptr()
            }
            .cast_mut(),
            armed: &NOTHING,
            armed_step: 0,
            broken: null_mut(),
            pattern: null(),
            records: null(),
            index: null(),
            index_at: null(),
            x: std::array::from_fn(|a| self.layout.x[a].as_ptr()),
            streams: [Stream::NONE; MAX_GEOMETRY],
            history: [null(); MAX_HISTORIES],
            next: [null_mut(); MAX_HISTORIES],
            reverse: bonds.reverse.as_ptr(),
            tape: &*p.tape,
            packs: &[],
        };
        for a in 0..self.spec.dim {
            call.u[a] = s.u[a].as_ptr();
        }
        for (to, &slot) in call.own.iter_mut().zip(&p.own) {
            *to = self.values(slot, s);
        }
        for (to, &slot) in call.nbr.iter_mut().zip(&p.nbr) {
            *to = self.values(slot, s);
        }
        for (k, &h) in p.history.iter().enumerate() {
            call.history[k] = match h.checked_sub(bonds.initial.len()) {
                None => state.history[h].as_ptr(),
                Some(weight) => bonds.weights[weight].as_ptr(),
            };
        }
        self.point_to_geometry(k, &mut call);
        self.point_to_outputs(k, &mut call);
        self.point_to_records(k, &mut call);
        self.point_to_rounded(k, &mut call);
        call
    }

    fn values(&self, slot: usize, s: &State) -> *const f64 {
        self.read(self.homes[slot], s).as_ptr()
    }

    pub(super) fn read<'a>(&'a self, home: Home, s: &'a State) -> &'a [f64] {
        match home {
            Home::Displacement(a) => &s.u[a],
            Home::Velocity(a) => &s.v[a],
            Home::Position(a) => &self.layout.x[a],
            Home::State(k) => &s.slots[k],
            Home::Array(k) => &self.arrays[k],
        }
    }

    fn point_to_geometry(&self, k: usize, call: &mut Call) {
        match &self.geometry[k] {
            Geometry::Table { records, .. } => call.records = records.as_ptr().cast(),
            Geometry::Streams(streams) => {
                for (to, &s) in call.streams.iter_mut().zip(streams) {
                    *to = self.streams[s].call();
                }
            }
        }
        match &self.families[self.programs[k].family].shape {
            Shape::Stencil(s) => call.pattern = s.pattern.as_ptr(),
            Shape::List(list) => {
                call.index = list.index.as_ptr();
                call.index_at = list.at.as_ptr();
            }
        }
    }

    fn point_to_outputs(&mut self, k: usize, call: &mut Call) {
        let p = &self.programs[k];
        for (to, &slot) in call.out.iter_mut().zip(&p.out) {
            if let Home::Array(a) = self.homes[slot] {
                *to = self.arrays[a].as_mut_ptr();
            }
        }
        for (k, &h) in p.history.iter().enumerate() {
            // Of a weight that is known there is no next value.
            let next = self.bonds[p.family].next.get_mut(h);
            call.next[k] = next.map_or(null_mut(), |next| next.as_mut_ptr());
        }
    }

    /// Ghosts of what a sweep wrote, where another sweep reads them.
    pub(super) fn refresh_outputs(&mut self, k: usize) {
        self.refresh_ghosts_of_outputs(k);
        self.round_outputs(k, None);
    }

    fn refresh_ghosts_of_outputs(&mut self, k: usize) {
        if self.layout.ghosts.to.is_empty() {
            return;
        }
        for n in 0..self.programs[k].out.len() {
            let slot = self.programs[k].out[n];
            if let (true, Home::Array(a)) = (self.reads_ghosts[slot], self.homes[slot]) {
                self.layout.ghosts.refresh(&mut self.arrays[a]);
            }
        }
        self.lay_out_ghosts(k);
    }

    /// Ghosts of the state.
    pub(super) fn refresh_state(&self, s: &mut State) {
        if self.layout.ghosts.to.is_empty() {
            return;
        }
        // What is stored on a part of the body is read at the node alone.
        let slots = s.slots.iter_mut().enumerate();
        let slots = slots.filter(|(k, _)| self.parts.of_state(*k).is_none());
        let slots = slots.map(|(_, values)| values);
        for values in s.u.iter_mut().chain(&mut s.v).chain(slots) {
            self.layout.ghosts.refresh(values);
        }
    }

    /// What has changed is found; the time step becomes a node slot, displacements are made as the cloud traversal reads them.
    pub(super) fn pack(&mut self, s: &State) {
        self.stir(s);
        if let Some(convolution) = &mut self.convolution {
            convolution.forget();
        }
        for (slot, home) in self.spec.slots.iter().zip(&self.homes) {
            if let (SlotKind::TimeStep, Home::Array(a)) = (slot.kind, home)
                && self.arrays[*a].first() != Some(&s.dt)
            {
                self.arrays[*a].fill(s.dt);
            }
        }
        if self.lattice {
            return self.forget_rounded();
        }
        let (u, listed) = (&s.u, &self.listed);
        let one = |slot: usize, r: &mut Record| {
            for (to, u) in r.0.iter_mut().zip(u) {
                *to = u[slot];
            }
        };
        if let Some(awake) = self.sleep.to_pack() {
            let slots = self.layout.slots_of(awake.iter().cloned().flatten());
            let read = slots.filter(|slot| listed[slot / CHUNK]);
            read.for_each(|slot| one(slot, &mut self.u_records[slot]));
            return;
        }
        self.sleep.packed();
        let eight = |(k, records): (usize, &mut [Record])| {
            if listed[k] {
                let slots = (k * CHUNK..).zip(records);
                slots.for_each(|(slot, record)| one(slot, record));
            }
        };
        if rayon::current_num_threads() > 1 {
            let parts = self.u_records.par_chunks_mut(CHUNK).enumerate();
            parts.with_min_len(512).for_each(eight);
        } else {
            let parts = self.u_records.chunks_mut(CHUNK).enumerate();
            parts.for_each(eight);
        }
    }

    /// Runs what is known before anything moves. A weight that a sweep wrote is there for the next one.
    pub(super) fn reference_stage(&mut self, rest: &State, without: &[String]) {
        for (f, bonds) in self.bonds.iter_mut().enumerate() {
            let ones = vec![1.0; super::history_len(&self.families[f])];
            bonds
                .next
                .resize(bonds.initial.len() + bonds.weights.len(), ones);
        }
        for k in 0..self.programs.len() {
            if self.programs[k].stage != Stage::Reference {
                continue;
            }
            self.run_all(k, rest);
            let p = &self.programs[k];
            let bonds = &mut self.bonds[p.family];
            for (&h, _) in p.history.iter().zip(&p.writes).filter(|w| *w.1) {
                let weight = h - bonds.initial.len();
                let of_family = self.spec.weights.iter();
                let mut of_family = of_family.filter(|w| w.family as usize == p.family);
                if of_family
                    .nth(weight)
                    .is_some_and(|w| !without.contains(&w.name))
                {
                    std::mem::swap(&mut bonds.weights[weight], &mut bonds.next[h]);
                }
            }
        }
        for bonds in &mut self.bonds {
            bonds.next.truncate(bonds.initial.len());
        }
    }

    /// What update sweeps wrote becomes the committed value.
    pub(super) fn swap_histories(&mut self, s: &mut State) {
        for p in self.programs.iter().filter(|p| p.stage == Stage::Update) {
            for (&h, _) in p.history.iter().zip(&p.writes).filter(|w| *w.1) {
                std::mem::swap(
                    &mut s.families[p.family].history[h],
                    &mut self.bonds[p.family].next[h],
                );
            }
        }
        self.remember(s);
        for h in &self.spec.histories {
            let Some((committed, next)) = h.slot else {
                continue;
            };
            if let (Home::State(k), Home::Array(a)) =
                (self.homes[committed as usize], self.homes[next as usize])
            {
                s.slots[k].copy_from_slice(&self.arrays[a]);
            }
        }
    }

    /// What the law puts in the place of the velocity. Padding is left alone.
    pub(super) fn replace_velocities(&self, s: &mut State) {
        for (v, &slot) in s.v.iter_mut().zip(&self.spec.after_step) {
            if let Home::Array(a) = self.homes[slot as usize] {
                let new = self.arrays[a].iter().zip(&self.layout.volume);
                for (v, (new, volume)) in v.iter_mut().zip(new) {
                    *v = if *volume > 0.0 { *new } else { *v };
                }
            }
        }
    }

    /// Lengths that the traversals rely on, without looking at the masks.
    pub(super) fn fits_quickly(&self, s: &State) -> bool {
        let len = self.layout.len;
        let nodes =
            |list: &[Vec<f64>], n: usize| list.len() == n && list.iter().all(|v| v.len() == len);
        nodes(&s.u, self.spec.dim)
            && nodes(&s.v, self.spec.dim)
            && self.fits_slots(s)
            && s.families.len() == self.families.len()
            && s.families
                .iter()
                .zip(&self.families)
                .zip(&self.bonds)
                .all(|((s, f), b)| {
                    s.intact.len() == f.present.len()
                        && s.history.len() == b.initial.len()
                        && s.history
                            .iter()
                            .all(|h| h.len() == f.present.len() * CHUNK + CHUNK)
                })
    }
}

/// Runs stretches of chunks that share an instance.
pub(super) unsafe fn stretch(run: [Run; 2], call: &Call, whole: &[u8], mut from: usize, to: usize) {
    while from < to {
        let kind = whole.get(from).copied().unwrap_or(0);
        let mut end = from + 1;
        while end < to && whole.get(end).copied().unwrap_or(0) == kind {
            end += 1;
        }
        unsafe { run[1 - kind as usize](call, from, end) };
        from = end;
    }
}
