//! A law on a body: forces, energies, tangents, breaking, histories.
//!
//! The engine owns what does not change during a run (layout, families, geometry, constants) and the values
//! that sweeps compute; everything that changes is in a [`State`]. Threads are those of the rayon pool that
//! the caller runs in; results do not depend on their number.
mod bonds;
mod breakable;
mod check;
mod constants;
mod convolution;
mod error;
mod geometry;
mod levels;
mod meets;
mod memory;
mod needs;
mod parts;
mod program;
pub(crate) mod records;
mod redo;
mod run;
mod setup;
mod single;
mod sleep;
#[cfg(test)]
pub(crate) mod tests;
mod unread;

pub use crate::lane::Isa;
pub use crate::law::Law;
pub use crate::state::{Bond, FamilyState, State};
pub use convolution::ConvolutionReport;
pub use error::SetupError;
pub use levels::Grading;
pub use memory::{Report, SweepReport};
pub use needs::Need;
pub use parts::{Feeding, PartReport, Stray};

use crate::lane::Record;
use crate::language::Exponents;
use crate::layout::{Family, Layout};
use crate::spec::{InfluenceFn, SlotKind, Spec, Stage, Stepped};
use crate::traverse::CHUNK;
use geometry::Geometry;
use program::Program;
use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::Duration;

/// What a scene says about a law.
#[derive(Clone, Debug)]
pub struct Settings {
    /// Parameter values of every material: SI, one per [`Spec::params`].
    pub materials: Vec<Vec<f64>>,
    /// One per [`Spec::influences`], with its parameter values.
    pub influences: Vec<(InfluenceFn, Vec<f64>)>,
    /// Of every material [m]; a single one is that of all. Two meet in their average: a bond between two materials
    /// exists where it is no longer than that.
    pub horizon: Vec<f64>,
    /// How many different horizons [`crate::body::Body::horizon`] may have; where it has more, they are rounded to so many.
    pub horizon_levels: usize,
    /// Neighbours near the rim count in part: 1 for r <= delta - dx/2, else (delta + dx/2 - r)/dx.
    pub partial_volume: bool,
    /// `ball()` is the sum over a full lattice family instead of the integral.
    pub lattice_constants: bool,
    /// Names of the weights that are 1 instead of computed.
    pub without: Vec<String>,
    pub traversal: Traversal,
    /// None: the best that the processor has.
    pub isa: Option<Isa>,
    pub precision: Precision,
}

impl Settings {
    /// The horizon on bonds between two materials [m].
    pub(crate) fn met_horizon(&self, a: usize, b: usize) -> f64 {
        let of = |material: usize| self.horizon[material.min(self.horizon.len() - 1)];
        if a == b { of(a) } else { 0.5 * (of(a) + of(b)) }
    }

    /// The largest horizon [m].
    pub(crate) fn reach(&self) -> f64 {
        self.horizon.iter().copied().fold(0.0, f64::max)
    }
}

/// How families are stored and walked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Traversal {
    /// The lattice where the body has a grid that wastes few lanes and all volumes are equal.
    Auto,
    Lattice,
    Cloud,
    /// The lattice, its sums over bonds as convolutions.
    Convolution,
}

/// Of the sums over bonds at every step. All else, and what is stored, is in double precision.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    #[default]
    Double,
    /// On a lattice, for sums in which nothing that stays as it is meets what moves ([`crate::spec::SweepSpec::single`]): about seven
    /// digits, of displacements as well. Double precision on a processor without AVX2.
    Single,
}

/// Whether a force evaluation may break bonds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Breaking {
    /// A pure evaluation: bonds beyond their limit still hold.
    Held,
    /// Bonds beyond their limit break, and the state says so.
    Armed,
}

/// Where the values of a node slot of the law are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Home {
    Displacement(usize),
    Velocity(usize),
    Position(usize),
    State(usize),
    Array(usize),
}

