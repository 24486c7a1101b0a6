//! The command line: one file per command, exit codes as a contract.
//!
//! 0: done. 1: the input is wrong (a scene, a law, a file). 2: the command line is wrong. 3: the run went
//! unstable or could not go on. 130: the user stopped it.

mod bench;
mod check;
mod choices;
mod dispersion;
mod emit;
mod explain;
mod fmt;
mod forecast;
mod lsp;
mod models;
mod plan;
mod progress;
mod run;
mod statement;
mod table;
mod verify;

use std::io::{IsTerminal, stderr};
use std::process::ExitCode;

use clap::{ArgMatches, Command};

/// Why a command ends without its result.
#[derive(Debug)]
pub enum Failure {
    /// The scene, the law or a file is wrong: exit code 1. The text says what, where and what to do.
    Input(String),
    /// The run could not go on: exit code 3. The text says the step, the node, the reason and the last checkpoint.
    Run(String),
    /// The user stopped the run: exit code 130. The text says how to go on.
    Interrupted(String),
}

impl Failure {
    /// An input failure that has no place in a text.
    fn plain(message: impl std::fmt::Display) -> Failure {
        Failure::Input(format!("error: {message}"))
    }
}

/// An input failure without a place: what, and what to do.
fn input_error(what: impl std::fmt::Display, remedy: impl std::fmt::Display) -> Failure {
    Failure::Input(format!("error: {what}\n  = help: {remedy}"))
}

/// What shells report of a program that Ctrl-C ended: 128 and the number of the signal.
const INTERRUPTED: u8 = 130;

type Outcome = Result<(), Failure>;

pub fn main() -> ExitCode {
    let matches = cli().get_matches();
    match dispatch(&matches) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failure::Input(text)) => {
            eprintln!("{text}");
            ExitCode::from(1)
        }
        Err(Failure::Run(text)) => {
            eprintln!("{text}");
            ExitCode::from(3)
        }
        Err(Failure::Interrupted(text)) => {
            eprintln!("{text}");
            ExitCode::from(INTERRUPTED)
        }
    }
}

fn cli() -> Command {
    Command::new("pdlang")
        .version(env!("CARGO_PKG_VERSION"))
        .about("Peridynamic laws as pages of maths: check them, plan a scene, run it")
        .after_help(
            "Exit codes: 0 done; 1 the input is wrong; 2 the command line is wrong; 3 the run went unstable;\n\
             130 Ctrl-C.",
        )
        .subcommand_required(true)
        .arg_required_else_help(true)
        .disable_help_subcommand(true)
        .subcommand(run::command())
        .subcommand(plan::command())
        .subcommand(check::command())
        .subcommand(explain::command())
        .subcommand(verify::command())
        .subcommand(dispersion::command())
        .subcommand(models::command())
        .subcommand(emit::command())
        .subcommand(fmt::command())
        .subcommand(lsp::command())
        .subcommand(bench::command())
}

fn dispatch(matches: &ArgMatches) -> Outcome {
    match matches.subcommand() {
        Some(("run", m)) => run::execute(m),
        Some(("plan", m)) => plan::execute(m),
        Some(("check", m)) => check::execute(m),
        Some(("explain", m)) => explain::execute(m),
        Some(("verify", m)) => verify::execute(m),
        Some(("dispersion", m)) => dispersion::execute(m),
        Some(("models", m)) => models::execute(m),
        Some(("emit", m)) => emit::execute(m),
        Some(("fmt", m)) => fmt::execute(m),
        Some(("lsp", m)) => lsp::execute(m),
        Some(("bench", m)) => bench::execute(m),
        // The parser has refused everything else.
        _ => Ok(()),
    }
}

/// Whether messages on the error stream may be coloured.
fn color() -> bool {
    stderr().is_terminal() && std::env::var_os("NO_COLOR").is_none()
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_command_tree_is_consistent() {
        super::cli().debug_assert();
    }

    #[test]
    fn a_wrong_command_line_is_exit_code_two() {
        for line in [
            vec!["pdlang", "fly"],
            vec!["pdlang", "run"],
            vec!["pdlang", "run", "a.toml", "--threads", "x"],
        ] {
            let error = super::cli().try_get_matches_from(line).expect_err("wrong");
            assert_eq!(error.exit_code(), 2);
        }
    }
}
