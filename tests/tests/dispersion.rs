//! Waves of laws on lattices and in the continuum, against tables and closed forms that this program did not make.
//!
//! `fixtures/dispersion/lattices.txt` has frequencies from closed forms in 40-digit arithmetic. Equation numbers in brackets
//! are those of Seleson and Parks 2011 (influence functions) and of Nicely, Tang and Qian 2018 (correspondence), as
//! corrected.

use pdlang::front;
use pdlang::ir::{Flavour, Law};
use pdlang::oracle::Ball;
use pdlang_models::registry;
use pdlang_models::verify::bodies::Random;
use pdlang_models::verify::constants;
use pdlang_models::verify::{Options, Subject};
use pdlang_models::waves::{
    self, Hermitian, Moving, Request, Stencil, continuum, root_series, study,
};
use std::f64::consts::PI;

const TABLE: &str = include_str!("../fixtures/dispersion/lattices.txt");

/// A law at certain values.
#[derive(Clone)]
struct Case {
    law: &'static str,
    flavour: Flavour,
    params: Vec<(&'static str, f64)>,
    influence: Option<String>,
    /// In spacings.
    reach: f64,
    spacing: f64,
    lattice_constants: bool,
}

fn case(law: &'static str, flavour: Flavour, params: &[(&'static str, f64)], reach: f64) -> Case {
    Case {
        law,
        flavour,
        params: params.to_vec(),
        influence: None,
        reach,
        spacing: 1.0,
        lattice_constants: false,
    }
}

impl Case {
    fn influence(mut self, text: &str) -> Case {
        self.influence = Some(text.into());
        self
    }

    fn spacing(mut self, spacing: f64) -> Case {
        self.spacing = spacing;
        self
    }

    fn ask<A>(&self, question: impl FnOnce(&Subject) -> A) -> A {
        let law = law(self.law);
        let influence = self.influence.as_ref().map(|text| {
            front::influence_call(text, &[]).unwrap_or_else(|e| panic!("{text}: {e:?}"))
        });
        let options = Options {
            params: self
                .params
                .iter()
                .map(|(n, v)| (n.to_string(), *v))
                .collect(),
            influence,
            horizon: self.reach * self.spacing,
            reach: self.reach,
            density: 1.0,
            lattice_constants: self.lattice_constants,
            partial_volume: false,
        };
        let subject = Subject::new(&law, "", &options).expect("a subject");
        question(&subject)
    }

    fn stencil(&self) -> Stencil {
        self.ask(|s| {
            waves::stencil(s, self.flavour).unwrap_or_else(|e| panic!("{}: {e}", self.law))
        })
    }

    /// Of the continuum, along a unit direction.
    fn continuum(&self, n: [f64; 3], k: f64) -> Hermitian {
        self.ask(|s| {
            continuum::matrix(s, self.flavour, Moving::Displacement, n, k).expect("a continuum")
        })
    }
}

fn law(name: &str) -> Law {
    registry::find(name)
        .expect("a law of the catalogue")
        .law()
        .expect("a correct law")
}

/// Frequencies at unit density, ascending.
fn omegas(matrix: &Hermitian) -> Vec<f64> {
    matrix
        .pairs()
        .iter()
        .map(|p| p.value.max(0.0).sqrt())
        .collect()
}

fn along_x(k: f64) -> [f64; 3] {
    [k, 0.0, 0.0]
}

fn close(found: f64, expected: f64, scale: f64, tolerance: f64, what: &str) {
    let error = (found - expected).abs() / scale;
    assert!(
        error <= tolerance,
        "{what}: {found} is not {expected} ({error:.1e})"
    );
}

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

/// Every law of the catalogue that moves, in every flavour, at usual values.
fn catalogue() -> Vec<(&'static str, Flavour)> {
    let mut all = Vec::new();
    for entry in registry::CATALOGUE {
        let law = law(entry.name);
        for flavour in &law.flavours {
            all.push((entry.name, *flavour));
        }
    }
    all
}

