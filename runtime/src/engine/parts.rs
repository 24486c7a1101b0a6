//! Fields that live on a part of the body: where that is, and how they are stored.
//!
//! Whether a field lives at a node is decided once, when the coefficients of a run are set ([`Engine::settle`]). From
//! then on the arrays of such a field (its values, and what it is stepped with) hold those chunks alone in which a
//! node has it, one chunk behind the other; on all others sweeps read zeros, and write where nobody reads. Before,
//! and where the law reads the field at the other end of a bond, its arrays are as long as all others: answers do not
//! depend on that.
use super::program::Program;
use super::run::stretch;
use super::{Engine, Home, State};
use crate::layout::{Layout, NONE};
use crate::spec::{PartSpec, Spec, Stage};
use crate::traverse::{CHUNK, Call};
use std::borrow::Cow;
use std::mem::MaybeUninit;

/// Slots between the first and the last chunk of a run without storage.
const SPAN: usize = 512;
static ZEROS: [f64; SPAN] = [0.0; SPAN];

/// What is stored of one part of the body.
#[derive(Debug)]
pub(super) struct Places {
    /// Per eight slots of the layout: which eight numbers of the storage are theirs, `NONE` without storage.
    place: Vec<u32>,
    /// Per eight numbers of the storage: which eight slots they belong to, and the lanes where the fields live.
    block: Vec<u32>,
    lanes: Vec<u8>,
    nodes: usize,
}

impl Places {
    /// From numbers that are not zero where the fields live.
    fn new(layout: &Layout, lives: &[f64]) -> Places {
        let mut places = Places {
            place: vec![NONE; layout.len.div_ceil(CHUNK)],
            block: vec![],
            lanes: vec![],
            nodes: 0,
        };
        for (&base, &occupied) in layout.base.iter().zip(&layout.nodes) {
            let here = &lives[base as usize..base as usize + CHUNK];
            let bit = |(lane, v): (usize, &f64)| u8::from(*v != 0.0) << lane;
            let lanes = here.iter().enumerate().map(bit).fold(0, |a, b| a | b) & occupied;
            if lanes == 0 {
                continue;
            }
            // Chunks of several materials may share their slots.
            let place = &mut places.place[base as usize / CHUNK];
            if *place == NONE {
                *place = places.block.len() as u32;
                places.block.push(base / CHUNK as u32);
                places.lanes.push(0);
            }
            places.lanes[*place as usize] |= lanes;
            places.nodes += lanes.count_ones() as usize;
        }
        places
    }

    /// Numbers stored.
    fn len(&self) -> usize {
        self.block.len() * CHUNK
    }

    fn index(&self, slot: usize) -> Option<usize> {
        match self.place[slot / CHUNK] {
            NONE => None,
            place => Some(place as usize * CHUNK + slot % CHUNK),
        }
    }

    fn lives(&self, slot: usize) -> bool {
        let index = self.index(slot);
        index.is_some_and(|k| self.lanes[k / CHUNK] >> (k % CHUNK) & 1 == 1)
    }

    /// Slot of the layout of a stored number.
    pub(super) fn slot(&self, index: usize) -> usize {
        self.block[index / CHUNK] as usize * CHUNK + index % CHUNK
    }

    fn bytes(&self) -> usize {
        4 * (self.place.len() + self.block.len()) + self.lanes.len()
    }
}

/// The parts of a law on a body.
#[derive(Debug, Default)]
pub(super) struct Parts {
    /// Empty until they are known.
    places: Vec<Places>,
    /// Per state slot: the part that the field lives on, and the one that it is stored on.
    lives: Vec<Option<usize>>,
    state: Vec<Option<usize>>,
    /// Per computed array: the part that it is stored on.
    array: Vec<Option<usize>>,
}

impl Parts {
    pub(super) fn new(spec: &Spec, homes: &[Home], arrays: usize, states: usize) -> Parts {
        let mut parts = Parts {
            places: vec![],
            lives: vec![None; states],
            state: vec![None; states],
            array: vec![None; arrays],
        };
        for (slot, home) in spec.slots.iter().zip(homes) {
            let part = slot.part.map(|part| part as usize);
            match *home {
                Home::State(k) => parts.state[k] = part,
                Home::Array(k) => parts.array[k] = part,
                _ => {}
            }
        }
        for f in &spec.fields {
            for &slot in &f.slots {
                if let Home::State(k) = homes[slot as usize] {
                    parts.lives[k] = f.part.map(|part| part as usize);
                }
            }
        }
        parts
    }

