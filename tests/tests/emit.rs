//! What `pdlang emit` prints: every stage of a law in `fixtures/emit`, and the pages in `docs/laws`.
//!
//! After a deliberate change, `UPDATE_EXPECT=1 cargo test -p pdlang-tests --test emit` writes them anew: read
//! the difference.

use pdlang::emit::{Stage, emit};
use pdlang_models::registry::CATALOGUE;
use std::fs;
use std::path::{Path, PathBuf};

fn compare(path: PathBuf, found: &str, wrong: &mut Vec<String>) {
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(&path, found).unwrap();
    } else if fs::read_to_string(&path).unwrap_or_default() != found {
        wrong.push(path.display().to_string());
    }
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).into()
}

#[test]
fn stages_of_the_journey() {
    let mut wrong = Vec::new();
    for (name, stages) in [
        ("pmb", Stage::ALL.as_slice()),
        ("lps", &[Stage::Ast, Stage::Ir, Stage::Passes]),
    ] {
        let entry = CATALOGUE.iter().find(|e| e.name == name).unwrap();
        for stage in stages {
            let found = emit(entry.text, *stage, Some(&entry.link())).unwrap();
            let file = format!("fixtures/emit/{name}.{}.txt", stage.name());
            compare(root().join(file), &found, &mut wrong);
        }
    }
    assert!(wrong.is_empty(), "changed: {}", wrong.join(", "));
}

#[test]
fn pages_of_the_catalogue_are_current() {
    let mut wrong = Vec::new();
    for entry in CATALOGUE {
        let page = emit(entry.text, Stage::Markdown, Some(&entry.link())).unwrap();
        let path = root()
            .join("../docs/laws")
            .join(entry.name)
            .with_extension("md");
        compare(path, &page, &mut wrong);
        let linked = root().join("../docs/laws").join(entry.link());
        assert!(linked.exists(), "{} is not there", linked.display());
    }
    assert!(wrong.is_empty(), "regenerate: {}", wrong.join(", "));
}
