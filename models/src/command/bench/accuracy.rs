//! `pdlang bench accuracy`: what is known beside what the program computes, as a table, as JSON or as a page.

use std::path::PathBuf;

use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use pdlang_models::accuracy::{Measure, STUDIES, Study, figure};
use serde_json::{Value, json};

use super::super::models::json_flag;
use super::super::run::{threads, threads_argument};
use super::super::table::Table;
use super::super::{Failure, Outcome, input_error};
use super::{curves, progress};

const COLUMNS: [&str; 6] = ["id", "quantity", "value", "reference", "tolerance", "pass"];

pub fn command() -> Command {
    Command::new("accuracy")
        .about("Compare with papers, exact solutions and independent computations")
        .arg(
            Arg::new("all")
                .long("all")
                .action(ArgAction::SetTrue)
                .help("The long studies too, which take minutes"),
        )
        .arg(
            Arg::new("only")
                .long("only")
                .value_name("ID")
                .num_args(1..)
                .conflicts_with("all")
                .help("These studies alone, long or not"),
        )
        .arg(
            Arg::new("markdown")
                .long("markdown")
                .action(ArgAction::SetTrue)
                .conflicts_with("json")
                .help("Print as a page; docs/accuracy.md is that of --all"),
        )
        .arg(
            Arg::new("plot")
                .long("plot")
                .value_name("FILE.svg")
                .value_parser(value_parser!(PathBuf))
                .help("Also draws the curves of the studies, as of paper-pml-3b-fit"),
        )
        .arg(threads_argument())
        .arg(json_flag())
        .after_help("One row that does not pass is exit code 1.")
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    threads(matches)?;
    let chosen = chosen(matches)?;
    let bar = progress(chosen.len());
    let mut found = Vec::new();
    for study in chosen {
        bar.set_message(study.id);
        let rows = rayon::scope(|_| (study.measure)());
        let rows = rows.map_err(|why| Failure::Run(format!("error: {}: {why}", study.id)))?;
        found.push((study, rows));
        bar.inc(1);
    }
    bar.finish_and_clear();
    if matches.get_flag("markdown") {
        print!("{}", page(&found));
    } else {
        table(&found, matches.get_flag("json")).print(matches.get_flag("json"));
    }
    if let Some(path) = matches.get_one::<PathBuf>("plot") {
        curves::draw(path, &found)
            .map_err(|why| Failure::plain(format!("cannot draw {}: {why}", path.display())))?;
    }
    let failed: Vec<&str> = found
        .iter()
        .filter(|(_, rows)| rows.iter().any(|row| !row.pass()))
        .map(|(study, _)| study.id)
        .collect();
    match failed.is_empty() {
        true => Ok(()),
        false => Err(Failure::plain(format!("off: {}", failed.join(", ")))),
    }
}

fn chosen(matches: &ArgMatches) -> Result<Vec<&'static Study>, Failure> {
    let studies = || STUDIES.iter().copied().flatten();
    let Some(only) = matches.get_many::<String>("only") else {
        let all = matches.get_flag("all");
        return Ok(studies().filter(|study| all || !study.long).collect());
    };
    let only: Vec<&String> = only.collect();
    if let Some(unknown) = only
        .iter()
        .find(|id| studies().all(|s| s.id != id.as_str()))
    {
        let mut known: Vec<&str> = studies().map(|study| study.id).collect();
        known.dedup();
        return Err(input_error(
            format!("there is no study `{unknown}`"),
            format!("choose from {}", known.join(", ")),
        ));
    }
    let asked = |study: &&Study| only.iter().any(|id| id.as_str() == study.id);
    Ok(studies().filter(asked).collect())
}

fn table(found: &[(&Study, Vec<Measure>)], json: bool) -> Table {
    let number = |value: f64| match json {
        true => json!(value),
        false => Value::String(figure(value)),
    };
    let mut table = Table::new(&COLUMNS);
    for (study, rows) in found {
        for row in rows {
            table.row(vec![
                json!(study.id),
                json!(row.quantity),
                number(row.value),
                number(row.reference),
                json!(row.tolerance.to_string()),
                json!(row.pass()),
            ]);
        }
    }
    table
}

/// `docs/accuracy.md`.
fn page(found: &[(&Study, Vec<Measure>)]) -> String {
    let mut text = String::from(
        "# How accurate it is\n\n\
         Written by `pdlang bench accuracy --all --markdown`. A test compares the quick studies with this page; `pdlang bench\n\
         accuracy` runs them alone, `--only ID` the named ones. Tolerances: a part of the reference in percent, an absolute\n\
         difference, a factor either way, or a bound. `examples/` has the scenes.\n",
    );
    let mut last = "";
    for (study, rows) in found {
        if study.id != last {
            text += &format!("\n## {}\n", study.id);
        }
        last = study.id;
        text += &format!("\n{}\n\n", study.about);
        text += "| quantity | value | reference | tolerance | |\n|---|---|---|---|---|\n";
        for row in rows {
            text += &format!(
                "| {} | {} | {} | {} | {} |\n",
                row.quantity,
                figure(row.value),
                figure(row.reference),
                row.tolerance,
                if row.pass() { "pass" } else { "off" },
            );
        }
    }
    text
}
