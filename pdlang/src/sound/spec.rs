//! The law as data: every value is there before it is read, nothing is there in vain.

use std::collections::BTreeSet;

use super::Report;
use super::tapes::{Place, Port, Ports, check};
use crate::ir::Meet;
use crate::spec::{SlotKind, Spec, Stage, Stepped, SweepSpec};
use crate::tape::Op;

/// What is wrong with a law as data.
#[must_use]
pub fn spec(s: &Spec) -> Vec<String> {
    let mut report = Report::default();
    check(
        &mut report,
        &s.constants,
        Place::Constants,
        &|port| match port {
            Port::Param => s.params.len(),
            Port::Omega => s.influences.len(),
            _ => 0,
        },
    );
    let mut reads = Ports::new();
    for i in &s.influences {
        let Some(f) = &i.default else { continue };
        report.at(format!("influence function `{}`", f.name));
        check(&mut report, &f.body, Place::Influence, &|port| match port {
            Port::Var => 1 + f.params.len(),
            _ => 0,
        });
    }
    for p in &s.params {
        if let Meet::Formula(_, tape) = &p.meet {
            report.at(format!("parameter `{}`", p.name));
            check(&mut report, tape, Place::Meet, &|port| match port {
                Port::Var => 4,
                _ => 0,
            });
        }
    }
    for family in &s.families {
        let Some(filter) = &family.filter else {
            continue;
        };
        report.at(format!("family `{}`", family.name));
        reads.extend(check(&mut report, filter, Place::Filter, &|port| {
            reference(s, port)
        }));
        if filter.outs.len() != 1 {
            report.add("a filter has one output".into());
        }
    }
    let mut slots = Slots::new(s);
    for sweep in &s.sweeps {
        report.at(format!("sweep `{}` ({:?})", sweep.name, sweep.stage));
        reads.extend(tapes(&mut report, s, sweep));
        slots.sweep(&mut report, s, sweep);
    }
    report.at("law".into());
    for k in 0..s.constants.outs.len() as u32 {
        if !reads.contains(&(Port::Const, k)) {
            report.add(format!("constant {k} is read by nobody"));
        }
    }
    slots.answers(&mut report, s);
    promises(&mut report, s);
    report.found
}

/// Slots that are computed though no sweep and no answer needs them. Not unsound, but not free.
#[must_use]
pub fn unread(s: &Spec) -> Vec<&str> {
    let sweeps = s.sweeps.iter().flat_map(|w| w.own.iter().chain(&w.nbr));
    let named = s.named.iter().flat_map(|(_, slots)| slots);
    let answers = s
        .force
        .iter()
        .chain(&s.tangent)
        .chain(&s.energy)
        .chain(named);
    let next = s
        .histories
        .iter()
        .filter_map(|h| h.slot.as_ref().map(|(_, next)| next));
    let rates = s
        .rates
        .iter()
        .flat_map(|r| [Some(&r.rate), r.damping.as_ref()]);
    let read: BTreeSet<u32> = sweeps
        .chain(answers)
        .chain(next)
        .chain(rates.flatten())
        .chain(&s.after_step)
        .chain(s.parts.iter().map(|p| &p.slot))
        .copied()
        .collect();
    let computed = |(k, slot): &(usize, &crate::spec::SlotSpec)| {
        matches!(slot.kind, SlotKind::Computed(_)) && !read.contains(&(*k as u32))
    };
    let slots = s.slots.iter().enumerate().filter(computed);
    slots.map(|(_, slot)| slot.name.as_str()).collect()
}

fn reference(s: &Spec, port: Port) -> usize {
    match port {
        Port::Const => s.constants.outs.len(),
        Port::Omega => s.influences.len(),
        Port::Axis => s.dim,
        _ => 0,
    }
}

