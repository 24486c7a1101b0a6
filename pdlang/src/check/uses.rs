//! PD070: a file that cannot be used.

use crate::ast::{Name, Text};
use crate::diag::Diagnostic;

const CODE: &str = "PD070";

pub(crate) fn missing(used: &Text, path: &str, why: &str) -> Diagnostic {
    Diagnostic::error(CODE, format!("cannot use `{}`", used.text))
        .at(used.span, format!("{path}: {why}"))
        .help("paths start at the folder of the file that uses them")
}

pub(crate) fn cycle(used: &Text, chain: &[String]) -> Diagnostic {
    Diagnostic::error(CODE, format!("`{}` uses itself", used.text))
        .at(used.span, chain.join(" -> "))
        .help("put what both need into a third file")
}

/// `shown` is the first finding in that file.
pub(crate) fn broken(used: &Text, path: &str, shown: &str) -> Diagnostic {
    Diagnostic::error(CODE, format!("`{path}` has errors"))
        .at(used.span, "used here")
        .help(format!("the first one is\n{shown}"))
}

pub(crate) fn taken(name: &Name, path: &str) -> Diagnostic {
    Diagnostic::error(CODE, format!("`{}` is defined twice", name.text)).at(
        name.span,
        format!("`{path}`, which is used, defines it too"),
    )
}

pub(crate) fn twice(used: &Text, name: &str, earlier: &str, path: &str) -> Diagnostic {
    Diagnostic::error(CODE, format!("`{name}` is defined twice"))
        .at(used.span, format!("both by `{earlier}` and by `{path}`"))
}

#[cfg(test)]
mod tests {
    use crate::front;

    const FILES: [(&str, &str); 9] = [
        (
            "lib/a.pd",
            "use \"sub/b.pd\"  let half = 0.5  fn third(a) = half*twice(a)/3",
        ),
        (
            "lib/sub/b.pd",
            "fn twice(a) = a + a  bond mean = (x + y)/2  influence soft(r) = twice(1 - r/delta)",
        ),
        (
            "lib/both.pd",
            "use \"a.pd\" use \"sub/b.pd\" model m { let a = 1 }",
        ),
        ("lib/loop.pd", "use \"back.pd\""),
        ("lib/back.pd", "use \"loop.pd\""),
        ("lib/syntax.pd", "fn good(a) = a\nfn bad(a) = = a"),
        ("lib/bad.pd", "influence bad(r) = 1/q"),
        ("lib/again.pd", "fn twice(a) = 2*a"),
        ("lib/inner.pd", "fn inner(a) = a + unknown"),
    ];

    fn found(text: &str) -> Vec<(String, String)> {
        let mut files = |path: &str| {
            let found = FILES.iter().find(|(name, _)| *name == path);
            found
                .map(|(_, text)| text.to_string())
                .ok_or_else(|| "not there".to_string())
        };
        let checked = front::file_in(text, "lib/law.pd", &mut files);
        let token = |d: &crate::diag::Diagnostic| {
            assert!(!d.span().prelude, "{d:?}");
            (
                d.message.clone(),
                text[d.span().start as usize..d.span().end as usize].to_string(),
            )
        };
        checked
            .diagnostics
            .iter()
            .filter(|d| d.is_error())
            .map(token)
            .collect()
    }

    fn law(uses: &str, energy: &str) -> String {
        format!(
            "{uses} model m \"T\" cite \"N, eq. 1\" {{ influence w = soft param K : pressure \"K\" energy W = {energy} }}"
        )
    }

    #[track_caller]
    fn refuse(text: &str, message: &str, token: &str) {
        assert_eq!(
            found(text),
            [(message.to_string(), token.to_string())],
            "{text}"
        );
    }

    #[test]
    fn definitions_are_shared_once() {
        let energy = "third(K)*sum(w*mean*s^2)/ball(w*x)";
        assert_eq!(found(&law("use \"a.pd\"", energy)), []);
        assert_eq!(
            found(&law("use \"both.pd\" use \"./sub/../a.pd\"", energy)),
            []
        );
    }

    #[test]
    fn says_what_is_wrong_with_a_file() {
        refuse("use \"none.pd\"", "cannot use `none.pd`", "\"none.pd\"");
        refuse("use \"loop.pd\"", "`loop.pd` uses itself", "\"loop.pd\"");
        refuse("use \"law.pd\"", "`law.pd` uses itself", "\"law.pd\"");
        refuse(
            "use \"syntax.pd\"",
            "`lib/syntax.pd` has errors",
            "\"syntax.pd\"",
        );
        refuse("use \"bad.pd\"", "`lib/bad.pd` has errors", "\"bad.pd\"");
        refuse(
            "use \"a.pd\" use \"again.pd\"",
            "`twice` is defined twice",
            "\"again.pd\"",
        );
        refuse(
            "use \"a.pd\" fn third(a) = a",
            "`third` is defined twice",
            "third",
        );
    }

    #[test]
    fn what_is_wrong_inside_of_a_function_is_said_at_its_use() {
        let text = law(
            "use \"inner.pd\" use \"a.pd\"",
            "inner(K)*sum(w*s^2)/ball(w)",
        );
        refuse(&text, "in `inner()`: `unknown` is not defined", "inner(K)");
    }

    #[test]
    fn a_text_without_a_file_uses_none() {
        let checked = front::file("use \"a.pd\"");
        assert!(checked.has_errors() && checked.diagnostics.len() == 1);
    }
}
