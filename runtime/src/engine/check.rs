//! What must hold before anything is computed.
mod parts;

use super::{Settings, SetupError};
use crate::body::{Body, Grid};
use crate::spec::{SlotKind, Spec};

/// Finite positions, positive volumes, a grid and periods that agree with them.
pub(super) fn body(b: &Body) -> Result<(), SetupError> {
    let fail = |m: String| Err(SetupError::Body(m));
    if b.x.is_empty() {
        return fail("the body has no nodes: check shapes, holes and spacing".into());
    }
    if b.x.len() >= 1 << 30 {
        return fail(format!(
            "{} nodes are too many (2^30 is the limit): use a larger spacing",
            b.x.len()
        ));
    }
    if b.volume.len() != b.x.len() {
        return fail(format!(
            "{} nodes but {} volumes",
            b.x.len(),
            b.volume.len()
        ));
    }
    for (i, (x, v)) in b.x.iter().zip(&b.volume).enumerate() {
        if x.iter().any(|c| !c.is_finite()) {
            return fail(format!(
                "node {i} has a position that is not a number: {x:?}"
            ));
        }
        if !(v.is_finite() && *v > 0.0) {
            return fail(format!("node {i} has volume {v}; volumes must be positive"));
        }
    }
    if !b.horizon.is_empty() && b.horizon.len() != b.x.len() {
        return fail("horizons for some of the nodes only".into());
    }
    let bad = |h: &f64| !(h.is_finite() && *h >= 0.0);
    if let Some((i, h)) = b.horizon.iter().enumerate().find(|(_, h)| bad(h)) {
        return fail(format!("node {i} has the horizon {h}; it must be positive"));
    }
    for (name, v) in [
        ("spacing", b.spacing),
        ("cross-section or thickness", b.cross),
    ] {
        if !(v.is_finite() && v > 0.0) {
            return fail(format!("the {name} is {v}; it must be positive"));
        }
    }
    periods(b)?;
    b.grid.as_ref().map_or(Ok(()), |g| grid(b, g))
}

fn periods(b: &Body) -> Result<(), SetupError> {
    for (a, period) in b.periodic.iter().enumerate().take(b.flavour.dim()) {
        let Some(period) = period else { continue };
        if !(period.is_finite() && *period > 0.0) {
            return Err(SetupError::Body(format!(
                "the period along axis {a} is {period}; it must be positive"
            )));
        }
        let low = b.x.iter().map(|x| x[a]).fold(f64::INFINITY, f64::min);
        let high = b.x.iter().map(|x| x[a]).fold(f64::NEG_INFINITY, f64::max);
        if high - low >= *period {
            let extent = high - low;
            return Err(SetupError::Body(format!(
                "the body is {extent} m long along axis {a}, more than its period of {period} m"
            )));
        }
    }
    Ok(())
}

fn grid(b: &Body, g: &Grid) -> Result<(), SetupError> {
    let fail = |m: String| Err(SetupError::Body(m));
    if g.cell.len() != b.x.len() {
        return fail(format!(
            "{} nodes but {} grid cells",
            b.x.len(),
            g.cell.len()
        ));
    }
    if !(g.spacing.is_finite() && g.spacing > 0.0) {
        return fail(format!(
            "the grid spacing is {}; it must be positive",
            g.spacing
        ));
    }
    if g.shape.iter().map(|&n| n as f64).product::<f64>() > 4e9 {
        return fail(format!(
            "a grid of {:?} cells is too large: use a larger spacing",
            g.shape
        ));
    }
    let strides = [
        1,
        g.shape[0] as usize,
        g.shape[0] as usize * g.shape[1] as usize,
    ];
    let mut taken = vec![false; strides[2] * g.shape[2] as usize];
    for (i, cell) in g.cell.iter().enumerate() {
        if (0..3).any(|a| cell[a] >= g.shape[a]) {
            return fail(format!(
                "node {i} lies in cell {cell:?}, outside the grid of {:?} cells",
                g.shape
            ));
        }
        let k: usize = (0..3).map(|a| cell[a] as usize * strides[a]).sum();
        if std::mem::replace(&mut taken[k], true) {
            return fail(format!("two nodes share the grid cell {cell:?}"));
        }
    }
    for (a, period) in b.periodic.iter().enumerate().take(b.flavour.dim()) {
        let length = g.shape[a] as f64 * g.spacing;
        if period.is_some_and(|p| (p - length).abs() > 1e-9 * length) {
            return fail(format!(
                "the period along axis {a} must be the length of the grid, {length} m"
            ));
        }
    }
    Ok(())
}