/// The tapes of a sweep, and that each list beside them is used to the last entry.
fn tapes(report: &mut Report, s: &Spec, w: &SweepSpec) -> Ports {
    let limit = |port: Port| match port {
        Port::Own => w.own.len(),
        Port::Nbr => w.nbr.len(),
        Port::Geo => w.geometry.outs.len(),
        Port::Pre => w.pre.outs.len(),
        Port::Acc | Port::AddTo | Port::MaxTo => w.accumulators as usize,
        Port::History | Port::Put => w.history.len(),
        _ => reference(s, port),
    };
    let mut ports = check(report, &w.geometry, Place::Geometry, &limit);
    ports.extend(check(report, &w.streams, Place::Geometry, &limit));
    streams(report, s, w);
    for (tape, place) in [
        (&w.pre, Place::Pre),
        (&w.bond, Place::Bond),
        (&w.post, Place::Post),
    ] {
        ports.extend(check(report, tape, place, &limit));
    }
    let mut all_used = |what: &str, n: usize, by: &[Port]| {
        for k in 0..n as u32 {
            if !by.iter().any(|port| ports.contains(&(*port, k))) {
                report.add(format!("{what} {k} is used by nobody"));
            }
        }
    };
    all_used("own slot", w.own.len(), &[Port::Own]);
    all_used("slot of the other end", w.nbr.len(), &[Port::Nbr]);
    all_used("table", w.geometry.outs.len(), &[Port::Geo]);
    all_used("prologue value", w.pre.outs.len(), &[Port::Pre]);
    all_used("sum", w.accumulators as usize, &[Port::Acc]);
    all_used("history", w.history.len(), &[Port::History, Port::Put]);
    for k in 0..w.accumulators {
        if [Port::AddTo, Port::MaxTo]
            .iter()
            .all(|port| ports.contains(&(*port, k)))
        {
            report.add(format!("sum {k} is a sum and an extreme"));
        }
    }
    let kills = ports.contains(&(Port::Kill, 0));
    if kills != w.kills {
        report.add(format!("breaks bonds: {kills}, declared {}", w.kills));
    }
    if kills && (w.reference || !matches!(w.stage, Stage::Step | Stage::Update)) {
        report.add("bonds may break over intact bonds, in a step or after it, only".into());
    }
    for k in puts(s, w) {
        let right = match is_weight(s, k) {
            false => !w.reference && w.stage == Stage::Update,
            true => w.reference && w.stage == Stage::Reference,
        };
        if !right {
            report.add(
                "histories change over intact bonds in an update only, weights over all of the reference".into(),
            );
        }
    }
    if w.post.outs.len() != w.out.len() {
        report.add(format!(
            "{} values for {} slots",
            w.post.outs.len(),
            w.out.len()
        ));
    }
    ports
}

/// What a cloud keeps is used, and gives all values of geometry.
fn streams(report: &mut Report, s: &Spec, w: &SweepSpec) {
    let limit = |port: Port| match port {
        Port::Geo => w.streams.outs.len(),
        _ => reference(s, port),
    };
    let ports = check(report, &w.from_streams, Place::FromStreams, &limit);
    for k in 0..w.streams.outs.len() as u32 {
        if !ports.contains(&(Port::Geo, k)) {
            report.add(format!("stream {k} is used by nobody"));
        }
    }
    let (values, formed) = (w.geometry.outs.len(), w.from_streams.outs.len());
    if values != formed {
        report.add(format!(
            "{values} values of geometry, {formed} from streams"
        ));
    }
}

/// Weights are numbered behind the histories.
fn is_weight(s: &Spec, number: u32) -> bool {
    number as usize >= s.histories.len()
}

/// Numbers of the histories and weights that the bonds of a sweep write.
fn puts(s: &Spec, w: &SweepSpec) -> Vec<u32> {
    let put = |op: &Op| match op {
        Op::PutHistory(k, _) => w.history.get(*k as usize).copied(),
        _ => None,
    };
    let numbers = w.bond.ops.iter().filter_map(put);
    numbers
        .filter(|k| (*k as usize) < s.histories.len() + s.weights.len())
        .collect()
}

/// The node slots and the weights, sweep after sweep.
struct Slots {
    written: BTreeSet<u32>,
    weighed: BTreeSet<u32>,
    last: Option<Stage>,
}

