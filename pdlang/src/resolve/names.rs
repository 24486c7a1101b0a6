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
    /// What it is, as editors say it.
    pub doc: &'static str,
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
        "the number pi",
    ),
    primitive(
        "inf",
        ExprKind::Number(f64::INFINITY),
        Shape::Scalar,
        Home::Constant,
        Unit::NUMBER,
        "infinity: a bound that nothing reaches",
    ),
    primitive(
        "dim",
        ExprKind::Dim,
        Shape::Scalar,
        Home::Constant,
        Unit::NUMBER,
        "number of dimensions",
    ),
    primitive(
        "delta",
        ExprKind::Delta,
        Shape::Scalar,
        Home::Constant,
        Unit::length(),
        "horizon",
    ),
    primitive(
        "I",
        ExprKind::Identity,
        Shape::Symmetric,
        Home::Constant,
        Unit::NUMBER,
        "unit tensor",
    ),
    primitive(
        "xi",
        ExprKind::Xi,
        Shape::Vector,
        Home::Bond,
        Unit::length(),
        "reference bond vector",
    ),
    primitive(
        "eta",
        ExprKind::Eta,
        Shape::Vector,
        Home::Bond,
        Unit::length(),
        "relative displacement",
    ),
    primitive(
        "X",
        ExprKind::Position,
        Shape::Vector,
        Home::Node,
        Unit::length(),
        "reference position",
    ),
    primitive(
        "velocity",
        ExprKind::Velocity,
        Shape::Vector,
        Home::Node,
        Unit::velocity(),
        "velocity",
    ),
    primitive(
        "dt",
        ExprKind::TimeStep,
        Shape::Scalar,
        Home::Node,
        Unit::time(),
        "time step",
    ),
];

const fn primitive(
    name: &'static str,
    kind: ExprKind,
    shape: Shape,
    home: Home,
    unit: Unit,
    doc: &'static str,
) -> Primitive {
    Primitive {
        name,
        kind,
        shape,
        home,
        unit,
        doc,
    }
}

/// Primitives that mean something outside of a law, in influence functions and scenes.
pub(crate) const PURE: [&str; 2] = ["pi", "inf"];

/// Built-in functions: name, meaning, number of arguments, and what editors say.
pub(crate) const BUILTINS: &[(&str, Builtin, usize, &str)] = &[
    ("norm", Builtin::Norm, 1, "the length of a vector"),
    ("dot", Builtin::Dot, 2, "the scalar product of two vectors"),
    (
        "outer",
        Builtin::Outer,
        2,
        "the tensor product of two vectors; symmetric, if they are the same",
    ),
    ("tr", Builtin::Trace, 1, "the trace of a tensor"),
    ("sym", Builtin::Sym, 1, "the symmetric part of a tensor"),
    (
        "dev",
        Builtin::Dev,
        1,
        "the deviator of a tensor, whose trace in the dimensions of the scene is zero",
    ),
    (
        "det",
        Builtin::Det,
        1,
        "the determinant of a tensor of pure numbers",
    ),
    ("inverse", Builtin::Inverse, 1, "the inverse of a tensor"),
    (
        "transpose",
        Builtin::Transpose,
        1,
        "the transpose of a tensor",
    ),
    (
        "diag",
        Builtin::Diag,
        1,
        "the tensor with a vector on its diagonal, or the vector on the diagonal of a tensor",
    ),
    ("sqrt", Builtin::Sqrt, 1, "the square root"),
    ("abs", Builtin::Abs, 1, "the magnitude"),
    ("exp", Builtin::Exp, 1, "the exponential"),
    ("ln", Builtin::Ln, 1, "the natural logarithm"),
    ("sin", Builtin::Sin, 1, "the sine of an angle in radians"),
    ("cos", Builtin::Cos, 1, "the cosine of an angle in radians"),
    ("tan", Builtin::Tan, 1, "the tangent of an angle in radians"),
    (
        "min",
        Builtin::Min,
        2,
        "the smaller of two values; with one argument: the extreme over the intact bonds",
    ),
    (
        "max",
        Builtin::Max,
        2,
        "the larger of two values; with one argument: the extreme over the intact bonds",
    ),
    (
        "select",
        Builtin::Select,
        3,
        "the second value where the condition, which comes first, is true, else the third",
    ),
];

/// Forms that look like functions and change the home of their argument, and what editors say.
pub(crate) const FORMS: &[(&str, &str)] = &[
    (
        "sum",
        "the sum over the intact bonds, weighted with the volume of the other end",
    ),
    ("sum0", "the same as `sum` over all bonds there ever were"),
    (
        "mean",
        "the average over the intact bonds, weighted with the volume of the other end",
    ),
    (
        "count",
        "the number of intact bonds for which a condition holds",
    ),
    (
        "ball",
        "the integral of a reference bond value over the whole horizon: a constant",
    ),
    (
        "other",
        "the value at the other end of the bond, which is also written `T'`",
    ),
    (
        "under",
        "`under(H, q)` is `q` for the uniform displacement gradient `H`, a constant tensor",
    ),
];

pub(crate) fn is_function(name: &str) -> bool {
    function_doc(name).is_some()
}

pub(crate) fn is_primitive(name: &str) -> bool {
    PRIMITIVES.iter().any(|primitive| primitive.name == name)
}

/// What a built-in function or form is.
pub(crate) fn function_doc(name: &str) -> Option<&'static str> {
    let builtins = BUILTINS.iter().map(|builtin| (builtin.0, builtin.3));
    let mut all = builtins.chain(FORMS.iter().copied());
    all.find(|(known, _)| *known == name).map(|(_, doc)| doc)
}
