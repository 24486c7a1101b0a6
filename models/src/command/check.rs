//! `pdlang check`: what is wrong with law files, with places.

use clap::{Arg, ArgMatches, Command};
use pdlang::diag::Diagnostic;
use pdlang::{codes, front, probe};
use pdlang_models::files;

use super::{Failure, Outcome, color, input_error};

pub fn command() -> Command {
    Command::new("check")
        .about("Check law files: names, shapes, units, bounds, metadata, and the values of their probes")
        .arg(
            Arg::new("files")
                .value_name("FILE.pd")
                .help("Law files to check")
                .required_unless_present("explain")
                .num_args(1..),
        )
        .arg(
            Arg::new("explain")
                .long("explain")
                .value_name("CODE")
                .conflicts_with("files")
                .help("Say what a code such as PD012 means, with examples"),
        )
        .after_help("All errors of all files are shown, each with its place and a remedy.")
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    if let Some(code) = matches.get_one::<String>("explain") {
        return explain(code);
    }
    let files: Vec<&String> = matches.get_many("files").into_iter().flatten().collect();
    let wrong = files.iter().filter(|file| !check(file)).count();
    match wrong {
        0 => Ok(()),
        n => Err(Failure::plain(format!(
            "{n} of {} files wrong",
            files.len()
        ))),
    }
}

fn explain(code: &str) -> Outcome {
    match codes::explanation(code) {
        Some(section) => {
            println!("{section}");
            Ok(())
        }
        None => {
            let known: Vec<&str> = codes::codes().collect();
            Err(input_error(
                format!("there is no code `{code}`"),
                format!("codes are {}", known.join(", ")),
            ))
        }
    }
}

/// Prints the findings of one file, or one line when it is correct.
fn check(path: &str) -> bool {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) => {
            eprintln!("error: cannot read `{path}`: {error}\n");
            return false;
        }
    };
    let checked = front::file_in(&text, path, &mut files::read);
    let probed = checked.laws.iter().flat_map(probe::findings);
    let findings: Vec<Diagnostic> = checked.diagnostics.iter().cloned().chain(probed).collect();
    for diagnostic in &findings {
        eprintln!("{}\n", diagnostic.render(&text, path, color()));
    }
    if findings.iter().any(Diagnostic::is_error) {
        return false;
    }
    println!("{path}: ok ({})", contents(&checked));
    true
}

/// `laws pmb, lps; influence functions softened`.
fn contents(checked: &front::Checked) -> String {
    let laws: Vec<&str> = checked.laws.iter().map(|l| l.name.as_str()).collect();
    let functions: Vec<&str> = checked.influences.iter().map(|f| f.name.as_str()).collect();
    let part = |word: &str, names: Vec<&str>| match names.len() {
        0 => None,
        1 => Some(format!("{word} {}", names[0])),
        _ => Some(format!("{word}s {}", names.join(", "))),
    };
    let parts = [part("law", laws), part("influence function", functions)];
    let parts: Vec<String> = parts.into_iter().flatten().collect();
    if parts.is_empty() {
        "empty".into()
    } else {
        parts.join("; ")
    }
}
