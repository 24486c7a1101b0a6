//! `pdlang verify`: the physics of a law, before any simulation.

use clap::{Arg, ArgAction, ArgMatches, Command};
use pdlang::{front, quantity};
use pdlang_models::files;
use pdlang_models::verify::{self, Level, Options, Place, Verdict};
use serde_json::{Value, json};

use super::emit::{self, Text};
use super::models::json_flag;
use super::table::Table;
use super::{Failure, Outcome, color, input_error};

pub fn command() -> Command {
    Command::new("verify")
        .about("Check the physics of a law: balance, derivatives, constants, waves, limits, rates and probes")
        .arg(
            Arg::new("law")
                .value_name("LAW")
                .help("A law of the catalogue, or a .pd file")
                .required(true),
        )
        .arg(
            Arg::new("param")
                .long("param")
                .value_name("NAME=VALUE")
                .help("A parameter, in SI or with its unit: K=3e9, \"E = 70 GPa\"")
                .action(ArgAction::Append),
        )
        .arg(
            Arg::new("horizon")
                .long("horizon")
                .value_name("LENGTH")
                .help("The horizon, in m or with its unit [default: 1.5 mm]"),
        )
        .arg(
            Arg::new("influence")
                .long("influence")
                .value_name("FUNCTION")
                .help("The influence function, as a scene names it [default: that of the law]"),
        )
        .arg(json_flag())
        .after_help(
            "pass: as it should be. skip: what it is about does not exist in the law. warn: worth a look, or known to the\n\
             law. fail: wrong; the sentence names the definition. One fail is exit code 1.",
        )
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    let name = matches.get_one::<String>("law").map_or("", String::as_str);
    let Text { text, path, .. } = emit::read(name)?;
    let options = options(matches)?;
    let checked = front::file_in(&text, &path, &mut files::read);
    if checked.has_errors() {
        let shown: Vec<String> = checked
            .diagnostics
            .iter()
            .map(|d| d.render(&text, &path, color()))
            .collect();
        return Err(Failure::Input(shown.join("\n\n")));
    }
    if checked.laws.is_empty() {
        return Err(input_error(
            format!("`{path}` holds no law"),
            "a law begins with `model`",
        ));
    }
    let mut failed = 0;
    let mut pages = Vec::new();
    for law in &checked.laws {
        let verdicts = verify::verify(law, &text, &options).map_err(Failure::plain)?;
        failed += verdicts.iter().filter(|v| v.level == Level::Fail).count();
        match matches.get_flag("json") {
            true => pages.push(page(&law.name, &verdicts)),
            false => print!("{}", shown(&law.name, &verdicts)),
        }
    }
    if matches.get_flag("json") {
        println!("{:#}", Value::Array(pages));
    }
    match failed {
        0 => Ok(()),
        n => {
            let laws: Vec<&str> = checked.laws.iter().map(|law| law.name.as_str()).collect();
            Err(Failure::plain(format!(
                "{}: {n} findings fail",
                laws.join(", ")
            )))
        }
    }
}

fn options(matches: &ArgMatches) -> Result<Options, Failure> {
    let mut options = Options::default();
    for given in matches.get_many::<String>("param").into_iter().flatten() {
        let Some((name, value)) = given.split_once('=') else {
            return Err(input_error(
                format!("`--param {given}` sets nothing"),
                "give a name and a value: --param K=3e9",
            ));
        };
        options.params.push((name.trim().into(), number(value)?));
    }
    if let Some(text) = matches.get_one::<String>("horizon") {
        options.horizon = number(text)?;
        if !(1e-12..=1e9).contains(&options.horizon) {
            return Err(input_error(
                format!("the horizon is {text}"),
                "it is a length above 0, between 1e-12 and 1e9 m",
            ));
        }
    }
    if let Some(text) = matches.get_one::<String>("influence") {
        let found = front::influence_call(text, &[]);
        let shown = |found: Vec<pdlang::diag::Diagnostic>| {
            let shown: Vec<String> = found
                .iter()
                .map(|d| d.render(text, "--influence", color()))
                .collect();
            Failure::Input(shown.join("\n\n"))
        };
        options.influence = Some(found.map_err(shown)?);
    }
    Ok(options)
}

