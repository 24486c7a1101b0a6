//! The documents say what is there: their paths exist, their laws and scenes are accepted, their tables are whole.

use pdlang_models::language::Pdlang;
use pdlang_models::registry;
use pdlang_runtime::scene::Scene;
use std::path::{Path, PathBuf};

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

fn read(path: &str) -> String {
    std::fs::read_to_string(root().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// The code blocks of a kind.
fn blocks<'a>(text: &'a str, kind: &str) -> Vec<&'a str> {
    let start = format!("```{kind}\n");
    text.split(&start)
        .skip(1)
        .filter_map(|rest| rest.split("```").next())
        .collect()
}

/// What stands between `open` and `close` on one line.
fn between<'a>(text: &'a str, open: &str, close: &str) -> Vec<&'a str> {
    let inner = |line: &'a str| -> Vec<&'a str> {
        let parts = line.split(open).skip(1);
        parts
            .filter_map(|p| p.split_once(close))
            .map(|(inner, _)| inner)
            .collect()
    };
    text.lines().flat_map(inner).collect()
}

#[test]
fn links_lead_somewhere() {
    for document in ["README.md", "ARCHITECTURE.md"] {
        let text = read(document);
        for target in between(&text, "](", ")") {
            assert!(root().join(target).exists(), "{document} links to {target}");
        }
    }
}

#[test]
fn paths_of_the_architecture_exist() {
    let text = read("ARCHITECTURE.md");
    let rooms = [
        "pdlang/",
        "macros/",
        "runtime/",
        "models/",
        "tests/",
        "examples/",
        ".ci/",
    ];
    // Code between backquotes alternates with text.
    let spans = text
        .lines()
        .flat_map(|line| line.split('`').skip(1).step_by(2));
    let paths: Vec<&str> = spans
        .filter(|s| rooms.iter().any(|room| s.starts_with(room)))
        .collect();
    assert!(paths.len() > 20, "the paths were not found");
    for path in paths {
        assert!(root().join(path).exists(), "ARCHITECTURE.md names {path}");
    }
}

#[test]
fn laws_in_documents_are_without_findings() {
    for document in ["README.md", "ARCHITECTURE.md"] {
        let text = read(document);
        let laws = blocks(&text, "pd");
        assert!(!laws.is_empty());
        for law in laws {
            let findings = pdlang::front::file(law).diagnostics;
            let shown: Vec<String> = findings
                .iter()
                .map(|d| d.render(law, document, false))
                .collect();
            assert!(findings.is_empty(), "{}", shown.join("\n"));
        }
    }
}

#[test]
fn the_readme_shows_files_as_they_are() {
    let readme = read("README.md");
    let law = blocks(&readme, "pd")[0];
    // Without its probes.
    let shown = law.trim_end().trim_end_matches('}');
    assert!(read("models/laws/gpmb.pd").contains(shown));
    assert_eq!(
        blocks(&readme, "toml"),
        [read("examples/cracked-plate.toml")]
    );
    // The inline law is that of the example, which is indented by its macro as well.
    let inline = blocks(&readme, "rust")[0];
    let example = read("examples/law-in-rust/main.rs");
    for line in inline.lines().filter(|line| line.starts_with("    ")) {
        assert!(example.contains(line), "the example lacks: {line}");
    }
}

#[test]
fn the_readme_lists_every_law() {
    let readme = read("README.md");
    for name in registry::names() {
        assert!(
            readme.contains(&format!("| `{name}` |")),
            "README.md does not list {name}"
        );
    }
}

#[test]
fn scenes_of_the_examples_are_accepted() {
    let folder = root().join("examples");
    let entries = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let scenes: Vec<PathBuf> = entries
        .filter(|p| p.extension().is_some_and(|e| e == "toml"))
        .collect();
    assert!(scenes.len() >= 2);
    for scene in scenes {
        // What does not fit the body is found when that is made.
        let made = Scene::read(&scene, &Pdlang).and_then(|scene| scene.simulation());
        if let Err(problems) = made {
            panic!("{}", problems.render(false));
        }
    }
}
