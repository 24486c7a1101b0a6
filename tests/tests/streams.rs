//! What a cloud keeps of a bond beside its index and its mask: as few numbers as its law allows.

use pdlang_models::bench::scene;
use pdlang_models::registry;
use pdlang_runtime::body::Body;
use pdlang_runtime::engine::{Engine, Law, Precision, Settings, Traversal};
use pdlang_tests::{agreement, laws};

/// A law of the catalogue in three dimensions.
fn engine(name: &str, body: &Body, partial_volume: bool, given: &[&[(&str, f64)]]) -> Engine {
    let law = laws::law(name);
    let spec = registry::find(name).and_then(|entry| entry.compiled(3));
    let spec = spec.expect("the catalogue has the law").spec;
    let influences = laws::default_influences(&law).into_iter();
    let influences = influences.map(|(f, values)| (agreement::influence(&f), values));
    let settings = Settings {
        materials: given.iter().map(|g| laws::params(&law, g)).collect(),
        influences: influences.collect(),
        horizon: vec![scene::HORIZON],
        horizon_levels: 64,
        partial_volume,
        lattice_constants: false,
        without: vec![],
        traversal: Traversal::Cloud,
        isa: None,
        precision: Precision::Double,
    };
    Engine::new(body, Law::interpreted(spec), settings).expect("a valid scene")
}

/// Numbers per bond, by the memory that they take. Heat in a jittered cloud has one; bonds of `pmb` between equal volumes
/// have none, but slots and a mask, about which the law decides nothing.
fn numbers(name: &str, body: &Body, partial_volume: bool, given: &[&[(&str, f64)]]) -> i64 {
    let bytes = |e: &Engine| e.report().bond_bytes as f64;
    let alike: Vec<&[(&str, f64)]> = given.iter().map(|_| &[][..]).collect();
    let mut equal = body.clone();
    equal.volume.fill(1.0);
    let breaking: Vec<&[(&str, f64)]> = given.iter().map(|_| &[("s0", 0.5)][..]).collect();
    let none = bytes(&engine("pmb", &equal, false, &breaking));
    let one = bytes(&engine("heat", body, true, &alike)) - none;
    let of_law = bytes(&engine(name, body, partial_volume, given)) - none;
    (of_law / one).round() as i64
}

#[test]
fn sweeps_share_what_differs_by_lengths_and_constants() {
    let body = scene::jittered(9, 0.2);
    let found = [
        "pmb",
        "gpmb",
        "pmb_compression",
        "thermo_pmb",
        "lps",
        "lps_frozen",
        "thermo_lps",
        "correspondence",
        // Where the influence function is 1, omega w is w.
        "correspondence_stabilised",
        // omega w in one sum, omega and w in another, where they stand in different terms.
        "heat_state",
    ]
    .map(|name| (name, numbers(name, &body, true, &[&[]])));
    let expected = [
        ("pmb", 1),
        ("gpmb", 1),
        ("pmb_compression", 1),
        ("thermo_pmb", 1),
        ("lps", 1),
        ("lps_frozen", 1),
        ("thermo_lps", 1),
        ("correspondence", 1),
        ("correspondence_stabilised", 1),
        ("heat_state", 3),
    ];
    assert_eq!(found, expected);
}

/// Equal volumes: c w is one number, as is the square of the stretch at which bonds break.
#[test]
fn what_is_one_number_takes_no_memory() {
    let mut body = scene::jittered(9, 0.2);
    assert_eq!(numbers("pmb", &body, false, &[&[("s0", 0.5)]]), 0);
    // One node that is different makes few rows of bonds that are, which are stored once.
    body.volume[0] *= 1.5;
    assert_eq!(numbers("pmb", &body, false, &[&[("s0", 0.5)]]), 0);
    for (k, volume) in body.volume.iter_mut().enumerate() {
        *volume *= 1.0 + 1e-3 * k as f64;
    }
    assert_eq!(numbers("pmb", &body, false, &[&[("s0", 0.5)]]), 1);
}

/// The stretch at which bonds break is one of three where two materials meet, and rows of bonds that differ in it are few;
/// a modulus is in c w.
#[test]
fn constants_of_materials_are_few() {
    let mut body = scene::jittered(9, 0.2);
    body.material = (0..body.x.len()).map(|k| u8::from(k % 9 > 4)).collect();
    let stiff: &[(&str, f64)] = &[("K", 3e10), ("s0", 0.5)];
    let weak: &[(&str, f64)] = &[("K", 3e10), ("s0", 0.2)];
    let soft: &[(&str, f64)] = &[("K", 1e10), ("s0", 0.5)];
    assert_eq!(numbers("pmb", &body, true, &[stiff, weak]), 1);
    assert_eq!(numbers("pmb", &body, true, &[stiff, soft]), 1);
}
