//! PD009: a law without end.

use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD009";

pub(crate) fn too_deep(span: Span) -> Diagnostic {
    Diagnostic::error(CODE, "this expression is nested too deeply")
        .at(span, "")
        .help("give parts of it a name with `let`, `node` or `bond`")
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
}
