//! How much machine code the catalogue is: counted here, so that it grows only on purpose.

use pdlang_models::registry::CATALOGUE;

/// {lattice, cloud} x {whole, any} x {scalar, AVX2, AVX-512}.
const INSTANCES_OF_A_SWEEP: usize = 2 * 2 * 3;

#[test]
fn compiled_sweeps_are_counted() {
    let sweeps: Vec<(&str, usize)> = CATALOGUE
        .iter()
        .map(|e| {
            let kernels = e.kernels.kernels.iter();
            (e.name, kernels.map(|k| k.sweeps.len()).sum())
        })
        .collect();
    // Three dimensions each. Bond-based: force, energy, tangent. LPS: weighted volume (not when frozen),
    // dilatation, force, energy, and two for the tangent. A rule that remembers: two more after the step. The rate of
    // a coupled law shares a sweep of the force; state-based heat has shape, gradient and rate.
    // Plastic and viscoelastic, in two dimensions of space and three: no energy, but an update, and with plasticity
    // the norm of the force state and its tangent. Correspondence: shape tensor, stress, force, two for the tangent.
    // The lamina, in two dimensions only: a sum for every family at each of its stages.
    let expected = [
        ("pmb", 9),
        ("pmb_compression", 15),
        ("gpmb", 9),
        ("lps", 18),
        ("lps_frozen", 15),
        ("heat", 3),
        ("heat_state", 9),
        ("thermo_pmb", 9),
        ("thermo_lps", 18),
        ("lps_plastic", 16),
        ("lps_viscoelastic", 12),
        ("correspondence", 15),
        ("correspondence_stabilised", 15),
        ("correspondence_svk", 15),
        ("lamina", 11),
    ];
    assert_eq!(sweeps, expected);
    let instances = sweeps.iter().map(|(_, n)| n).sum::<usize>() * INSTANCES_OF_A_SWEEP;
    assert_eq!(instances, 2268);
}
