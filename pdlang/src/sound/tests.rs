//! Laws of the language are sound; with something planted in a stage, its check says so.

use super::*;
use crate::front;
use crate::ir::{ExprKind, Home, Law};
use crate::spec::{RateSpec, Spec, Stage, Stepped, SweepSpec};
use crate::tape::Op;
use crate::units::Unit;

const LAW: &str = "model test \"A law of everything\" cite \"This test, eq. 1\" {
    influence omega = 1/x
    family long = horizon where x > delta/2
    param K : pressure > 0 \"modulus\"
    param s0 : number > 0 = inf \"critical stretch\"
    field T : temperature \"temperature\"
    history p : number = 0 on bond \"memory\"
    weight A = x/delta \"correction\"
    node m = sum(omega*x^2)
    node theta = dim/m*sum(omega*x*e)
    node far = sum0(omega*x*e)/sum0(omega*x^2)
    energy W = K*theta^2/2 + K*sum[long](A*omega*e^2)/m
    pair f = K/ball(x)*p
    rate T = far*sum0(T' - T)/ball(1)*(1 [1/s])
    update p = max(p, s)
    break when s > s0
}";

/// A field at half steps, what flows at full ones, the force of a node, and a rule after the step.
const WAVES: &str = "model waves \"Waves in fields\" cite \"This test, eq. 1\" {
    param c : velocity > 0 \"speed\"
    param K : pressure > 0 \"modulus\"
    field p : number \"pressure\"
    field w : vector number at half \"velocity\"
    field rim : number \"coefficient\"
    field lost : number where rim > 0 \"what the rim took\"
    node m = sum(x^2)
    rate w = -c*dim*sum((p' - p)*xi)/m - w*c/delta
    rate p = -c*dim*sum(dot(w' - w, xi))/m
    rate lost = rim*p*c/delta - lost*c/delta
    force f = K*w/delta
    after step velocity = velocity - velocity*m/sum(2*x^2)
}";

fn checked() -> Law {
    read(LAW)
}

fn read(text: &str) -> Law {
    let mut found = front::file(text);
    assert!(!found.has_errors(), "{:?}", found.diagnostics);
    found.laws.remove(0)
}

fn made() -> Spec {
    let (spec, found) = compiled(&checked(), 2, Kinematics::General).expect("it fits");
    assert_eq!(found, Vec::<String>::new());
    spec
}

#[test]
fn what_the_compiler_makes_is_sound() {
    for law in [checked(), read(WAVES)] {
        for dim in 1..=3 {
            let (_, found) = compiled(&law, dim, Kinematics::General).expect("it fits");
            assert_eq!(found, Vec::<String>::new(), "{} in {dim}D", law.name);
        }
    }
}

/// What reads a field at half steps waits for all that steps it; the velocity after a step is a vector.
#[test]
fn planted_in_the_data_of_waves() {
    type Plant = fn(&mut Spec);
    let plants: [(&str, Plant); 6] = [
        ("`lost` is needed beyond its part", |s| {
            let (lost, last) = (s.fields[3].slots[0], s.sweeps.len() - 1);
            s.sweeps[last].nbr.push(lost);
        }),
        ("`p` is needed beyond its part", |s| {
            let p = s.fields[0].slots[0];
            s.slots[p as usize].part = Some(0);
        }),
        ("lives on a part that does not exist", |s| s.parts.clear()),
        ("before it is at its half step", |s| {
            let half = |r: &&RateSpec| r.stepped == Stepped::Half;
            let field = s.rates.iter().find(half).expect("a field").field;
            let in_step = |w: &&mut SweepSpec| w.stage == Stage::Step;
            let first = s.sweeps.iter_mut().find(in_step).expect("a sweep");
            first.own.push(field);
        }),
        ("field with a rate", |s| s.rates[0].field = s.rates[0].rate),
        ("velocity after the step of 1", |s| s.after_step.truncate(1)),
    ];
    for (says, plant) in plants {
        let (mut s, found) = compiled(&read(WAVES), 2, Kinematics::General).expect("it fits");
        assert_eq!(found, Vec::<String>::new());
        plant(&mut s);
        let found = spec(&s);
        assert!(found.iter().any(|f| f.contains(says)), "{says}: {found:?}");
    }
}

/// What is only looked at, and reads a field, is formed in a pass of its own, and so is what is made of it there: from what
/// the pass has just found, not from what an earlier one left.
#[test]
fn late_quantities_read_one_another_as_they_are() {
    let law = "model late \"Made of one another\" cite \"This test, eq. 1\" {
        param K : pressure > 0 \"modulus\"
        field q : number \"coefficient\"
        node m = sum(x^2)
        node theta = dim*sum(x*e)/m
        node D = theta + q
        node W = K*D^2/2
        state T = K*theta*x/m
    }";
    let (s, found) = compiled(&read(law), 2, Kinematics::General).expect("it fits");
    assert_eq!(found, Vec::<String>::new());
    let slot = |name: &str| s.slots.iter().position(|slot| slot.name == name);
    let d = slot("D").expect("D") as u32;
    assert!(s.sweeps.iter().any(|w| w.out.contains(&d)));
    assert!(s.sweeps.iter().all(|w| !w.own.contains(&d)));
}

/// Each change of a sound law as data is found, in words that name it.
#[test]
fn planted_in_the_data() {
    type Plant = fn(&mut Spec);
    let plants: [(&str, Plant); 17] = [
        ("is read by nobody", |s| {
            s.sweeps[0].bond.ops.push(Op::Lit(2.0))
        }),
        ("reads what comes later", |s| {
            let n = s.sweeps[0].post.ops.len() as u32;
            s.sweeps[0].post.ops.push(Op::Neg(n));
        }),
        ("operand of the wrong type", |s| {
            let n = s.sweeps[0].post.ops.len() as u32;
            s.sweeps[0].post.ops.push(Op::Lit(1.0));
            s.sweeps[0].post.ops.push(Op::Not(n));
        }),
        ("may not stand there", |s| {
            s.sweeps[0].post.ops.push(Op::Xi(0))
        }),
        ("does not exist", |s| s.sweeps[0].bond.ops.push(Op::Geo(99))),
        ("before it is written", |s| {
            let last = s.sweeps.len() - 1;
            s.sweeps.swap(0, last);
        }),
        ("stands behind one of stage", |s| s.sweeps.reverse()),
        ("a second time", |s| {
            let writes = |w: &&SweepSpec| !w.out.is_empty();
            let again = s.sweeps.iter().find(writes).expect("a sweep").clone();
            s.sweeps.insert(0, again);
        }),
        ("is used by nobody", |s| s.sweeps[0].own.push(0)),
        ("breaks bonds", |s| {
            s.sweeps.iter_mut().for_each(|w| w.kills = false)
        }),
        ("over intact bonds", |s| {
            s.sweeps.iter_mut().for_each(|w| w.reference = true)
        }),
        ("output register", |s| s.constants.outs.push(1000)),
        ("reads a weight before it is written", |s| {
            s.sweeps
                .retain(|w| w.history.is_empty() || w.stage != Stage::Reference)
        }),
        ("is used by nobody", |s| {
            s.sweeps.iter_mut().for_each(|w| w.streams.outs.push(0))
        }),
        ("values of geometry", |s| {
            s.sweeps
                .iter_mut()
                .for_each(|w| w.from_streams.outs.clear())
        }),
        ("`A` is written in 0 sweeps", |s| {
            s.sweeps
                .retain(|w| w.history.is_empty() || w.stage != Stage::Reference)
        }),
        ("changes in 0 sweeps", |s| {
            for w in &mut s.sweeps {
                w.bond.ops.retain(|op| !matches!(op, Op::PutHistory(..)));
            }
        }),
    ];
    for (says, plant) in plants {
        let mut s = made();
        plant(&mut s);
        let found = spec(&s);
        assert!(found.iter().any(|f| f.contains(says)), "{says}: {found:?}");
    }
}

#[test]
fn planted_in_the_checked_law() {
    type Plant = fn(&mut Law);
    let plants: [(&str, Plant); 6] = [
        ("not", |law| {
            let sum = |e: &&mut crate::ir::Expr| matches!(e.kind, ExprKind::Reduce(..));
            law.exprs.iter_mut().find(sum).expect("a sum").home = Home::Bond;
        }),
        ("is in Pa, not m", |law| law.params[0].unit = Unit::length()),
        ("a value in", |law| law.histories[0].unit = Unit::length()),
        ("an operand comes later", |law| {
            let last = crate::ir::ExprId(law.exprs.len() as u32 - 1);
            law.exprs[0].kind = ExprKind::Neg(last);
        }),
        ("names what does not exist", |law| law.params.clear()),
        ("needs a definition that comes later", |law| {
            law.defs.reverse()
        }),
    ];
    for (says, plant) in plants {
        let mut planted = checked();
        plant(&mut planted);
        let found = law(&planted);
        assert!(found.iter().any(|f| f.contains(says)), "{says}: {found:?}");
    }
}

/// Answers and the plan of sweeps, changed between the stages.
#[test]
fn planted_between_the_stages() {
    let mut found = Vec::new();
    assemble::watched(
        &checked(),
        2,
        Kinematics::General,
        &mut |between| match between {
            Between::Answers(algebra, r) => {
                let mut bad = crate::schedule::Responses {
                    tangent: r.force.clone(),
                    force: r.tangent.clone(),
                    ..Default::default()
                };
                bad.breaks
                    .push((crate::ir::FamilyId(0), r.force[0].clone()));
                found.extend(polynomials::check(algebra, &bad));
            }
            Between::Schedule(algebra, plan) => {
                let first = *plan.drafts.keys().next().expect("a sweep");
                let last = *plan.drafts.keys().next_back().expect("a sweep");
                let mut planted = plan.clone();
                let moved = planted.drafts.remove(&last).expect("it is there");
                planted
                    .drafts
                    .entry(first)
                    .or_default()
                    .sums
                    .extend(moved.sums);
                planted
                    .drafts
                    .entry(first)
                    .or_default()
                    .writes
                    .extend(moved.writes);
                planted
                    .drafts
                    .entry(first)
                    .or_default()
                    .kills
                    .extend(moved.kills);
                planted
                    .drafts
                    .entry(first)
                    .or_default()
                    .updates
                    .extend(moved.updates);
                found.extend(schedule::check(algebra, &planted));
            }
        },
    )
    .expect("it fits");
    for says in [
        "depends on the increment",
        "is no condition",
        "is not linear in the increment",
        "changes memory",
    ] {
        assert!(found.iter().any(|f| f.contains(says)), "{says}: {found:?}");
    }
}
