//! `pdlang verify`: the physics of a law, before any simulation.

use clap::{Arg, ArgMatches, Command};
use pdlang::ir::Law;
use pdlang_models::verify::{self, Level, Options, Place, Verdict};
use serde_json::{Value, json};

use super::models::json_flag;
use super::table::Table;
use super::{Failure, Outcome, choices, input_error};

pub fn command() -> Command {
    Command::new("verify")
        .about("Check the physics of a law: balance, derivatives, constants, waves, limits, rates and probes")
        .arg(choices::law_arg())
        .arg(choices::param_arg())
        .arg(
            Arg::new("horizon")
                .long("horizon")
                .value_name("LENGTH")
                .help("The horizon, in m or with its unit [default: 1.5 mm]"),
        )
        .arg(choices::influence_arg())
        .arg(json_flag())
        .after_help(
            "pass: as it should be. skip: what it is about does not exist in the law. warn: worth a look, or known to the\n\
             law. fail: wrong; the sentence names the definition. One fail is exit code 1.",
        )
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    let name = matches.get_one::<String>("law").map_or("", String::as_str);
    let (laws, text) = choices::laws(name)?;
    let mut failed = 0;
    let mut pages = Vec::new();
    for law in &laws {
        let options = options(matches, law)?;
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
            let laws: Vec<&str> = laws.iter().map(|law| law.name.as_str()).collect();
            Err(Failure::plain(format!(
                "{}: {n} findings fail",
                laws.join(", ")
            )))
        }
    }
}

fn options(matches: &ArgMatches, law: &Law) -> Result<Options, Failure> {
    let mut options = Options::default();
    for chosen in choices::params(matches)? {
        let values = chosen.of(law)?;
        let [value] = values[..] else {
            return Err(input_error(
                format!("`{}` has {} values", chosen.name, values.len()),
                "a law is verified at one value of each parameter",
            ));
        };
        options.params.push((chosen.name, value));
    }
    if let Some(text) = matches.get_one::<String>("horizon") {
        options.horizon = choices::length(text, "horizon")?;
    }
    if let Some(text) = matches.get_one::<String>("influence") {
        options.influence = Some(choices::influence(text)?);
    }
    Ok(options)
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
