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
