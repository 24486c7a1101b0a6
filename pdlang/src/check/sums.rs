//! PD023: a sum of values that do not belong to its bonds.

use crate::ast::Name;
use crate::diag::Diagnostic;
use crate::ir::Expr;

const CODE: &str = "PD023";

/// The summand lives at the node. A lone name could take a prime.
pub(crate) fn node_value(sum: &Name, summand: &Expr, is_name: bool) -> Diagnostic {
    let finding = Diagnostic::error(
        CODE,
        format!("`{}` of a value that is the same in every term", sum.text),
    )
    .at(summand.span, "this is a node value");
    match is_name {
        true => finding.help("the value at the other end of each bond is written with a prime: `T'`"),
        false => finding.help(format!("prime what belongs to the other end, as in `T'`, or take the factor out of the sum: `T*{}(1)`", sum.text)),
    }
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, refuse};

    #[test]
    fn terms_belong_to_bonds() {
        refuse("node m = sum(x) node n = sum(m)", "PD023", "m");
        refuse("node m = sum0(sum(x)*2)", "PD023", "sum(x)*2");
        accept("node v = sum(1) node m = sum(x) node n = sum(m' - m) + m*sum(1)");
    }
}
