//! What a new simulation asks of its set-up: whether it can be computed, what is cut and held, and what tells it from others.

use super::{End, Setup, StepRule};
use crate::body::Body;
use crate::checkpoint::Fingerprint;
use crate::conditions::{Condition, Conditions, Quantity, nodes_in, who_sets};
use crate::contact::{Contact, Indenter};
use crate::engine::{Engine, Feeding, State, Stray, Traversal};
use crate::error::{About, InputError};
use crate::matching::Face;
use crate::shape::{Surface, tolerance};
use crate::spec::Spec;

pub(super) fn check(setup: &Setup) -> Result<(), InputError> {
    let positive = |v: f64| v > 0.0 && v.is_finite();
    let moves = !setup.law.spec.force.is_empty();
    if setup.settings.traversal == Traversal::Convolution && !setup.cracks.is_empty() {
        let what = "a convolution takes bonds that hold, and a crack has cut some";
        return Err(InputError::new(what, "use `lattice`").about(About::Traversal));
    }
    if setup.density.len() != setup.settings.materials.len() {
        return Err(InputError::new(
            format!(
                "{} densities for {} materials",
                setup.density.len(),
                setup.settings.materials.len()
            ),
            "give one density per material",
        ));
    }
    if let Some(density) = setup.density.iter().find(|d| moves && !positive(**d)) {
        return Err(InputError::new(
            format!("the density is {density} kg/m^3"),
            "give a positive density",
        ));
    }
    match setup.step {
        StepRule::Fixed(dt) if !positive(dt) => {
            return Err(InputError::new(
                format!("the time step is {dt} s"),
                "give a positive time step",
            ));
        }
        StepRule::Stable { safety } if !(positive(safety) && safety <= 1.0) => {
            return Err(InputError::new(
                format!("the safety factor of the step is {safety}"),
                "give a number above 0 and up to 1",
            ));
        }
        _ => {}
    }
    if let End::Time(end) = setup.end
        && !(end >= 0.0 && end.is_finite())
    {
        return Err(InputError::new(
            format!("the run ends at {end} s"),
            "give an end that is not negative",
        ));
    }
    if !moves {
        still(setup)?;
    }
    setup.cracks.iter().try_for_each(Surface::check)?;
    setup.indenters.iter().try_for_each(Indenter::check)
}

/// A law without a force moves nothing.
fn still(setup: &Setup) -> Result<(), InputError> {
    let law = &setup.law.spec.law;
    let moving = |c: &&Condition| !matches!(c.quantity, Quantity::Field(_));
    let what = if !setup.indenters.is_empty() {
        "a sphere"
    } else if setup
        .initial
        .iter()
        .chain(&setup.conditions)
        .any(|c| moving(&c))
    {
        "a condition on the motion"
    } else {
        return Ok(());
    };
    Err(InputError::new(
        format!("the law `{law}` has no force, so that {what} means nothing"),
        "leave it out, or choose a law that moves",
    ))
}

pub(super) fn strayed(stray: &Stray, body: &Body, initial: &[Condition]) -> InputError {
    let Stray {
        field,
        condition,
        node,
    } = stray;
    let x = body.x[*node];
    let error = InputError::new(
        format!(
            "the field `{field}` has an initial value at node {node} ({:e}, {:e}, {:e}) m, where it does not live",
            x[0], x[1], x[2]
        ),
        format!("leave it zero there: the law has it where `{condition}`"),
    );
    match who_sets(initial, field, x, body.spacing) {
        Some(k) => error.about(About::Initial(k)),
        None => error,
    }
}