/// A number in SI units, with a unit or without.
fn number(text: &str) -> Result<f64, Failure> {
    match quantity::parse(text.trim()) {
        Ok(quantity) => Ok(quantity.value),
        Err(_) => Err(input_error(
            format!("`{}` is no number", text.trim()),
            "write it as 3e9, or with a unit: \"3 GPa\"",
        )),
    }
}

fn page(law: &str, verdicts: &[Verdict]) -> Value {
    let one = |v: &Verdict| {
        json!({
            "check": v.check,
            "flavour": v.flavour.map(|f| f.name()),
            "quantity": v.quantity,
            "level": v.level.word(),
            "measured": v.measured.filter(|m| m.is_finite()),
            "expected": v.expected,
            "sentence": v.sentence,
            "definition": v.place.as_ref().map(|p| p.name.as_str()),
            "line": v.place.as_ref().map(|p| p.line),
            "column": v.place.as_ref().map(|p| p.column),
        })
    };
    json!({ "law": law, "verdicts": verdicts.iter().map(one).collect::<Vec<_>>() })
}

/// The table: a row for all flavours with the same sentence, and below it what fails or warns.
fn shown(law: &str, verdicts: &[Verdict]) -> String {
    let mut table = Table::new(&[
        "check", "result", "flavours", "measured", "expected", "what",
    ]);
    let mut rest: Vec<&Verdict> = verdicts.iter().collect();
    let count = |level: Level| verdicts.iter().filter(|v| v.level == level).count();
    while let Some(first) = rest.first().copied() {
        let alike =
            |v: &&Verdict| v.check == first.check && v.level == first.level && same(first, v);
        let (group, others): (Vec<&Verdict>, Vec<&Verdict>) = rest.iter().partition(|v| alike(v));
        rest = others;
        let mut flavours: Vec<&str> = Vec::new();
        for flavour in group.iter().filter_map(|v| v.flavour) {
            if !flavours.contains(&flavour.name()) {
                flavours.push(flavour.name());
            }
        }
        let worst = group
            .iter()
            .copied()
            .reduce(|a, b| if off(b) > off(a) { b } else { a });
        let value = |v: Option<f64>| v.map_or(String::new(), |v| format!("{v:.4e}"));
        let pick = |of: fn(&Verdict) -> Option<f64>| value(worst.and_then(of));
        let what = match (first.level, group.len()) {
            (Level::Pass, n) if n > 1 && first.sentence.is_empty() => pdlang::known::CHECKS
                .iter()
                .find(|(name, _)| *name == first.check)
                .map_or(String::new(), |(_, what)| what.to_string()),
            (Level::Pass, _) if first.sentence.is_empty() => first.quantity.clone(),
            _ => first.sentence.clone(),
        };
        table.row(vec![
            first.check.into(),
            first.level.word().into(),
            flavours.join(", ").into(),
            pick(|v| v.measured).into(),
            pick(|v| v.expected).into(),
            what.into(),
        ]);
    }
    format!(
        "{law}: {} pass, {} warn, {} fail, {} skip\n{}\n",
        count(Level::Pass),
        count(Level::Warn),
        count(Level::Fail),
        count(Level::Skip),
        table.text()
    )
}

/// Passes of a check are one row, whatever they measured; others where they say the same of the same definition.
fn same(a: &Verdict, b: &Verdict) -> bool {
    let place = |v: &Verdict| v.place.as_ref().map(|p: &Place| (p.line, p.column));
    // Behind the figures of a constant stands what mends it.
    let advice = |v: &Verdict| match v.check {
        "constants" => v
            .sentence
            .split_once(": ")
            .map(|(_, advice)| advice.to_string()),
        _ => None,
    };
    match a.level {
        Level::Pass => true,
        Level::Skip => a.sentence == b.sentence,
        _ => place(a) == place(b) && a.quantity == b.quantity && advice(a) == advice(b),
    }
}

fn off(v: &Verdict) -> f64 {
    match (v.measured, v.expected) {
        (Some(m), Some(e)) if e != 0.0 => (m / e).abs(),
        (Some(m), _) => m.abs(),
        _ => 0.0,
    }
}
