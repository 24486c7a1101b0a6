//! Prototype microelastic brittle: one sweep, breaking.
use super::*;

fn settings(traversal: Traversal, isa: Isa) -> Settings {
    Settings {
        params: vec![3.0, 0.1],
        influences: vec![],
        horizon: 3.015,
        partial_volume: true,
        lattice_constants: false,
        traversal,
        isa: Some(isa),
    }
}

fn engine(body: &Body, traversal: Traversal, isa: Isa) -> Engine {
    let law = Law::interpreted(laws::pmb(body.flavour.dim()));
    Engine::new(body, law, settings(traversal, isa)).unwrap_or_else(|e| panic!("{e}"))
}

/// Minimum image of a - b.
fn apart(body: &Body, a: usize, b: usize) -> Vec<[f64; 3]> {
    let mut all = vec![];
    let range = |k: usize| {
        if body.periodic[k].is_some() {
            -3i32..=3
        } else {
            0..=0
        }
    };
    for i in range(0) {
        for j in range(1) {
            for k in range(2) {
                let n = [i, j, k];
                all.push(std::array::from_fn(|c| {
                    body.x[b][c] - body.x[a][c] + n[c] as f64 * body.periodic[c].unwrap_or(0.0)
                }));
            }
        }
    }
    all
}

/// The formula, node by node.
fn naive(body: &Body, u: &dyn Fn(usize) -> [f64; 3], s0: f64) -> (Vec<Vec<f64>>, usize) {
    let (dim, delta, dx) = (body.flavour.dim(), 3.015, body.spacing);
    let mut f = vec![vec![0.0; body.x.len()]; dim];
    let mut broken = 0;
    for i in 0..body.x.len() {
        for j in 0..body.x.len() {
            for xi in apart(body, i, j) {
                let r = xi.iter().map(|c| c * c).sum::<f64>().sqrt();
                if r == 0.0 || r > delta {
                    continue;
                }
                let y: [f64; 3] = std::array::from_fn(|c| xi[c] + u(j)[c] - u(i)[c]);
                let ry = y.iter().map(|c| c * c).sum::<f64>().sqrt();
                let s = (ry - r) / r;
                if s > s0 {
                    broken += 1;
                    continue;
                }
                let v = if r <= delta - dx / 2.0 {
                    1.0
                } else {
                    (delta + dx / 2.0 - r) / dx
                };
                for a in 0..dim {
                    f[a][i] += 3.0 * s * y[a] / ry * v * body.volume[j];
                }
            }
        }
    }
    (f, broken)
}

fn bodies() -> Vec<Body> {
    let mut all = vec![
        block(Flavour::Solid, [11, 7, 6], 1.0),
        carve(&block(Flavour::Solid, [9, 12, 5], 1.0), |x| {
            (x[0] - 4.0).hypot(x[1] - 5.5) < 5.0
        }),
        block(Flavour::PlaneStress, [13, 9, 1], 1.0),
        block(Flavour::Bar, [29, 1, 1], 1.0),
        block(Flavour::Solid, [1, 1, 1], 1.0),
        carve(&block(Flavour::PlaneStrain, [30, 9, 1], 1.0), |x| {
            x[0] == 0.0 || x[0] > 15.0
        }),
    ];
    for (flavour, shape, periodic) in [
        (Flavour::Solid, [8, 7, 6], [true, true, true]),
        (Flavour::Solid, [11, 2, 5], [false, true, false]),
        (Flavour::PlaneStress, [9, 8, 1], [true, false, false]),
        (Flavour::Slab, [5, 1, 1], [true, false, false]),
    ] {
        let mut b = block(flavour, shape, 1.0);
        for a in 0..3 {
            b.periodic[a] = periodic[a].then_some(shape[a] as f64);
        }
        all.push(b);
    }
    all
}

#[test]
fn every_path_gives_the_double_loop() {
    for body in bodies() {
        let mut truth: Option<(Vec<Vec<f64>>, usize)> = None;
        for traversal in [Traversal::Lattice, Traversal::Cloud] {
            for isa in isas() {
                let mut e = engine(&body, traversal, isa);
                let mut s = e.state();
                displace(&e, &mut s, &body, 0.05);
                let u =
                    |i: usize| std::array::from_fn(|a| s.u.get(a).map_or(0.0, |u| u[e.slot(i)]));
                let (f, broken) = truth.get_or_insert_with(|| naive(&body, &u, 0.1)).clone();
                let (held, _) = naive(&body, &u, f64::INFINITY);
                assert_eq!(e.forces(&mut s, Breaking::Held), 0);
                assert!(
                    difference(&forces(&e), &held) < 1e-14,
                    "{:?} {traversal:?} {isa:?} {}",
                    body.flavour,
                    difference(&forces(&e), &held)
                );
                assert_eq!(
                    e.forces(&mut s, Breaking::Armed),
                    broken,
                    "{:?} {traversal:?} {isa:?}",
                    body.flavour
                );
                assert!(
                    difference(&forces(&e), &f) < 1e-14,
                    "{:?} {traversal:?} {isa:?}",
                    body.flavour
                );
            }
        }
    }
}

#[test]
fn undeformed_and_translated_bodies_feel_exactly_nothing() {
    for body in bodies() {
        for traversal in [Traversal::Lattice, Traversal::Cloud] {
            for isa in isas() {
                let mut e = engine(&body, traversal, isa);
                let mut s = e.state();
                for shift in [0.0, 0.123] {
                    for u in &mut s.u {
                        u.fill(shift);
                    }
                    assert_eq!(e.forces(&mut s, Breaking::Armed), 0);
                    assert!(e.force().concat().iter().all(|&f| f == 0.0));
                }
            }
        }
    }
}
