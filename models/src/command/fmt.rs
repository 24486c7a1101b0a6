//! `pdlang fmt`: law files in canonical form.

use clap::{Arg, ArgAction, ArgMatches, Command};
use pdlang::fmt;

use super::{Failure, Outcome, color};

pub fn command() -> Command {
    Command::new("fmt")
        .about(
            "Write law files in canonical form: one item per line, columns aligned, comments kept",
        )
        .arg(
            Arg::new("files")
                .value_name("FILE.pd")
                .help("Law files to format")
                .required(true)
                .num_args(1..),
        )
        .arg(
            Arg::new("check")
                .long("check")
                .action(ArgAction::SetTrue)
                .help("Write nothing; fail when a file is not in canonical form"),
        )
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    let files: Vec<&String> = matches.get_many("files").into_iter().flatten().collect();
    let only_check = matches.get_flag("check");
    let wrong = files
        .iter()
        .filter(|file| !format(file, only_check))
        .count();
    match wrong {
        0 => Ok(()),
        n => Err(Failure::plain(format!(
            "{n} of {} files wrong",
            files.len()
        ))),
    }
}

/// Whether a file is in canonical form now.
fn format(path: &str, only_check: bool) -> bool {
    let text = match std::fs::read_to_string(path) {
        Ok(text) => text,
        Err(error) => {
            eprintln!("error: cannot read `{path}`: {error}\n");
            return false;
        }
    };
    let formatted = match fmt::format(&text) {
        Ok(formatted) => formatted,
        Err(findings) => {
            for finding in findings {
                eprintln!("{}\n", finding.render(&text, path, color()));
            }
            return false;
        }
    };
    if formatted == text {
        return true;
    }
    if only_check {
        eprintln!("error: `{path}` is not in canonical form\n  = help: `pdlang fmt {path}`\n");
        return false;
    }
    match std::fs::write(path, formatted) {
        Ok(()) => {
            println!("{path}: formatted");
            true
        }
        Err(error) => {
            eprintln!("error: cannot write `{path}`: {error}\n");
            false
        }
    }
}