/// Refuses a field that damps others where it is negative: it would feed them, and the rule by which they are stepped
/// holds for damping alone.
pub(super) fn damped(
    (initial, conditions): (&[Condition], &[Condition]),
    body: &Body,
    engine: &Engine,
    state: &State,
) -> Result<(), InputError> {
    let Some(feeding) = engine.feeding(state) else {
        return Ok(());
    };
    let Feeding {
        field,
        component,
        fed,
        node,
        value,
    } = feeding;
    let x = body.x[node];
    let error = InputError::new(
        format!(
            "`{field}{component}`, by which `{fed}` is damped, is {value:.3e} 1/s at node {node} ({:e}, {:e}, {:e}) m: `{fed}` would grow \
             without bound",
            x[0], x[1], x[2]
        ),
        "give rates that are not negative; 0 damps nothing",
    );
    let who = |list: &[Condition]| who_sets(list, &field, x, body.spacing);
    Err(match (who(conditions), who(initial)) {
        (Some(k), _) => error.about(About::Condition(k)),
        (None, Some(k)) => error.about(About::Initial(k)),
        (None, None) => error,
    })
}

/// Nodes whose bonds never break; empty where all may, or none can. Those of matching boundaries are among them: behind a
/// crack no wave would be the one that is matched.
pub(super) fn no_fail(setup: &Setup, faces: &[Face]) -> Result<Vec<bool>, InputError> {
    let mut flags = vec![false; setup.body.x.len()];
    for region in &setup.no_fail {
        region.check()?;
        let nodes = nodes_in(&setup.body, region);
        if nodes.is_empty() {
            return Err(InputError::new(
                "a no-fail region holds no node",
                "move or enlarge the region",
            ));
        }
        nodes.iter().for_each(|&n| flags[n as usize] = true);
    }
    if !setup.law.spec.breaks || setup.no_fail.is_empty() && faces.is_empty() {
        return Ok(Vec::new());
    }
    for (node, flag) in flags.iter_mut().enumerate() {
        *flag |= faces.iter().any(|f| f.holds(node, &setup.body));
    }
    Ok(flags)
}

pub(super) fn cut(engine: &Engine, state: &mut State, cracks: &[Surface], body: &Body) {
    let margin = tolerance(body.spacing);
    if !cracks.is_empty() {
        engine.cut(state, &|a, b| {
            cracks.iter().any(|c| c.crosses(a, b, margin))
        });
    }
}

pub(super) fn contact(
    indenters: &[Indenter],
    conditions: &Conditions,
    dim: usize,
    len: usize,
) -> Contact {
    let mut driven = Vec::new();
    if !indenters.is_empty() {
        driven = vec![false; len];
        conditions.driven(|s| driven[s] = true);
    }
    Contact::new(indenters, dim, len, driven)
}

/// Everything that decides how the state goes on, except the step.
pub(super) fn fingerprint(setup: &Setup, spec: &Spec) -> Result<u64, InputError> {
    let mut f = Fingerprint::default();
    let law = serde_json::to_vec(spec)
        .map_err(|e| InputError::new(format!("the law cannot be written: {e}"), ""))?;
    f.bytes(&law);
    let s = &setup.settings;
    f.debug(&(
        &s.materials,
        &s.influences,
        &s.horizon,
        s.partial_volume,
        s.lattice_constants,
        &s.without,
    ));
    let body = &setup.body;
    f.debug(&(body.flavour, body.periodic, &setup.density));
    f.debug(&(body.cross, body.spacing, &body.material, &body.regions));
    f.debug(&s.horizon_levels);
    body.horizon.iter().for_each(|h| f.number(*h));
    setup
        .body
        .x
        .iter()
        .flatten()
        .chain(&setup.body.volume)
        .for_each(|x| f.number(*x));
    f.debug(&(
        &setup.initial,
        &setup.conditions,
        &setup.cracks,
        &setup.no_fail,
        &setup.indenters,
        &setup.matching,
    ));
    Ok(f.0)
}

pub(super) fn layout(engine: &Engine) -> u64 {
    let mut f = Fingerprint::default();
    f.debug(&engine.len());
    let places = std::iter::once(engine.slots()).chain(engine.rows());
    (places.flatten()).for_each(|place| f.bytes(&place.to_le_bytes()));
    // The same order, but other bits.
    f.debug(&engine.is_single());
    if let Some(convolution) = engine.report().convolution {
        f.debug(&convolution.size);
    }
    f.0
}
