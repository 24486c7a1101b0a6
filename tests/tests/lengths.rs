//! Parameters that meet by the lengths of a bond in two materials: the fractions, the forces, and a steady temperature.

use pdlang_runtime::body::{Body, Flavour};
use pdlang_runtime::engine::{Breaking, Engine, Law};
use pdlang_tests::agreement::{Question, gather, per_node};
use pdlang_tests::materials::{beyond, engine, state};
use pdlang_tests::{bodies, laws};

/// The law `heat` with another rule for its conductivity, and a body that is of another material beyond a plane.
fn conductors(rule: &str, mut body: Body, interface: f64) -> (pdlang::ir::Law, Body) {
    let text = include_str!("../../models/laws/heat.pd");
    assert!(text.contains("meets series"));
    body.material = body.x.iter().map(|x| (x[0] > interface) as u8).collect();
    body.regions = vec![beyond(interface)];
    (laws::parse(&text.replace("meets series", rule)), body)
}

/// Conductivities on both sides.
const CONDUCT: [f64; 2] = [1.0, 40.0];

fn heat_engine(question: &Question, law: Law) -> Engine {
    let set = |k| {
        let capacity = [("k", k), ("density", 1.0), ("cv", 1.0)];
        laws::params(question.law, &capacity)
    };
    engine(question, &question.body, law, &CONDUCT.map(set))
}

/// Rates of the temperature for given temperatures, per node.
fn heating(engine: &mut Engine, temperatures: &[f64]) -> Vec<f64> {
    let mut state = engine.state();
    for (i, t) in temperatures.iter().enumerate() {
        state.slots[0][engine.slot(i)] = *t;
    }
    engine.forces(&mut state, Breaking::Held);
    let rate = engine.rates().next().expect("a rate").drive.to_vec();
    per_node(engine, &rate)
}

/// Temperature between layers at 0 and 1 in two conductors in a row.
fn in_series(x: f64, interface: f64, end: f64) -> f64 {
    let [k, l] = CONDUCT;
    let all = interface / k + (end - interface) / l;
    (x.min(interface) / k + (x - interface).max(0.0) / l) / all
}

/// Where conductors meet by the lengths of the bond in each, the heat through a bond is that of the series of its two
/// parts, and so the steady temperature of the local theory is that of the nodes, wherever between them the interface is.
#[test]
fn two_conductors_in_a_row_have_the_temperature_of_the_local_theory() {
    for flavour in [Flavour::Bar, Flavour::PlaneStrain, Flavour::Solid] {
        let shape = [
            24,
            [1, 9, 7][flavour.dim() - 1],
            [1, 1, 7][flavour.dim() - 1],
        ];
        let lattice = bodies::lattice(flavour, shape, false);
        let (dx, end) = (lattice.spacing, 24.0 * lattice.spacing);
        for part in [0.5, 0.8, 0.05] {
            let interface = (11.5 + part) * dx;
            let excess = |rule: &str| {
                let (law, body) = conductors(rule, lattice.clone(), interface);
                let mut question = Question::at_rest(&law, body);
                question.horizon = 3.015 * dx;
                let mut e = heat_engine(&question, question.interpreted());
                let x = question.body.x.clone();
                let steady: Vec<f64> = x.iter().map(|x| in_series(x[0], interface, end)).collect();
                // Against the heat that leaves through one side of a node.
                let scale = 0.5 * in_series(0.1 * dx, interface, end) / (0.1 * dx) / dx;
                let inner = |x: &[f64; 3]| {
                    let full =
                        |a: usize| x[a] > 3.1 * dx && x[a] < dx * f64::from(shape[a]) - 3.1 * dx;
                    (0..flavour.dim()).all(full)
                };
                let rates = heating(&mut e, &steady);
                let inside = x.iter().zip(&rates).filter(|(x, _)| inner(x));
                let worst = inside.fold((0, 0.0_f64), |(n, w), (_, r)| (n + 1, w.max(r.abs())));
                assert!(worst.0 > 10);
                worst.1 / scale
            };
            let [series, halves] = ["meets series", "meets harmonic"].map(excess);
            println!("{flavour:?} {part}: {series:.1e} {halves:.1e}");
            assert!(series < 1e-12, "{flavour:?} {part}: {series:e}");
            assert!(halves > 1e-2, "{flavour:?} {part}: {halves:e}");
        }
    }
}

/// The steady state itself, between two layers that are held: linear, so found by elimination.
#[test]
fn the_steady_temperature_of_a_bar_of_two_conductors() {
    let lattice = bodies::lattice(Flavour::Slab, [40, 1, 1], false);
    let (dx, end) = (lattice.spacing, 40.0 * lattice.spacing);
    let interface = 19.8 * dx;
    let error = |rule: &str| {
        let (law, body) = conductors(rule, lattice.clone(), interface);
        let mut question = Question::at_rest(&law, body);
        question.horizon = 3.015 * dx;
        let mut e = heat_engine(&question, question.interpreted());
        let exact = |i: usize| in_series(question.body.x[i][0], interface, end);
        let free: Vec<usize> = (3..37).collect();
        let held: Vec<f64> = (0..40)
            .map(|i| if free.contains(&i) { 0.0 } else { exact(i) })
            .collect();
        // rate(held) + sum_j T_j rate(e_j) = 0 at the free nodes.
        let unit = |j: usize| -> Vec<f64> { (0..40).map(|i| f64::from(i == j)).collect() };
        let load = heating(&mut e, &held);
        let columns: Vec<Vec<f64>> = free.iter().map(|j| heating(&mut e, &unit(*j))).collect();
        let mut rows: Vec<Vec<f64>> = free
            .iter()
            .map(|&i| {
                let row = columns.iter().map(|c| c[i]);
                row.chain([-load[i]]).collect()
            })
            .collect();
        let found = eliminate(&mut rows);
        let errors = free.iter().zip(found).map(|(i, t)| (t - exact(*i)).abs());
        errors.fold(0.0, f64::max)
    };
    let [series, halves, average] = ["meets series", "meets harmonic", ""].map(error);
    println!("largest error of the temperature: {series:.1e}, {halves:.1e}, {average:.1e}");
    assert!(series < 1e-12, "{series:e}");
    assert!(halves > 5e-3 && average > halves, "{halves:e} {average:e}");
}

