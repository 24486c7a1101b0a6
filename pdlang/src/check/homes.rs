//! PD020: a value where it does not live.

use crate::ast::Name;
use crate::diag::Diagnostic;
use crate::ir::{Expr, Home};
use crate::span::Span;

const CODE: &str = "PD020";

/// `what` is the thing that should live at `home`, `blamed` the part that lives too far out.
pub(crate) fn too_far(
    what: &str,
    name: &Name,
    home: Home,
    found: &Expr,
    blamed: Span,
) -> Diagnostic {
    let label = match found.home {
        Home::Bond => "this is a bond value: each bond of the node has its own",
        _ => "this is a node value: each node has its own",
    };
    let message = match home {
        Home::Constant => format!("`{}` is not constant", name.text),
        _ => format!("the {what} `{}` needs a sum over the bonds", name.text),
    };
    let finding = Diagnostic::error(CODE, message).at(blamed, label).at(
        name.span,
        if home == Home::Constant {
            "a constant"
        } else {
            "one value per node"
        },
    );
    match (home, found.home) {
        (Home::Constant, Home::Node) => {
            finding.help(format!("define it with `node {} = ..`", name.text))
        }
        (Home::Constant, _) => finding.help(format!(
            "define it with `bond {0} = ..`, or take the integral over the horizon, `ball(..)`",
            name.text
        )),
        _ => finding.help("take the sum over the family, `sum(..)`, or define a `bond` value"),
    }
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, bare, refuse, refuse_text};

    #[test]
    fn values_live_where_they_are_declared() {
        refuse("node m = omega*x^2", "PD020", "omega");
        refuse("let c = 1/x", "PD020", "x");
        refuse("let c = K/sum(x)", "PD020", "sum(x)");
        refuse("field T : number \"T\" rate T = s/(1 s)", "PD020", "s");
        refuse(
            "history p : number on node \"p\" update p = s",
            "PD020",
            "s",
        );
        refuse_text(
            &bare("param K : pressure \"K\" energy W = K*s"),
            "PD020",
            "s",
        );
    }

    #[test]
    fn what_lives_nearer_is_fine() {
        accept("node c = 1 bond d = c*K");
    }
}
