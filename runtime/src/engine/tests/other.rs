//! Family stage, histories, named families, fields, errors.
use super::pmb::{apart, bodies, weight};
use super::*;
use crate::spec::Spec;

fn make(body: &Body, spec: Spec, params: Vec<f64>, traversal: Traversal, isa: Isa) -> Engine {
    let settings = Settings {
        materials: vec![params],
        influences: vec![],
        horizon: vec![3.015],
        horizon_levels: 64,
        partial_volume: true,
        lattice_constants: false,
        without: vec![],
        traversal,
        isa: Some(isa),
        precision: super::super::Precision::Double,
    };
    Engine::new(body, Law::interpreted(spec), settings).unwrap_or_else(|e| panic!("{e}"))
}

const BOTH: [Traversal; 2] = [Traversal::Lattice, Traversal::Cloud];

#[test]
fn after_breaking_everything_is_as_if_computed_afresh() {
    for body in bodies() {
        for traversal in BOTH {
            for isa in isas() {
                let law = || laws::live(body.flavour.dim());
                let mut e = make(&body, law(), vec![3.0, 0.07], traversal, isa);
                let mut s = e.state();
                displace(&e, &mut s, &body, 0.05);
                e.forces(&mut s, Breaking::Held);
                let broken = e.forces(&mut s, Breaking::Armed);
                assert!(
                    broken > 0 || body.x.len() < 100,
                    "the test wants some broken bonds"
                );
                let armed = forces(&e);
                let m = e.named("m");
                let mut fresh = make(&body, law(), vec![3.0, 0.07], traversal, isa);
                fresh.forces(&mut s, Breaking::Held);
                assert_eq!(forces(&fresh), armed, "{traversal:?} {isa:?}");
                assert_eq!(fresh.named("m"), m);
                // A state that the engine has not seen before is noticed.
                let mut whole = e.state();
                whole.u = s.u.clone();
                e.forces(&mut whole, Breaking::Held);
                assert_eq!(e.intact_bonds(&whole), e.report().bonds);
                e.forces(&mut s, Breaking::Held);
                assert_eq!(forces(&e), armed);
                assert_eq!(e.intact_bonds(&s) + broken, e.report().bonds);
            }
        }
    }
}

#[test]
fn histories_are_directed_and_change_at_commits_only() {
    for body in bodies() {
        let dim = body.flavour.dim();
        // h_ij = 0.5 + n (w xi_0 + 1) and h_ji = 0.5 + n (1 - w xi_0), as all volumes are equal.
        let truth = |n: f64| -> Vec<f64> {
            let sum = |i: usize| {
                let mut f = 0.0;
                for j in 0..body.x.len() {
                    for xi in apart(&body, i, j) {
                        if let Some(w) = weight(&body, xi, j) {
                            f += w
                                * (0.5 + n * (w * xi[0] + 1.0)
                                    - 2.0 * (0.5 + n * (1.0 - w * xi[0])));
                        }
                    }
                }
                f
            };
            (0..body.x.len()).map(sum).collect()
        };
        let truth = [truth(0.0), truth(1.0), truth(2.0)];
        for traversal in BOTH {
            for isa in isas() {
                let mut e = make(&body, laws::memory(dim), vec![], traversal, isa);
                let mut s = e.state();
                for (n, truth) in truth.iter().enumerate() {
                    e.forces(&mut s, Breaking::Held);
                    e.forces(&mut s, Breaking::Held);
                    let found = forces(&e).swap_remove(0);
                    assert!(
                        difference(&[found], std::slice::from_ref(truth)) < 1e-13,
                        "{n} {traversal:?} {isa:?}"
                    );
                    let count = e.state_slots("n").unwrap()[0];
                    assert_eq!(s.slots[count][e.slot(0)], 3.0 + 2.0 * n as f64);
                    e.commit(&mut s);
                }
                let copy: State =
                    serde_json::from_str(&serde_json::to_string(&s).unwrap()).unwrap();
                assert!(copy == s && e.fits(&copy));
            }
        }
    }
}