    /// Where a state slot is stored, if not on the whole body.
    pub(super) fn of_state(&self, k: usize) -> Option<&Places> {
        self.state[k].and_then(|part| self.places.get(part))
    }

    pub(super) fn of_array(&self, k: usize) -> Option<&Places> {
        self.array[k].and_then(|part| self.places.get(part))
    }

    pub(super) fn bytes(&self) -> usize {
        self.places.iter().map(Places::bytes).sum()
    }
}

/// A slot of a sweep that is stored on a part of the body.
#[derive(Clone, Copy, Debug)]
pub(super) struct Confined {
    pub part: usize,
    /// Position in the list of what is written, or else of what is read at the node.
    pub written: bool,
    pub position: usize,
}

/// Fields of a law on one part of the body.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PartReport {
    pub fields: Vec<String>,
    /// As the law says it.
    pub condition: String,
    /// Nodes that have the fields.
    pub nodes: usize,
    /// Of the fields and their rates.
    pub bytes: usize,
}

/// A value where the field does not live.
#[derive(Clone, Debug, PartialEq)]
pub struct Stray {
    pub field: String,
    /// As the law says it.
    pub condition: String,
    /// User number.
    pub node: usize,
}

/// A damping that is negative.
#[derive(Clone, Debug, PartialEq)]
pub struct Feeding {
    pub field: String,
    /// What the name of its component ends in: `_x`; nothing for a scalar.
    pub component: String,
    /// The field that it would feed.
    pub fed: String,
    /// User number.
    pub node: usize,
    /// [1/s]
    pub value: f64,
}

impl Engine {
    /// Says where the fields live that are not on the whole body, by the coefficients in `s`, and stores them there
    /// alone from now on, in `s` and in all states to come. Once; the coefficients that decide stay as they are.
    ///
    /// # Errors
    /// A field is not zero where it does not live. The engine and the state are then as they were.
    pub fn settle(&mut self, s: &mut State) -> Result<(), Stray> {
        if self.spec.parts.is_empty() || !self.parts.places.is_empty() {
            return Ok(());
        }
        assert!(self.fits_quickly(s), "the state belongs to another engine");
        self.run_stage(Stage::Part, s);
        let mut places = vec![];
        for part in &self.spec.parts {
            let Home::Array(a) = self.homes[part.slot as usize] else {
                return Ok(());
            };
            places.push(Places::new(&self.layout, &self.arrays[a]));
        }
        self.parts.places = places;
        self.sleep.forget();
        if let Some(stray) = self.stray(s) {
            self.parts.places = vec![];
            return Err(stray);
        }
        for part in &self.spec.parts {
            if let Home::Array(a) = self.homes[part.slot as usize] {
                self.arrays[a] = vec![];
            }
        }
        for (k, values) in s.slots.iter_mut().enumerate() {
            if let Some(places) = self.parts.of_state(k) {
                *values = (0..places.len()).map(|i| values[places.slot(i)]).collect();
            }
        }
        for a in 0..self.arrays.len() {
            if let Some(places) = self.parts.of_array(a) {
                self.arrays[a] = vec![0.0; places.len()];
            }
        }
        Ok(())
    }

    fn stray(&self, s: &State) -> Option<Stray> {
        for field in self.spec.fields.iter() {
            let part = field.part.and_then(|p| self.spec.parts.get(p as usize));
            let Some(part) = part else { continue };
            for k in self.state_slots(&field.name).unwrap_or_default() {
                let strays = |slot: &u32| {
                    s.slots[k][*slot as usize] != 0.0 && !self.lives(k, *slot as usize)
                };
                if let Some(node) = self.layout.slot.iter().position(strays) {
                    return Some(Stray {
                        field: field.name.clone(),
                        condition: part.condition.clone(),
                        node,
                    });
                }
            }
        }
        None
    }

