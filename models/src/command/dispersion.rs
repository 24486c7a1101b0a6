//! `pdlang dispersion`: the waves of a law on its lattice, against its continuum and the local wave equation.

mod report;

use clap::builder::PossibleValuesParser;
use clap::{Arg, ArgAction, ArgMatches, Command, value_parser};
use pdlang::ir::{Flavour, InfluenceFn, Law};
use pdlang_models::verify::{Options, Subject};
use pdlang_models::waves::plot::{self, Curve, Series};
use pdlang_models::waves::{self, Request};
use serde_json::Value;
use std::path::Path;

use super::choices::{self, Chosen};
use super::models::json_flag;
use super::{Failure, Outcome, input_error};
use report::{Shown, page, text_of};

/// Combinations of what is listed, at most.
const MOST_SERIES: usize = 36;

pub fn command() -> Command {
    let several = |arg: Arg, help: &'static str| arg.help(help).action(ArgAction::Append);
    Command::new("dispersion")
        .about("Show the waves of a law: frequencies on its lattice, in its continuum, and of the local wave equation")
        .arg(choices::law_arg().num_args(1..))
        .arg(choices::param_arg().help(
            "A parameter, in SI or with its unit: K=3e9, \"E = 70 GPa\"; several values after commas: Gs=0,0.5,1",
        ))
        .arg(several(
            choices::influence_arg(),
            "The influence function, as a scene names it; may be repeated [default: that of the law]",
        ))
        .arg(
            Arg::new("flavour")
                .long("flavour")
                .value_parser(PossibleValuesParser::new(Flavour::ALL.map(Flavour::name)))
                .help("What the body is [default: the most dimensions that the law is for]"),
        )
        .arg(
            Arg::new("dim")
                .long("dim")
                .value_name("N")
                .conflicts_with("flavour")
                .value_parser(value_parser!(u8).range(1..=3))
                .help("Dimensions: the law's first flavour of so many"),
        )
        .arg(
            Arg::new("horizon")
                .long("horizon")
                .value_name("M[,M..]")
                .allow_hyphen_values(true)
                .default_value("3")
                .help("The horizon in spacings; several after commas"),
        )
        .arg(
            Arg::new("spacing")
                .long("spacing")
                .allow_hyphen_values(true)
                .value_name("LENGTH")
                .default_value("0.5 mm")
                .help("The lattice constant dx, in m or with its unit"),
        )
        .arg(
            Arg::new("density")
                .long("density")
                .value_name("DENSITY")
                .allow_hyphen_values(true)
                .help("Mass density, in kg/m^3 or with its unit [default: that of the law, else 2200]"),
        )
        .arg(
            Arg::new("direction")
                .long("direction")
                .value_name("X,Y,Z|ANGLE")
                .allow_hyphen_values(true)
                .default_value("1")
                .help("Along what the waves run: components, or in two dimensions the angle from the x axis, \"30 deg\""),
        )
        .arg(
            Arg::new("constants")
                .long("constants")
                .value_parser(["integral", "lattice"])
                .default_value("integral")
                .help("What `ball(..)` is: the integral over the horizon, or the sum over a full family"),
        )
        .arg(
            Arg::new("partial-volume")
                .long("partial-volume")
                .action(ArgAction::SetTrue)
                .help("A bond that the horizon cuts counts with the part inside"),
        )
        .arg(
            Arg::new("points")
                .long("points")
                .value_name("N")
                .default_value("12")
                .value_parser(value_parser!(u32).range(1..=100_000))
                .help("Wave numbers up to the edge of the Brillouin zone"),
        )
        .arg(
            Arg::new("curves")
                .long("curves")
                .value_name("WHICH")
                .value_delimiter(',')
                .value_parser(PossibleValuesParser::new(Curve::ALL.map(Curve::name)))
                .help("What is drawn [default: all of one series, lattice and local of several]"),
        )
        .arg(
            Arg::new("plot")
                .long("plot")
                .value_name("FILE.svg|FILE.png")
                .help("Draws the curves, a panel for each horizon"),
        )
        .arg(json_flag())
        .after_help(
            "With several laws, values, influence functions or horizons there is a series for each combination.\n\
             L: the branch that moves along long waves; T: across. Modes without energy, but for translations, are listed:\n\
             no force acts on them. Frequencies are in rad/s; for a law without force, heat for instance, rates of decay in 1/s.",
        )
}

