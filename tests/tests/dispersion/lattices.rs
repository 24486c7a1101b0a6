//! Stencils on lattices. `fixtures/dispersion/lattices.txt` has frequencies from closed forms in 40-digit arithmetic.

use pdlang::ir::Flavour;
use pdlang_models::waves::{Hermitian, Stencil, root_series};
use std::f64::consts::PI;

use super::{Case, along_x, case, close, omegas};

const TABLE: &str = include_str!("../../fixtures/dispersion/lattices.txt");

/// What the table calls a lattice.
fn of_table(name: &str) -> Case {
    use Flavour::{Bar, PlaneStrain, PlaneStress, Slab, Solid};
    let parts: Vec<&str> = name.split('-').collect();
    // A number behind a letter: `n3`, `G0.25`.
    let number = |letter: char| {
        let found = parts
            .iter()
            .find_map(|p| p.strip_prefix(letter)?.parse::<f64>().ok());
        found.unwrap_or_else(|| panic!("{name} has no {letter}"))
    };
    let softened = |p: f64, eps: &str| format!("softened(p = {p}, eps = {eps})");
    let chain = |law| case(law, Slab, &[("K", 1.0)], 20.0).spacing(0.25);
    let correspondence = |flavour, e, reach, gs| {
        let params = [("E", e), ("nu", 0.25)];
        match gs {
            None => case("correspondence", flavour, &params, reach),
            Some(gs) => {
                let all = [&params[..], &[("Gs", gs)]].concat();
                case("correspondence_stabilised", flavour, &all, reach)
            }
        }
    };
    match name {
        "disp-1d-pmb" => chain("pmb"),
        n if n.starts_with("disp-1d-gpmb") => {
            chain("gpmb").influence(&softened(number('p'), "1 m"))
        }
        "disp-1d-lps" => case("lps", Slab, &[("K", 1.0 - 0.8 / 3.0), ("G", 0.2)], 3.0),
        n if n.starts_with("disp-1d-corr") => {
            let gs = n.contains('G').then(|| number('G'));
            correspondence(Bar, 1.0, number('n'), gs)
        }
        "disp-2d-pmb" => case("pmb", PlaneStress, &[("K", 100.0)], 3.0),
        "disp-2d-gpmb-p2" => {
            case("gpmb", PlaneStress, &[("K", 100.0)], 3.0).influence(&softened(2.0, "1 m"))
        }
        "disp-2d-lps-planestress" => {
            case("lps", PlaneStress, &[("K", 100.0 / 1.5), ("G", 40.0)], 3.0)
        }
        n if n.starts_with("disp-2d-corr") => {
            correspondence(PlaneStress, 100.0, number('d'), Some(number('G')))
        }
        "disp-2d-pml-gauss" => correspondence(PlaneStrain, 1.0, 4.09, None)
            .spacing(0.01)
            .influence("gaussian(l = 0.011 m)"),
        "disp-3d-pmb" => case("pmb", Solid, &[("K", 2.0 / 3.0)], 3.0),
        "disp-3d-gpmb-p3" => {
            case("gpmb", Solid, &[("K", 2.0 / 3.0)], 3.0).influence(&softened(3.0, "1 m"))
        }
        "disp-3d-lps" => case("lps", Solid, &[("K", 1.0 / 1.2), ("G", 1.0 / 2.6)], 3.0),
        n if n.starts_with("disp-3d-corr") => correspondence(Solid, 1.0, 2.0, Some(number('G'))),
        _ => panic!("no lattice is called {name}"),
    }
}

