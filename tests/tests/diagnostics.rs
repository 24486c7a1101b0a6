//! What the language accepts, what it refuses, and in which words: `fixtures/lang`.
//!
//! Each file of `fail` and `warn` has the rendered findings beside it. After a deliberate change of words,
//! `UPDATE_EXPECT=1 cargo test -p pdlang-tests --test diagnostics` writes them anew: read the difference.

use pdlang::front;
use pdlang::ir::Law;
use std::fs;
use std::path::{Path, PathBuf};

fn fixtures(folder: &str) -> Vec<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let entries =
        fs::read_dir(&folder).unwrap_or_else(|error| panic!("{}: {error}", folder.display()));
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.retain(|path| path.extension().is_some_and(|extension| extension == "pd"));
    files.sort();
    assert!(!files.is_empty(), "{}", folder.display());
    files
}

fn read(path: &Path) -> String {
    fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All findings of a file, as `pdlang check` prints them.
fn rendered(path: &Path) -> String {
    let text = read(path);
    let name = path.file_name().unwrap().to_string_lossy();
    let findings = front::file(&text).diagnostics;
    findings
        .iter()
        .map(|finding| finding.render(&text, &name, false) + "\n\n")
        .collect()
}

fn compare_with_expected(path: &Path, wrong: &mut Vec<String>) {
    let expected = path.with_extension("txt");
    let found = rendered(path);
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        fs::write(&expected, found).unwrap();
    } else if fs::read_to_string(&expected).unwrap_or_default() != found {
        wrong.push(format!("{}\n{found}", path.display()));
    }
}

#[test]
fn refused_texts_get_the_expected_messages() {
    let mut wrong = Vec::new();
    for path in fixtures("fixtures/lang/fail") {
        assert!(
            front::file(&read(&path)).has_errors(),
            "{} has no error",
            path.display()
        );
        compare_with_expected(&path, &mut wrong);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn doubtful_texts_get_warnings_and_a_law() {
    let mut wrong = Vec::new();
    for path in fixtures("fixtures/lang/warn") {
        let checked = front::file(&read(&path));
        assert!(
            !checked.has_errors() && !checked.laws.is_empty(),
            "{} has errors",
            path.display()
        );
        assert!(
            !checked.diagnostics.is_empty(),
            "{} has no warning",
            path.display()
        );
        compare_with_expected(&path, &mut wrong);
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn accepted_texts_have_no_findings() {
    for folder in ["fixtures/lang/pass", "fixtures/laws", "../models/laws"] {
        for path in fixtures(folder) {
            assert_eq!(rendered(&path), "", "{}", path.display());
            let checked = front::file(&read(&path));
            assert!(
                !checked.laws.is_empty() || !checked.influences.is_empty(),
                "{} is empty",
                path.display()
            );
        }
    }
}

/// Two ways to write the same law: Greek letters, primes and powers, and what survives as Rust tokens.
#[test]
fn spellings_make_no_difference() {
    let law = |name: &str| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("fixtures/lang/pass")
            .join(name);
        front::file(&read(&path)).laws.remove(0)
    };
    assert_eq!(
        formulas(&law("spelling_greek.pd")),
        formulas(&law("spelling_tokens.pd"))
    );
}

/// A law without its places in the text.
fn formulas(law: &Law) -> Vec<String> {
    let exprs = law.exprs.iter().map(|expr| {
        format!(
            "{:?} {:?} {:?} {:?}",
            expr.kind, expr.shape, expr.home, expr.unit
        )
    });
    let defs = law
        .defs
        .iter()
        .map(|def| format!("{} {:?} {:?}", def.name, def.home, def.expr));
    exprs
        .chain(defs)
        .chain([format!("{:?} {:?}", law.responses, law.name)])
        .collect()
}
