//! The continuum, which the oracle has, against integrals, and lattices against it.

use pdlang::ir::Flavour;
use pdlang::oracle::Ball;
use pdlang_models::registry;
use pdlang_models::verify::bodies::Random;
use pdlang_models::verify::constants;
use pdlang_models::waves::{self, Request, continuum, study};
use std::f64::consts::PI;

use super::{along_x, case, close, law, omegas};

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
