//! PD102: a definition that nothing uses.

use crate::ast::Name;
use crate::diag::Diagnostic;

const CODE: &str = "PD102";

pub(crate) fn warning(what: &str, name: &Name) -> Diagnostic {
    Diagnostic::warning(CODE, format!("the {what} `{}` is never used", name.text))
        .at(name.span, "no response, break or node value needs it")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::bare;

    #[test]
    fn finds_what_nothing_needs() {
        let text = bare(
            "param K : pressure \"K\" param G : pressure \"G\" field h : number \"h\"
             let a = G bond b = a*x energy W = K*sum(s^2)/ball(1)",
        );
        let findings = crate::front::file(&text).diagnostics;
        let names: Vec<&str> = findings
            .iter()
            .map(|finding| &text[finding.span().start as usize..finding.span().end as usize])
            .collect();
        assert_eq!(names, ["G", "h", "a", "b"]);
        assert!(findings.iter().all(|finding| finding.code == "PD102"));
    }

    #[test]
    fn a_field_without_a_rate_is_a_coefficient() {
        let text = bare(
            "param K : pressure \"K\" field h : number \"h\" node W_h = h*sum(s^2) energy W = K*W_h/ball(1)",
        );
        assert!(crate::front::file(&text).diagnostics.is_empty());
    }

    #[test]
    fn node_values_are_outputs() {
        let text = bare(
            "param K : pressure \"K\" let a = 1 node n = sum(a*x) energy W = K*sum(s^2)/ball(1)",
        );
        assert!(crate::front::file(&text).diagnostics.is_empty());
    }
}
