//! `pdlang emit`: a law at any stage of its journey, printed.

use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use pdlang::assemble::Kinematics;
use pdlang::diag::Diagnostic;
use pdlang::emit::{self, Request, Stage};
use pdlang_models::registry::Entry;
use pdlang_models::{files, page, registry};

use super::{Failure, Outcome, color, input_error};

pub fn command() -> Command {
    Command::new("emit")
        .about("Print a law at a stage of its journey from text to kernel, or as a page")
        .arg(
            Arg::new("law")
                .value_name("LAW")
                .help("A law of the catalogue, or a .pd file")
                .required(true),
        )
        .arg(
            Arg::new("stage")
                .long("stage")
                .help("What to print")
                .required(true)
                .value_parser(PossibleValuesParser::new(Stage::ALL.map(Stage::name))),
        )
        .arg(
            Arg::new("linearised")
                .long("linearised")
                .help("Passes and kernels for small displacements")
                .action(ArgAction::SetTrue),
        )
        .arg(
            Arg::new("dim")
                .long("dim")
                .value_name("N")
                .help("Dimensions of the passes and kernels [default: the most that the law is for]")
                .value_parser(value_parser!(u8).range(1..=3)),
        )
        .after_help(
            "ast: the tree as it was read. ir: after all checks. passes: what is summed when, as tapes. \
             rust: the kernels, as a macro writes them. latex, markdown: the page of the law.",
        )
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    let word = |id: &str| matches.get_one::<String>(id).map_or("", String::as_str);
    let (law, stage) = (word("law"), word("stage"));
    // The parser has refused every other word.
    let Some(stage) = Stage::ALL.into_iter().find(|s| s.name() == stage) else {
        return Ok(());
    };
    let Text { text, path, link } = read(law)?;
    let kinematics = match matches.get_flag("linearised") {
        true => Kinematics::Linearised,
        false => Kinematics::General,
    };
    let request = Request {
        stage,
        kinematics,
        dim: matches.get_one::<u8>("dim").map(|n| usize::from(*n)),
        link: Some(&link),
        more: &[],
    };
    let made = match stage {
        Stage::Latex | Stage::Markdown => {
            let picture = registry::find(&path).map(Entry::picture);
            page::page(&text, &path, stage, Some(&link), picture.as_deref()).map(|page| page.text)
        }
        _ => emit::emit_in(&text, &path, &mut files::read, request),
    };
    print!("{}", made.map_err(|found| shown(&found, &text, &path))?);
    Ok(())
}

/// Findings, each at its place.
pub fn shown(found: &[Diagnostic], text: &str, path: &str) -> Failure {
    let shown: Vec<String> = found
        .iter()
        .map(|d| d.render(text, path, color()))
        .collect();
    Failure::Input(shown.join("\n\n"))
}

/// The text of a law, what it is called in messages, and where a page in `docs/laws` finds it.
pub struct Text {
    pub text: String,
    pub path: String,
    link: String,
}

pub fn read(law: &str) -> Result<Text, Failure> {
    if let Some(entry) = registry::find(law) {
        return Ok(Text {
            text: entry.text.into(),
            path: law.into(),
            link: entry.link(),
        });
    }
    if !law.ends_with(".pd") {
        return Err(input_error(
            format!("there is no law `{law}` in the catalogue"),
            format!(
                "known laws: {}; or give a .pd file",
                registry::names().join(", ")
            ),
        ));
    }
    let text = std::fs::read_to_string(law)
        .map_err(|error| Failure::plain(format!("cannot read `{law}`: {error}")))?;
    Ok(Text {
        text,
        path: law.into(),
        link: law.into(),
    })
}