/// All of the table, to 1e-10 of the largest branch; where there is no stabilisation, by the law without it too.
#[test]
fn lattices_have_the_frequencies_of_the_table() {
    let (mut tables, mut values) = (Vec::new(), 0);
    let mut stencils: Vec<Stencil> = Vec::new();
    for line in TABLE.lines().filter(|l| !l.starts_with('#')) {
        let [name, k, omega] = line.split('|').map(str::trim).collect::<Vec<_>>()[..] else {
            panic!("{line}");
        };
        let numbers = |text: &str, by: &[char]| -> Vec<f64> {
            text.split(by)
                .map(|t| t.parse().expect("a number"))
                .collect()
        };
        if tables.last() != Some(&name) {
            tables.push(name);
            let case = of_table(name);
            stencils = vec![case.stencil()];
            if case.params.contains(&("Gs", 0.0)) {
                let mut plain = case.clone();
                plain.law = "correspondence";
                plain.params.pop();
                stencils.push(plain.stencil());
            }
        }
        let mut vector = [0.0; 3];
        for (to, c) in vector.iter_mut().zip(numbers(k, &[','])) {
            *to = c;
        }
        let expected = numbers(omega, &[' ']);
        for stencil in &stencils {
            let found = omegas(&stencil.matrix(vector));
            assert_eq!(found.len(), expected.len(), "{name}");
            let largest = expected[expected.len() - 1];
            for (found, expected) in found.iter().zip(&expected) {
                close(*found, *expected, largest, 1e-10, line);
                values += 1;
            }
        }
    }
    assert_eq!((tables.len(), values), (28, 190), "{tables:?}");
}

/// An isotropic law on a cubic lattice: axes may be swapped.
#[test]
fn a_swap_of_axes_swaps_components() {
    for name in [
        "pmb",
        "lps",
        "correspondence_stabilised",
        "solid",
        "lps_plastic",
    ] {
        let stencil = case(name, Flavour::Solid, &[], 3.0).stencil();
        let k = [0.7, -1.9, 2.8];
        let (m, s) = (stencil.matrix(k).re, stencil.matrix([k[1], k[0], k[2]]).re);
        let swap = [1, 0, 2];
        for i in 0..3 {
            for j in 0..3 {
                close(m[i][j], s[swap[i]][swap[j]], m[0][0].abs(), 1e-11, name);
            }
        }
    }
}

/// The identity of Seleson and Parks, section 3: at `G = 3 K/5` a linear peridynamic solid with `omega = omega_g/x` is
/// bond-based, where both sum over the same family.
#[test]
fn lps_at_the_ratio_of_bonds_is_gpmb() {
    let lps = case("lps", Flavour::Solid, &[("K", 1.0), ("G", 0.6)], 3.0).stencil();
    let mut gpmb = case("gpmb", Flavour::Solid, &[("K", 1.0)], 3.0).influence("constant");
    gpmb.lattice_constants = true;
    let gpmb = gpmb.stencil();
    for k in [[0.3, 0.0, 0.0], [1.2, 0.4, -2.0], [3.0, 3.0, 3.0]] {
        for (a, b) in omegas(&lps.matrix(k)).iter().zip(omegas(&gpmb.matrix(k))) {
            close(*a, b, b, 1e-10, "LPS is GPMB");
        }
    }
}

/// Long waves: speeds of correspondence are those of the local law on any lattice, and the stabilisation is of the order k^4.
#[test]
fn stabilisation_does_not_touch_long_waves() {
    let params = [("E", 100.0), ("nu", 0.25), ("Gs", 1.0)];
    for reach in [1.0, 2.0, 3.0] {
        let plain = case("correspondence", Flavour::PlaneStress, &params[..2], reach).stencil();
        let stable = case(
            "correspondence_stabilised",
            Flavour::PlaneStress,
            &params,
            reach,
        );
        let stable = stable.stencil();
        let n = [0.6, 0.8, 0.0];
        let (a, b) = (plain.taylor(n, 2), stable.taylor(n, 2));
        let speeds: Vec<f64> = omegas(&Hermitian::part(2, a[0], [[0.0; 3]; 3]).0);
        // c_T^2 = 2/5 c^2, c_L^2 = 16/15 c^2.
        close(speeds[0], 40.0_f64.sqrt(), 1.0, 1e-11, "c_T");
        close(speeds[1], (1600.0_f64 / 15.0).sqrt(), 1.0, 1e-11, "c_L");
        for i in 0..2 {
            for j in 0..2 {
                close(a[0][i][j], b[0][i][j], 100.0, 1e-12, "k^2");
            }
        }
        assert!(b[1][0][0] - a[1][0][0] > 1.0, "k^4: {:?} {:?}", a[1], b[1]);
    }
}

