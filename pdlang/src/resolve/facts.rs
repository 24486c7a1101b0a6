//! What is known of every typed expression beyond shape, home and unit. Facts are made together with
//! the expression, from those of its operands: no check walks a tree, which may be shared a million times.

use crate::ir::{BinaryOp, Builtin, ExprId, ExprKind, Reduction};
use crate::resolve::walk::operands;
use std::hash::{DefaultHasher, Hash, Hasher};

#[derive(Clone, Debug)]
pub(crate) struct Facts {
    /// Height of the tree; a definition is a leaf.
    pub height: u32,
    /// Operations, where what is shared is counted as often as it is read; a definition is a leaf.
    pub size: usize,
    /// Height with all that its definitions lean on.
    pub depth: u32,
    /// True for values of any unit: literal zero and infinity, and what influence functions raise to a power.
    pub any_unit: bool,
    /// Value of an expression of numbers alone.
    pub literal: Option<f64>,
    /// Equal for equal formulas.
    pub structure: u64,
    /// True when the value changes with the displacement.
    pub moves: bool,
    /// True for what neither the reference body nor the displacement determines.
    pub reads_state: bool,
    /// True when an extreme over bonds changes with the displacement: there is no derivative.
    pub extreme: bool,
    /// True when a sum that moves is read at the other end; second entry: when the expression itself is
    /// read at the other end.
    pub second_ring: [bool; 2],
    /// Why this is no function of what a run leaves alone at one node; of the reference body; of one reference bond;
    /// of its length alone.
    pub beyond: [Option<&'static str>; 4],
}

/// Positions in [`Facts::beyond`].
pub(crate) const NODE: usize = 0;
pub(crate) const REFERENCE: usize = 1;
pub(crate) const BOND: usize = 2;
pub(crate) const LENGTH: usize = 3;

impl Facts {
    /// `of` gives the facts of an operand, `definition` those of the expression behind a definition or a weight.
    pub(crate) fn new<'f>(
        kind: &ExprKind,
        definition: Option<&Facts>,
        of: impl Fn(ExprId) -> &'f Facts,
    ) -> Facts {
        let parts: Vec<&Facts> = operands(kind).into_iter().map(&of).collect();
        Facts {
            height: 1 + parts.iter().map(|part| part.height).max().unwrap_or(0),
            size: parts
                .iter()
                .fold(1, |sum, part| part.size.saturating_add(sum)),
            depth: 1 + parts
                .iter()
                .copied()
                .chain(definition)
                .map(|part| part.depth)
                .max()
                .unwrap_or(0),
            any_unit: any_unit(kind, &parts),
            literal: literal(kind, &parts),
            structure: structure(kind, &parts),
            moves: matches!(kind, ExprKind::Eta)
                || parts
                    .iter()
                    .copied()
                    .chain(definition)
                    .any(|part| part.moves),
            reads_state: matches!(
                kind,
                ExprKind::Velocity | ExprKind::TimeStep | ExprKind::Field(_) | ExprKind::History(_)
            ) || parts
                .iter()
                .copied()
                .chain(definition)
                .any(|part| part.reads_state),
            extreme: parts
                .iter()
                .copied()
                .chain(definition)
                .any(|part| part.extreme)
                || matches!(kind, ExprKind::Reduce(r, ..) if r.is_extreme()) && parts[0].moves,
            second_ring: [false, true].map(|primed| second_ring(kind, primed, &parts, definition)),
            beyond: [NODE, REFERENCE, BOND, LENGTH]
                .map(|want| beyond(kind, want, &parts, definition)),
        }
    }
}

fn any_unit(kind: &ExprKind, parts: &[&Facts]) -> bool {
    match kind {
        ExprKind::Number(value) => *value == 0.0 || value.is_infinite(),
        ExprKind::Neg(_) => parts[0].any_unit,
        _ => false,
    }
}

fn literal(kind: &ExprKind, parts: &[&Facts]) -> Option<f64> {
    match kind {
        ExprKind::Number(value) => Some(*value),
        ExprKind::Pi => Some(std::f64::consts::PI),
        ExprKind::Neg(_) => Some(-parts[0].literal?),
        ExprKind::Binary(op, ..) => {
            let (left, right) = (parts[0].literal?, parts[1].literal?);
            match op {
                BinaryOp::Add => Some(left + right),
                BinaryOp::Sub => Some(left - right),
                BinaryOp::Mul => Some(left * right),
                BinaryOp::Div => Some(left / right),
                BinaryOp::Pow => Some(left.powf(right)),
                BinaryOp::And | BinaryOp::Or => None,
            }
        }
        _ => None,
    }
}

fn structure(kind: &ExprKind, parts: &[&Facts]) -> u64 {
    let mut hasher = DefaultHasher::new();
    std::mem::discriminant(kind).hash(&mut hasher);
    own(kind).hash(&mut hasher);
    parts
        .iter()
        .for_each(|part| part.structure.hash(&mut hasher));
    hasher.finish()
}

/// What an expression holds besides its operands.
fn own(kind: &ExprKind) -> String {
    use ExprKind::*;
    match kind {
        Neg(_) | Not(_) | Prime(_) | Ball(_) | Case(_) | Vector(_) => String::new(),
        Component(_, axes) => format!("{axes:?}"),
        Reduce(reduction, family, _) => format!("{reduction:?} {family:?}"),
        Binary(op, ..) => format!("{op:?}"),
        Compare(op, ..) => format!("{op:?}"),
        Call(builtin, _) => format!("{builtin:?}"),
        leaf => format!("{leaf:?}"),
    }
}

fn second_ring(
    kind: &ExprKind,
    primed: bool,
    parts: &[&Facts],
    definition: Option<&Facts>,
) -> bool {
    match kind {
        ExprKind::Prime(_) => parts[0].second_ring[usize::from(!primed)],
        ExprKind::Reduce(..) if primed => parts[0].moves,
        _ => parts
            .iter()
            .copied()
            .chain(definition)
            .any(|part| part.second_ring[usize::from(primed)]),
    }
}

fn beyond(
    kind: &ExprKind,
    want: usize,
    parts: &[&Facts],
    definition: Option<&Facts>,
) -> Option<&'static str> {
    use ExprKind::*;
    match kind {
        // The length of xi is a length, whatever the direction.
        Call(Builtin::Norm, _) if parts[0].structure == structure(&Xi, &[]) => None,
        Xi if want == LENGTH => Some("this depends on the direction of the bond"),
        // A sum over bonds is wrong by itself.
        Eta if want == NODE => None,
        Eta => Some("this changes with the displacement"),
        Velocity => Some("this changes with the velocity"),
        Position if want > REFERENCE => Some("this depends on where the node is"),
        TimeStep => Some("this may change with every step"),
        // A coefficient; whether it is one is known elsewhere.
        Field(_) if want == NODE => None,
        Field(_) => Some("this is a field, which evolves"),
        History(_) => Some("this is a history, which evolves"),
        Reduce(Reduction::Sum0, ..) if want == REFERENCE => parts[0].beyond[want],
        Reduce(..) if want == REFERENCE => Some("this runs over the intact bonds, which may break"),
        Reduce(..) => Some("this is a sum over the bonds of one node"),
        Weight(_) if want > REFERENCE => Some("this depends on the families of both ends"),
        Prime(_) if want > REFERENCE => Some("this belongs to the other end"),
        _ => parts
            .iter()
            .copied()
            .chain(definition)
            .find_map(|part| part.beyond[want]),
    }
}