/// Gauss, for a matrix whose diagonal dominates; the last column is the right-hand side.
fn eliminate(rows: &mut [Vec<f64>]) -> Vec<f64> {
    let n = rows.len();
    for k in 0..n {
        let pivot = rows[k].clone();
        for (_, row) in rows.iter_mut().enumerate().filter(|(i, _)| *i != k) {
            let factor = row[k] / pivot[k];
            row.iter_mut()
                .zip(&pivot)
                .for_each(|(r, p)| *r -= factor * p);
        }
    }
    rows.iter()
        .enumerate()
        .map(|(k, row)| row[n] / row[k])
        .collect()
}

/// Against sums written out here, with the lengths from plane geometry; compiled and interpreted to the same bits.
#[test]
fn lengths_in_either_material_are_those_of_geometry() {
    for flavour in [Flavour::Bar, Flavour::PlaneStress, Flavour::Solid] {
        let cloud = bodies::cloud(flavour, 5);
        let interface = cloud.x.iter().map(|x| x[0]).sum::<f64>() / cloud.x.len() as f64;
        for (rule, mean) in [
            (
                "meets series",
                (|[a, b]: [f64; 2], [fa, fb]: [f64; 2]| 1.0 / (fa / a + fb / b)) as fn(_, _) -> f64,
            ),
            ("meets (fa*sqrt(a) + fb*sqrt(b))^2", |[a, b], [fa, fb]| {
                (fa * a.sqrt() + fb * b.sqrt()).powi(2)
            }),
        ] {
            let (law, body) = conductors(rule, cloud.clone(), interface);
            let question = Question::at_rest(&law, body);
            let body = &question.body;
            let mut e = heat_engine(&question, question.interpreted());
            let mut compiled = heat_engine(&question, question.fastest());
            let t: Vec<f64> = (0..body.x.len()).map(|i| ((i * i) % 17) as f64).collect();
            let rates = heating(&mut e, &t);
            if rule == "meets series" {
                assert_eq!(rates, heating(&mut compiled, &t), "{question}");
            }
            let delta = question.horizon;
            let micro = match flavour.dim() {
                1 => 2.0 / (body.cross * delta.powi(2)),
                2 => 6.0 / (std::f64::consts::PI * body.cross * delta.powi(3)),
                _ => 6.0 / (std::f64::consts::PI * delta.powi(4)),
            };
            let heat = |i: usize, j: usize| {
                let (a, b) = (body.x[i], body.x[j]);
                let r = (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
                if i == j || r > delta {
                    return 0.0;
                }
                let k = [i, j].map(|n| CONDUCT[body.material[n] as usize]);
                let k = if k[0] == k[1] {
                    k[0]
                } else {
                    let fa = (interface - a[0]) / (b[0] - a[0]);
                    mean(k, [fa, 1.0 - fa])
                };
                micro * k * (t[j] - t[i]) / r * body.volume[j]
            };
            let (mut total, mut size) = (0.0, 0.0);
            for (i, rate) in rates.iter().enumerate() {
                let terms: Vec<f64> = (0..body.x.len()).map(|j| heat(i, j)).collect();
                let scale: f64 = terms.iter().map(|h| h.abs()).sum();
                let gap = (rate - terms.iter().sum::<f64>()).abs();
                assert!(gap <= 1e-12 * scale, "{question} {rule}: {:e}", gap / scale);
                total += rate * body.volume[i];
                size += scale * body.volume[i];
            }
            assert!(
                total.abs() <= 1e-14 * size,
                "{question}: {:e}",
                total / size
            );
        }
    }
}

/// Forces with stiffnesses by lengths: antisymmetric to the bit between two nodes.
#[test]
fn forces_by_lengths_are_the_same_from_both_ends() {
    let text = include_str!("../../models/laws/pmb.pd")
        .replace("pressure > 0 ", "pressure > 0 meets series ");
    let law = laws::parse(&text);
    let mut random = bodies::Random(11);
    for flavour in [Flavour::Bar, Flavour::PlaneStress, Flavour::Solid] {
        for _ in 0..20 {
            let mut body = bodies::lattice(flavour, [2, 1, 1], false);
            for x in &mut body.x {
                (0..flavour.dim()).for_each(|a| x[a] += 0.3 * body.spacing * random.signed());
            }
            let [a, b] = [body.x[0][0], body.x[1][0]];
            body.regions = vec![beyond(a + random.uniform() * (b - a))];
            body.material = vec![0, 1];
            let mut question = Question::deformed(&law, body, 1e-2, 5);
            question.horizon = 2.0 * question.body.spacing;
            let materials = [1e9, 40e9].map(|k| laws::params(&law, &[("K", k)]));
            let mut e = engine(
                &question,
                &question.body,
                question.interpreted(),
                &materials,
            );
            let mut s = state(&e, question.path.last().expect("a displacement"));
            e.forces(&mut s, Breaking::Held);
            let [f, g] = [0, 1].map(|i| gather(&e, e.force())[i]);
            assert!(f[0] != 0.0 && f == g.map(|c| -c), "{question}: {f:?} {g:?}");
        }
    }
}
