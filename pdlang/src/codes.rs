//! What the codes of findings mean, at length: the sections of `codes.md`.

/// The page of all codes.
pub const PAGE: &str = include_str!("codes.md");

/// The section of a code: heading, text and examples.
pub fn explanation(code: &str) -> Option<&'static str> {
    let heading = format!("\n## {}:", code.to_uppercase());
    let start = PAGE.find(&heading)? + 1;
    let rest = &PAGE[start..];
    let end = rest[3..].find("\n## ").map_or(rest.len(), |k| k + 3);
    Some(rest[..end].trim_end())
}

/// Every code that has a section, in order.
pub fn codes() -> impl Iterator<Item = &'static str> {
    let headings = PAGE.lines().filter_map(|line| line.strip_prefix("## "));
    headings.filter_map(|heading| heading.split(':').next())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::front;
    use std::collections::BTreeSet;
    use std::path::Path;

    #[test]
    fn every_code_is_explained() {
        fn collect(folder: &Path, found: &mut BTreeSet<String>) {
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.is_dir() {
                    collect(&path, found);
                } else if path.extension().is_some_and(|e| e == "rs") {
                    let text = std::fs::read_to_string(&path).unwrap();
                    let codes = text.match_indices("\"PD").map(|(k, _)| &text[k + 1..]);
                    let quoted = codes.filter_map(|rest| rest.split('"').next());
                    found.extend(quoted.filter(|code| code.len() == 5).map(String::from));
                }
            }
        }
        let mut found = BTreeSet::new();
        collect(
            &Path::new(env!("CARGO_MANIFEST_DIR")).join("src"),
            &mut found,
        );
        // Named by tests alone.
        found.retain(|code| !["PD100", "PD999"].contains(&code.as_str()));
        let explained: BTreeSet<String> = codes().map(String::from).collect();
        assert_eq!(found, explained);
        assert!(explanation("pd012").is_some_and(|text| text.starts_with("## PD012: units")));
        assert_eq!(explanation("PD999"), None);
        assert_eq!(explanation(""), None);
    }

    #[test]
    fn examples_are_what_they_are_said_to_be() {
        let (mut wrong, mut off) = (0, Vec::new());
        for code in codes() {
            let section = explanation(code).unwrap();
            for (kind, example) in examples(section) {
                let law = law(example);
                let found: Vec<&str> = front::file(&law)
                    .diagnostics
                    .iter()
                    .map(|d| d.code)
                    .collect();
                let as_said = match kind {
                    "wrong" => found.contains(&code),
                    _ => found.iter().all(|code| *code > "PD100"),
                };
                wrong += usize::from(kind == "wrong");
                if !as_said {
                    off.push(format!("{code}: {found:?}\n{example}"));
                }
            }
        }
        assert!(off.is_empty(), "{}", off.join("\n"));
        assert!(wrong > 30, "{wrong}");
    }

    /// The examples of a section, as (`wrong` or `right`, items).
    fn examples(section: &str) -> impl Iterator<Item = (&str, &str)> {
        let fences = section.split("```").skip(1).step_by(2);
        fences.filter_map(|fence| fence.split_once('\n'))
    }

    fn law(items: &str) -> String {
        let own = items.lines().any(|line| line.starts_with("energy"));
        let energy = match own {
            true => "",
            false => "  energy W = K*sum(omega*s^2)/ball(omega)\n",
        };
        format!(
            "model m \"M\"\n  cite \"N, eq. 1\"\n{{\n  influence omega = 1/x\n  param K : pressure > 0 \"modulus\"\n{energy}{items}}}\n"
        )
    }
}
