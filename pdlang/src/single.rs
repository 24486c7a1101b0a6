//! Which sweeps may sum in single precision.
//!
//! Contract: a sweep of the steps is marked where, in all of its tapes, nothing that stays as it is (bonds of the reference,
//! constants, sums over families) is added to what moves, and nothing is taken away from it. A small displacement added to a
//! bond loses its last digits, as does a small difference of two lengths; a sum of displacements does not.

use crate::spec::{SlotKind, Spec, Stage, SweepSpec};
use crate::tape::{Op, Tape, operands};

/// Marks them.
pub(crate) fn mark(spec: &mut Spec) {
    let may: Vec<bool> = spec.sweeps.iter().map(|s| may(spec, s)).collect();
    for (sweep, may) in spec.sweeps.iter_mut().zip(may) {
        sweep.single = may;
    }
}

fn may(spec: &Spec, s: &SweepSpec) -> bool {
    if s.stage != Stage::Step || s.bond.ops.is_empty() || !s.history.is_empty() {
        return false;
    }
    let slot = |list: &[u32], k: u32| {
        let slot = list
            .get(k as usize)
            .and_then(|k| spec.slots.get(*k as usize));
        slot.is_none_or(|slot| match slot.kind {
            SlotKind::Position(_) => false,
            SlotKind::Computed(stage) => {
                !matches!(stage, Stage::Reference | Stage::Part | Stage::Family)
            }
            _ => true,
        })
    };
    let leaf = |op: &Op, pre: &[bool]| match *op {
        Op::Eta(_) | Op::Acc(_) => true,
        Op::Own(k) => slot(&s.own, k),
        Op::Nbr(k) => slot(&s.nbr, k),
        Op::Pre(k) => pre.get(k as usize).is_none_or(|moves| *moves),
        _ => false,
    };
    let Some(pre) = moving(&s.pre, |op| leaf(op, &[])) else {
        return false;
    };
    let outs = s.pre.outs.iter();
    let pre: Vec<bool> = outs
        .map(|r| pre.get(*r as usize).is_none_or(|m| *m))
        .collect();
    [&s.bond, &s.post]
        .into_iter()
        .all(|tape| moving(tape, |op| leaf(op, &pre)).is_some())
}

/// Which registers hold what moves; None where that meets what stays in a sum.
fn moving(tape: &Tape, leaf: impl Fn(&Op) -> bool) -> Option<Vec<bool>> {
    let mut moves: Vec<bool> = Vec::with_capacity(tape.ops.len());
    for op in &tape.ops {
        let of = |r: u32| moves.get(r as usize).is_none_or(|m| *m);
        let zero = |r: u32| matches!(tape.ops.get(r as usize), Some(Op::Lit(v)) if *v == 0.0);
        let meet = |a: (bool, bool), b: (bool, bool)| a.0 != b.0 && !a.1 && !b.1;
        let met = match *op {
            Op::Add(a, b) | Op::Sub(a, b) => meet((of(a), zero(a)), (of(b), zero(b))),
            Op::Fma(a, b, c) => meet((of(a) || of(b), false), (of(c), zero(c))),
            _ => false,
        };
        if met {
            return None;
        }
        let any = operands(op).into_iter().any(of);
        moves.push(any || leaf(op));
    }
    Some(moves)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assemble::{self, Kinematics};
    use crate::front;

    fn marked(text: &str, kinematics: Kinematics) -> Vec<bool> {
        let checked = front::file(text);
        assert!(!checked.has_errors(), "{:?}", checked.diagnostics);
        let spec = assemble::spec(&checked.laws[0], 2, kinematics).expect("a law that compiles");
        let steps = spec.sweeps.iter().filter(|s| s.stage == Stage::Step);
        steps.map(|s| s.single).collect()
    }

    const BOND_BASED: &str = "model m \"Bond\" cite \"Nobody, eq. 1\" for plane_stress {
        param K : pressure > 0 \"bulk modulus\"
        energy W = 9*K*sum(s^2)/(4*ball(1))
    }";

    /// The stretch of a bond is a difference of lengths; of a linearised law it is a product.
    #[test]
    fn a_stretch_keeps_its_digits_where_it_is_linearised() {
        assert_eq!(marked(BOND_BASED, Kinematics::General), [false]);
        assert_eq!(marked(BOND_BASED, Kinematics::Linearised), [true]);
    }

    #[test]
    fn differences_of_a_field_keep_theirs_and_deviations_from_a_constant_do_not() {
        let conduction = |difference: &str| {
            let text = format!(
                "model h \"Heat\" cite \"Nobody, eq. 1\" for plane_stress {{
                    field T : temperature \"temperature\"
                    param k : [W/m/K] > 0 \"conductivity\"
                    param c : [J/m^3/K] > 0 \"heat capacity\"
                    param T0 : temperature \"reference temperature\"
                    rate T = sum(4*k/ball(x^2)*{difference})/c
                }}"
            );
            marked(&text, Kinematics::General)
        };
        assert_eq!(conduction("(T' - T)"), [true]);
        assert_eq!(conduction("(T' - T)*abs(T - T0)/(1 K)"), [false]);
        assert_eq!(conduction("(T' - T0)"), [false]);
        // The second sum stays as it is, on whichever side of the sum over bonds the difference is taken.
        let apart = "T')/c - sum(4*k/ball(x^2)*T0";
        assert_eq!(conduction(apart), [false]);
    }
}