/// Parameter and influence values, one each, finite where they must be.
pub(super) fn settings(spec: &Spec, body: &Body, s: &Settings) -> Result<(), SetupError> {
    let fail = |m: String| Err(SetupError::Settings(m));
    let flavour = body.flavour.name();
    if !spec.flavours.is_empty() && spec.flavours.iter().all(|f| f != flavour) {
        return fail(format!(
            "law `{}` is for {}, not for {flavour}",
            spec.law,
            spec.flavours.join(" and ")
        ));
    }
    if let Some(h) = s.horizon.iter().find(|h| !(h.is_finite() && **h > 0.0)) {
        return fail(format!("the horizon is {h}; it must be positive"));
    }
    if s.horizon_levels == 0 {
        return fail("0 levels of the horizon; one is the least".into());
    }
    if s.horizon.len() != 1 && s.horizon.len() != s.materials.len() {
        return fail(format!(
            "{} horizons for {} materials: give one, or one each",
            s.horizon.len(),
            s.materials.len()
        ));
    }
    if !(1..=256).contains(&s.materials.len()) {
        return fail(format!(
            "{} materials (1 to 256 are possible)",
            s.materials.len()
        ));
    }
    for params in &s.materials {
        if params.len() != spec.params.len() {
            return fail(format!(
                "law `{}` has {} parameters, {} values were given",
                spec.law,
                spec.params.len(),
                params.len()
            ));
        }
        for (p, v) in spec.params.iter().zip(params) {
            if v.is_nan() {
                return fail(format!(
                    "parameter `{}` of law `{}` is not a number",
                    p.name, spec.law
                ));
            }
        }
    }
    if let Some(m) = body
        .material
        .iter()
        .find(|m| **m as usize >= s.materials.len())
    {
        return Err(SetupError::Body(format!(
            "a node is of material {m}, of {} (counted from 0)",
            s.materials.len()
        )));
    }
    if !body.material.is_empty() && body.material.len() != body.x.len() {
        return Err(SetupError::Body(
            "materials for some of the nodes only".into(),
        ));
    }
    if s.influences.len() != spec.influences.len() {
        let (n, given) = (spec.influences.len(), s.influences.len());
        return fail(format!(
            "law `{}` has {n} influence functions, {given} were given",
            spec.law
        ));
    }
    let known = |name: &String| spec.weights.iter().any(|w| w.name == *name);
    if let Some(name) = s.without.iter().find(|name| !known(name)) {
        return fail(format!("law `{}` has no weight `{name}`", spec.law));
    }
    if s.isa.is_some_and(|isa| !isa.available()) {
        return fail(
            "this processor does not have the requested instruction set: leave the choice open"
                .into(),
        );
    }
    Ok(())
}

/// Lists of the law agree with each other.
pub(super) fn spec(s: &Spec) -> Result<(), SetupError> {
    let fail = |m: String| Err(SetupError::law(&s.law, m));
    if !(1..=3).contains(&s.dim) {
        return fail(format!("dimension {} (1, 2 or 3 are possible)", s.dim));
    }
    if s.families.is_empty() || s.families[0].filter.is_some() {
        return fail("the first family must be the whole horizon".into());
    }
    let slots = s.slots.len();
    let mut named = s
        .force
        .iter()
        .chain(&s.tangent)
        .chain(&s.energy)
        .copied()
        .collect::<Vec<u32>>();
    named.extend(s.rates.iter().flat_map(|r| [r.field, r.rate]));
    named.extend(s.rates.iter().filter_map(|r| r.damping));
    named.extend(&s.after_step);
    named.extend(s.named.iter().flat_map(|n| n.1.clone()));
    named.extend(s.fields.iter().flat_map(|f| f.slots.clone()));
    named.extend(
        s.histories
            .iter()
            .filter_map(|h| h.slot)
            .flat_map(|h| [h.0, h.1]),
    );
    if let Some(slot) = named.iter().find(|&&k| k as usize >= slots) {
        return fail(format!("node slot {slot} does not exist"));
    }
    let component = |kind: SlotKind| match kind {
        SlotKind::Displacement(a)
        | SlotKind::Velocity(a)
        | SlotKind::Position(a)
        | SlotKind::Increment(a) => a,
        SlotKind::TimeStep | SlotKind::State | SlotKind::Computed(_) => 0,
    };
    if let Some(slot) = s
        .slots
        .iter()
        .find(|slot| component(slot.kind) as usize >= s.dim)
    {
        return fail(format!(
            "node slot `{}` is a component that {} dimensions do not have",
            slot.name, s.dim
        ));
    }
    for list in [&s.force, &s.tangent, &s.after_step] {
        if !(list.is_empty() || list.len() == s.dim) {
            return fail(format!(
                "a vector needs {} slots, not {}",
                s.dim,
                list.len()
            ));
        }
    }
    if let Some(h) = s
        .histories
        .iter()
        .find(|h| h.family as usize >= s.families.len())
    {
        return fail(format!(
            "history `{}` names a family that does not exist",
            h.name
        ));
    }
    parts::check(s).or_else(fail)?;
    if s.sweeps.windows(2).any(|w| w[0].stage > w[1].stage) {
        return fail("sweeps must stand in the order of their stages".into());
    }
    Ok(())
}
