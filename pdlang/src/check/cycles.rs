//! PD005: definitions that need themselves.

use crate::ast::Name;
use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD005";

/// Each name of the chain needs the next, and the last the first.
pub(crate) fn definitions(chain: &[&Name]) -> Diagnostic {
    let mut finding = Diagnostic::error(
        CODE,
        format!(
            "{} {}",
            list(chain),
            if chain.len() == 1 {
                "needs itself"
            } else {
                "need each other"
            }
        ),
    );
    for (k, name) in chain.iter().enumerate() {
        let next = chain[(k + 1) % chain.len()];
        finding = finding.at(name.span, format!("needs `{}`", next.text));
    }
    finding
        .help("memory of an earlier step is a `history`; what evolves is a `field` with a `rate`")
}

fn list(chain: &[&Name]) -> String {
    chain
        .iter()
        .map(|name| format!("`{}`", name.text))
        .collect::<Vec<_>>()
        .join(", ")
}

/// Library definitions and functions, which are inlined and so cannot recur.
pub(crate) fn recursion(chain: &[String], span: Span) -> Diagnostic {
    let path = chain
        .iter()
        .map(|name| format!("`{name}`"))
        .collect::<Vec<_>>()
        .join(" -> ");
    Diagnostic::error(CODE, format!("{path} needs itself"))
        .at(span, "used inside of itself")
        .help("functions are inlined where they are used, and cannot recur")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{accept, law, refuse, refuse_text};

    #[test]
    fn names_the_chain() {
        refuse("node a = b node b = sum(c) bond c = a*x", "PD005", "a");
        refuse("let a = a", "PD005", "a");
        refuse_text(
            &format!("fn f(a) = g(a) fn g(a) = f(a) {}", law("let c = f(1)")),
            "PD005",
            "f",
        );
        refuse_text(
            &format!("bond p = q bond q = p {}", law("bond b = p")),
            "PD005",
            "p",
        );
    }

    #[test]
    fn order_is_free_and_memory_is_no_cycle() {
        accept("node a = sum(b) bond b = c*x let c = 2");
        accept("history p : number on bond \"memory\" update p = p/2");
    }
}
