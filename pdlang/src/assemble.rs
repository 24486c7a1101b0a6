//! A checked law -> its responses as polynomials -> schedule -> [`Spec`], at one dimension.

mod answers;

use std::collections::{BTreeMap, BTreeSet};

use crate::constants::Constants;
use crate::damping;
use crate::diag::Diagnostic;
use crate::direct;
use crate::ir::{History, Home, Law};
use crate::linear::{self, Linear};
use crate::lower::{Lowering, Reading, stored_components, stored_names};
use crate::poly::{Algebra, Atom, Func, Poly};
use crate::schedule::{Responses, Schedule};
use crate::single;
use crate::spec::{
    FamilySpec, FieldSpec, HistorySpec, InfluenceFn, InfluenceSpec, Number, ParamSpec, PartSpec,
    RateSpec, SlotKind, Spec, SweepSpec, WeightSpec,
};
use crate::streams;
use crate::sweep;
use crate::tape::Builder;
use crate::units::Unit;

use answers::answers;

/// What one stage hands to the next.
pub enum Between<'a> {
    /// Lowered and derived.
    Answers(&'a Algebra, &'a Responses),
    Schedule(&'a mut Algebra, &'a Schedule),
}

/// Displacements as large as they come, or what is left of the law for small ones.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Kinematics {
    #[default]
    General,
    Linearised,
}

/// A law for every number of dimensions that it is meant for.
///
/// # Errors
/// As [`spec`].
pub fn specs(law: &Law, kinematics: Kinematics) -> Result<Vec<Spec>, Vec<Diagnostic>> {
    let served = |dim: &usize| law.flavours.iter().any(|flavour| flavour.dim() == *dim);
    let dims = (1..=3).filter(served);
    dims.map(|dim| spec(law, dim, kinematics)).collect()
}

/// Compiles a law for bodies of `dim` dimensions.
///
/// # Errors
/// A law whose coefficients do not fit exact arithmetic, or one that cannot be linearised.
pub fn spec(law: &Law, dim: usize, kinematics: Kinematics) -> Result<Spec, Vec<Diagnostic>> {
    watched(law, dim, kinematics, &mut |_| {})
}

/// As [`spec`]; `watch` sees what stands between the stages.
///
/// # Errors
/// As [`spec`].
pub fn watched(
    law: &Law,
    dim: usize,
    kinematics: Kinematics,
    watch: &mut dyn FnMut(Between),
) -> Result<Spec, Vec<Diagnostic>> {
    let mut algebra = Algebra::default();
    let mut lowering = Lowering::new(law, dim, &mut algebra);
    let linearised = kinematics == Kinematics::Linearised;
    if linearised {
        let refused = linear::refused(law);
        lowering.linear = Some(Linear::default());
        if !refused.is_empty() {
            return Err(refused);
        }
    }
    let weights = weights(&mut lowering);
    let mut answers = answers(&mut lowering);
    if let Some(linear) = lowering.linear.take().filter(|l| !l.refused.is_empty()) {
        return Err(linear.refused);
    }
    answers.responses.weights = weights;
    let (parts, part_of) = parts(&mut lowering);
    answers.responses.parts = parts.iter().map(|part| part.1.clone()).collect();
    let (field_slots, history_slots) =
        (lowering.field_slots.clone(), lowering.history_slots.clone());
    let filters = filters(&mut lowering);
    let components = |h: &History| stored_components(h.shape, dim) as u32;
    let remembered = law.histories.iter().map(components).sum();
    let mut schedule = Schedule::new(dim, state_names(law, dim), remembered);
    watch(Between::Answers(&algebra, &answers.responses));
    schedule.build(&mut algebra, &answers.responses);
    watch(Between::Schedule(&mut algebra, &schedule));
    name_slots(&mut schedule, &answers.responses);
    let mut constants = Constants::default();
    let families = families(law, &mut algebra, &mut constants, &filters);
    let drafts = schedule.drafts.clone();
    let written: Vec<(SweepSpec, Vec<Poly>)> = drafts
        .iter()
        .map(|d| {
            sweep::write(
                &mut algebra,
                &mut schedule,
                &mut constants,
                d,
                &answers.vectors,
            )
        })
        .collect();
    let sweeps = streams::choose(&mut algebra, &mut constants, dim, written);
    if algebra.overflow {
        return Err(vec![too_large(law, dim)]);
    }
    let r = &answers.responses;
    let slot = |p: &Poly, s: &Schedule, stage| s.find(p, stage).map_or(0, |q| q.slot);
    use crate::spec::Stage::{Energy, Part, Step, Tangent, Update};
    let part = |(text, p): (String, Poly)| PartSpec {
        condition: text,
        slot: slot(&p, &schedule, Part),
    };
    let mut spec = Spec {
        law: law.name.clone(),
        title: law.title.clone(),
        cites: law.cites.clone(),
        flavours: law.flavours.iter().map(|f| f.name()).collect(),
        dim,
        linearised,
        params: law.params.iter().map(param).collect(),
        influences: law.influences.iter().map(influence).collect(),
        families,
        fields: fields(law, dim, &field_slots, &part_of),
        parts: parts.into_iter().map(part).collect(),
        histories: histories(law, dim, &history_slots, &schedule, r, Update),
        constants: constants.builder.tape,
        sweeps,
        force: r.force.iter().map(|p| slot(p, &schedule, Step)).collect(),
        tangent: r
            .tangent
            .iter()
            .map(|p| slot(p, &schedule, Tangent))
            .collect(),
        energy: r.energy.as_ref().map(|p| slot(p, &schedule, Energy)),
        rates: rates(r, &algebra, &schedule),
        after_step: r
            .after_step
            .iter()
            .map(|p| slot(p, &schedule, Update))
            .collect(),
        breaks: !law.breaks.is_empty(),
        pairwise: answers.pairwise,
        named: r
            .named
            .iter()
            .map(|(n, ps)| {
                (
                    n.clone(),
                    ps.iter().map(|p| slot(p, &schedule, Energy)).collect(),
                )
            })
            .collect(),
        weights: schedule
            .weights()
            .map(|(weight, family)| WeightSpec {
                name: law.weights[weight as usize].name.clone(),
                doc: law.weights[weight as usize].doc.clone(),
                family: family.0,
            })
            .collect(),
        slots: schedule.slots,
    };
    store_on_parts(&mut spec);
    single::mark(&mut spec);
    Ok(spec)
}