/// The rate of a field component, `drive - damping*field`, stored as the field is: in layout order where it lives on
/// the whole body.
#[derive(Clone, Copy, Debug)]
pub struct FieldRate<'a> {
    /// Position of the component in [`State::slots`].
    pub slot: usize,
    pub drive: &'a [f64],
    damping: Option<Damping<'a>>,
    pub stepped: Stepped,
    /// Where the field is stored while its damping is not.
    apart: Option<&'a parts::Places>,
}

#[derive(Clone, Copy, Debug)]
enum Damping<'a> {
    Values(&'a [f64]),
    /// Position in [`State::slots`].
    Field(usize),
}

impl<'a> FieldRate<'a> {
    /// The position in [`State::slots`] of a damping that is a field as it stands.
    pub fn damping_field(&self) -> Option<usize> {
        match self.damping {
            Some(Damping::Field(k)) => Some(k),
            _ => None,
        }
    }

    /// Calls `act` with stretches of the field and their damping, one after the other; `None`: 0.
    pub fn each(
        &self,
        state: &State,
        range: std::ops::Range<usize>,
        mut act: impl FnMut(std::ops::Range<usize>, Option<&[f64]>),
    ) {
        let values = match self.damping {
            None => return act(range, None),
            Some(Damping::Values(values)) => values,
            Some(Damping::Field(k)) => &state.slots[k],
        };
        let Some(places) = self.apart else {
            return act(range.clone(), Some(&values[range]));
        };
        let mut from = range.start;
        while from < range.end {
            // Eight numbers of the storage are eight of the layout.
            let to = (from + CHUNK - from % CHUNK).min(range.end);
            let at = places.slot(from);
            act(from..to, Some(&values[at..at + to - from]));
            from = to;
        }
    }

    /// The whole rate, stored as the field is.
    pub fn whole(&self, state: &State) -> Vec<f64> {
        let mut rate = self.drive.to_vec();
        self.each(state, 0..rate.len(), |here, damping| {
            let q = state.slots[self.slot][here.clone()].iter();
            let q = q.zip(damping.unwrap_or_default());
            rate[here]
                .iter_mut()
                .zip(q)
                .for_each(|(r, (q, c))| *r -= c * q);
        });
        rate
    }
}

/// A law on a body.
#[derive(Debug)]
pub struct Engine {
    spec: Spec,
    isa: Isa,
    lattice: bool,
    layout: Layout,
    families: Vec<Family>,
    programs: Vec<Program>,
    needs: needs::Needs,
    geometry: Vec<Geometry>,
    streams: Vec<geometry::Kept>,
    /// Positions and displacements of a cloud.
    x_records: Vec<Record>,
    u_records: Vec<Record>,
    /// Per eight slots whether anybody reads records of them: rows of lists do, runs read arrays.
    listed: Vec<bool>,
    /// Values of sweeps that others read in a cloud, and who.
    groups: Vec<records::Group>,
    uses: Vec<records::Uses>,
    /// Of the nodes, material after material, and where those of each chunk begin.
    constants: Vec<f64>,
    constants_at: Vec<u32>,
    homes: Vec<Home>,
    /// Values of computed slots and increments; forces first, then tangents.
    arrays: Vec<Vec<f64>>,
    /// Equal components of a force or a tangent: from which array into which.
    twins: Vec<(usize, usize)>,
    /// Computed slots that some sweep reads at the other end of a bond.
    reads_ghosts: Vec<bool>,
    /// Number of state slots.
    state_slots: usize,
    parts: parts::Parts,
    bonds: Vec<BondData>,
    grading: Grading,
    /// Bonds broken by the running sweep, per chunk.
    broken: Vec<u32>,
    redo: redo::Redo,
    sleep: sleep::Sleep,
    convolution: Option<Box<convolution::Convolution>>,
    /// What sums in single precision read of nodes.
    rounded: single::Rounded,
    /// What laying out the nodes and finding their families took.
    search: Duration,
    /// Slots that share an array, as nobody reads them.
    unread: BTreeSet<usize>,
}

