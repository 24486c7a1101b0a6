//! Prototype microelastic brittle: one sweep, breaking.
use super::*;

fn settings(traversal: Traversal, isa: Isa) -> Settings {
    Settings {
        materials: vec![vec![3.0, 0.07]],
        influences: vec![],
        horizon: vec![3.015],
        horizon_levels: 64,
        partial_volume: true,
        lattice_constants: false,
        without: vec![],
        traversal,
        isa: Some(isa),
        precision: super::super::Precision::Double,
    }
}

fn engine(body: &Body, traversal: Traversal, isa: Isa) -> Engine {
    let law = Law::interpreted(laws::pmb(body.flavour.dim()));
    Engine::new(body, law, settings(traversal, isa)).unwrap_or_else(|e| panic!("{e}"))
}

/// Minimum image of a - b.
pub(super) fn apart(body: &Body, a: usize, b: usize) -> Vec<[f64; 3]> {
    let mut all = vec![];
    let copies = |k: usize| body.periodic[k].map_or(0, |p| (3.015 / p).ceil() as i32);
    let range = |k: usize| -copies(k)..=copies(k);
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

/// w_ij of a bond within the horizon.
pub(super) fn weight(body: &Body, xi: [f64; 3], j: usize) -> Option<f64> {
    let (delta, dx) = (3.015, body.spacing);
    let r = xi.iter().map(|c| c * c).sum::<f64>().sqrt();
    let v = if r <= delta - dx / 2.0 {
        1.0
    } else {
        (delta + dx / 2.0 - r) / dx
    };
    (r > 0.0 && r <= delta).then_some(v * body.volume[j])
}

/// The formula, node by node. Bonds for which `skip` holds are left out.
fn naive(
    body: &Body,
    u: &dyn Fn(usize) -> [f64; 3],
    skip: &dyn Fn(usize, usize, f64) -> bool,
) -> (Vec<Vec<f64>>, usize) {
    let dim = body.flavour.dim();
    let mut f = vec![vec![0.0; body.x.len()]; dim];
    let mut skipped = 0;
    for i in 0..body.x.len() {
        for j in 0..body.x.len() {
            for xi in apart(body, i, j) {
                let Some(w) = weight(body, xi, j) else {
                    continue;
                };
                let r = xi.iter().map(|c| c * c).sum::<f64>().sqrt();
                let y: [f64; 3] = std::array::from_fn(|c| xi[c] + u(j)[c] - u(i)[c]);
                let ry = y.iter().map(|c| c * c).sum::<f64>().sqrt();
                let s = (ry - r) / r;
                if skip(i, j, s) {
                    skipped += 1;
                    continue;
                }
                for (f, y) in f.iter_mut().zip(y) {
                    f[i] += 3.0 * s * y / ry * w;
                }
            }
        }
    }
    (f, skipped)
}

pub(super) fn bodies() -> Vec<Body> {
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

const BOTH: [Traversal; 2] = [Traversal::Lattice, Traversal::Cloud];

/// Displacement of a node, whatever the dimension.
fn at(e: &Engine, s: &State, i: usize) -> [f64; 3] {
    std::array::from_fn(|a| s.u.get(a).map_or(0.0, |u| u[e.slot(i)]))
}

#[test]
fn every_path_gives_the_double_loop() {
    for body in bodies() {
        let mut truth = None;
        for traversal in BOTH {
            for isa in isas() {
                let mut e = engine(&body, traversal, isa);
                let mut s = e.state();
                displace(&e, &mut s, &body, 0.05);
                let (held, armed, broken) = truth.get_or_insert_with(|| {
                    let u = |i: usize| at(&e, &s, i);
                    let (armed, broken) = naive(&body, &u, &|_, _, s| s > 0.07);
                    (naive(&body, &u, &|_, _, _| false).0, armed, broken)
                });
                assert_eq!(e.forces(&mut s, Breaking::Held), 0);
                assert!(
                    difference(&forces(&e), held) < 1e-14,
                    "{traversal:?} {isa:?}"
                );
                assert_eq!(e.forces(&mut s, Breaking::Armed), *broken);
                assert!(
                    difference(&forces(&e), armed) < 1e-14,
                    "{traversal:?} {isa:?}"
                );
                assert_eq!(e.forces(&mut s, Breaking::Armed), 0);
            }
        }
    }
}

#[test]
fn cuts_zones_and_damage() {
    for body in bodies() {
        let middle = body.x.iter().map(|x| x[0]).fold(0.0, f64::max) / 2.0 + 0.25;
        let strong: Vec<bool> = body.x.iter().map(|x| x[0] > middle).collect();
        let periodic = body.periodic.iter().any(|p| p.is_some());
        for traversal in BOTH {
            for isa in isas() {
                let mut e = engine(&body, traversal, isa);
                let mut s = e.state();
                e.cut(&mut s, &|a, b| (a[0] < middle) != (b[0] < middle));
                e.no_fail(&strong);
                displace(&e, &mut s, &body, 0.05);
                let u = |i: usize| at(&e, &s, i);
                let apart = |i: usize, j: usize| strong[i] != strong[j];
                let weak = |i: usize, j: usize| !strong[i] && !strong[j];
                let (f, gone) = naive(&body, &u, &|i, j, s| apart(i, j) || weak(i, j) && s > 0.07);
                let (_, cut) = naive(&body, &u, &|i, j, _| apart(i, j));
                if !periodic {
                    // Across a periodic boundary the plane is met where the body ends, too.
                    assert_eq!(e.forces(&mut s, Breaking::Armed), gone - cut);
                    assert!(difference(&forces(&e), &f) < 1e-14);
                }
                let intact = e.intact_bonds(&s);
                let damage = e.damage(&s);
                let volume = body.volume[0];
                let lost: f64 = damage
                    .iter()
                    .enumerate()
                    .map(|(i, d)| d * neighbours(&body, i) as f64 * volume)
                    .sum();
                let directed = (e.report().bonds - intact) as f64;
                assert!(
                    (lost - directed * volume).abs() <= 1e-9 * (1.0 + lost),
                    "{lost} {directed}"
                );
            }
        }
    }
}

fn neighbours(body: &Body, i: usize) -> usize {
    let all = (0..body.x.len()).flat_map(|j| apart(body, i, j).into_iter().map(move |xi| (xi, j)));
    all.filter(|&(xi, j)| weight(body, xi, j).is_some()).count()
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
