//! `pdlang models`: the catalogue, and one law's page.

use clap::{Arg, ArgAction, ArgMatches, Command};
use pdlang::ir::{self, Bound, Param, Response};
use serde_json::{Value, json};

use super::table::Table;
use super::{Failure, Outcome};
use crate::command::input_error;
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
        Some(name) => page(name, as_json),
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
    entry.law().map_err(|diagnostics| {
        let shown: Vec<String> = diagnostics
            .iter()
            .map(|d| d.render(entry.text, entry.name, false))
            .collect();
        Failure::Input(shown.join("\n\n"))
    })
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

fn page(name: &str, as_json: bool) -> Outcome {
    let Some(entry) = registry::find(name) else {
        let names = registry::names().join(", ");
        return Err(input_error(
            format!("there is no law `{name}` in the catalogue"),
            format!("known laws: {names}"),
        ));
    };
    let law = read(entry)?;
    if as_json {
        println!("{:#}", page_json(&law, entry));
    } else {
        print!("{}", page_text(&law, entry));
    }
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
        "text": entry.text,
    })
}

fn page_text(law: &ir::Law, entry: &Entry) -> String {
    let mut text = format!("{}: {}\n", law.name, law.title);
    for cite in &law.cites {
        text.push_str(&format!("  {cite}\n"));
    }
    let flavours = flavours(law).join(", ");
    text.push_str(&format!(
        "\nFlavours: {flavours}\nResponse: {}\n",
        response(law)
    ));
    let breaks = if law.breaks.is_empty() {
        "cannot break"
    } else {
        "can break"
    };
    text.push_str(&format!("Bonds:    {breaks}\n"));
    for (heading, table) in [
        ("Parameters", parameters(law)),
        ("Influence", influences(law)),
    ] {
        text.push_str(&format!("\n{heading}\n{}", indented(&table.text())));
    }
    if !law.weights.is_empty() {
        text.push_str(&format!(
            "\nWeights, which a scene may set to 1\n{}",
            indented(&weights(law).text())
        ));
    }
    let constants = constants(law);
    if !constants.is_empty() {
        text.push_str(&format!("\nConstants: {}\n", constants.join(", ")));
    }
    text.push_str(&format!("\nText\n{}", indented(entry.text)));
    text
}

fn flavours(law: &ir::Law) -> Vec<&'static str> {
    law.flavours.iter().map(|flavour| flavour.name()).collect()
}

fn indented(text: &str) -> String {
    text.lines()
        .map(|l| format!("  {l}\n").replace("  \n", "\n"))
        .collect()
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

/// Names of the constants that the law computes.
fn constants(law: &ir::Law) -> Vec<&str> {
    let constant = |d: &&ir::Def| d.home == ir::Home::Constant && !d.span.prelude;
    law.defs
        .iter()
        .filter(constant)
        .map(|d| d.name.as_str())
        .collect()
}