#[test]
fn fields_have_rates_over_named_families() {
    for body in bodies() {
        let temperature = |i: usize| noise(i as u64);
        let rate = |i: usize| {
            let mut sum = 0.0;
            for j in 0..body.x.len() {
                for xi in apart(&body, i, j) {
                    let along = xi[1] == 0.0 && xi[2] == 0.0;
                    if let (true, Some(w)) = (along, weight(&body, xi, j)) {
                        sum += 2.5 * w * (temperature(j) - temperature(i));
                    }
                }
            }
            sum
        };
        let truth: Vec<f64> = (0..body.x.len()).map(rate).collect();
        for traversal in BOTH {
            for isa in isas() {
                let mut e = make(
                    &body,
                    laws::heat(body.flavour.dim()),
                    vec![2.5],
                    traversal,
                    isa,
                );
                let mut s = e.state();
                let slot = e.state_slots("T").unwrap()[0];
                for i in 0..body.x.len() {
                    s.slots[slot][e.slot(i)] = temperature(i);
                }
                assert_eq!(e.forces(&mut s, Breaking::Armed), 0);
                let rate = e.rates().next().unwrap();
                let (field, rate) = (rate.slot, rate.drive);
                assert_eq!(field, slot);
                let found: Vec<f64> = e.slots().iter().map(|&s| rate[s as usize]).collect();
                assert!(difference(&[found], std::slice::from_ref(&truth)) < 1e-14);
                assert!(e.force().is_empty() && e.energy(&s).is_empty());
            }
        }
    }
}

#[test]
fn threads_do_not_change_a_bit() {
    let body = block(Flavour::Solid, [31, 29, 23], 1.0);
    for traversal in BOTH {
        let run = |threads: usize| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap()
                .install(|| {
                    let mut e = make(
                        &body,
                        laws::live(3),
                        vec![3.0, 0.07],
                        traversal,
                        Isa::best(),
                    );
                    let mut s = e.state();
                    displace(&e, &mut s, &body, 0.05);
                    let broken = e.forces(&mut s, Breaking::Armed);
                    assert!(broken > 0);
                    (broken, forces(&e), s)
                })
        };
        assert!(run(1) == run(2));
    }
}

#[test]
fn a_body_that_does_not_fit_is_refused_before_it_is_built() {
    let body = block(Flavour::Solid, [60, 60, 60], 1.0);
    let mut settings = Settings {
        materials: vec![vec![3.0, 0.1]],
        influences: vec![],
        horizon: vec![60.0],
        horizon_levels: 64,
        partial_volume: false,
        lattice_constants: false,
        without: vec![],
        traversal: Traversal::Cloud,
        isa: None,
        precision: super::super::Precision::Double,
    };
    // 216,000 nodes with a family of nearly all others: 5e10 bonds.
    let error = Engine::new(&body, Law::interpreted(laws::pmb(3)), settings.clone()).err();
    assert!(
        matches!(error, Some(SetupError::Memory { .. })),
        "{error:?}"
    );
    settings.horizon = vec![-1.0];
    let error = Engine::new(&body, Law::interpreted(laws::pmb(3)), settings).err();
    assert_eq!(
        error.unwrap().to_string(),
        "the horizon is -1; it must be positive"
    );
}

#[test]
fn spoilt_laws_are_errors_or_run() {
    let body = block(Flavour::PlaneStress, [6, 5, 1], 1.0);
    let text = serde_json::to_string(&laws::live(2)).unwrap();
    let digits: Vec<usize> = text
        .char_indices()
        .filter(|(_, c)| c.is_ascii_digit())
        .map(|(i, _)| i)
        .collect();
    let (mut refused, mut ran) = (0, 0);
    for seed in 0..800u64 {
        let mut bytes = text.clone().into_bytes();
        let at = digits[(noise(2 * seed).abs() * digits.len() as f64) as usize % digits.len()];
        bytes[at] = b'0' + (noise(2 * seed + 1).abs() * 10.0) as u8 % 10;
        let Ok(spec) = serde_json::from_slice::<Spec>(&bytes) else {
            continue;
        };
        let settings = Settings {
            materials: vec![vec![3.0; spec.params.len()]],
            influences: vec![],
            horizon: vec![2.1],
            horizon_levels: 64,
            partial_volume: false,
            lattice_constants: false,
            without: vec![],
            traversal: BOTH[seed as usize % 2],
            isa: None,
            precision: super::super::Precision::Double,
        };
        match Engine::new(&body, Law::interpreted(spec), settings) {
            Ok(mut e) => {
                ran += 1;
                let mut s = e.state();
                e.forces(&mut s, Breaking::Armed);
                e.energy(&s);
                e.commit(&mut s);
            }
            Err(_) => refused += 1,
        }
    }
    assert!(refused > 50 && ran > 50, "{refused} {ran}");
}
