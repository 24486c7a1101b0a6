//! Whether a law can be stored on parts of the body as its spec says.
use crate::spec::{RateSpec, SlotKind, Spec, Stage};

/// What is stored on a part is a field that lives there or what it is stepped with, and nobody reads it elsewhere.
pub(super) fn check(s: &Spec) -> Result<(), String> {
    let exists = |part: Option<u32>| part.is_none_or(|part| (part as usize) < s.parts.len());
    for part in &s.parts {
        let kind = s.slots.get(part.slot as usize).map(|slot| slot.kind);
        if kind != Some(SlotKind::Computed(Stage::Part)) {
            return Err(format!("nothing says where `{}`", part.condition));
        }
    }
    if !s.fields.iter().all(|f| exists(f.part)) || !s.slots.iter().all(|slot| exists(slot.part)) {
        return Err("a part of the body does not exist".into());
    }
    let named = s.named.iter().flat_map(|(_, slots)| slots);
    let histories = s.histories.iter().filter_map(|h| h.slot);
    let everywhere: Vec<u32> = (s.sweeps.iter().flat_map(|w| &w.nbr))
        .chain(&s.force)
        .chain(&s.tangent)
        .chain(&s.energy)
        .chain(&s.after_step)
        .chain(named)
        .copied()
        .chain(histories.flat_map(|(now, next)| [now, next]))
        .chain(s.parts.iter().map(|p| p.slot))
        .collect();
    let of = |slot: u32| s.fields.iter().find(|f| f.slots.contains(&slot));
    for (k, slot) in s.slots.iter().enumerate() {
        let k = k as u32;
        let mut lists = s
            .rates
            .iter()
            .map(|r| ([r.field, r.rate], r.damping, r.field));
        let fits = slot.part.is_none()
            || !everywhere.contains(&k)
                && lists.all(|(two, damping, field)| {
                    let used = two.contains(&k) || damping == Some(k);
                    !used || of(field).is_some_and(|f| f.part == slot.part)
                })
                && (slot.kind != SlotKind::State || of(k).is_some_and(|f| f.part == slot.part));
        if !fits {
            return Err(format!(
                "`{}` is needed beyond its part of the body",
                slot.name
            ));
        }
    }
    // The field and its drive are walked together; a damping may be there for the whole body.
    let part = |k: u32| s.slots[k as usize].part;
    let apart = |r: &&RateSpec| {
        let damping = r.damping.and_then(part);
        part(r.field) != part(r.rate) || damping.is_some() && damping != part(r.field)
    };
    match s.rates.iter().find(apart) {
        Some(r) => Err(format!(
            "`{}` and its rate are stored differently",
            s.slots[r.field as usize].name
        )),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::engine::tests::laws;
    use crate::spec::{FieldSpec, PartSpec};

    /// dT = -T where part 0 is.
    fn law() -> Spec {
        let mut spec = laws::empty("decay", 1);
        spec.slots = vec![
            laws::slot("T", SlotKind::State),
            laws::slot("dT", SlotKind::Computed(Stage::Step)),
            laws::slot("where", SlotKind::Computed(Stage::Part)),
        ];
        spec.slots[0].part = Some(0);
        spec.slots[1].part = Some(0);
        spec.fields = vec![FieldSpec {
            name: "T".into(),
            slots: vec![0],
            components: vec![String::new()],
            exponents: [0; 7],
            part: Some(0),
        }];
        spec.parts = vec![PartSpec {
            condition: "X.x > 0".into(),
            slot: 2,
        }];
        spec.rates = vec![RateSpec {
            field: 0,
            rate: 1,
            damping: None,
            stepped: crate::spec::Stepped::Together,
        }];
        let mut sweep = laws::sweep("rate", Stage::Step);
        (sweep.own, sweep.out) = (vec![0], vec![1]);
        spec.sweeps = vec![sweep];
        spec
    }

    #[test]
    fn what_is_needed_elsewhere_is_not_stored_on_a_part() {
        assert_eq!(check(&law()), Ok(()));
        type Plant = fn(&mut Spec);
        let plants: [(&str, Plant); 6] = [
            ("`T` is needed beyond", |s| s.sweeps[0].nbr = vec![0]),
            ("`dT` is needed beyond", |s| s.force = vec![1]),
            ("`T` is needed beyond", |s| s.fields[0].part = None),
            ("`T` and its rate are stored differently", |s| {
                s.slots[1].part = None
            }),
            ("nothing says where `X.x > 0`", |s| s.parts[0].slot = 1),
            ("does not exist", |s| s.slots[0].part = Some(1)),
        ];
        for (says, plant) in plants {
            let mut spec = law();
            plant(&mut spec);
            let found = check(&spec).expect_err(says);
            assert!(found.contains(says), "{says}: {found}");
        }
    }
}
