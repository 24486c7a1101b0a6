//! Constants of the papers, as the laws of the catalogue give them: from the oracle's quadrature, and from
//! the runtime's through the force on a single bond.

use pdlang::oracle::integrate;
use pdlang_runtime::body::{Body, Flavour};
use pdlang_runtime::engine::{Breaking, Traversal};
use pdlang_tests::agreement::{Question, gather, spread};
use pdlang_tests::{laws, pulse};
use std::f64::consts::PI;

/// Two nodes with one bond along x.
fn pair(flavour: Flavour, length: f64) -> Body {
    Body {
        flavour,
        x: vec![[0.0; 3], [length, 0.0, 0.0]],
        volume: vec![1.0; 2],
        material: vec![],
        regions: vec![],
        horizon: vec![],
        cross: 1.0,
        grid: None,
        spacing: length,
        periodic: [None; 3],
    }
}

fn assert_close(what: &str, got: f64, expected: f64, tolerance: f64) {
    let error = (got / expected - 1.0).abs();
    assert!(
        error <= tolerance,
        "{what}: {got} is not {expected}, error {error:e}"
    );
}

/// c_g of GPMB for an influence function, cross 1: first by the oracle, then from the engine, where a bond of
/// length r stretched by s bears the force density c_g s omega(r) V.
fn gpmb_constant(flavour: Flavour, k: f64, horizon: f64, influence: &str) -> f64 {
    let law = laws::law("gpmb");
    let mut question = Question::at_rest(&law, pair(flavour, horizon / 2.0)).with(&[("K", k)]);
    question.horizon = horizon;
    question.influences = vec![laws::influence(influence)];
    let (by_oracle, omega) = question.consult(|oracle, _, state| {
        let value = oracle.named(state, "cg").expect("the law names it")[0];
        (
            value.scalar().expect("a number"),
            oracle.influence(0, horizon / 2.0).expect("finite"),
        )
    });
    let mut engine = question.engine(question.interpreted(), Traversal::Cloud, None);
    let mut state = engine.state();
    // Half the length again: the stretch 1/2 is exact.
    spread(
        &engine,
        &[[0.0; 3], [horizon / 4.0, 0.0, 0.0]],
        &mut state.u,
    );
    engine.forces(&mut state, Breaking::Held);
    if omega == 0.0 {
        // (r + eps)^-1000 underflows at this length: there is no force to compare with.
        return by_oracle;
    }
    let by_engine = gather(&engine, engine.force())[0][0] / (0.5 * omega);
    assert_close(&format!("{influence}: engine"), by_engine, by_oracle, 1e-13);
    by_oracle
}

/// Closed form of the integral from 0 to delta of r (r + eps)^-p dr.
fn softened_moment(p: f64, delta: f64, eps: f64) -> f64 {
    let power = |n: f64| {
        if n == p {
            ((delta + eps) / eps).ln()
        } else {
            ((delta + eps).powf(n - p) - eps.powf(n - p)) / (n - p)
        }
    };
    power(2.0) - eps * power(1.0)
}

#[test]
fn gamma_in_one_dimension() {
    // Seleson and Parks 2011, eq. 4.3 with K = 1, delta = 5, eps = 1; printed to 13 digits from 40-digit arithmetic.
    for (p, expected) in [
        (0.0, 0.144),
        (1.0, 0.561055189826),
        (2.0, 1.878079001174),
        (5.0, 21.95576470588),
        (10.0, 129.6005915665),
        (20.0, 615.6000000001),
        (100.0, 17463.6),
        (1000.0, 1794603.6),
    ] {
        let influence = format!("softened(p = {p}, eps = 1 m)");
        let gamma = gpmb_constant(Flavour::Slab, 1.0, pulse::DELTA, &influence);
        assert_close(&influence, gamma, expected, 2e-12);
        let closed = pulse::AXIAL_MODULUS / softened_moment(p, pulse::DELTA, pulse::EPS);
        assert_close(&influence, gamma, closed, 1e-12);
    }
}

#[test]
fn beta_in_one_dimension() {
    // Seleson and Parks 2011, eq. 4.11: (9K/5)(2 - p)/delta^(2 - p).
    for p in [1.5, 1.0, 0.0, -1.0, -5.0, -10.0] {
        let influence = format!("power(p = {p})");
        let beta = gpmb_constant(Flavour::Slab, 1.0, 5.0, &influence);
        assert_close(
            &influence,
            beta,
            1.8 * (2.0 - p) / 5.0_f64.powf(2.0 - p),
            1e-13,
        );
    }
}

#[test]
fn gamma_in_three_dimensions() {
    // Seleson and Parks 2011, Table 5.1 (printed digits) with K = 14.9 GPa, delta = 1.5 mm, eps = 0.5 mm.
    for (p, printed, digits) in [
        (0, 1.6863e22, 1.686335e22),
        (3, 6.8586e13, 6.8585515e13),
        (5, 1.3491e8, 1.349068e8),
        (10, 1.6977e-7, 1.6977036e-7),
    ] {
        let influence = format!("softened(p = {p}, eps = 0.5 mm)");
        let gamma = gpmb_constant(Flavour::Solid, 14.9e9, 1.5e-3, &influence);
        assert_close(&influence, gamma, printed, 5e-5);
        assert_close(&influence, gamma, digits, 5e-7);
    }
    // p = 0 is PMB.
    let pmb = 18.0 * 14.9e9 / (PI * 1.5e-3_f64.powi(4));
    assert_close(
        "PMB",
        gpmb_constant(Flavour::Solid, 14.9e9, 1.5e-3, "constant"),
        pmb,
        1e-14,
    );
}

