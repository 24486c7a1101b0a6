//! `pdlang models`: the catalogue, and one law's page.

use clap::{Arg, ArgAction, ArgMatches, Command};
use pdlang::emit::Stage;
use pdlang::ir::{self, Bound, Param, Response};
use serde_json::{Value, json};

use super::emit::shown;
use super::table::Table;
use super::{Failure, Outcome};
use crate::command::input_error;
use pdlang_models::page;
use pdlang_models::registry::{self, Entry};

pub fn command() -> Command {
    Command::new("models")
        .about("List the laws of the catalogue, or show one law's page")
        .arg(
            Arg::new("name")
                .value_name("NAME")
                .help("A law of the catalogue"),
        )
        .arg(json_flag())
}

/// `--json`, as every command has it that prints a table.
pub fn json_flag() -> Arg {
    Arg::new("json")
        .long("json")
        .action(ArgAction::SetTrue)
        .help("Print as JSON")
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    let as_json = matches.get_flag("json");
    match matches.get_one::<String>("name") {
        Some(name) => show(name, as_json),
        None => list(as_json),
    }
}

fn list(as_json: bool) -> Outcome {
    let mut table = Table::new(&[
        "law",
        "title",
        "parameters",
        "response",
        "can break",
        "source",
    ]);
    for entry in registry::CATALOGUE {
        let law = read(entry)?;
        let parameters: Vec<&str> = law.params.iter().map(|p| p.name.as_str()).collect();
        table.row(vec![
            law.name.as_str().into(),
            law.title.as_str().into(),
            parameters.join(", ").into(),
            response(&law).into(),
            (if law.breaks.is_empty() { "no" } else { "yes" }).into(),
            law.cites.join("; ").into(),
        ]);
    }
    table.print(as_json);
    Ok(())
}

fn read(entry: &Entry) -> Result<ir::Law, Failure> {
    entry
        .law()
        .map_err(|found| shown(&found, entry.text, entry.name))
}

fn response(law: &ir::Law) -> String {
    let word = |r: &Response| match r {
        Response::Energy(_) => "energy",
        Response::Pair(..) => "pair",
        Response::State(..) => "state",
        Response::Force(..) => "force",
        Response::Rate(..) => "rate",
    };
    law.responses
        .iter()
        .map(word)
        .collect::<Vec<_>>()
        .join(", ")
}

fn show(name: &str, as_json: bool) -> Outcome {
    let Some(entry) = registry::find(name) else {
        let names = registry::names().join(", ");
        return Err(input_error(
            format!("there is no law `{name}` in the catalogue"),
            format!("known laws: {names}"),
        ));
    };
    if as_json {
        println!("{:#}", page_json(&read(entry)?, entry));
        return Ok(());
    }
    let page = page::page(entry.text, name, Stage::Terminal, None, None);
    let page = page.map_err(|found| shown(&found, entry.text, name))?;
    print!("{}", page.text);
    Ok(())
}

fn page_json(law: &ir::Law, entry: &Entry) -> Value {
    json!({
        "law": law.name,
        "title": law.title,
        "cites": law.cites,
        "parameters": parameters(law).json(),
        "influences": influences(law).json(),
        "weights": weights(law).json(),
        "response": response(law),
        "can_break": !law.breaks.is_empty(),
        "flavours": flavours(law),
        "kernels": entry.kernels_said(),
        "text": entry.text,
    })
}

fn flavours(law: &ir::Law) -> Vec<&'static str> {
    law.flavours.iter().map(|flavour| flavour.name()).collect()
}

fn parameters(law: &ir::Law) -> Table {
    let mut table = Table::new(&["name", "unit", "bounds", "default", "description"]);
    for p in &law.params {
        let unit = if p.unit.is_number() {
            String::new()
        } else {
            p.unit.symbol()
        };
        let default = p
            .default
            .map_or_else(|| "required".into(), |v| v.to_string());
        table.row(vec![
            p.name.as_str().into(),
            unit.into(),
            bounds(p).into(),
            default.into(),
            p.doc.as_str().into(),
        ]);
    }
    table
}

fn bounds(param: &Param) -> String {
    let side = |bound: Option<Bound>, strict: &str, loose: &str| {
        bound.map(|b| format!("{} {}", if b.inclusive { loose } else { strict }, b.value))
    };
    let sides = [side(param.lower, ">", ">="), side(param.upper, "<", "<=")];
    sides.into_iter().flatten().collect::<Vec<_>>().join(", ")
}

fn influences(law: &ir::Law) -> Table {
    let mut table = Table::new(&["name", "default"]);
    for influence in &law.influences {
        let default = influence
            .default
            .as_ref()
            .map_or("required", |f| f.name.as_str());
        table.row(vec![influence.name.as_str().into(), default.into()]);
    }
    table
}

fn weights(law: &ir::Law) -> Table {
    let mut table = Table::new(&["name", "description"]);
    for weight in &law.weights {
        table.row(vec![
            weight.name.as_str().into(),
            weight.doc.as_str().into(),
        ]);
    }
    table
}