impl Slots {
    fn new(s: &Spec) -> Slots {
        let is_state = |k: &u32| !matches!(s.slots[*k as usize].kind, SlotKind::Computed(_));
        Slots {
            written: (0..s.slots.len() as u32).filter(is_state).collect(),
            weighed: BTreeSet::new(),
            last: None,
        }
    }

    fn sweep(&mut self, report: &mut Report, s: &Spec, w: &SweepSpec) {
        if self.last > Some(w.stage) {
            report.add(format!("stands behind one of stage {:?}", self.last));
        }
        self.last = self.last.max(Some(w.stage));
        if w.family as usize >= s.families.len() {
            report.add(format!("family {} does not exist", w.family));
        }
        for k in w.own.iter().chain(&w.nbr) {
            let Some(slot) = s.slots.get(*k as usize) else {
                report.add(format!("slot {k} does not exist"));
                continue;
            };
            if !self.written.contains(k) {
                report.add(format!("reads `{}` before it is written", slot.name));
            }
            if w.stage == Stage::Step && is_half(s, *k) && !self.half_rates_known(s) {
                report.add(format!(
                    "reads `{}` before it is at its half step",
                    slot.name
                ));
            }
            match slot.kind {
                SlotKind::Increment(_) if w.stage != Stage::Tangent => {
                    report.add(format!(
                        "reads `{}`, which the tangent only knows",
                        slot.name
                    ));
                }
                // What a stage behind the step computed is not there for another such stage.
                SlotKind::Computed(of) if of > Stage::Step && of != w.stage => {
                    report.add(format!("reads `{}` of stage {of:?}", slot.name));
                }
                SlotKind::Computed(of) if of > w.stage => {
                    report.add(format!("reads `{}` of the later stage {of:?}", slot.name));
                }
                _ => {}
            }
        }
        for k in &w.out {
            let Some(slot) = s.slots.get(*k as usize) else {
                report.add(format!("slot {k} does not exist"));
                continue;
            };
            if slot.kind != SlotKind::Computed(w.stage) {
                report.add(format!("writes `{}`, which is {:?}", slot.name, slot.kind));
            }
            if w.nbr.contains(k) {
                report.add(format!("writes `{}` while other nodes read it", slot.name));
            }
            if !self.written.insert(*k) {
                report.add(format!("writes `{}` a second time", slot.name));
            }
        }
        let histories = |h: &u32| match h.checked_sub(s.histories.len() as u32) {
            None => {
                let h = &s.histories[*h as usize];
                h.bond && h.family == w.family
            }
            Some(k) => s
                .weights
                .get(k as usize)
                .is_some_and(|weight| weight.family == w.family),
        };
        if !w.history.iter().all(histories) {
            report.add("reads a history that its family does not have".into());
        }
        for op in &w.bond.ops {
            let (Op::History(k) | Op::Reverse(k)) = op else {
                continue;
            };
            let number = w.history.get(*k as usize).filter(|n| is_weight(s, **n));
            if number.is_some_and(|n| !self.weighed.contains(n)) {
                report.add("reads a weight before it is written".into());
            }
        }
        let puts = puts(s, w);
        self.weighed.extend(&puts);
        if w.out.is_empty() && !w.kills && puts.is_empty() {
            report.add("does nothing".into());
        }
    }

    /// What fields at half steps are stepped with.
    fn half_rates_known(&self, s: &Spec) -> bool {
        let half = s.rates.iter().filter(|r| r.stepped == Stepped::Half);
        let mut needed = half.flat_map(|r| [Some(r.rate), r.damping]).flatten();
        needed.all(|k| self.written.contains(&k))
    }

