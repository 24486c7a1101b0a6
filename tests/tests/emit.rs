//! What `pdlang emit` prints: every stage of a law in `fixtures/emit`, and the pages in `docs/laws`.
//!
//! After a deliberate change, `UPDATE_EXPECT=1 cargo test -p pdlang-tests --test emit` writes them anew: read
//! the difference.

use pdlang::emit::{Stage, emit};
use pdlang_models::page::page;
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
    let docs = root().join("../docs/laws");
    for entry in CATALOGUE {
        let (link, picture) = (entry.link(), entry.picture());
        let made = page(
            entry.text,
            entry.name,
            Stage::Markdown,
            Some(&link),
            Some(&picture),
        );
        let made = made.unwrap_or_else(|found| panic!("{found:?}"));
        compare(
            docs.join(entry.name).with_extension("md"),
            &made.text,
            &mut wrong,
        );
        if let Some(drawn) = made.picture {
            compare(docs.join(picture), &drawn, &mut wrong);
        }
        assert!(docs.join(&link).exists(), "{link} is not there");
    }
    assert!(wrong.is_empty(), "regenerate: {}", wrong.join(", "));
}

/// The words of a page, without marks, formulas and line ends.
fn words(text: &str) -> String {
    let marks = ["`", "$", "#", "\\texttt{", "\\", "{", "}"];
    let bare = marks
        .iter()
        .fold(text.to_string(), |t, mark| t.replace(mark, " "));
    bare.split_whitespace().collect::<Vec<_>>().join(" ")
}

/// The forms of a page are of one model: headings and sentences are the same in all.
#[test]
fn forms_of_a_page_say_the_same() {
    for name in ["lps", "heat", "correspondence"] {
        let entry = CATALOGUE.iter().find(|e| e.name == name).unwrap();
        let of = |stage| words(&page(entry.text, name, stage, None, None).unwrap().text);
        let forms = [Stage::Terminal, Stage::Markdown, Stage::Latex].map(of);
        for part in [
            "Parameters",
            "Definitions",
            "The law as it is written",
            "Waves and moduli",
            "Related laws",
            &words(&entry.kernels_said()),
            "How it is computed",
            "Probes",
            "Its bonds",
            &words(&entry.law().unwrap().cites[0]),
        ] {
            for form in &forms {
                assert!(form.contains(part), "{name}: `{part}` is missing in {form}");
            }
        }
        assert_eq!(forms[0].contains("The tangent"), name != "heat");
        assert!(!forms[0].contains("frac"), "{}", forms[0]);
    }
}
