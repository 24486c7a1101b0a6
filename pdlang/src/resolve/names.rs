//! Words that the language itself gives a meaning: the one table of primitives and built-in functions.

use crate::ir::{Builtin, ExprKind, Home, Reduction, Shape};
use crate::units::Unit;

/// A value that is not definable in the language.
pub(crate) struct Primitive {
    pub name: &'static str,
    pub kind: ExprKind,
    pub shape: Shape,
    pub home: Home,
    pub unit: Unit,
}

/// The reduction of that name. `min` and `max` of one argument are extremes over bonds, of two functions.
pub(crate) fn reduction(name: &str, arguments: usize) -> Option<Reduction> {
    match (name, arguments) {
        ("sum", _) => Some(Reduction::Sum),
        ("sum0", _) => Some(Reduction::Sum0),
        ("mean", _) => Some(Reduction::Mean),
        ("count", _) => Some(Reduction::Count),
        ("min", 1) => Some(Reduction::Min),
        ("max", 1) => Some(Reduction::Max),
        _ => None,
    }
}

pub(crate) const PRIMITIVES: &[Primitive] = &[
    primitive(
        "pi",
        ExprKind::Pi,
        Shape::Scalar,
        Home::Constant,
        Unit::NUMBER,
    ),
    primitive(
        "inf",
        ExprKind::Number(f64::INFINITY),
        Shape::Scalar,
        Home::Constant,
        Unit::NUMBER,
    ),
    primitive(
        "dim",
        ExprKind::Dim,
        Shape::Scalar,
        Home::Constant,
        Unit::NUMBER,
    ),
    primitive(
        "delta",
        ExprKind::Delta,
        Shape::Scalar,
        Home::Constant,
        Unit::length(),
    ),
    primitive(
        "I",
        ExprKind::Identity,
        Shape::Symmetric,
        Home::Constant,
        Unit::NUMBER,
    ),
    primitive(
        "xi",
        ExprKind::Xi,
        Shape::Vector,
        Home::Bond,
        Unit::length(),
    ),
    primitive(
        "eta",
        ExprKind::Eta,
        Shape::Vector,
        Home::Bond,
        Unit::length(),
    ),
    primitive(
        "X",
        ExprKind::Position,
        Shape::Vector,
        Home::Node,
        Unit::length(),
    ),
    primitive(
        "velocity",
        ExprKind::Velocity,
        Shape::Vector,
        Home::Node,
        Unit::velocity(),
    ),
    primitive(
        "dt",
        ExprKind::TimeStep,
        Shape::Scalar,
        Home::Node,
        Unit::time(),
    ),
];

const fn primitive(
    name: &'static str,
    kind: ExprKind,
    shape: Shape,
    home: Home,
    unit: Unit,
) -> Primitive {
    Primitive {
        name,
        kind,
        shape,
        home,
        unit,
    }
}

/// Primitives that mean something outside of a law, in influence functions and scenes.
pub(crate) const PURE: [&str; 2] = ["pi", "inf"];

/// Built-in functions: name, meaning, number of arguments.
pub(crate) const BUILTINS: &[(&str, Builtin, usize)] = &[
    ("norm", Builtin::Norm, 1),
    ("dot", Builtin::Dot, 2),
    ("outer", Builtin::Outer, 2),
    ("tr", Builtin::Trace, 1),
    ("sym", Builtin::Sym, 1),
    ("dev", Builtin::Dev, 1),
    ("det", Builtin::Det, 1),
    ("inverse", Builtin::Inverse, 1),
    ("transpose", Builtin::Transpose, 1),
    ("diag", Builtin::Diag, 1),
    ("sqrt", Builtin::Sqrt, 1),
    ("abs", Builtin::Abs, 1),
    ("exp", Builtin::Exp, 1),
    ("ln", Builtin::Ln, 1),
    ("sin", Builtin::Sin, 1),
    ("cos", Builtin::Cos, 1),
    ("tan", Builtin::Tan, 1),
    ("min", Builtin::Min, 2),
    ("max", Builtin::Max, 2),
    ("select", Builtin::Select, 3),
];

/// Forms that look like functions and change the home of their argument.
pub(crate) const FORMS: &[&str] = &["sum", "sum0", "mean", "count", "ball", "other", "under"];

pub(crate) fn is_function(name: &str) -> bool {
    FORMS.contains(&name) || BUILTINS.iter().any(|builtin| builtin.0 == name)
}

pub(crate) fn is_primitive(name: &str) -> bool {
    PRIMITIVES.iter().any(|primitive| primitive.name == name)
}