/// Conditions of the parts of the body that fields live on, each once, as they are written and as numbers of that
/// name; and for every field the part that it lives on.
fn parts(lowering: &mut Lowering) -> (Vec<(String, Poly)>, Vec<Option<u32>>) {
    let law = lowering.law;
    let mut conditions: Vec<Poly> = Vec::new();
    let mut found = Vec::new();
    let mut of_field = Vec::new();
    for field in &law.fields {
        of_field.push(field.lives.as_ref().map(|lives| {
            let when = lowering.value(lives.when, Reading::Whole).remove(0);
            if let Some(known) = conditions.iter().position(|p| *p == when) {
                return known as u32;
            }
            let choice = vec![when.clone(), Poly::int(1), Poly::zero()];
            let number = lowering.algebra.func(Func::Select, choice);
            let named = Atom::Named(format!("where {}", lives.text), number);
            found.push((lives.text.clone(), lowering.algebra.poly(named)));
            conditions.push(when);
            conditions.len() as u32 - 1
        }));
    }
    (found, of_field)
}

/// Fields that live on a part of the body are stored there alone, and so are their rates, unless somebody reads them
/// at the other end of a bond or as something else.
fn store_on_parts(spec: &mut Spec) {
    let of = |slot: u32| spec.fields.iter().find(|f| f.slots.contains(&slot));
    let part = |r: &RateSpec| of(r.field).and_then(|f| f.part);
    let sweeps = || spec.sweeps.iter();
    let named = spec.named.iter().flat_map(|(_, slots)| slots);
    let next = spec.histories.iter().filter_map(|h| h.slot);
    let answers: BTreeSet<u32> = sweeps()
        .flat_map(|s| s.own.iter().chain(&s.nbr))
        .chain(&spec.force)
        .chain(&spec.tangent)
        .chain(&spec.energy)
        .chain(&spec.after_step)
        .chain(named)
        .copied()
        .chain(next.map(|(_, next)| next))
        .collect();
    // What only rates of one part need.
    let alone = |slot: u32, part_of: Option<u32>| {
        let uses = |r: &&RateSpec| r.rate == slot || r.damping == Some(slot);
        !answers.contains(&slot) && spec.rates.iter().filter(uses).all(|r| part(r) == part_of)
    };
    let mut stored: Vec<(u32, Option<u32>)> = Vec::new();
    for r in spec.rates.iter().filter(|r| part(r).is_some()) {
        let far = sweeps().any(|s| s.nbr.contains(&r.field));
        let damps = spec.rates.iter().any(|o| o.damping == Some(r.field));
        if far || damps || !alone(r.rate, part(r)) {
            continue;
        }
        stored.extend([(r.field, part(r)), (r.rate, part(r))]);
        let computed = |k: &u32| matches!(spec.slots[*k as usize].kind, SlotKind::Computed(_));
        let damping = r.damping.filter(computed).filter(|k| alone(*k, part(r)));
        stored.extend(damping.map(|k| (k, part(r))));
    }
    for (slot, part) in stored {
        spec.slots[slot as usize].part = part;
    }
}