/// The stencil comes from derived and compiled tapes; the oracle reads the law itself. Both have the same `M(k)`, which is
/// Hermitian, not negative, and nothing at k = 0.
#[test]
fn the_oracle_has_the_same_matrices() {
    let mut random = Random(7);
    let mut asked = 0;
    for (name, flavour) in catalogue() {
        let case = case(name, flavour, &[], 2.3).spacing(1e-3);
        case.ask(|subject| {
            let Ok(moving) = waves::moving(subject) else {
                return;
            };
            let stencil = waves::stencil(subject, flavour).expect("a stencil");
            let points = constants::lattice_points(subject, flavour);
            let origin = stencil.matrix([0.0; 3]);
            assert_eq!(
                (origin.re, origin.im),
                ([[0.0; 3]; 3], [[0.0; 3]; 3]),
                "{name}: a translation"
            );
            for _ in 0..3 {
                let k: [f64; 3] = std::array::from_fn(|a| {
                    if a < flavour.dim() {
                        PI / 1e-3 * random.signed()
                    } else {
                        0.0
                    }
                });
                let found = stencil.matrix(k);
                let ball = Ball::Integral {
                    cross: constants::cross(flavour),
                };
                let expected =
                    continuum::of_family(subject, flavour, moving, (&points, false), ball, k);
                let expected = expected.expect("the oracle answers");
                let scale = expected
                    .re
                    .iter()
                    .flatten()
                    .fold(0.0_f64, |m, v| m.max(v.abs()));
                for (f, e) in found.re.iter().flatten().zip(expected.re.iter().flatten()) {
                    close(
                        *f,
                        *e,
                        scale,
                        1e-11,
                        &format!("{name} {flavour:?} at {k:?}"),
                    );
                }
                assert!(
                    stencil.asymmetry(k) < 1e-12,
                    "{name}: {}",
                    stencil.asymmetry(k)
                );
                let least = found.pairs()[0].value;
                assert!(least > -1e-12 * scale, "{name}: {least}");
                // Slopes are those of differences.
                for a in 0..flavour.dim() {
                    let h = 1e-5 / 1e-3;
                    let [plus, minus] = [h, -h].map(|h| {
                        let mut at = k;
                        at[a] += h;
                        stencil.matrix(at).re
                    });
                    let slope = stencil.slope(k, a).re;
                    for i in 0..stencil.size {
                        for j in 0..stencil.size {
                            let difference = (plus[i][j] - minus[i][j]) / (2.0 * h);
                            close(slope[i][j], difference, scale * 1e-3, 1e-6, name);
                        }
                    }
                }
                asked += 1;
            }
        });
    }
    assert!(asked > 3 * 60, "{asked}");
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

/// [4.5], [4.12] and [27]: the continuum, where integrals are in closed form or by Simpson's rule on 20,000 intervals.
#[test]
fn the_continuum_has_the_frequencies_of_its_integrals() {
    let delta = 5.0;
    let simpson = |f: &dyn Fn(f64) -> f64| {
        let n = 20_000;
        let h = delta / f64::from(n);
        let weight = |i: i32| match i {
            0 => 1.0,
            i if i == n => 1.0,
            i if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        h / 3.0
            * (0..=n)
                .map(|i| weight(i) * f(f64::from(i) * h))
                .sum::<f64>()
    };
    for k in [0.05, 0.5, 1.5, 4.0, 6.0] {
        for p in [0.0, 1.0, 5.0, 10.0] {
            let psi = |r: f64| (r + 1.0_f64).powf(-p);
            let gamma = 1.8 / simpson(&|r| r * psi(r));
            let wave = |r: f64| {
                if r == 0.0 {
                    0.0
                } else {
                    (1.0 - (k * r).cos()) / r * psi(r)
                }
            };
            let expected = 2.0 * gamma * simpson(&wave);
            let law = case("gpmb", Flavour::Slab, &[("K", 1.0)], 5.0)
                .influence(&format!("softened(p = {p}, eps = 1 m)"));
            let found = law.continuum(along_x(1.0), k).re[0][0];
            close(
                found,
                expected,
                expected,
                1e-9,
                &format!("softened, p = {p}, k = {k}"),
            );
        }
        // A power of the length: p = -1 and -5.
        for p in [-1.0, -5.0] {
            let beta = 1.8 * (2.0 - p) / 5.0_f64.powf(2.0 - p);
            let wave = |r: f64| (1.0 - (k * r).cos()) * r.powf(-p - 1.0);
            let expected = 2.0 * beta * simpson(&wave);
            let law = case("gpmb", Flavour::Slab, &[("K", 1.0)], 5.0)
                .influence(&format!("power(p = {p})"));
            let found = law.continuum(along_x(1.0), k).re[0][0];
            close(
                found,
                expected,
                expected,
                1e-9,
                &format!("power, p = {p}, k = {k}"),
            );
        }
        let z = k * delta;
        let expected = 3.0 * (z.sin() - z * z.cos()).abs() / (delta.powi(3) * k * k);
        for law in ["correspondence", "correspondence_stabilised"] {
            let case = case(law, Flavour::Bar, &[("E", 1.0), ("nu", 0.25)], 5.0);
            let found = case.continuum(along_x(1.0), k).re[0][0].max(0.0).sqrt();
            close(found, expected, 0.3, 1e-9, &format!("{law}, k = {k}"));
        }
    }
}

/// In two and three dimensions a fine lattice comes near its continuum, in any direction, and long waves run at the
/// speeds of the local law.
#[test]
fn fine_lattices_approach_their_continuum() {
    for (law, flavour, reach, tolerance) in [
        ("lps", Flavour::PlaneStrain, 16.0, 0.02),
        ("correspondence", Flavour::PlaneStress, 16.0, 0.03),
        ("lps", Flavour::Solid, 5.0, 0.08),
        ("pmb", Flavour::Solid, 8.0, 0.08),
    ] {
        let case = case(law, flavour, &[], reach);
        let stencil = case.stencil();
        let n = [0.6, 0.8, 0.0];
        for z in [0.5, 3.0, 6.0] {
            let k = z / reach;
            let whole = omegas(&case.continuum(n, k));
            let lattice = omegas(&stencil.matrix(n.map(|c| c * k)));
            let largest = whole[whole.len() - 1].max(lattice[lattice.len() - 1]);
            for (a, b) in lattice.iter().zip(&whole) {
                close(
                    *a,
                    *b,
                    largest,
                    tolerance,
                    &format!("{law} {flavour:?}, k delta = {z}"),
                );
            }
        }
    }
    let (k, g): (f64, f64) = (14.9e9, 6e9);
    let request = Request {
        flavour: Flavour::Solid,
        direction: [1.0, 2.0, 3.0],
        points: 2,
    };
    let lps = case("lps", Flavour::Solid, &[("K", k), ("G", g)], 3.0).spacing(1e-3);
    let study = lps.ask(|s| study(s, &request)).expect("a study");
    let speeds: Vec<f64> = study
        .branches
        .iter()
        .map(|b| b.continuum.unwrap())
        .collect();
    let density = study.density;
    for (found, modulus) in speeds.iter().zip([k + 4.0 * g / 3.0, g, g]) {
        close(
            found * density,
            modulus,
            modulus,
            1e-8,
            "a speed of the continuum",
        );
    }
    let names: Vec<&str> = study.branches.iter().map(|b| b.name.as_str()).collect();
    assert_eq!(names, ["L", "T1", "T2"]);
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

/// What a study says of zero-energy modes, largest frequencies and moduli, where papers have the values.
#[test]
fn studies_find_modes_without_energy_and_soft_lattices() {
    let asked = |case: &Case, direction: [f64; 3]| {
        let request = Request {
            flavour: case.flavour,
            direction,
            points: 8,
        };
        case.ask(|s| study(s, &request)).expect("a study")
    };
    let x = [1.0, 0.0, 0.0];
    // Largest Omega/c of chains, and of plates at E = 100: table of the paper recomputed.
    for (gs, largest) in [
        (0.0, [1.0, 0.547163, 0.382217, 0.294659, 0.240022]),
        (0.5, [2.0, 0.664212, 0.421665, 0.314306, 0.251753]),
        (2.0, [4.0, 1.25, 0.652862, 0.415315, 0.301671]),
    ] {
        for (n, largest) in (1..).zip(largest) {
            let params = [("E", 1.0), ("nu", 0.25), ("Gs", gs)];
            let chain = case(
                "correspondence_stabilised",
                Flavour::Bar,
                &params,
                f64::from(n),
            );
            let study = asked(&chain, x);
            close(
                study.step.fastest,
                largest,
                largest,
                5e-6,
                &format!("n = {n}, Gs = {gs}"),
            );
            close(
                study.step.dt,
                2.0 / study.step.fastest,
                study.step.dt,
                1e-15,
                "a step",
            );
            // A chain of n neighbours has n zeros without stabilisation, the last at pi.
            assert_eq!(
                study.zero.len(),
                if gs == 0.0 { n as usize } else { 0 },
                "n = {n}, Gs = {gs}"
            );
            if gs == 0.0 {
                let last = study.zero[study.zero.len() - 1].k[0];
                close(last, PI, PI, 1e-9, "the last zero");
                assert!(study.zone.zero.len() == n as usize, "{:?}", study.zone.zero);
            }
        }
    }
    // The table's values are the largest of samples.
    for (gs, largest) in [(0.0, 4.868), (0.25, 4.913), (1.0, 5.059), (2.0, 5.279)] {
        let params = [("E", 100.0), ("nu", 0.25), ("Gs", gs)];
        let plate = case(
            "correspondence_stabilised",
            Flavour::PlaneStress,
            &params,
            3.0,
        );
        let study = asked(&plate, x);
        close(
            study.step.fastest,
            largest,
            largest,
            5e-4,
            &format!("a plate, Gs = {gs}"),
        );
        assert_eq!(study.zone.zero.is_empty(), gs > 0.0);
        let (free, _) = study.free.expect("a block");
        assert!(free.fastest >= 0.8 * study.step.fastest && free.dt.is_finite());
    }
    // Bonds to the nearest neighbours alone resist no shear.
    let loose = asked(&case("pmb", Flavour::PlaneStress, &[], 1.0), x);
    assert!(loose.zone.zero_points > 30, "{}", loose.zone.zero_points);
    assert!(
        loose
            .rows
            .iter()
            .all(|row| row.lattice[1].omega <= 1e-6 * loose.step.fastest)
    );
    // Table 5.1: K_lat/K = 1.12, 1.04, 0.94, 0.40 for p = 0, 3, 5, 10 with eps = dx and three spacings.
    for (p, ratio) in [(0.0, 1.12), (3.0, 1.04), (5.0, 0.94), (10.0, 0.40)] {
        let soft = case("gpmb", Flavour::Solid, &[("K", 1.0)], 3.0)
            .influence(&format!("softened(p = {p}, eps = 1 m)"));
        let study = asked(&soft, x);
        let bulk = study.moduli.iter().find(|m| m.name == "K").expect("K");
        close(
            bulk.lattice / bulk.declared,
            ratio,
            1.0,
            0.005,
            &format!("p = {p}"),
        );
        let warned = study
            .warnings
            .iter()
            .any(|w| w.contains(": K 0.40, G 0.20"));
        assert_eq!(warned, p == 10.0, "{:?}", study.warnings);
    }
}

/// Group velocities against differences of frequencies, and waves of heat, which decay.
#[test]
fn energy_runs_at_the_slope_of_the_frequency() {
    let lattice = case("lps", Flavour::PlaneStrain, &[], 3.0);
    let request = |points| Request {
        flavour: Flavour::PlaneStrain,
        direction: [2.0, 1.0, 0.0],
        points,
    };
    let study = lattice
        .ask(|s| waves::study(s, &request(400)))
        .expect("a study");
    for b in 0..2 {
        for i in (5..390).step_by(37) {
            let (below, at, above) = (&study.rows[i - 1], &study.rows[i], &study.rows[i + 1]);
            let slope = (above.lattice[b].omega - below.lattice[b].omega) / (above.k - below.k);
            let group = at.lattice[b].group.expect("a velocity");
            let along: f64 = (0..3).map(|a| group[a] * study.direction[a]).sum();
            let speed = study.branches[0].lattice.sqrt();
            close(
                along,
                slope,
                speed,
                1e-4,
                &format!("branch {b}, k = {}", at.k),
            );
        }
    }
    // lambda = k sum(..)(1 - cos)/(rho c): the diffusivity of long waves is k/(rho c), of the continuum exactly.
    let heat = case(
        "heat",
        Flavour::Solid,
        &[("k", 3.0), ("density", 5.0), ("cv", 7.0)],
        3.0,
    );
    let request = Request {
        flavour: Flavour::Solid,
        direction: [1.0, 1.0, 0.0],
        points: 6,
    };
    let study = heat.ask(|s| waves::study(s, &request)).expect("a study");
    assert_eq!(study.branches[0].name, "T");
    close(
        study.branches[0].continuum.unwrap(),
        3.0 / 35.0,
        3.0 / 35.0,
        1e-8,
        "diffusivity",
    );
    let (free, _) = study.free.expect("a block");
    assert!(study.step.fastest > 0.0 && (free.fastest / study.step.fastest - 1.0).abs() < 0.4);
    assert!(
        study.notes.iter().any(|n| n.contains("decay")),
        "{:?}",
        study.notes
    );
}

#[test]
fn what_has_no_waves_says_so() {
    let refused = |case: &Case| {
        let request = Request {
            flavour: case.flavour,
            direction: [1.0, 0.0, 0.0],
            points: 2,
        };
        case.ask(|s| study(s, &request)).expect_err("refused")
    };
    let layer = refused(&case("absorbing", Flavour::PlaneStrain, &[], 3.0));
    assert!(
        layer.contains("`drag`") && layer.contains("no real frequency"),
        "{layer}"
    );
    let large = refused(&case("lps", Flavour::Solid, &[], 60.0));
    assert!(large.contains("too large for a stencil"), "{large}");
    let nowhere = Request {
        flavour: Flavour::Bar,
        direction: [0.0, 1.0, 0.0],
        points: 2,
    };
    let bar = case("pmb", Flavour::Bar, &[], 3.0);
    let error = bar.ask(|s| study(s, &nowhere)).expect_err("no direction");
    assert!(error.contains("a direction of 1 dimensions"), "{error}");
}