    /// What the law answers is written, at its stage.
    fn answers(&self, report: &mut Report, s: &Spec) {
        let mut answer = |what: &str, k: u32, most: Stage| {
            let kind = s.slots.get(k as usize).map(|slot| slot.kind);
            let in_time = match kind {
                Some(SlotKind::Computed(stage)) => stage <= Stage::Step || stage == most,
                Some(_) => true,
                None => false,
            };
            if !in_time || !self.written.contains(&k) {
                report.add(format!("{what}: slot {k} is {kind:?}"));
            }
        };
        for k in &s.force {
            answer("force", *k, Stage::Step);
        }
        for r in &s.rates {
            answer("rate", r.rate, Stage::Step);
            if let Some(damping) = r.damping {
                answer("damping", damping, Stage::Step);
            }
            if s.slots.get(r.field as usize).map(|slot| slot.kind) != Some(SlotKind::State) {
                answer("field with a rate", u32::MAX, Stage::Step);
            }
        }
        for p in &s.parts {
            answer("part of the body", p.slot, Stage::Part);
        }
        for k in &s.after_step {
            answer("velocity after the step", *k, Stage::Update);
        }
        for k in &s.tangent {
            answer("tangent", *k, Stage::Tangent);
        }
        for k in s
            .energy
            .iter()
            .chain(s.named.iter().flat_map(|(_, slots)| slots))
        {
            answer("energy or named value", *k, Stage::Energy);
        }
        for (_, next) in s.histories.iter().filter_map(|h| h.slot) {
            answer("next value of a history", next, Stage::Update);
        }
    }
}

fn is_half(s: &Spec, slot: u32) -> bool {
    let mut of = s.rates.iter().filter(|r| r.field == slot);
    of.any(|r| r.stepped == Stepped::Half)
}

/// What the law says about itself.
fn promises(report: &mut Report, s: &Spec) {
    for (what, n) in [
        ("force", s.force.len()),
        ("tangent", s.tangent.len()),
        ("velocity after the step", s.after_step.len()),
    ] {
        if n != 0 && n != s.dim {
            report.add(format!("{what} of {n} components in {}D", s.dim));
        }
    }
    if s.breaks != s.sweeps.iter().any(|w| w.kills) {
        report.add(format!("bonds break: {}, declared {}", !s.breaks, s.breaks));
    }
    on_parts(report, s);
    // Every history of a bond changes somewhere, once, and every weight is written once.
    let changes = |k: usize| {
        let of = s.sweeps.iter().filter(|w| puts(s, w).contains(&(k as u32)));
        of.count()
    };
    for (k, h) in s.histories.iter().enumerate() {
        let n = changes(k);
        if h.bond && n != 1 || !h.bond && h.slot.is_none() {
            report.add(format!("history `{}` changes in {n} sweeps", h.name));
        }
    }
    for (k, w) in s.weights.iter().enumerate() {
        let n = changes(s.histories.len() + k);
        if n != 1 {
            report.add(format!("weight `{}` is written in {n} sweeps", w.name));
        }
    }
}

/// What is stored on a part of the body is a field that lives there, or what it is stepped with; nobody looks for it
/// elsewhere.
fn on_parts(report: &mut Report, s: &Spec) {
    for f in s.fields.iter().filter(|f| f.part.is_some()) {
        if f.part.is_some_and(|k| k as usize >= s.parts.len()) {
            report.add(format!("`{}` lives on a part that does not exist", f.name));
        }
    }
    let of = |slot: u32| s.fields.iter().find(|f| f.slots.contains(&slot));
    for (k, slot) in s.slots.iter().enumerate().filter(|(_, s)| s.part.is_some()) {
        let k = k as u32;
        let steps = |r: &&crate::spec::RateSpec| {
            [Some(r.field), Some(r.rate), r.damping].contains(&Some(k))
        };
        let mut served = s.rates.iter().filter(steps).peekable();
        let alien = served.peek().is_none()
            || served.any(|r| of(r.field).is_none_or(|f| f.part != slot.part));
        let computed = matches!(slot.kind, SlotKind::Computed(_));
        let read = |w: &SweepSpec| w.nbr.contains(&k) || computed && w.own.contains(&k);
        if alien || s.sweeps.iter().any(read) {
            report.add(format!(
                "`{}` is needed beyond its part of the body",
                slot.name
            ));
        }
    }
}
