//! Laws of the catalogue as they are, at random values.

use pdlang::ir::Law;
use pdlang_models::registry;
use pdlang_models::verify::bodies::Random;
use pdlang_models::verify::{Options, verify};
use pdlang_tests::laws;
use rayon::prelude::*;

use super::summary;

/// Sets of random parameters, influence functions and horizons per law.
const SETS: u64 = if cfg!(feature = "long") { 100 } else { 2 };

fn random(law: &Law, seed: u64) -> Options {
    let mut random = Random(seed.wrapping_mul(0x9E37_79B9) ^ 0xBEEF);
    let mut within = |low: f64, high: f64| low + (high - low) * random.uniform();
    let horizon = 10f64.powf(within(-5.0, 0.0));
    let k = 10f64.powf(within(6.0, 11.5));
    let nu = within(-0.2, 0.45);
    let e = 3.0 * k * (1.0 - 2.0 * nu);
    let (e2, g12) = (10f64.powf(within(8.0, 10.0)), within(0.2, 0.6));
    let ratio = within(1.0, 20.0);
    let value = |name: &str, free: f64| match name {
        "K" => Some(k),
        "G" => Some(e / (2.0 * (1.0 + nu))),
        "E" => Some(e),
        "nu" => Some(nu),
        "E1" => Some(ratio * e2),
        "E2" => Some(e2),
        "G12" => Some(g12 * e2),
        "nu12" => Some(0.1 + 0.3 * free),
        "Em" => Some(0.3 * e2),
        "Gm" => Some(0.12 * e2),
        "h" => Some(horizon / 3.0),
        "k" => Some(0.1 + 300.0 * free),
        "density" => Some(500.0 + 8000.0 * free),
        "cv" => Some(100.0 + 4000.0 * free),
        "alpha" => Some(1e-6 + 3e-5 * free),
        "T0" => Some(200.0 + 300.0 * free),
        "share" => Some(free),
        "tau" => Some(10f64.powf(-6.0 * free)),
        "tauy" => Some(k * (1e-4 + 1e-2 * free)),
        "Gs" => Some(0.3 + free),
        "s0" | "s1" | "s2" | "sn" | "ss" | "s00" => Some(1e-4 + 0.1 * free),
        _ => None,
    };
    let mut params = Vec::new();
    for param in &law.params {
        let free = within(0.0, 1.0);
        params.extend(value(&param.name, free).map(|v| (param.name.clone(), v)));
    }
    let influences = [
        "constant".to_string(),
        "inverse".into(),
        format!("softened(p = 3, eps = {} m)", horizon / 3.0),
        "power(p = 0.5)".into(),
        format!("gaussian(l = {} m)", 0.4 * horizon),
        "1 - 0.5*(x/delta)^2".into(),
    ];
    let chosen = &influences[(within(0.0, influences.len() as f64)) as usize];
    Options {
        params,
        influence: Some(laws::influence(chosen)),
        horizon,
        density: within(500.0, 8000.0),
        ..Options::default()
    }
}

/// Whatever the parameters, the influence function and the horizon: a law of the catalogue fails nothing.
#[test]
fn the_catalogue_raises_no_false_alarm() {
    let alarms: Vec<String> = registry::CATALOGUE
        .par_iter()
        .flat_map_iter(alarms)
        .collect();
    assert!(alarms.is_empty(), "{}", alarms.concat());
}

/// What fails of a law, set by set.
fn alarms(entry: &registry::Entry) -> Vec<String> {
    let law = entry.law().expect("a correct law");
    let started = std::time::Instant::now();
    let usual = std::iter::once(Options::default());
    let mut alarms = Vec::new();
    for (k, options) in usual
        .chain((0..SETS).map(|seed| random(&law, seed)))
        .enumerate()
    {
        let verdicts = verify(&law, entry.text, &options).expect("values within bounds");
        let failed = summary(&verdicts);
        if !failed.is_empty() {
            let (name, chosen) = (&law.name, &options.influence.as_ref().map(|(f, _)| &f.name));
            let alarm = format!(
                "{name} set {k} {:?} {chosen:?} {:e} m:\n{failed}",
                options.params, options.horizon
            );
            println!("{alarm}");
            alarms.push(alarm);
        }
    }
    let seconds = started.elapsed().as_secs_f64() / (SETS + 1) as f64;
    println!("{}: {seconds:.1} s per set, {} sets", law.name, SETS + 1);
    alarms
}