/// What belongs to the bonds of one family besides the family itself.
#[derive(Debug, Default)]
struct BondData {
    /// Initial value of each bond history, and the buffer that update sweeps write.
    initial: Vec<f64>,
    next: Vec<Vec<f64>>,
    /// Correction factors, which no step changes.
    weights: Vec<Vec<f64>>,
    reverse: Vec<u32>,
    /// Bonds that may break, one byte per row; empty: all.
    armed: Vec<u8>,
    /// Per chunk: every bond of every node present (and intact): the instance without masks may run.
    whole_reference: Vec<u8>,
    whole_intact: Vec<u8>,
    /// Whether all bonds are intact.
    unbroken: bool,
    /// State that `whole_intact` and the values of the family stage belong to.
    stamp: u64,
}

impl Engine {
    /// Lays the body out, finds families, evaluates constants and geometry, runs the reference stage.
    ///
    /// # Errors
    /// The body, the settings or the law are inconsistent, or the body does not fit in memory.
    pub fn new(
        body: &crate::body::Body,
        law: Law,
        settings: Settings,
    ) -> Result<Engine, SetupError> {
        setup::engine(body, law, settings)
    }

    /// At rest: no displacement, no velocity, all bonds intact, histories at their initial values.
    pub fn state(&self) -> State {
        let zero = || vec![0.0; self.layout.len];
        let slot = |k: usize| vec![0.0; self.stored(k)];
        let mut slots: Vec<Vec<f64>> = (0..self.state_slots).map(slot).collect();
        for h in &self.spec.histories {
            if let Some(Home::State(k)) = h.slot.map(|s| self.homes[s.0 as usize]) {
                slots[k].fill(h.initial);
            }
        }
        let family = |(k, (f, b)): (usize, (&Family, &BondData))| {
            let history = |&v: &f64| vec![v; history_len(f)];
            // Masks of its own from the start, if a step may change them: it allocates nothing.
            let masks = match self.breaks(k) {
                true => Arc::new(f.present.to_vec()),
                false => Arc::clone(&f.present),
            };
            FamilyState::new(masks, b.initial.iter().map(history).collect())
        };
        let families = self.families.iter().zip(&self.bonds);
        State {
            step: 0,
            time: 0.0,
            dt: 0.0,
            u: (0..self.spec.dim).map(|_| zero()).collect(),
            v: (0..self.spec.dim).map(|_| zero()).collect(),
            slots,
            families: families.enumerate().map(family).collect(),
        }
    }

    /// Whether a sweep may break bonds of a family.
    fn breaks(&self, family: usize) -> bool {
        let mut programs = self.programs.iter();
        programs.any(|p| p.kills && p.family == family)
    }

    /// True where a state has the arrays that this engine needs: a checkpoint of another scene has not.
    pub fn fits(&self, s: &State) -> bool {
        let nodes = |list: &[Vec<f64>], n: usize| {
            list.len() == n && list.iter().all(|v| v.len() == self.layout.len)
        };
        let bonds = |(f, (b, s)): (&Family, (&BondData, &FamilyState))| {
            let masks = s.intact.len() == f.present.len()
                && s.intact.iter().zip(&*f.present).all(|(i, p)| i & !p == 0);
            masks
                && s.history.len() == b.initial.len()
                && s.history.iter().all(|h| h.len() == history_len(f))
        };
        nodes(&s.u, self.spec.dim)
            && nodes(&s.v, self.spec.dim)
            && self.fits_slots(s)
            && s.families.len() == self.families.len()
            && self
                .families
                .iter()
                .zip(self.bonds.iter().zip(&s.families))
                .all(bonds)
    }

    fn fits_slots(&self, s: &State) -> bool {
        let mut slots = s.slots.iter().enumerate();
        s.slots.len() == self.state_slots && slots.all(|(k, v)| v.len() == self.stored(k))
    }

    /// Evaluates the force density and the rates of fields. Returns the directed bonds that broke now.
    pub fn forces(&mut self, s: &mut State, breaking: Breaking) -> usize {
        self.evaluate(s, breaking, Need::All)
    }