    /// A field that damps another as it stands, where it is negative.
    pub fn feeding(&self, s: &State) -> Option<Feeding> {
        let name = |k: usize| {
            let fields = self.spec.fields.iter();
            let mut all = fields.filter_map(|f| {
                let slots = self.state_slots(&f.name)?;
                let component = slots.iter().position(|slot| *slot == k)?;
                Some((f, component))
            });
            all.next()
        };
        self.rates().find_map(|rate| {
            let k = rate.damping_field()?;
            let value = |slot: &u32| self.index(k, *slot as usize).map_or(0.0, |i| s.slots[k][i]);
            let node = self.layout.slot.iter().position(|slot| value(slot) < 0.0)?;
            let (field, component) = name(k)?;
            Some(Feeding {
                field: field.name.clone(),
                component: field.components.get(component).cloned().unwrap_or_default(),
                fed: name(rate.slot)?.0.name.clone(),
                node,
                value: value(&self.layout.slot[node]),
            })
        })
    }

    /// Whether a state slot is more than zero for ever at a layout slot.
    pub fn lives(&self, k: usize, slot: usize) -> bool {
        let places = self.parts.lives[k].and_then(|part| self.parts.places.get(part));
        places.is_none_or(|places| places.lives(slot))
    }

    /// The condition of the part of the body that a field lives on, as the law says it, where not on all.
    pub fn lives_where(&self, field: &str) -> Option<&str> {
        let field = self.spec.fields.iter().find(|f| f.name == field)?;
        let part = self.spec.parts.get(field.part? as usize)?;
        Some(&part.condition)
    }

    /// A field that lives where this one says.
    pub fn decided_by(&self, field: &str) -> Option<&str> {
        let by = self.spec.fields.iter().find(|f| f.name == field)?;
        let decides = |part: u32| {
            let slot = self.spec.parts.get(part as usize).map(|p| p.slot);
            let writes = |p: &&Program| slot.is_some_and(|slot| p.out.contains(&(slot as usize)));
            let mut sweeps = self.programs.iter().filter(writes);
            sweeps.any(|p| by.slots.iter().any(|k| p.own.contains(&(*k as usize))))
        };
        let mut fields = self.spec.fields.iter();
        let found = fields.find(|f| f.part.is_some_and(decides))?;
        Some(&found.name)
    }

    /// Length of the array of a state slot.
    pub fn stored(&self, k: usize) -> usize {
        self.parts.of_state(k).map_or(self.layout.len, Places::len)
    }

    /// Position of a layout slot in the array of a state slot; `None` where nothing is stored: the value is zero.
    pub fn index(&self, k: usize, slot: usize) -> Option<usize> {
        match self.parts.of_state(k) {
            Some(places) => places.index(slot),
            None => Some(slot),
        }
    }

    /// Layout slot of a position in the array of a state slot.
    pub fn slot_of(&self, k: usize, index: usize) -> usize {
        self.parts
            .of_state(k)
            .map_or(index, |places| places.slot(index))
    }

    /// Value of a state slot at a layout slot.
    pub fn value(&self, s: &State, k: usize, slot: usize) -> f64 {
        self.index(k, slot).map_or(0.0, |index| s.slots[k][index])
    }

