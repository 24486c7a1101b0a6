//! PD025: a family that is not part of the reference horizon.

use crate::ast::Name;
use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD025";

pub(crate) fn changes(name: &Name, span: Span, why: &str) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!("the family `{}` would change during the run", name.text),
    )
    .at(span, why)
    .help("families are chosen once, by the reference bond: `xi`, `x` and constants")
}

pub(crate) fn base(name: &Name) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!("a family is a part of `horizon`, not of `{}`", name.text),
    )
    .at(name.span, "expected `horizon`")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn families_do_not_change() {
        refuse("family hot = horizon where s > 0", "PD025", "s");
        refuse("family near = close where x < delta", "PD025", "close");
        refuse("family left = horizon where X.x > 0", "PD025", "X");
        accept("family near = horizon where xi.x > 0.5*x and x < delta/2 node n = sum[near](1)");
    }
}