pub fn execute(matches: &ArgMatches) -> Outcome {
    let word = |id: &str| matches.get_one::<String>(id).map_or("", String::as_str);
    let file = matches.get_one::<String>("plot").map(Path::new);
    let format = file.map(plot::format).transpose().map_err(|ending| {
        input_error(
            format!("a plot cannot be {ending}"),
            "give the file the ending .svg or .png",
        )
    })?;
    let mut laws = Vec::new();
    for name in matches.get_many::<String>("law").into_iter().flatten() {
        let (found, text) = choices::laws(name)?;
        laws.extend(found.into_iter().map(|law| (law, text.clone())));
    }
    let params = choices::params(matches)?;
    let influences = influences(matches)?;
    let horizons = horizons(word("horizon"))?;
    let spacing = choices::length(word("spacing"), "spacing")?;
    let points = *matches.get_one::<u32>("points").unwrap_or(&1);

    let mut cases = Vec::new();
    for (law, text) in &laws {
        for horizon in &horizons {
            for influence in &influences {
                for values in combinations(&params, law)? {
                    cases.push((law, text, *horizon, influence, values));
                }
            }
        }
    }
    if cases.len() > MOST_SERIES {
        return Err(input_error(
            format!("{} series are asked for", cases.len()),
            format!(
                "no more than {MOST_SERIES}: list fewer values, influence functions or horizons"
            ),
        ));
    }
    let mut series = Vec::new();
    for (law, text, reach, influence, values) in cases {
        let flavour = flavour(matches, law)?;
        let mut options = Options {
            params: values,
            influence: influence.as_ref().map(|(_, chosen)| chosen.clone()),
            horizon: spacing * reach,
            reach,
            lattice_constants: word("constants") == "lattice",
            partial_volume: matches.get_flag("partial-volume"),
            ..Options::default()
        };
        if let Some(given) = matches.get_one::<String>("density") {
            set_density(&mut options, law, choices::density(given)?);
        }
        let request = Request {
            flavour,
            direction: direction(word("direction"), flavour)?,
            points: points as usize,
        };
        let subject = Subject::new(law, text, &options).map_err(Failure::plain)?;
        let study = waves::study(&subject, &request)
            .map_err(|error| Failure::plain(format!("{}: {error}", law.name)))?;
        let several = |list: usize, words: String| (list > 1).then_some(words);
        let mut label: Vec<String> = Vec::new();
        label.extend(several(laws.len(), law.name.clone()));
        for (chosen, (name, value)) in params.iter().zip(&options.params) {
            label.extend(several(chosen.values.len(), format!("{name} = {value}")));
        }
        if let Some((written, _)) = influence {
            label.extend(several(influences.len(), written.clone()));
        }
        let shown = Shown {
            law: law.name.clone(),
            params: law
                .params
                .iter()
                .map(|p| p.name.clone())
                .zip(subject.params.clone())
                .collect(),
            given: options.params.clone(),
            influences: subject
                .influences
                .iter()
                .map(|(f, _)| f.name.clone())
                .collect(),
            written: influence.as_ref().map(|(written, _)| written.clone()),
            reach,
        };
        if !matches.get_flag("json") {
            print!("{}", text_of(&shown, &study));
        }
        series.push((
            shown,
            Series {
                label: label.join(", "),
                panel: several(horizons.len(), format!("horizon {reach} dx")).unwrap_or_default(),
                study,
            },
        ));
    }
    if matches.get_flag("json") {
        let pages: Vec<Value> = series
            .iter()
            .map(|(s, series)| page(s, &series.study))
            .collect();
        println!("{:#}", Value::Array(pages));
    }
    if let (Some(file), Some(format)) = (file, format) {
        let drawn: Vec<Series> = series.into_iter().map(|(_, series)| series).collect();
        let curves = curves(matches, drawn.len());
        plot::draw(file, format, &drawn, &curves)
            .map_err(|error| Failure::plain(format!("cannot write {}: {error}", file.display())))?;
    }
    Ok(())
}

/// An influence function and how it was written; none: that of the law.
type Influence = Option<(String, (InfluenceFn, Vec<f64>))>;

fn influences(matches: &ArgMatches) -> Result<Vec<Influence>, Failure> {
    let given = matches
        .get_many::<String>("influence")
        .into_iter()
        .flatten();
    let one = |text: &String| Ok(Some((text.clone(), choices::influence(text)?)));
    let list: Vec<Influence> = given.map(one).collect::<Result<_, Failure>>()?;
    Ok(if list.is_empty() { vec![None] } else { list })
}