    /// As [`Engine::forces`], for a part of it.
    pub fn evaluate(&mut self, s: &mut State, breaking: Breaking, need: Need) -> usize {
        assert!(self.fits_quickly(s), "the state belongs to another engine");
        self.refresh_state(s);
        self.pack(s);
        self.family_stage(s);
        let mut broken = 0;
        for k in 0..self.programs.len() {
            let p = &self.programs[k];
            if p.stage != Stage::Step || p.unread || !self.needs.includes(k, need) {
                continue;
            }
            let armed = breaking == Breaking::Armed && self.programs[k].kills;
            let chunks = self.layout.chunks();
            self.sleep.count(k, armed, chunks);
            if armed {
                self.run_armed(k, s);
                broken += self.after_breaking(k, s);
            } else {
                self.run_all(k, s);
            }
        }
        self.copy_twins();
        broken
    }

    fn copy_twins(&mut self) {
        for &(from, to) in &self.twins {
            if let Ok([from, to]) = self.arrays.get_disjoint_mut([from, to]) {
                to.copy_from_slice(from);
            }
        }
    }

    /// Force density [N/m^3], one array per dimension in layout order; empty for a law without momentum.
    pub fn force(&self) -> &[Vec<f64>] {
        &self.arrays[..self.spec.force.len()]
    }

