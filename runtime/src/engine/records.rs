//! What compiled sweeps of a cloud read at the other end of a bond besides displacements: up to four numbers of a node
//! side by side, so that a bond reads one place of memory in the place of four.
//!
//! The arrays of the numbers stay what they are; who writes one of them lays its chunk out anew right afterwards, while
//! it is in the cache. No sweep reads at the other end what it writes itself.
use super::program::Program;
use super::{Engine, Home};
use crate::lane::Record;
use crate::spec::{SlotKind, Spec};
use crate::traverse::{CHUNK, Call, RECORD, recorded};
use std::ptr::null;

/// Slots whose numbers lie side by side.
#[derive(Debug)]
pub(super) struct Group {
    slots: Vec<usize>,
    records: Vec<Record>,
}

/// Which groups a sweep reads, in the order of its list, and which ones it changes.
#[derive(Clone, Debug, Default)]
pub(super) struct Uses {
    reads: Vec<usize>,
    writes: Vec<usize>,
    /// The same for the running call, allocated once.
    packs: Vec<Pack>,
}

/// One group, as a running sweep changes it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pack {
    from: [*const f64; RECORD],
    to: *mut Record,
}

/// The groups of the sweeps, not yet laid out.
fn slots_of(spec: &Spec, p: &Program) -> Vec<Vec<usize>> {
    if !p.compiled {
        return vec![];
    }
    let computed = |slot: &&usize| matches!(spec.slots[**slot].kind, SlotKind::Computed(_));
    let formed = p.nbr.iter().take_while(computed).count();
    let groups = p.nbr[..recorded(formed)].chunks(RECORD);
    groups.map(<[usize]>::to_vec).collect()
}

/// Groups of a cloud with `len` slots of nodes, and what each sweep does with them.
pub(super) fn groups(spec: &Spec, programs: &[Program], len: usize) -> (Vec<Group>, Vec<Uses>) {
    let mut groups: Vec<Group> = vec![];
    let mut uses = vec![Uses::default(); programs.len()];
    for (p, uses) in programs.iter().zip(&mut uses) {
        for slots in slots_of(spec, p) {
            let known = groups.iter().position(|g| g.slots == slots);
            uses.reads.push(known.unwrap_or(groups.len()));
            if known.is_none() {
                let records = vec![Record::default(); len];
                groups.push(Group { slots, records });
            }
        }
    }
    for (p, uses) in programs.iter().zip(&mut uses) {
        let changes = |g: &usize| groups[*g].slots.iter().any(|slot| p.out.contains(slot));
        uses.writes = (0..groups.len()).filter(changes).collect();
        uses.packs = Vec::with_capacity(uses.writes.len());
    }
    (groups, uses)
}

/// How many records a node has in a cloud, positions and displacements left out.
pub(super) fn per_node(spec: &Spec, programs: &[Program]) -> usize {
    groups(spec, programs, 0).0.len()
}

impl Engine {
    pub(super) fn record_bytes(&self) -> usize {
        let groups = self.groups.iter().map(|g| g.records.len());
        size_of::<Record>() * (groups.sum::<usize>() + self.x_records.len() + self.u_records.len())
    }

    /// Records that a sweep reads and changes.
    pub(super) fn point_to_records(&mut self, k: usize, call: &mut Call) {
        if self.lattice {
            return;
        }
        for (to, &g) in call.nbr_records.iter_mut().zip(&self.uses[k].reads) {
            *to = self.groups[g].records.as_ptr();
        }
        let Uses { writes, packs, .. } = &mut self.uses[k];
        packs.clear();
        for &g in writes.iter() {
            let group = &mut self.groups[g];
            let mut from = [null(); RECORD];
            for (from, &slot) in from.iter_mut().zip(&group.slots) {
                if let Home::Array(a) = self.homes[slot] {
                    *from = self.arrays[a].as_ptr();
                }
            }
            let to = group.records.as_mut_ptr();
            packs.push(Pack { from, to });
        }
        call.packs = &packs[..];
    }

    /// Lays out what a sweep has written on the chunks `from..to`.
    ///
    /// # Safety
    /// The call is one of this engine, and nobody else writes to these chunks.
    pub(super) unsafe fn lay_out(&self, call: &Call, (from, to): (usize, usize)) {
        // SAFETY: the engine of the call has them.
        let packs = unsafe { &*call.packs };
        if packs.is_empty() {
            return;
        }
        for &base in &self.layout.base[from..to] {
            let base = base as usize;
            if !self.listed[base / CHUNK] {
                continue;
            }
            for pack in packs {
                // SAFETY: slots of a chunk are slots of the arrays.
                (base..base + CHUNK).for_each(|slot| unsafe { pack.one(slot) });
            }
        }
    }

    /// Ghosts of what a sweep has written.
    pub(super) fn lay_out_ghosts(&mut self, k: usize) {
        for &g in &self.uses[k].writes {
            let Group { slots, records } = &mut self.groups[g];
            for (axis, slot) in slots.iter().enumerate() {
                if let Home::Array(a) = self.homes[*slot] {
                    for &ghost in &self.layout.ghosts.to {
                        records[ghost as usize].0[axis] = self.arrays[a][ghost as usize];
                    }
                }
            }
        }
    }
}

// SAFETY: addresses are followed while the engine runs a call alone, by threads on disjoint chunks.
unsafe impl Send for Pack {}
unsafe impl Sync for Pack {}

impl Pack {
    #[inline(always)]
    unsafe fn one(&self, slot: usize) {
        let mut record = Record::default();
        for (to, from) in record.0.iter_mut().zip(self.from) {
            if !from.is_null() {
                *to = unsafe { *from.add(slot) };
            }
        }
        unsafe { *self.to.add(slot) = record };
    }
}
