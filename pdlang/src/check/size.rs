//! PD009: a law without end.

use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD009";

pub(crate) fn too_deep(span: Span) -> Diagnostic {
    Diagnostic::error(CODE, "this expression is nested too deeply")
        .at(span, "")
        .help("give parts of it a name with `let`, `node` or `bond`")
}

pub(crate) fn leans_too_far(span: Span, most: u32) -> Diagnostic {
    let message =
        format!("more than {most} operations wait for each other here, through definitions");
    Diagnostic::error(CODE, message)
        .at(span, "the limit is reached here")
        .help("a law states what an iteration ends with, not its steps: let fewer definitions lean on each other")
}

pub(crate) fn too_large(span: Span) -> Diagnostic {
    Diagnostic::error(
        CODE,
        "this law grows without end as its functions are inlined",
    )
    .at(span, "the limit is reached here")
    .help("give parts of it a name with `let`, `node` or `bond`")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::{found, law};

    #[test]
    fn inlining_ends() {
        let doubling: String = (1..50)
            .map(|k| format!("fn f{k}(a) = f{0}(a) + f{0}(a) ", k - 1))
            .collect();
        let text = format!("fn f0(a) = a {doubling}{}", law("bond b = f20(x)"));
        assert_eq!(found(&text)[0].0, "PD009");
        let chain: String = (1..50)
            .map(|k| format!("fn f{k}(a) = f{}(a) + 1 ", k - 1))
            .collect();
        let text = format!("fn f0(a) = a {chain}{}", law("bond b = f49(s)"));
        assert_eq!(found(&text)[0].0, "PD009");
    }

    #[test]
    fn what_is_shared_counts_as_often_as_it_is_read() {
        let nested = |n| format!("bond b = {}s{}", "f(".repeat(n), ")".repeat(n));
        let text = |n| format!("fn f(a) = a + a {}", law(&nested(n)));
        assert!(found(&text(10)).iter().all(|f| f.0 != "PD009"));
        assert_eq!(found(&text(20))[0].0, "PD009");
    }

    #[test]
    fn definitions_lean_on_each_other_within_a_limit() {
        let chain = |n: usize| -> String {
            let links = (1..n).map(|k| format!("bond b{k} = b{} + 1 ", k - 1));
            law(&format!("bond b0 = s {}", links.collect::<String>()))
        };
        let errors = |n| {
            found(&chain(n))
                .into_iter()
                .filter(|f| f.0 == "PD009")
                .count()
        };
        assert_eq!(errors(195), 0);
        // Said once: what leans on it is not known.
        assert_eq!(errors(220), 1);
    }
}
