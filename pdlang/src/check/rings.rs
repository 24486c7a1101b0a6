//! PD024: an energy that needs the neighbours of neighbours.

use crate::ast::Name;
use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD024";

pub(crate) fn second(energy: &Name, span: Span) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!("the energy `{}` needs a second ring", energy.text),
    )
    .at(
        span,
        "a sum over the bonds of the other end, which changes with the displacement",
    )
    .at(
        energy.span,
        "its force would reach the neighbours of neighbours",
    )
    .help("write the force state itself with `state`, which may read sums of both ends")
}
