//! `docs/language.md` and `docs/tutorial.md` are run: their laws are right, their mistakes get the messages that
//! stand below them, and no word of the language is forgotten.
//!
//! A block `pd` is a text without findings whose probes hold; `pd items` is a part of a model; `pd wrong` is
//! followed by a block `text` with what `pdlang check` says. `UPDATE_EXPECT=1 cargo test -p pdlang-tests --test
//! language_pages` writes those messages anew: read the difference.

use pdlang::diag::Diagnostic;
use pdlang::{front, probe};
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Code blocks: kind, and the place of their text.
fn blocks(page: &str) -> Vec<(String, std::ops::Range<usize>)> {
    let (mut blocks, mut at) = (Vec::new(), 0);
    let mut open: Option<(String, usize)> = None;
    for line in page.split_inclusive('\n') {
        at += line.len();
        if let Some(kind) = line.trim_end().strip_prefix("```") {
            open = match open.take() {
                Some((kind, start)) => {
                    blocks.push((kind, start..at - line.len()));
                    None
                }
                None => Some((kind.to_string(), at)),
            };
        }
    }
    blocks
}

/// What `pdlang check` says of a text.
fn findings(text: &str) -> Vec<Diagnostic> {
    let checked = front::file(text);
    let probed = checked.laws.iter().flat_map(probe::findings);
    let all = checked.diagnostics.iter().cloned().chain(probed);
    all.filter(|finding| finding.code != "PD103").collect()
}

fn rendered(text: &str) -> String {
    let shown: Vec<String> = findings(text)
        .iter()
        .map(|finding| finding.render(text, "law.pd", false))
        .collect();
    shown.join("\n\n") + "\n"
}

/// Items as a model; what has no answer gets one.
fn model(items: &str) -> String {
    let answers = ["energy", "pair", "state", "rate"];
    let answered = items
        .lines()
        .any(|line| answers.iter().any(|word| line.starts_with(word)));
    let answer = if answered {
        ""
    } else {
        "energy W = 1 [Pa]*sum(s^2)/ball(1)"
    };
    format!("model m \"Example\" cite \"This page, eq. 1\" {{\n{items}\n{answer}\n}}")
}

fn check(path: &str) {
    let mut page = read(path);
    let update = std::env::var_os("UPDATE_EXPECT").is_some();
    let mut wrong = Vec::new();
    let mut k = 0;
    while let Some((kind, range)) = blocks(&page).get(k).cloned() {
        let text = page[range].to_string();
        match kind.as_str() {
            "pd" if !findings(&text).is_empty() => wrong.push(rendered(&text)),
            "pd items" if !findings(&model(&text)).is_empty() => {
                wrong.push(rendered(&model(&text)))
            }
            "pd wrong" => {
                let (kind, shown) = blocks(&page)[k + 1].clone();
                assert_eq!(kind, "text", "a message follows a mistake");
                assert_ne!(rendered(&text), "\n", "this is no mistake:\n{text}");
                if update {
                    page.replace_range(shown, &rendered(&text));
                } else if page[shown.clone()] != rendered(&text) {
                    wrong.push(format!(
                        "{}\nis shown, but said is\n{}",
                        &page[shown],
                        rendered(&text)
                    ));
                }
            }
            _ => {}
        }
        k += 1;
    }
    if update {
        std::fs::write(root().join(path), page).unwrap();
    }
    assert!(k > 5 && wrong.is_empty(), "{path}\n{}", wrong.join("\n"));
}

#[test]
fn the_language_page_is_right() {
    check("docs/language.md");
}

#[test]
fn the_tutorial_is_right_and_shows_files_as_they_are() {
    check("docs/tutorial.md");
    let page = read("docs/tutorial.md");
    let of = |wanted: &str| {
        let all = blocks(&page);
        let last = all.iter().rfind(|(kind, _)| kind == wanted).unwrap();
        page[last.1.clone()].to_string()
    };
    assert_eq!(of("toml"), read("examples/softening.toml"));
    let law = pdlang::fmt::format(&of("pd")).unwrap();
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        std::fs::write(root().join("examples/softening.pd"), &law).unwrap();
    }
    assert_eq!(law, read("examples/softening.pd"));
}

/// Every word of the grammar stands on the page.
#[test]
fn no_word_is_forgotten() {
    let page = read("docs/language.md");
    let grammar = read("pdlang/src/grammar.pest");
    let lines = grammar
        .lines()
        .filter(|line| !line.trim_start().starts_with("//"));
    let words = lines.flat_map(|line| line.split('"').skip(1).step_by(2));
    let words = words.filter(|word| word.len() > 1 && word.chars().all(|c| c.is_ascii_lowercase()));
    let mut count = 0;
    for word in words {
        let named = page
            .split(|c: char| !(c.is_alphanumeric() || c == '_'))
            .any(|found| found == word);
        assert!(named, "docs/language.md does not say `{word}`");
        count += 1;
    }
    assert!(count > 40);
}

#[test]
fn links_lead_somewhere() {
    for path in ["docs/language.md", "docs/tutorial.md"] {
        let page = read(path);
        // Code between backquotes alternates with text, and a fence is three of them.
        let prose: String = page.split('`').step_by(2).collect();
        for link in prose.split("](").skip(1) {
            let target = link.split(')').next().unwrap();
            assert!(
                root().join("docs").join(target).exists(),
                "{path} links to {target}"
            );
        }
    }
}
