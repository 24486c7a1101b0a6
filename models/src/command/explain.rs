//! `pdlang explain`: how a law is computed, what that costs at a bond, and what a scene takes away from it.

use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use pdlang::assemble::Kinematics;
use pdlang::emit::{self, Request, Stage};
use pdlang_models::{files, registry};

use super::emit::{Text, read};
use super::{Failure, Outcome, color};

pub fn command() -> Command {
    Command::new("explain")
        .about("Say how a law is computed: its sums with their formulas, and what a bond costs")
        .arg(
            Arg::new("law")
                .value_name("LAW")
                .help("A law of the catalogue, or a .pd file")
                .required(true),
        )
        .arg(
            Arg::new("linearised")
                .long("linearised")
                .help("For small displacements")
                .action(ArgAction::SetTrue),
        )
        .arg(
            Arg::new("dim")
                .long("dim")
                .value_name("N")
                .help("Dimensions [default: the most that the law is for]")
                .value_parser(value_parser!(u8).range(1..=3)),
        )
        .after_help(
            "c0, g0: constants, and values of the reference bond. sum0 +=: at every bond. A prime: at the other end. \
             q0: a number that only the kernels name.",
        )
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    let law = matches.get_one::<String>("law").map_or("", String::as_str);
    let Text { text, path, .. } = read(law)?;
    let linearised = matches.get_flag("linearised");
    let request = Request {
        stage: Stage::Explained,
        kinematics: match linearised {
            true => Kinematics::Linearised,
            false => Kinematics::General,
        },
        dim: matches.get_one::<u8>("dim").map(|n| usize::from(*n)),
        link: None,
        more: &[],
    };
    let shown = emit::emit_in(&text, &path, &mut files::read, request);
    let shown = shown.map_err(|findings| {
        let shown: Vec<String> = findings
            .iter()
            .map(|d| d.render(&text, &path, color()))
            .collect();
        Failure::Input(shown.join("\n\n"))
    })?;
    print!("{shown}");
    if let Some(entry) = registry::find(law) {
        println!("\n{}", entry.kernels_said());
    }
    Ok(())
}
