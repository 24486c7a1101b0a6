//! Sweeps made ready to run: tapes checked and packed, instances chosen.
use super::SetupError;
use super::parts::{self, Confined};
use crate::body::Flavour;
use crate::kernel::{CompiledKernel, Entries, Instances, Run};
use crate::lane::Isa;
use crate::spec::{Op, SlotKind, Spec, Stage, SweepSpec};
use crate::tape::{Code, Limits, MAX_VALUES, Place, TapeError, TapeSweep, with_streams};
use crate::traverse::{MAX_GEOMETRY, MAX_HISTORIES, MAX_SLOTS, interpreted, interpreted_single};

/// One sweep.
#[derive(Debug)]
pub(super) struct Program {
    pub name: String,
    pub stage: Stage,
    pub family: usize,
    pub reference: bool,
    pub kills: bool,
    /// Bonds are added before they are tested: the ones that break now still count in this evaluation.
    pub kills_after: bool,
    pub own: Vec<usize>,
    pub nbr: Vec<usize>,
    pub out: Vec<usize>,
    /// Positions among the bond histories and then the weights of the family; the second says which ones this
    /// sweep writes.
    pub history: Vec<usize>,
    pub writes: Vec<bool>,
    pub reads_reverse: bool,
    pub loops: bool,
    /// Slots that are stored on a part of the body, and whether all that is written is.
    pub confined: Vec<Confined>,
    pub stays: bool,
    pub tape: Box<TapeSweep>,
    /// Its outputs are the records of a lattice, or the streams of a cloud.
    pub geometry: Code,
    pub compiled: bool,
    pub run: [Run; 2],
    /// The instances that sum its bonds in single precision, where it is to.
    pub single: Option<[Run; 2]>,
    /// Nobody reads what it writes.
    pub unread: bool,
}

impl Program {
    /// Whether it changes nothing: it was there to break bonds, and none can.
    pub fn is_idle(&self) -> bool {
        !self.kills && self.out.is_empty() && !self.writes.contains(&true)
    }
}

/// Where the instances come from.
pub(super) struct Choice {
    pub kernel: Option<&'static CompiledKernel>,
    pub isa: Isa,
    pub lattice: bool,
    /// Single precision where a sweep may have it.
    pub single: bool,
    pub flavour: Flavour,
}

pub(super) fn programs(spec: &Spec, choice: &Choice) -> Result<Vec<Program>, SetupError> {
    let one = |(k, s): (usize, &SweepSpec)| {
        program(spec, k, s, choice)
            .map_err(|e| SetupError::law(&spec.law, format!("sweep `{}`: {e}", s.name)))
    };
    spec.sweeps.iter().enumerate().map(one).collect()
}

fn program(
    spec: &Spec,
    position: usize,
    s: &SweepSpec,
    choice: &Choice,
) -> Result<Program, TapeError> {
    check_lists(spec, s)?;
    let (geometry, bond) = match choice.lattice {
        true => (&s.geometry, s.bond.clone()),
        false => (&s.streams, with_streams(s)?),
    };
    if !choice.lattice {
        // A cloud runs others in their place, but whether bonds may break is asked of these.
        let limits = limits(spec, s, s.geometry.outs.len());
        Code::new(&s.geometry, Place::Geometry, &limits, choice.flavour)?;
        Code::new(&s.bond, Place::Bond, &limits, choice.flavour)?;
    }
    let limits = limits(spec, s, geometry.outs.len());
    let code = |tape, place| Code::new(tape, place, &limits, choice.flavour);
    let tape = Box::new(TapeSweep {
        pre: code(&s.pre, Place::Pre)?,
        bond: code(&bond, Place::Bond)?,
        post: code(&s.post, Place::Post)?,
        extremes: s.bond.ops.iter().fold(0, |bits, op| match op {
            Op::MaxTo(k, _) => bits | 1 << k,
            _ => bits,
        }),
        streams: match choice.lattice {
            true => 0,
            false => s.streams.outs.len(),
        },
    });
    if s.post.outs.len() != s.out.len() {
        return Err(TapeError(format!(
            "{} values for {} slots",
            s.post.outs.len(),
            s.out.len()
        )));
    }
    let entries = choice
        .kernel
        .and_then(|k| k.sweeps.iter().find(|e| e.0 == position));
    let index = |list: &[u32]| list.iter().map(|&k| k as usize).collect::<Vec<_>>();
    let confined = parts::confined(spec, &index(&s.own), &index(&s.out));
    let single = choice.single && s.single;
    let single = match entries {
        _ if !single => None,
        Some((_, e)) => e.single,
        None => interpreted_single(spec.dim),
    };
    let single = single.map(|s| match choice.isa {
        // What is stored on a part of the body need not lie side by side in two chunks.
        Isa::Avx512 if confined.is_empty() => s.wide,
        _ => s.avx2,
    });
    let run = match entries {
        Some((_, e)) => compiled(e, choice),
        None => interpreted(spec.dim, choice.isa, choice.lattice),
    };
    let kill = s.bond.ops.iter().position(|op| matches!(op, Op::Kill(_)));
    let add = s
        .bond
        .ops
        .iter()
        .position(|op| matches!(op, Op::AddTo(..) | Op::MaxTo(..)));
    let history = s
        .history
        .iter()
        .map(|&h| history_position(spec, h as usize))
        .collect::<Vec<_>>();
    let writes = |k: usize| {
        s.bond
            .ops
            .iter()
            .any(|op| matches!(*op, Op::PutHistory(h, _) if h as usize == k))
    };
    let stays = !confined.is_empty()
        && kill.is_none()
        && !(0..history.len()).any(writes)
        && s.out.iter().all(|k| spec.slots[*k as usize].part.is_some());
    Ok(Program {
        name: s.name.clone(),
        stage: s.stage,
        family: s.family as usize,
        reference: s.reference,
        kills: kill.is_some(),
        kills_after: s.stage == Stage::Update || matches!((kill, add), (Some(k), Some(a)) if a < k),
        own: index(&s.own),
        nbr: index(&s.nbr),
        out: index(&s.out),
        writes: (0..history.len()).map(writes).collect(),
        history,
        reads_reverse: s.bond.ops.iter().any(|op| matches!(op, Op::Reverse(_))),
        loops: !tape.bond.steps.is_empty(),
        confined,
        stays,
        geometry: code(geometry, Place::Geometry)?,
        tape,
        compiled: entries.is_some(),
        run,
        single,
        unread: false,
    })
}

