//! Between the stages of the compiler every law of the catalogue and of the fixtures is sound: see `pdlang::sound`. The
//! laws of chance of `random_laws` go through the same checks.

use pdlang_models::registry;
use pdlang_tests::{agreement, laws};

#[test]
fn every_stage_of_every_law_is_sound() {
    let fixtures = [
        "bond_heat",
        "bond_memory",
        "dragging",
        "leaking",
        "moving_fields",
        "relaxing",
        "sound",
    ];
    for name in registry::names().into_iter().chain(fixtures) {
        let law = laws::law(name);
        for dim in 1..=3 {
            if law.flavours.iter().any(|flavour| flavour.dim() == dim) {
                // The checks are in there.
                let spec = agreement::spec(&law, dim);
                assert!(!spec.sweeps.is_empty(), "{name} in {dim}D does nothing");
            }
        }
    }
}