/// Moments of an influence function: a law that is nothing but constants.
const MOMENTS: &str = r#"
    model moments "Ratios of moments of an influence function"
      cite "Seleson and Parks 2011, Int. J. Multiscale Comput. Eng. 9, eq. 4.6"
    {
      influence omega
      param K : pressure > 0 "modulus"
      let third = ball(omega * x^3)/ball(omega * x)
      let fifth = ball(omega * x^5)/ball(omega * x)
      let c = K*(third/delta^2 + fifth/delta^4)/ball(x^2)
      energy W = c*sum(s^2*x^2)
    }"#;

#[test]
fn moments_of_the_softened_function() {
    // Seleson and Parks 2011, Table 4.1: 2 I_n/((n+1)! I_1), eps = 1, delta = 5; eight digits by closed forms.
    let law = laws::parse(MOMENTS);
    for (p, third, fifth) in [
        (0, 1.0416667, 0.57870370),
        (5, 0.12254902, 0.031258788),
        (20, 1.8382353e-3, 5.8356672e-6),
        (100, 5.3694158e-5, 4.0085224e-9),
        (1000, 5.0351859e-7, 3.394023e-13),
    ] {
        let mut question = Question::at_rest(&law, pair(Flavour::Slab, 2.5));
        question.horizon = 5.0;
        question.influences = vec![laws::influence(&format!("softened(p = {p}, eps = 1 m)"))];
        let ratio = |name: &str| {
            question.consult(|oracle, _, state| {
                oracle.named(state, name).expect("the law names it")[0]
                    .scalar()
                    .expect("a number")
            })
        };
        assert_close(
            &format!("p = {p}, n = 3"),
            2.0 * ratio("third") / 24.0,
            third,
            1e-7,
        );
        assert_close(
            &format!("p = {p}, n = 5"),
            2.0 * ratio("fifth") / 720.0,
            fifth,
            1e-7,
        );
    }
}

const PLANAR: [(&str, f64); 5] = [
    ("constant", 9.0),
    ("linear", 36.0),
    ("cubic", 45.0),
    ("quintic", 50.4),
    ("septic", 54.0),
];

/// omega(rho) of [`PLANAR`], written out.
fn planar_influence(name: &str, q: f64) -> f64 {
    match name {
        "constant" => 1.0,
        "linear" => 1.0 - q,
        "cubic" => 1.0 - 3.0 * q.powi(2) + 2.0 * q.powi(3),
        "quintic" => 1.0 - 10.0 * q.powi(3) + 15.0 * q.powi(4) - 6.0 * q.powi(5),
        _ => 1.0 - 35.0 * q.powi(4) + 84.0 * q.powi(5) - 70.0 * q.powi(6) + 20.0 * q.powi(7),
    }
}

#[test]
fn planar_constants() {
    // c pi h delta^3/E. Plane stress: nu = 1/3, E = K; plane strain: nu = 1/4, E = 3K/2, 16/15 of it.
    let delta = 2e-3_f64;
    for (influence, expected) in PLANAR {
        let number = |flavour, e| {
            let c = gpmb_constant(flavour, 1e9, delta, influence);
            c * PI * delta.powi(3) / e
        };
        assert_close(
            influence,
            number(Flavour::PlaneStress, 1e9),
            expected,
            1e-14,
        );
        assert_close(
            influence,
            number(Flavour::PlaneStrain, 1.5e9),
            expected * 16.0 / 15.0,
            1e-14,
        );
    }
}

/// The energy of all bonds across a line of unit length at the critical stretch is G0, where
/// s0^2 = G0/(c h integral of omega r^3 dr).
#[test]
fn planar_critical_stretch() {
    let (delta, g0, k) = (2e-3_f64, 10.0, 1e9);
    for (name, _) in PLANAR {
        let c = gpmb_constant(Flavour::PlaneStress, k, delta, name);
        let omega = |r: f64| planar_influence(name, r / delta);
        let moment = integrate(delta, &|r| Ok(omega(r) * r.powi(3))).expect("smooth");
        let squared = g0 / (c * moment);
        // A bond holds c omega s^2 r/2 per pair of volumes. From depth z below the line reach the bonds longer than z
        // within an angle acos(z/r) on both sides. Midpoints in both lengths.
        let n = 1000;
        let step = delta / n as f64;
        let mut energy = 0.0;
        for i in 0..n {
            let r = (i as f64 + 0.5) * step;
            let inner = r / n as f64;
            let angles: f64 = (0..n).map(|k| ((k as f64 + 0.5) / n as f64).acos()).sum();
            energy += c * omega(r) * squared * r * r * angles * inner * step;
        }
        assert_close(name, energy, g0, 1e-4);
    }
}
