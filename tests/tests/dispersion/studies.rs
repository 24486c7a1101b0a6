//! What a study of the waves of a law says; what has no waves says so.

use pdlang::ir::Flavour;
use pdlang_models::waves::{self, Request, study};
use std::f64::consts::PI;

use super::{Case, case, close};

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