/// A damping of nothing has no slot.
fn rates(r: &Responses, algebra: &Algebra, schedule: &Schedule) -> Vec<RateSpec> {
    let slot = |p: &Poly| schedule.find(p, crate::spec::Stage::Step).map(|q| q.slot);
    let damping = |rate: &damping::Rate| match rate.damping.is_zero() {
        true => None,
        false => rate.damping_field(algebra).or_else(|| slot(&rate.damping)),
    };
    let rate = |rate: &damping::Rate| RateSpec {
        field: rate.slot,
        rate: slot(&rate.drive).unwrap_or_default(),
        damping: damping(rate),
        stepped: rate.stepped,
    };
    r.rates.iter().map(rate).collect()
}

pub(crate) fn too_large(law: &Law, dim: usize) -> Diagnostic {
    let place = law
        .defs
        .iter()
        .map(|d| d.span)
        .find(|s| !s.prelude)
        .unwrap_or_default();
    let message = format!("`{}` does not fit exact arithmetic in {dim}D", law.name);
    Diagnostic::error("PD090", message)
        .at(
            place,
            "multiplied out, this has coefficients beyond 38 digits or thousands of terms",
        )
        .help("write numbers with fewer digits, or name a part of the expression with `let`")
}

/// The weights; those that are the same from both ends of a bond are known as such from then on.
fn weights(lowering: &mut Lowering) -> Vec<Poly> {
    let law = lowering.law;
    let mut found = Vec::new();
    for (k, weight) in law.weights.iter().enumerate() {
        let value = lowering.value(weight.expr, Reading::Whole).remove(0);
        if lowering.algebra.prime(&value) == value {
            lowering.algebra.symmetric.insert(k as u32);
        }
        found.push(value);
    }
    found
}

fn state_names(law: &Law, dim: usize) -> Vec<String> {
    let fields = law.fields.iter().map(|f| (&f.name, f.shape));
    let nodes = law.histories.iter().filter(|h| h.home == Home::Node);
    let named = fields.chain(nodes.map(|h| (&h.name, h.shape)));
    named
        .flat_map(|(n, s)| {
            let parts = stored_names(s, dim).into_iter();
            parts.map(move |part| format!("{n}{part}"))
        })
        .collect()
}

fn name_slots(schedule: &mut Schedule, r: &Responses) {
    use crate::spec::Stage::{Energy, Step, Tangent};
    let axes = ["x", "y", "z"];
    let mut names: BTreeMap<u32, String> = BTreeMap::new();
    let mut note = |slot: Option<u32>, name: String| {
        if let Some(slot) = slot {
            names.entry(slot).or_insert(name);
        }
    };
    let find = |p: &Poly, s| schedule.find(p, s).map(|q| q.slot);
    for (n, ps) in &r.named {
        for (k, p) in ps.iter().enumerate() {
            let name = if ps.len() == 1 {
                n.clone()
            } else {
                format!("{n}_{k}")
            };
            note(find(p, Energy), name);
        }
    }
    for (p, a) in r.force.iter().zip(axes) {
        note(find(p, Step), format!("force_{a}"));
    }
    for (p, a) in r.tangent.iter().zip(axes) {
        note(find(p, Tangent), format!("tangent_{a}"));
    }
    if let Some(p) = &r.energy {
        note(find(p, Energy), "energy".into());
    }
    for (k, rate) in r.rates.iter().enumerate() {
        note(find(&rate.drive, Step), format!("rate{k}"));
        note(find(&rate.damping, Step), format!("damping{k}"));
    }
    for (slot, name) in names {
        if matches!(schedule.slots[slot as usize].kind, SlotKind::Computed(_)) {
            schedule.rename(slot, name);
        }
    }
}