fn horizons(text: &str) -> Result<Vec<f64>, Failure> {
    let one = |given: &str| {
        let given = given.trim();
        let bare = given.strip_suffix("dx").unwrap_or(given).trim();
        match bare.parse::<f64>() {
            Ok(reach) if (1.0..=1e4).contains(&reach) => Ok(reach),
            Ok(reach) if reach < 1.0 => Err(input_error(
                format!("the horizon is {reach} spacings: a node has no neighbours"),
                "it is 1 or more, 3 for instance",
            )),
            _ => Err(input_error(
                format!("the horizon is `{given}`"),
                "it is a number of spacings from 1 on: 3, or 3,4.5 for two series; `--spacing` has the length",
            )),
        }
    };
    text.split(',').map(one).collect()
}

/// Every combination of the values that were listed.
fn combinations(params: &[Chosen], law: &Law) -> Result<Vec<Vec<(String, f64)>>, Failure> {
    let mut all = vec![Vec::new()];
    for chosen in params {
        let values = chosen.of(law)?;
        let with = |head: &Vec<(String, f64)>| {
            let one = |v: &f64| {
                let mut list = head.clone();
                list.push((chosen.name.clone(), *v));
                list
            };
            values.iter().map(one).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(with).collect();
        if all.len() > MOST_SERIES {
            break;
        }
    }
    Ok(all)
}

/// The density goes to the law's own parameter, where it has one.
fn set_density(options: &mut Options, law: &Law, density: f64) {
    options.density = density;
    let own = law
        .params
        .iter()
        .find(|p| ["density", "rho"].contains(&p.name.as_str()));
    if let Some(param) = own {
        options.params.push((param.name.clone(), density));
    }
}

fn flavour(matches: &ArgMatches, law: &Law) -> Result<Flavour, Failure> {
    let names = |list: &[Flavour]| {
        let names: Vec<&str> = list.iter().map(|f| f.name()).collect();
        names.join(", ")
    };
    let refused = |what: String| {
        input_error(
            format!("`{}` is not for {what}", law.name),
            format!("it is for {}", names(&law.flavours)),
        )
    };
    if let Some(name) = matches.get_one::<String>("flavour") {
        let found = law.flavours.iter().find(|f| f.name() == name);
        return found.copied().ok_or_else(|| refused(name.clone()));
    }
    if let Some(dim) = matches.get_one::<u8>("dim") {
        let found = law.flavours.iter().find(|f| f.dim() == usize::from(*dim));
        return found
            .copied()
            .ok_or_else(|| refused(format!("{dim} dimensions")));
    }
    let most = law.flavours.iter().max_by_key(|f| f.dim());
    most.copied().ok_or_else(|| refused("any flavour".into()))
}

fn direction(text: &str, flavour: Flavour) -> Result<[f64; 3], Failure> {
    let dim = flavour.dim();
    let wrong = |what: String| {
        input_error(
            what,
            "give a component for each dimension, 1,1,0 for instance, not all 0; in two dimensions also an angle, \"30 deg\"",
        )
    };
    let parts: Vec<&str> = text.split(',').collect();
    if let ([angle], 2) = (&parts[..], dim)
        && angle.contains(|c: char| c.is_alphabetic())
    {
        let radians = choices::angle(angle)?;
        return Ok([radians.cos(), radians.sin(), 0.0]);
    }
    let mut n = [0.0; 3];
    for (a, part) in parts.iter().enumerate() {
        let value: f64 = part
            .trim()
            .parse()
            .map_err(|_| wrong(format!("the direction is `{text}`")))?;
        if a >= dim && value != 0.0 || a >= 3 || !value.is_finite() {
            return Err(wrong(format!(
                "the direction `{text}` is not one of {dim} dimensions"
            )));
        }
        n[a] = value;
    }
    if parts.len() == 1 && dim == 2 && n[0] != 1.0 {
        return Err(wrong(format!("the direction `{text}` is one number")));
    }
    if n == [0.0; 3] {
        return Err(wrong(format!("the direction `{text}` has no length")));
    }
    Ok(n)
}

fn curves(matches: &ArgMatches, series: usize) -> Vec<Curve> {
    let given: Vec<&String> = matches.get_many("curves").into_iter().flatten().collect();
    let chosen = |c: &Curve| match (given.is_empty(), series) {
        (true, 1) => true,
        (true, _) => *c != Curve::Continuum,
        (false, _) => given.iter().any(|name| *name == c.name()),
    };
    Curve::ALL.into_iter().filter(chosen).collect()
}
