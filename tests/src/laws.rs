//! Laws of the catalogue and of `tests/fixtures/laws`, and values for their parameters.

use std::path::Path;

use pdlang::front;
use pdlang::ir::{InfluenceFn, Law};
use pdlang_models::registry;
use pdlang_models::verify::subject::{MODULUS, SHEAR, usual};
use pdlang_runtime::body::Flavour;

/// Elastic moduli of the tests [Pa]: those of the reference block, Poisson's ratio 0.322.
pub const K: f64 = MODULUS;
pub const G: f64 = SHEAR;

/// Laws of the catalogue, and a fixture, that move and turn with the body: they balance angular momentum at any deformation.
pub const FINITE_STRAINS: [&str; 13] = [
    "pmb",
    "gpmb",
    "lps",
    "lps_frozen",
    "thermo_pmb",
    "thermo_lps",
    "lps_plastic",
    "lps_viscoelastic",
    "lamina",
    "correspondence_svk",
    "laminate",
    "solid",
    "corrected",
];

/// Laws of small strains: a turn by a finite angle strains them.
pub const SMALL_STRAINS: [&str; 2] = ["correspondence", "correspondence_stabilised"];

/// All of these.
pub fn moving() -> impl Iterator<Item = &'static str> {
    FINITE_STRAINS.into_iter().chain(SMALL_STRAINS)
}

/// The one law of a text.
pub fn parse(text: &str) -> Law {
    let mut checked = front::file(text);
    assert!(!checked.has_errors(), "{:?}", checked.diagnostics);
    assert_eq!(checked.laws.len(), 1, "one law is expected");
    checked.laws.remove(0)
}

/// A law of the catalogue, or of the fixtures.
pub fn law(name: &str) -> Law {
    match registry::find(name) {
        Some(entry) => parse(entry.text),
        None => {
            let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("fixtures/laws");
            let text = std::fs::read_to_string(folder.join(format!("{name}.pd")));
            parse(&text.expect("the fixture exists"))
        }
    }
}

/// The flavours that a law is for, as the runtime names them.
pub fn flavours(law: &Law) -> Vec<Flavour> {
    let served = |f: &Flavour| law.flavours.iter().any(|g| g.name() == f.name());
    Flavour::ALL.into_iter().filter(served).collect()
}

/// An influence function as a scene chooses it, with its parameter values.
pub fn influence(text: &str) -> (InfluenceFn, Vec<f64>) {
    front::influence_call(text, &[]).expect("the influence function is right")
}

/// The defaults of a law's influence slots; `constant` where there is none.
pub fn default_influences(law: &Law) -> Vec<(InfluenceFn, Vec<f64>)> {
    let of = |slot: &pdlang::ir::Influence| match &slot.default {
        // Of what a law leaves open.
        Some(f) => (f.clone(), vec![1.0; f.params.len()]),
        None => influence("constant"),
    };
    law.influences.iter().map(of).collect()
}

/// A value for every parameter: from `given`, else a usual one.
pub fn params(law: &Law, given: &[(&str, f64)]) -> Vec<f64> {
    let value = |name: &str| given.iter().find(|(n, _)| *n == name).map(|(_, v)| *v);
    law.params
        .iter()
        .map(|p| {
            value(&p.name)
                .or_else(|| usual(&p.name, crate::bodies::DX))
                .or(p.default)
                .unwrap_or(1.0)
        })
        .collect()
}