    /// Numbers that are stored as a state slot is, in layout order.
    pub fn spread<'v>(&self, k: usize, values: &'v [f64]) -> Cow<'v, [f64]> {
        let Some(places) = self.parts.of_state(k) else {
            return Cow::Borrowed(values);
        };
        let mut all = vec![0.0; self.layout.len];
        for (index, value) in values.iter().enumerate() {
            all[places.slot(index)] = *value;
        }
        Cow::Owned(all)
    }

    /// What is stored on parts of the body.
    pub(super) fn part_reports(&self) -> Vec<PartReport> {
        let one = |(number, part): (usize, &PartSpec)| {
            let fields = self.spec.fields.iter();
            let fields = fields.filter(|f| f.part == Some(number as u32));
            let places = self.parts.places.get(number);
            let nodes = places.map_or(self.layout.slot.len(), |p| p.nodes);
            let state =
                (0..self.parts.lives.len()).filter(|k| self.parts.lives[*k] == Some(number));
            let state: usize = state.map(|k| self.stored(k)).sum();
            let here = |a: &usize| self.parts.array[*a] == Some(number);
            let arrays = (0..self.arrays.len()).filter(here);
            let arrays: usize = arrays.map(|a| self.arrays[a].len()).sum();
            PartReport {
                fields: fields.map(|f| f.name.clone()).collect(),
                condition: part.condition.clone(),
                nodes,
                bytes: 8 * (state + arrays),
            }
        };
        self.spec.parts.iter().enumerate().map(one).collect()
    }

    /// Runs a sweep on the chunks `from..to`.
    ///
    /// # Safety
    /// As [`crate::kernel::Run`].
    pub(super) unsafe fn run_chunks(
        &self,
        p: &Program,
        call: &Call,
        whole: &[u8],
        range: (usize, usize),
    ) {
        // SAFETY: as of this function.
        unsafe {
            self.by_places(p, call, whole, range);
            self.lay_out(call, range);
        }
    }

    /// By stretches that are stored alike.
    ///
    /// # Safety
    /// As [`crate::kernel::Run`].
    unsafe fn by_places(
        &self,
        p: &Program,
        call: &Call,
        whole: &[u8],
        (mut from, to): (usize, usize),
    ) {
        if p.confined.is_empty() || self.parts.places.is_empty() {
            // SAFETY: as of this function.
            return unsafe { stretch(self.instances(p), call, whole, from, to) };
        }
        let mut scratch = [const { MaybeUninit::<f64>::uninit() }; SPAN];
        let mut here = call.clone();
        while from < to {
            let end = self.alike(p, from, to);
            let base = self.layout.base[from] as usize;
            let mut stored = false;
            for c in &p.confined {
                let place = self.parts.places[c.part].index(base);
                stored |= place.is_some();
                // The traversal adds the slot, which is at least `base`.
                match (c.written, place) {
                    (true, Some(place)) => {
                        let to = call.out[c.position].wrapping_add(place);
                        here.out[c.position] = to.wrapping_sub(base);
                    }
                    (true, None) => {
                        let to = scratch.as_mut_ptr().cast::<f64>();
                        here.out[c.position] = to.wrapping_sub(base);
                    }
                    (false, Some(place)) => {
                        let from = call.own[c.position].wrapping_add(place);
                        here.own[c.position] = from.wrapping_sub(base);
                    }
                    (false, None) => {
                        here.own[c.position] = ZEROS.as_ptr().wrapping_sub(base);
                    }
                }
            }
            if stored || !p.stays {
                // SAFETY: as of this function; the chunks are within the storage, or within `SPAN` of each other.
                unsafe { stretch(self.instances(p), &here, whole, from, end) };
            }
            from = end;
        }
    }

    /// The end of the chunks behind `from` that follow each other in every storage as in the layout, or have none.
    fn alike(&self, p: &Program, from: usize, to: usize) -> usize {
        let base = |chunk: usize| self.layout.base[chunk] as usize;
        let start = base(from);
        let follows = |chunk: usize| {
            let Some(ahead) = base(chunk).checked_sub(start) else {
                return false;
            };
            ahead <= SPAN - CHUNK
                && p.confined.iter().all(|c| {
                    let places = &self.parts.places[c.part];
                    let first = places.index(start);
                    places.index(base(chunk)) == first.map(|first| first + ahead)
                })
        };
        (from + 1..to).find(|c| !follows(*c)).unwrap_or(to)
    }
}

/// Slots of a sweep that are stored on parts of the body.
pub(super) fn confined(spec: &Spec, own: &[usize], out: &[usize]) -> Vec<Confined> {
    let of = |list: &[usize], written: bool| {
        let one = |(position, slot): (usize, &usize)| {
            let part = spec.slots[*slot].part? as usize;
            Some(Confined {
                part,
                written,
                position,
            })
        };
        list.iter().enumerate().filter_map(one).collect::<Vec<_>>()
    };
    [of(own, false), of(out, true)].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_with_a_node_are_stored_one_behind_the_other() {
        let layout = Layout {
            len: 32,
            base: vec![0, 8, 24, 24],
            nodes: vec![0xFF, 0x0F, 0x0F, 0xF0],
            ..Layout::default()
        };
        let mut lives = vec![0.0; 32];
        // Slot 13 holds no node.
        for slot in [9, 13, 24, 31] {
            lives[slot] = 1.0;
        }
        let places = Places::new(&layout, &lives);
        assert_eq!((places.len(), places.nodes), (16, 3));
        assert_eq!(
            [0, 8, 15, 16, 24].map(|s| places.index(s)),
            [None, Some(0), Some(7), None, Some(8)]
        );
        assert_eq!([0, 5, 15].map(|k| places.slot(k)), [8, 13, 31]);
        assert_eq!(
            [8, 9, 13, 24, 30, 31].map(|s| places.lives(s)),
            [false, true, false, true, false, true]
        );
    }
}
