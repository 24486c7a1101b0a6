//! PD040: a law that does not answer, or answers twice.

use crate::ast::Name;
use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD040";

pub(crate) fn none(model: &Name) -> Diagnostic {
    Diagnostic::error(CODE, format!("the model `{}` answers nothing", model.text))
        .at(model.span, "no response")
        .help("a law states an `energy`, from which the force is derived, a `pair`, `state` or `force`, or the `rate` of a field")
}

pub(crate) fn twice(what: &str, name: &Name, earlier: Span) -> Diagnostic {
    Diagnostic::error(CODE, format!("a second {what}"))
        .at(name.span, "")
        .at(earlier, "the first one")
        .help("write their sum")
}

pub(crate) fn without_update(history: &Name) -> Diagnostic {
    let name = &history.text;
    Diagnostic::error(CODE, format!("the history `{name}` never changes"))
        .at(history.span, "no `update`")
        .help(format!("`update {name} = ..`"))
}

pub(crate) fn not_the_velocity(name: &Name) -> Diagnostic {
    Diagnostic::error(
        CODE,
        format!("`{}` cannot be replaced after a step", name.text),
    )
    .at(name.span, "only the velocity can")
    .help("`after step velocity = ..`; what remembers is a `history` with its `update`")
}

pub(crate) fn no_family(what: &str, family: &Name) -> Diagnostic {
    Diagnostic::error(CODE, format!("{what} has no family"))
        .at(family.span, "families belong to bonds")
        .help(format!(
            "sum over the family inside of it: `sum[{}](..)`",
            family.text
        ))
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{bare, refuse, refuse_text};

    #[test]
    fn laws_answer_once() {
        refuse_text(&bare("node m = sum(x)"), "PD040", "m");
        refuse("energy V = K*sum(s^2)/ball(1)", "PD040", "V");
        refuse("history p : number on bond \"p\"", "PD040", "p");
        refuse(
            "field T : number \"T\" rate T = T/(1 s) rate T = T/(1 s)",
            "PD040",
            "T",
        );
        refuse_text(
            &bare(
                "param K : pressure \"K\" family near = horizon where x < delta energy[near] W = K",
            ),
            "PD040",
            "near",
        );
    }
}
