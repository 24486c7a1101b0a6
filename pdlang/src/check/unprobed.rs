//! PD103: a law without a probe. Said when probes are run, not when a law is compiled.

use crate::diag::Diagnostic;
use crate::span::Span;

const CODE: &str = "PD103";

pub(crate) fn warning(law: &str, place: Span) -> Diagnostic {
    Diagnostic::warning(CODE, format!("the law `{law}` has no probe"))
        .at(place, "nothing says which values are right")
        .help("`probe one_bond in 3d where K = 1 GPa, delta = 2 mm { node a = .. expect force(a) = .. }`")
}

#[cfg(test)]
mod tests {
    use crate::check::tests::law;
    use crate::{front, probe};

    #[test]
    fn a_law_is_probed() {
        let checked = front::file(&law(""));
        let findings = probe::findings(&checked.laws[0]);
        assert!(findings.len() == 1 && !findings[0].is_error() && findings[0].code == "PD103");
    }
}