/// [26] and [41]: chains of correspondence of 1 to 5 neighbours, at a spacing that is not 1.
#[test]
fn chains_of_correspondence_are_those_of_the_closed_forms() {
    for n in 1..=5 {
        for gs in [0.0, 0.25, 1.0, 2.0] {
            let dx = 0.5;
            let params = [("E", 3.0), ("nu", 0.25), ("Gs", gs)];
            let reach = f64::from(n);
            let chain = case("correspondence_stabilised", Flavour::Bar, &params, reach);
            let chain = chain.spacing(dx).stencil();
            let a = reach * (reach + 1.0) * (2.0 * reach + 1.0) / 3.0;
            for step in 1..=16 {
                let k = PI / dx * f64::from(step) / 16.0;
                let sum = |f: &dyn Fn(f64) -> f64| (1..=n).map(|m| f(f64::from(m))).sum::<f64>();
                let s = sum(&|m| m * (m * k * dx).sin());
                let c = sum(&|m| (m * k * dx).cos() - 1.0);
                // With a cell for the missing volume, Gs/(n^4 dx^3) is Gs/(n^4 dx^2).
                let squared = 4.0
                    * 3.0
                    * ((s / (a * dx)).powi(2) - gs / (reach.powi(4) * dx * dx) * (c + s * s / a));
                let found = chain.matrix(along_x(k)).re[0][0];
                close(
                    found,
                    squared,
                    12.0 / dx / dx,
                    1e-13,
                    &format!("n = {n}, Gs = {gs}, k = {k}"),
                );
                if gs == 0.0 {
                    let omega = 6.0 * 3.0_f64.sqrt() * s.abs()
                        / (dx * reach * (reach + 1.0) * (2.0 * reach + 1.0));
                    close(found.max(0.0).sqrt(), omega, 2.0 / dx, 1e-7, "[26]");
                }
            }
        }
    }
}

/// [71]-[74] and [84] as corrected: square lattices along an axis, and for one neighbour at any angle.
#[test]
fn square_lattices_of_correspondence_are_those_of_the_closed_forms() {
    // Prefactor squared; coefficients of pi and of 15 Gs..., of 1, cos k, cos 2k, ..; longitudinal, of pi alone transverse.
    type Form = (f64, f64, &'static [f64], &'static [f64]);
    const FORMS: [Form; 3] = [
        (1.0, 4.0 * 2.0 / 15.0, &[4.0, 4.0], &[15.0, -15.0]),
        (
            2.0,
            1.0 / (49.0 * 30.0),
            &[1856.0, 2880.0, 1280.0, 256.0],
            &[1435.0, -595.0, -700.0, -140.0],
        ),
        (
            3.0,
            1.0 / (153.0 * 153.0 * 35.0),
            &[759024.0, 1315440.0, 870912.0, 418824.0, 117936.0, 13608.0],
            &[245480.0, 27880.0, -149600.0, -94180.0, -26520.0, -3060.0],
        ),
    ];
    for (reach, factor, pi_terms, gs_terms) in FORMS {
        for gs in [0.0, 0.25, 1.0] {
            let params = [("E", 100.0), ("nu", 0.25), ("Gs", gs)];
            let lattice = case(
                "correspondence_stabilised",
                Flavour::PlaneStress,
                &params,
                reach,
            );
            let lattice = lattice.stencil();
            for k in [0.2, 0.9, 1.7, 2.0, 2.6, 3.1] {
                let p = |share: f64| -> f64 {
                    let terms = pi_terms.iter().zip(gs_terms).enumerate();
                    let one = |(m, (pi, g)): (usize, (&f64, &f64))| {
                        (share * pi * PI + gs * g) * (m as f64 * k).cos()
                    };
                    terms.map(one).sum()
                };
                let squared = |share: f64| 100.0 * factor / PI * p(share) * (0.5 * k).sin().powi(2);
                let m = lattice.matrix(along_x(k)).re;
                let what = format!("delta = {reach}, Gs = {gs}, k = {k}");
                close(m[0][0], squared(1.0), 100.0, 1e-12, &what);
                close(m[1][1], squared(0.375), 100.0, 1e-12, &what);
            }
        }
    }
    // [84], one neighbour on each side.
    for gs in [0.0, 0.5, 2.0] {
        let params = [("E", 100.0), ("nu", 0.25), ("Gs", gs)];
        let lattice = case(
            "correspondence_stabilised",
            Flavour::PlaneStress,
            &params,
            1.0,
        )
        .stencil();
        for (k, angle) in [(0.4, 0.3_f64), (1.9, 0.7), (3.0, 1.1)] {
            let (a, b) = (k * angle.cos(), k * angle.sin());
            let squared = 100.0 * 2.0 / (15.0 * PI)
                * (90.0 * gs + 8.0 * PI - 60.0 * gs * (a.cos() + b.cos())
                    + (15.0 * gs - 4.0 * PI) * ((2.0 * a).cos() + (2.0 * b).cos()));
            let found = lattice.matrix([a, b, 0.0]).pairs()[1].value;
            close(
                found,
                squared,
                100.0,
                1e-12,
                &format!("Gs = {gs}, angle = {angle}"),
            );
        }
    }
}