    /// The rate of every field component that has one; after `forces`.
    pub fn rates(&self) -> impl Iterator<Item = FieldRate<'_>> {
        let array = |slot: u32| match self.homes[slot as usize] {
            Home::Array(a) => Some(&self.arrays[a][..]),
            _ => None,
        };
        let damping = move |slot: u32| match self.homes[slot as usize] {
            Home::State(k) => Some(Damping::Field(k)),
            _ => array(slot).map(Damping::Values),
        };
        self.spec.rates.iter().filter_map(move |r| {
            let Home::State(slot) = self.homes[r.field as usize] else {
                return None;
            };
            let whole = |k: u32| match self.homes[k as usize] {
                Home::Array(a) => self.parts.of_array(a).is_none(),
                Home::State(k) => self.parts.of_state(k).is_none(),
                _ => true,
            };
            Some(FieldRate {
                slot,
                drive: array(r.rate)?,
                damping: r.damping.and_then(damping),
                stepped: r.stepped,
                apart: (self.parts.of_state(slot)).filter(|_| r.damping.is_some_and(whole)),
            })
        })
    }

    /// Positions in [`State::slots`] of the components of a field or the value of a node history.
    pub fn state_slots(&self, name: &str) -> Option<Vec<usize>> {
        let position = |&slot: &u32| match self.homes[slot as usize] {
            Home::State(k) => Some(k),
            _ => None,
        };
        if let Some(f) = self.spec.fields.iter().find(|f| f.name == name) {
            return f.slots.iter().map(position).collect();
        }
        let h = self.spec.histories.iter().find(|h| h.name == name)?;
        h.slot.map(|s| position(&s.0).into_iter().collect())
    }

    /// Name, unit and position in [`State::slots`] of every field component: `q`, `q_x`, `q_xy`.
    pub fn field_components(&self) -> Vec<(String, Exponents, usize)> {
        let mut found = Vec::new();
        for field in &self.spec.fields {
            let slots = self.state_slots(&field.name).unwrap_or_default();
            for (slot, part) in slots.into_iter().zip(&field.components) {
                found.push((format!("{}{part}", field.name), field.exponents, slot));
            }
        }
        found
    }

    /// Strain energy density [J/m^3] per slot; call after `forces` at the same state. Empty for a law without energy.
    pub fn energy(&mut self, s: &State) -> &[f64] {
        assert!(self.fits_quickly(s), "the state belongs to another engine");
        self.pack(s);
        self.family_stage(s);
        self.run_stage(Stage::Energy, s);
        match self.spec.energy.map(|k| self.homes[k as usize]) {
            Some(Home::Array(a)) => &self.arrays[a],
            _ => &[],
        }
    }

    /// Change of the force density along the increment `du` (one array per dimension, layout order);
    /// call after `forces` at the same state. Empty for a law without tangent.
    pub fn tangent(&mut self, s: &State, du: &[Vec<f64>]) -> &[Vec<f64>] {
        assert!(
            self.fits_quickly(s) && du.len() >= self.spec.dim,
            "the state belongs to another engine"
        );
        self.pack(s);
        self.family_stage(s);
        for k in 0..self.homes.len() {
            if let (SlotKind::Increment(a), Home::Array(to)) =
                (self.spec.slots[k].kind, self.homes[k])
            {
                self.arrays[to].copy_from_slice(&du[a as usize]);
                self.layout.ghosts.refresh(&mut self.arrays[to]);
            }
        }
        self.run_stage(Stage::Tangent, s);
        self.copy_twins();
        let n = self.spec.force.len();
        &self.arrays[n..n + self.spec.tangent.len()]
    }

    /// Accepts the step: writes the next histories, then breaks the bonds that break after the force. Once per
    /// step, after `forces`. Returns the directed bonds that broke now.
    pub fn commit(&mut self, s: &mut State) -> usize {
        assert!(self.fits_quickly(s), "the state belongs to another engine");
        if !self.programs.iter().any(|p| p.stage == Stage::Update) {
            return 0;
        }
        self.refresh_state(s);
        self.pack(s);
        self.family_stage(s);
        let mut broken = 0;
        for k in 0..self.programs.len() {
            match &self.programs[k] {
                p if p.stage != Stage::Update || p.is_idle() => {}
                p if p.kills => {
                    self.run_armed(k, s);
                    broken += self.after_breaking(k, s);
                }
                _ => self.run_all(k, s),
            }
        }
        self.wake_by_histories(s);
        self.swap_histories(s);
        self.replace_velocities(s);
        broken
    }

    /// Values of a named node quantity of the law as last computed: one array per component, user order. None of what is
    /// left out, see [`Engine::keep_named`].
    pub fn named(&self, name: &str) -> Option<Vec<Vec<f64>>> {
        let (_, slots) = self.spec.named.iter().find(|n| n.0 == name)?;
        let component = |&slot: &u32| {
            let values = match self.homes[slot as usize] {
                _ if self.unread.contains(&(slot as usize)) => return None,
                Home::Array(a) => &self.arrays[a],
                Home::Position(a) => &self.layout.x[a],
                _ => return None,
            };
            Some(
                self.layout
                    .slot
                    .iter()
                    .map(|&s| values[s as usize])
                    .collect(),
            )
        };
        slots.iter().map(component).collect()
    }

    /// Layout slot of a node.
    pub fn slot(&self, node: usize) -> usize {
        self.layout.slot[node] as usize
    }

    /// Layout slot of every node, in user order.
    pub fn slots(&self) -> &[u32] {
        &self.layout.slot
    }

    /// First row of bonds of every chunk, family by family.
    pub fn rows(&self) -> impl Iterator<Item = &[u32]> {
        self.families.iter().map(|f| &f.first[..])
    }

    /// Length of every node array; more than there are nodes.
    #[allow(clippy::len_without_is_empty)]
    pub fn len(&self) -> usize {
        self.layout.len
    }

    /// Node volumes [m^3] in layout order; 0 in padding.
    pub fn volume(&self) -> &[f64] {
        &self.layout.volume
    }

    /// Reference positions [m], one array per direction, layout order; anything in padding.
    pub fn positions(&self) -> &[Vec<f64>; 3] {
        &self.layout.x
    }

    pub fn spec(&self) -> &Spec {
        &self.spec
    }

    /// Constants of the law at the nodes of a material, in the order of [`Spec::constants`]. With [`crate::body::Body::horizon`],
    /// of those of one material and one horizon, in ascending order of both.
    pub fn constants(&self, material: usize) -> &[f64] {
        let count = self.spec.constants.outs.len();
        &self.constants[material * count..][..count]
    }

    /// The horizons of the nodes.
    pub fn grading(&self) -> &Grading {
        &self.grading
    }
}

/// One extra row holds the initial value, for bonds that have no reverse.
fn history_len(f: &Family) -> usize {
    (f.present.len() + 1) * CHUNK
}
