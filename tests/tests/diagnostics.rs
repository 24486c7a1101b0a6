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

/// Words of the language, and a fixture that misuses each.
const MISUSED: [(&str, &str); 66] = [
    ("use", "uses"),
    ("known", "known"),
    ("model", "no_metadata"),
    ("cite", "no_equation"),
    ("for", "flavours"),
    ("influence", "influence_choice"),
    ("fn", "recursive_function"),
    ("param", "bounds"),
    ("field", "half_steps"),
    ("history", "responses"),
    ("update", "responses"),
    ("family", "families"),
    ("break", "breaking"),
    ("node", "components"),
    ("bond", "components"),
    ("meets", "meets"),
    ("where", "families"),
    ("when", "breaking"),
    ("after", "breaking"),
    ("on", "responses"),
    ("in", "probes"),
    ("and", "conditions"),
    ("or", "conditions"),
    ("not", "conditions"),
    ("case", "flavours"),
    ("probe", "probes"),
    ("expect", "probes"),
    ("within", "probes"),
    ("lattice", "probes"),
    ("let", "not_constant"),
    ("rate", "unit_of_rate"),
    ("flavour", "flavours"),
    ("energy", "unit_of_energy"),
    ("pair", "responses"),
    ("state", "unit_of_state"),
    ("sum", "reductions"),
    ("sum0", "weights"),
    ("mean", "reductions"),
    ("count", "reductions"),
    ("min", "reductions"),
    ("max", "reductions"),
    ("norm", "functions"),
    ("dot", "functions"),
    ("outer", "functions"),
    ("tr", "functions"),
    ("sym", "functions"),
    ("dev", "functions"),
    ("det", "functions"),
    ("inverse", "functions"),
    ("transpose", "functions"),
    ("sqrt", "functions"),
    ("abs", "functions"),
    ("exp", "unit_of_argument"),
    ("ln", "functions"),
    ("sin", "functions"),
    ("cos", "functions"),
    ("tan", "functions"),
    ("select", "conditions"),
    ("diag", "functions"),
    ("force", "node_force"),
    ("at", "half_steps"),
    ("half", "half_steps"),
    ("step", "node_force"),
    ("flow", "flow"),
    ("weight", "weights"),
    ("under", "under"),
];

/// Every word of the grammar, every response and built-in function, `flow` and `under` stands in a line that an error points at.
#[test]
fn every_construct_is_misused_somewhere() {
    let source = |path: &str| {
        read(
            &Path::new(env!("CARGO_MANIFEST_DIR"))
                .join("../pdlang/src")
                .join(path),
        )
    };
    let grammar = source("grammar.pest");
    let keywords = grammar
        .lines()
        .filter_map(|line| line.strip_prefix("kw_")?.split(' ').next());
    let names = source("resolve/names.rs");
    let built_in = names
        .lines()
        .filter(|line| line.contains("Builtin::") || line.contains("Reduction::"));
    let built_in = built_in.filter_map(|line| line.trim().strip_prefix("(\"")?.split('"').next());
    let responses = ["energy", "pair", "state", "force"];
    let others = ["flow", "under"];
    let mut missing = Vec::new();
    for word in keywords.chain(built_in).chain(responses).chain(others) {
        let Some((_, fixture)) = MISUSED.iter().find(|(misused, _)| *misused == word) else {
            missing.push(format!("`{word}` has no fixture"));
            continue;
        };
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/lang/fail");
        let shown = read(&folder.join(fixture).with_extension("txt"));
        // Lines of the text, as a message shows them: `12 | break when s`.
        let lines = shown
            .lines()
            .filter_map(|line| line.split_once(" | "))
            .filter(|(n, _)| n.trim().parse::<u32>().is_ok());
        let mut words =
            lines.flat_map(|(_, text)| text.split(|c: char| !c.is_alphanumeric() && c != '_'));
        if !words.any(|w| w == word) {
            missing.push(format!("no error of {fixture} is about `{word}`"));
        }
    }
    assert!(missing.is_empty(), "{}", missing.join("\n"));
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