/// Coefficients for matching boundaries, from sums over the lattice, against those of a book of series: PMB and LPS chains.
#[test]
fn taylor_coefficients_are_sums_over_the_lattice() {
    let series = |case: &Case| {
        let p: Vec<f64> = case
            .stencil()
            .taylor(along_x(1.0), 4)
            .iter()
            .map(|m| m[0][0])
            .collect();
        root_series(&p)
    };
    // The modulus 1 of a bar is 3 K/2.
    let pmb = |n: f64| case("pmb", Flavour::Bar, &[("K", 2.0 / 3.0)], n);
    let lps = |n: f64| {
        case(
            "lps",
            Flavour::Slab,
            &[("K", 1.0 - 0.8 / 3.0), ("G", 0.2)],
            n,
        )
    };
    for (case, expected) in [
        (
            pmb(1.0),
            [
                std::f64::consts::SQRT_2,
                0.058925565099,
                0.000736569564,
                0.000004384343,
            ],
        ),
        (
            pmb(2.0),
            [
                1.224744871392,
                0.153093108924,
                0.009143060672,
                0.000163268941,
            ],
        ),
        (
            pmb(3.0),
            [
                1.154700538379,
                0.288675134595,
                0.037688142572,
                0.001632389154,
            ],
        ),
        (
            pmb(5.0),
            [
                1.095445115010,
                0.684653196881,
                0.234874082819,
                0.028578157995,
            ],
        ),
        (lps(2.0), [1.0, 0.275, 0.058020833333, 0.006430183532]),
        (lps(3.0), [1.0, 0.55, 0.240416666667, 0.057483134921]),
    ] {
        let found = series(&case);
        // The table has the magnitudes of Omega = a_1 k - a_3 k^3 + ..
        for (m, (found, expected)) in found.iter().zip(expected).enumerate() {
            close(
                found.abs(),
                expected,
                1.0,
                2e-12,
                &format!("{} a_{}", case.law, 2 * m + 1),
            );
        }
        // The chain of planes is the stencil itself here.
        let stencil = case.stencil();
        let planes = stencil.planes(0);
        let sum: f64 = planes.iter().map(|(_, m)| m[0][0]).sum();
        close(sum, 0.0, 1.0, 1e-12, "a chain");
        assert_eq!(planes.len() as i32, 2 * planes[planes.len() - 1].0 + 1);
    }
    assert!(root_series(&[-1.0, 2.0]).is_empty());
}
