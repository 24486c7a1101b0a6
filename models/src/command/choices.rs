//! What commands let a user choose of a law: its parameters, its influence function, lengths. One way of reading it.

use clap::{Arg, ArgAction, ArgMatches};
use pdlang::front;
use pdlang::ir::{InfluenceFn, Law};
use pdlang::quantity::{self, Quantity};
use pdlang_models::files;

use super::emit::{self, Text};
use super::{Failure, input_error};

/// The laws of the catalogue or of a file, and their text.
pub fn laws(name: &str) -> Result<(Vec<Law>, String), Failure> {
    let Text { text, path, .. } = emit::read(name)?;
    let checked = front::file_in(&text, &path, &mut files::read);
    if checked.has_errors() {
        return Err(emit::shown(&checked.diagnostics, &text, &path));
    }
    if checked.laws.is_empty() {
        return Err(input_error(
            format!("`{path}` holds no law"),
            "a law begins with `model`",
        ));
    }
    Ok((checked.laws, text))
}

pub fn law_arg() -> Arg {
    Arg::new("law")
        .value_name("LAW")
        .help("A law of the catalogue, or a .pd file")
        .required(true)
}

pub fn param_arg() -> Arg {
    Arg::new("param")
        .long("param")
        .value_name("NAME=VALUE")
        .help("A parameter, in SI or with its unit: K=3e9, \"E = 70 GPa\"")
        .action(ArgAction::Append)
}

pub fn influence_arg() -> Arg {
    Arg::new("influence")
        .long("influence")
        .value_name("FUNCTION")
        .help("The influence function, as a scene names it [default: that of the law]")
}

/// A parameter and the values that were given for it.
pub struct Chosen {
    pub name: String,
    pub values: Vec<Quantity>,
}

impl Chosen {
    /// SI values, where they have the unit of the law's parameter or none.
    pub fn of(&self, law: &Law) -> Result<Vec<f64>, Failure> {
        let param = law.params.iter().find(|p| p.name == self.name);
        let value = |q: &Quantity| match param {
            Some(p) if q.has_unit && !q.fits(&p.unit) => Err(input_error(
                format!("{} has another unit than {}", self.name, q.unit.symbol()),
                format!("`{}` of `{}` is in {}", p.name, law.name, unit_name(p)),
            )),
            _ => Ok(q.value),
        };
        self.values.iter().map(value).collect()
    }
}

fn unit_name(param: &pdlang::ir::Param) -> String {
    match param.unit.symbol() {
        symbol if symbol.is_empty() => "no unit: it is a number".into(),
        symbol => symbol,
    }
}

/// The parameters, each with one value or several after commas.
pub fn params(matches: &ArgMatches) -> Result<Vec<Chosen>, Failure> {
    let mut chosen = Vec::new();
    for given in matches.get_many::<String>("param").into_iter().flatten() {
        let Some((name, values)) = given.split_once('=') else {
            return Err(input_error(
                format!("`--param {given}` sets nothing"),
                "give a name and a value: --param K=3e9",
            ));
        };
        let values: Result<_, Failure> = values.split(',').map(read).collect();
        chosen.push(Chosen {
            name: name.trim().into(),
            values: values?,
        });
    }
    Ok(chosen)
}

/// An influence function as a scene names it.
pub fn influence(text: &str) -> Result<(InfluenceFn, Vec<f64>), Failure> {
    front::influence_call(text, &[]).map_err(|found| emit::shown(&found, text, "--influence"))
}

/// A length above 0, in SI or with its unit [m].
pub fn length(text: &str, what: &str) -> Result<f64, Failure> {
    read(text)?;
    of_kind(text, "m")
        .filter(|v| (1e-12..=1e9).contains(v))
        .ok_or_else(|| {
            input_error(
                format!("the {what} is {text}"),
                "it is a length above 0, between 1e-12 and 1e9 m",
            )
        })
}

fn read(text: &str) -> Result<Quantity, Failure> {
    quantity::parse(text.trim()).map_err(|_| {
        input_error(
            format!("`{}` is no number", text.trim()),
            "write it as 3e9, or with a unit: \"3 GPa\"",
        )
    })
}

/// A density above 0 [kg/m^3].
pub fn density(text: &str) -> Result<f64, Failure> {
    of_kind(text, "kg/m^3")
        .filter(|v| (1e-12..=1e12).contains(v))
        .ok_or_else(|| {
            input_error(
                format!("the density is {text}"),
                "it is a number above 0, in kg/m^3 or with its unit: 1e-12 to 1e12 kg/m^3",
            )
        })
}

/// An angle [rad].
pub fn angle(text: &str) -> Result<f64, Failure> {
    of_kind(text, "rad")
        .filter(|v| v.is_finite())
        .ok_or_else(|| {
            input_error(
                format!("the angle is `{}`", text.trim()),
                "write it with its unit: \"30 deg\" or \"0.5 rad\"",
            )
        })
}

/// A number without a unit, or with one of the kind of `unit`.
fn of_kind(text: &str, unit: &str) -> Option<f64> {
    let quantity = quantity::parse(text.trim()).ok()?;
    let unit = quantity::parse(&format!("1 {unit}")).ok()?.unit;
    (!quantity.has_unit || quantity.unit == unit).then_some(quantity.value)
}