fn filters(lowering: &mut Lowering) -> Vec<Option<Poly>> {
    let law = lowering.law;
    law.families
        .iter()
        .map(|f| {
            f.filter
                .map(|e| lowering.value(e, Reading::Split).remove(0))
        })
        .collect()
}

fn families(
    law: &Law,
    algebra: &mut Algebra,
    constants: &mut Constants,
    filters: &[Option<Poly>],
) -> Vec<FamilySpec> {
    let tape = |algebra: &mut Algebra, constants: &mut Constants, p: &Poly| {
        let mut b = Builder::default();
        let r = constants.geometry(algebra, &mut b, p);
        b.out(r);
        b.tape
    };
    law.families
        .iter()
        .zip(filters)
        .map(|(f, p)| FamilySpec {
            name: f.name.clone(),
            filter: p.as_ref().map(|p| tape(algebra, constants, p)),
        })
        .collect()
}

fn fields(law: &Law, dim: usize, first: &[u32], parts: &[Option<u32>]) -> Vec<FieldSpec> {
    law.fields
        .iter()
        .zip(first)
        .zip(parts)
        .map(|((f, s), part)| FieldSpec {
            name: f.name.clone(),
            slots: (0..stored_components(f.shape, dim) as u32)
                .map(|k| s + k)
                .collect(),
            components: stored_names(f.shape, dim),
            exponents: f.unit.base,
            part: *part,
        })
        .collect()
}

fn histories(
    law: &Law,
    dim: usize,
    first: &[u32],
    schedule: &Schedule,
    r: &Responses,
    stage: crate::spec::Stage,
) -> Vec<HistorySpec> {
    let mut out = Vec::new();
    // Bond histories come first: kernels count them alone.
    for bond in [true, false] {
        for (h, history) in law.histories.iter().enumerate() {
            if (history.home == Home::Bond) != bond {
                continue;
            }
            for k in 0..stored_components(history.shape, dim) as u32 {
                let current = first[h] + k;
                let next = r.node_updates.iter().find(|(s, _)| *s == current);
                let next = next
                    .and_then(|(_, p)| schedule.find(p, stage))
                    .map(|q| q.slot);
                out.push(HistorySpec {
                    name: history.name.clone(),
                    bond,
                    family: history.family.0,
                    initial: history.initial,
                    slot: next.filter(|_| !bond).map(|n| (current, n)),
                });
            }
        }
    }
    out
}

pub fn param(p: &crate::ir::Param) -> ParamSpec {
    let bound = |b: Option<crate::ir::Bound>| {
        b.filter(|b| b.value.is_finite())
            .map(|b| (b.value, b.inclusive))
    };
    ParamSpec {
        name: p.name.clone(),
        doc: p.doc.clone(),
        unit: unit_text(&p.unit),
        exponents: p.unit.base,
        meet: p.meet.clone(),
        lower: bound(p.lower),
        upper: bound(p.upper),
        default: p.default.map(|v| {
            if v.is_finite() {
                Number::Finite(v)
            } else {
                Number::Infinite
            }
        }),
    }
}

fn influence(i: &crate::ir::Influence) -> InfluenceSpec {
    InfluenceSpec {
        name: i.name.clone(),
        default: i.default.as_ref().map(influence_fn),
    }
}

/// An influence function as the runtime reads it.
pub fn influence_fn(f: &crate::ir::InfluenceFn) -> InfluenceFn {
    InfluenceFn {
        name: f.name.clone(),
        params: f.params.iter().map(param).collect(),
        body: direct::tape(&f.exprs, f.body),
    }
}

fn unit_text(u: &Unit) -> String {
    let symbols = ["m", "kg", "s", "A", "K", "mol", "cd"];
    let power = |(s, n): (&str, &i16)| match n {
        0 => None,
        2 => Some(s.to_string()),
        n if n % 2 == 0 => Some(format!("{s}^{}", n / 2)),
        n => Some(format!("{s}^{n}/2")),
    };
    symbols
        .into_iter()
        .zip(&u.base)
        .filter_map(power)
        .collect::<Vec<_>>()
        .join(" ")
}
