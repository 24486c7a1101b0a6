//! How much machine code the catalogue is: counted here, so that it grows only on purpose.

use pdlang_models::registry::CATALOGUE;
use pdlang_runtime::engine::Law;
use pdlang_runtime::kernel::CompiledLaw;
use pdlang_runtime::spec::Stage;

/// {lattice, cloud} x {scalar, AVX2, AVX-512}; twice, for whole families and any, where a sweep runs at every step.
const INSTANCES_OF_A_RARE_SWEEP: usize = 2 * 3;

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
    // The absorbing layer as correspondence, what stress gives by direction in the place of its sum.
    // The lamina, in two dimensions only: a sum for every family at each of its stages. The solid: in one dimension force,
    // energy, uncorrected sums and tangent; else also the sum of a weight, the dilatation and its tangent.
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
        ("absorbing", 21),
        ("lamina", 11),
        ("laminate", 14),
        ("solid", 18),
    ];
    assert_eq!(sweeps, expected);
    // For small displacements the same sums are taken.
    let linearised: Vec<(&str, usize)> = CATALOGUE
        .iter()
        .filter_map(|e| Some((e.name, e.linearised?)))
        .map(|(name, law)| (name, law.kernels.iter().map(|k| k.sweeps.len()).sum()))
        .collect();
    assert_eq!(linearised, [("pmb", 9), ("lps", 18)]);
    let all = sweeps.iter().chain(&linearised);
    let sweeps = all.map(|(_, n)| n).sum::<usize>();
    let laws = || {
        CATALOGUE
            .iter()
            .flat_map(|e| [Some(e.kernels), e.linearised])
    };
    let steps: usize = laws().flatten().map(at_every_step).sum();
    assert_eq!((sweeps + steps) * INSTANCES_OF_A_RARE_SWEEP, 2214);
    // On a lattice, AVX2 and AVX-512, whole families and any.
    #[cfg(target_arch = "x86_64")]
    {
        let kernels = laws().flatten().flat_map(|law| law.kernels);
        let single = kernels
            .flat_map(|k| k.sweeps)
            .filter(|(_, e)| e.single.is_some());
        assert_eq!(4 * single.count(), 136);
    }
}

/// How many of a law's compiled sweeps run at every step.
fn at_every_step(law: &'static CompiledLaw) -> usize {
    let kernels = law.kernels.iter();
    kernels
        .map(|kernel| {
            let law = Law::compiled(law, kernel.dim).expect("a law of the catalogue");
            let stage = |(position, _): &(usize, _)| law.spec.sweeps[*position].stage;
            kernel
                .sweeps
                .iter()
                .map(stage)
                .filter(|s| *s == Stage::Step)
                .count()
        })
        .sum()
}