fn limits(spec: &Spec, s: &SweepSpec, geometry: usize) -> Limits {
    Limits {
        dim: spec.dim,
        variables: 0,
        params: spec.params.len(),
        influences: spec.influences.len(),
        constants: spec.constants.outs.len(),
        own: s.own.len(),
        nbr: s.nbr.len(),
        geometry,
        pre: s.pre.outs.len(),
        accumulators: s.accumulators as usize,
        history: s.history.len(),
        kills: s.kills && !s.reference && matches!(s.stage, Stage::Step | Stage::Update),
        updates: matches!(s.stage, Stage::Reference | Stage::Update),
    }
}

/// Ids in range, and no write that another node could read in the same sweep.
fn check_lists(spec: &Spec, s: &SweepSpec) -> Result<(), TapeError> {
    let fail = |m: String| Err(TapeError(m));
    if s.family as usize >= spec.families.len() {
        return fail(format!("family {} does not exist", s.family));
    }
    for (name, list) in [
        ("read", &s.own),
        ("read at the other end", &s.nbr),
        ("written", &s.out),
    ] {
        if list.len() > MAX_SLOTS {
            return fail(format!(
                "{} slots are {name}, {MAX_SLOTS} are possible",
                list.len()
            ));
        }
        if let Some(k) = list.iter().find(|&&k| k as usize >= spec.slots.len()) {
            return fail(format!("slot {k} does not exist"));
        }
    }
    for &k in &s.out {
        if !matches!(spec.slots[k as usize].kind, SlotKind::Computed(_)) {
            return fail(format!(
                "slot `{}` is state and cannot be written",
                spec.slots[k as usize].name
            ));
        }
        if s.nbr.contains(&k) || s.out.iter().filter(|&&o| o == k).count() > 1 {
            return fail(format!(
                "slot `{}` is written twice, or while other nodes read it",
                spec.slots[k as usize].name
            ));
        }
    }
    for (n, most, name) in [
        (s.geometry.outs.len(), MAX_GEOMETRY, "geometry values"),
        (s.streams.outs.len(), MAX_GEOMETRY, "streams"),
        (s.pre.outs.len(), MAX_VALUES, "prologue values"),
        (s.accumulators as usize, MAX_VALUES, "sums"),
        (s.history.len(), MAX_HISTORIES, "histories"),
    ] {
        if n > most {
            return fail(format!("{n} {name}, {most} are possible"));
        }
    }
    for &h in &s.history {
        let of_family = match (h as usize).checked_sub(spec.histories.len()) {
            None => {
                let h = &spec.histories[h as usize];
                h.bond && h.family == s.family && s.stage != Stage::Reference
            }
            Some(w) => spec.weights.get(w).is_some_and(|w| w.family == s.family),
        };
        if !of_family {
            return fail(format!("{h} is no bond history or weight of its family"));
        }
    }
    Ok(())
}

/// Position of a history or weight among the bond histories and then the weights of its family.
fn history_position(spec: &Spec, h: usize) -> usize {
    let weight = h.checked_sub(spec.histories.len());
    let family = match weight {
        None => spec.histories[h].family,
        Some(w) => spec.weights[w].family,
    };
    let before = spec.histories.iter().take(h);
    let histories = before.filter(|o| o.bond && o.family == family).count();
    let weights = spec.weights.iter().take(weight.unwrap_or(0));
    histories + weights.filter(|o| o.family == family).count()
}

fn compiled(e: &Entries, choice: &Choice) -> [Run; 2] {
    let i: &Instances = match choice.isa {
        Isa::Scalar => &e.scalar,
        #[cfg(target_arch = "x86_64")]
        Isa::Avx2 => &e.avx2,
        #[cfg(target_arch = "x86_64")]
        Isa::Avx512 => &e.avx512,
        #[cfg(not(target_arch = "x86_64"))]
        _ => &e.scalar,
    };
    if choice.lattice { i.lattice } else { i.cloud }
}
