//! Bodies of several materials: the force is still the derivative of the energy, momentum is kept, and what
//! meets on a bond meets as the law says.

use pdlang_models::language::Pdlang;
use pdlang_runtime::body::{Body, Flavour};
use pdlang_runtime::engine::{Breaking, Engine, Isa, Law, Settings, State, Traversal};
use pdlang_runtime::scene::Scene;
use pdlang_runtime::shape::Shape;
use pdlang_runtime::spec::InfluenceSpec;
use pdlang_tests::agreement::{Question, gather, per_node, spread};
use pdlang_tests::{bodies, laws};

const LAWS: [&str; 5] = ["pmb", "pmb_compression", "gpmb", "lps", "lps_frozen"];

fn engine(question: &Question, body: &Body, law: Law, materials: &[Vec<f64>]) -> Engine {
    graded(question, body, law, materials, &[1.0])
}

/// `horizons`: of every material, in those of the question.
fn graded(
    question: &Question,
    body: &Body,
    law: Law,
    materials: &[Vec<f64>],
    horizons: &[f64],
) -> Engine {
    walked(
        question,
        body,
        law,
        materials,
        horizons,
        (Traversal::Auto, Isa::Scalar),
    )
}

fn walked(
    question: &Question,
    body: &Body,
    law: Law,
    materials: &[Vec<f64>],
    horizons: &[f64],
    (traversal, isa): (Traversal, Isa),
) -> Engine {
    let chosen = |i: &InfluenceSpec| i.default.clone().map(|f| (f, vec![]));
    let constant = |i: &InfluenceSpec| {
        let (f, values) = laws::influence("constant");
        chosen(i).unwrap_or((pdlang_tests::agreement::influence(&f), values))
    };
    let settings = Settings {
        materials: materials.to_vec(),
        influences: law.spec.influences.iter().map(constant).collect(),
        horizon: horizons.iter().map(|h| h * question.horizon).collect(),
        horizon_levels: 64,
        partial_volume: false,
        lattice_constants: false,
        without: vec![],
        traversal,
        isa: Some(isa),
    };
    Engine::new(body, law, settings).expect("the body is valid")
}

/// Every third node is of a material with other moduli.
fn mixed(body: &Body) -> Body {
    let of = |node: usize| u8::from(node.is_multiple_of(3)) * 2;
    Body {
        material: (0..body.x.len()).map(of).collect(),
        ..body.clone()
    }
}

fn three(law: &pdlang::ir::Law) -> [Vec<f64>; 3] {
    [(14.9e9, 6e9), (1e9, 1e9), (40e9, 11e9)].map(|(k, g)| laws::params(law, &[("K", k), ("G", g)]))
}

fn state(engine: &Engine, u: &[[f64; 3]]) -> State {
    let mut state = engine.state();
    spread(engine, u, &mut state.u);
    state
}

fn total_energy(engine: &mut Engine, state: &mut State) -> f64 {
    engine.forces(state, Breaking::Held);
    let volume = engine.volume().to_vec();
    let energy = engine.energy(state);
    energy.iter().zip(&volume).map(|(e, v)| e * v).sum()
}

#[test]
fn equal_materials_are_one_material() {
    for name in LAWS {
        let law = laws::law(name);
        for flavour in Flavour::ALL {
            let question = Question::deformed(&law, bodies::carved(flavour, 3), 1e-2, 7);
            let same = vec![three(&law)[0].clone(); 3];
            let mut one = engine(
                &question,
                &question.body,
                question.interpreted(),
                &same[..1],
            );
            let mut many = engine(
                &question,
                &mixed(&question.body),
                question.interpreted(),
                &same,
            );
            let u = question.path.last().expect("a displacement");
            let force = [&mut one, &mut many].map(|e| {
                let mut s = state(e, u);
                e.forces(&mut s, Breaking::Held);
                gather(e, e.force())
            });
            let size = force[0]
                .iter()
                .flatten()
                .fold(0.0_f64, |m, f| m.max(f.abs()));
            let gap = force[0].iter().flatten().zip(force[1].iter().flatten());
            let gap = gap.fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
            assert!(gap <= 1e-12 * size, "{question}: {:e}", gap / size);
        }
    }
}

/// Energies whose constants stand before a sum: beside a node value, and inside of a named one.
const CONSTANTS: [&str; 2] = [
    "field d : number  \"damage\"
     energy W = (1 - d)^2*c/4*sum(x*s^2)",
    "node w = c/4*sum(x*s^2) + 3*c/4*sum(x^3*s^2)/delta^2
     energy W = w",
];

#[test]
fn forces_are_derivatives_of_the_energy_and_keep_momentum() {
    let bare = |energy: &&str| {
        laws::parse(&format!(
            "model bare \"Bond-based\" cite \"This test, eq. 1\" {{
               param K : pressure > 0  \"bulk modulus\"
               let c = 2*dim^2*K_bb(K)/ball(x)
               {energy}
             }}"
        ))
    };
    let catalogue = LAWS.iter().map(|name| laws::law(name));
    for law in catalogue.chain(CONSTANTS.iter().map(bare)) {
        for flavour in Flavour::ALL {
            let question = Question::deformed(&law, bodies::cloud(flavour, 3), 1e-2, 7);
            let body = mixed(&question.body);
            let horizons = [1.0, 0.8, 1.3];
            let law = question.fastest();
            let mut e = graded(&question, &body, law, &three(question.law), &horizons);
            let u = question.path.last().expect("a displacement");
            let mut here = state(&e, u);
            e.forces(&mut here, Breaking::Held);
            let force = e.force().to_vec();
            let volume = e.volume().to_vec();
            let du = state(&e, &question.du).u;
            let mut work = 0.0;
            for (a, f) in force.iter().enumerate() {
                let (mut total, mut size) = (0.0, 0.0);
                for (s, v) in volume.iter().enumerate() {
                    work -= f[s] * du[a][s] * v;
                    total += f[s] * v;
                    size += (f[s] * v).abs();
                }
                assert!(
                    total.abs() <= 1e-13 * size,
                    "{question}: momentum {:e}",
                    total / size
                );
            }
            let h = 1e-4;
            let [plus, minus] = [h, -h].map(|h| {
                let mut moved = here.clone();
                for (u, d) in moved.u.iter_mut().zip(&du) {
                    u.iter_mut().zip(d).for_each(|(u, d)| *u += h * d);
                }
                total_energy(&mut e, &mut moved)
            });
            let slope = (plus - minus) / (2.0 * h);
            assert!(
                (slope - work).abs() <= 1e-6 * work.abs(),
                "{question}: {slope:e} {work:e}"
            );
        }
    }
}

/// A bond exists where it is no longer than the average of the horizons of its ends; away from the interface each part
/// is what a body of its horizon alone would be.
#[test]
fn a_part_has_its_own_horizon() {
    for name in LAWS {
        let law = laws::law(name);
        for flavour in [Flavour::Bar, Flavour::PlaneStrain] {
            let side = [24, 11, 1];
            let shape = std::array::from_fn(|a| if a < flavour.dim() { side[a] } else { 1 });
            let mut question = Question::at_rest(&law, bodies::lattice(flavour, shape, false));
            question.horizon = question.body.spacing;
            let (dx, x) = (question.body.spacing, question.body.x.clone());
            let middle = 0.5 * (x[0][0] + x[x.len() - 1][0]);
            let material: Vec<u8> = x.iter().map(|x| (x[0] > middle) as u8).collect();
            let horizons = [3.015, 2.015];
            let set = three(&law)[0].clone();
            let parts = Body {
                material: material.clone(),
                ..question.body.clone()
            };
            let expanded: Vec<[f64; 3]> = x.iter().map(|x| x.map(|c| 1e-3 * c)).collect();
            let energies = |body: &Body, materials: usize, horizons: &[f64]| {
                let materials = vec![set.clone(); materials];
                let mut e = graded(
                    &question,
                    body,
                    question.interpreted(),
                    &materials,
                    horizons,
                );
                let mut s = state(&e, &expanded);
                e.forces(&mut s, Breaking::Held);
                let bonds = e.report().bonds;
                let energy = e.energy(&s).to_vec();
                (bonds, per_node(&e, &energy))
            };
            let (bonds, mixed) = energies(&parts, 2, &horizons);
            let near = |i: usize, j: usize| {
                let of = |k: usize| horizons[material[k] as usize];
                let r2: f64 = (0..3).map(|a| (x[i][a] - x[j][a]).powi(2)).sum();
                i != j && r2.sqrt() <= 0.5 * (of(i) + of(j)) * dx
            };
            let pairs = (0..x.len()).flat_map(|i| (0..x.len()).map(move |j| (i, j)));
            assert_eq!(
                bonds,
                pairs.filter(|&(i, j)| near(i, j)).count(),
                "{question}"
            );
            for m in [0, 1] {
                let (_, alone) = energies(&question.body, 1, &horizons[m..=m]);
                let far =
                    |i: &usize| material[*i] == m as u8 && (x[*i][0] - middle).abs() > 6.1 * dx;
                let nodes: Vec<usize> = (0..x.len()).filter(far).collect();
                assert!(!nodes.is_empty());
                for i in nodes {
                    let gap = (mixed[i] - alone[i]).abs();
                    assert!(gap <= 1e-12 * alone[i], "{question}: {gap:e}");
                }
            }
        }
    }
}

/// On a grid several materials are rows of several kinds; as a cloud, bonds with values of their own. The answers are
/// the same, before bonds break, while they do and after, with histories that are read from both ends.
#[test]
fn a_lattice_of_several_materials_answers_as_a_cloud() {
    let others = [
        "lps_plastic",
        "lps_viscoelastic",
        "lamina",
        "thermo_lps",
        "correspondence_stabilised",
        "solid",
    ];
    for name in LAWS.into_iter().chain(others) {
        let law = laws::law(name);
        for flavour in laws::flavours(&law) {
            for periodic in [false, true] {
                let body = match periodic {
                    true => bodies::lattice(
                        flavour,
                        std::array::from_fn(|a| if a < flavour.dim() { [11, 5, 4][a] } else { 1 }),
                        true,
                    ),
                    false => bodies::carved(flavour, 3),
                };
                let question = Question::deformed(&law, body, 1e-2, 7);
                let body = mixed(&question.body);
                let horizons = [1.0, 0.8, 1.3];
                let sets = [(14.9e9, 6e9), (1e9, 1e9), (40e9, 11e9)];
                let limit = question.largest_stretch() * 0.9;
                let sets =
                    sets.map(|(k, g)| laws::params(&law, &[("K", k), ("G", g), ("s0", limit)]));
                let mut answers = vec![];
                for walk in [
                    (Traversal::Cloud, Isa::Scalar),
                    (Traversal::Lattice, Isa::Scalar),
                    (Traversal::Lattice, Isa::best()),
                ] {
                    let law = question.fastest();
                    let mut e = walked(&question, &body, law, &sets, &horizons, walk);
                    let mut s = e.state();
                    s.dt = 1e-7;
                    for (i, slot) in e.slots().to_vec().into_iter().enumerate() {
                        let fields = s.slots.iter_mut();
                        fields.for_each(|q| q[slot as usize] += 1e-4 * (i % 7) as f64);
                    }
                    let mut counts = vec![e.report().bonds];
                    let mut values: Vec<Vec<f64>> = vec![];
                    for u in &question.path {
                        spread(&e, u, &mut s.u);
                        counts.push(e.forces(&mut s, Breaking::Armed));
                        values.push(gather(&e, e.force()).into_iter().flatten().collect());
                        values.extend(e.rates().map(|r| per_node(&e, &r.whole(&s))));
                        let energy = e.energy(&s).to_vec();
                        if !energy.is_empty() {
                            values.push(per_node(&e, &energy));
                        }
                        counts.push(e.commit(&mut s));
                    }
                    answers.push((counts, values));
                }
                let size = |v: &[f64]| v.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
                let (counts, values) = &answers[0];
                for (others, other) in &answers[1..] {
                    assert_eq!(others, counts, "{question}");
                    for (a, b) in values.iter().zip(other) {
                        let gap: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
                        let off = size(&gap) / size(a).max(f64::MIN_POSITIVE);
                        assert!(off <= 1e-11, "{question}, periodic {periodic}: {off:e}");
                    }
                }
            }
        }
    }
}

/// All points with a larger x.
fn beyond(x: f64) -> Shape {
    let all = f64::INFINITY;
    Shape::Box {
        from: [x, -all, -all],
        to: [all; 3],
    }
}

/// Two cells that conduct, and meet at a quarter of their bond: the bond has the mean that the law names, the capacity is
/// each node's own.
#[test]
fn parameters_meet_as_the_law_says() {
    let text = include_str!("../fixtures/laws/bond_heat.pd");
    for (words, mean) in [
        ("", 2.0),
        ("meets harmonic", 1.5),
        ("meets min", 1.0),
        ("meets max", 3.0),
        ("meets 2*a*b/(a + b)", 1.5),
        ("meets sqrt(a*b)", 3.0_f64.sqrt()),
        ("meets series", 2.0),
        ("meets 1/(fa/a + fb/b)", 2.0),
        ("meets fa*a + fb*b", 2.5),
        ("meets a*(b/a)^fb", 3.0_f64.powf(0.75)),
    ] {
        let law =
            laws::parse(&text.replace("conductivity > 0 ", &format!("conductivity > 0 {words} ")));
        let mut question = Question::at_rest(&law, bodies::lattice(Flavour::Bar, [2, 1, 1], false));
        question.horizon = 1.5 * question.body.spacing;
        let rates = |k: [f64; 2]| {
            let set = |k, rho| laws::params(&law, &[("k", k), ("rho", rho), ("cv", 1.0)]);
            let body = Body {
                material: vec![0, 1],
                regions: vec![beyond(question.body.x[0][0] + 0.25 * question.body.spacing)],
                ..question.body.clone()
            };
            let materials = [set(k[0], 1.0), set(k[1], 10.0)];
            let mut e = engine(&question, &body, question.interpreted(), &materials);
            let mut s = e.state();
            s.slots[0][e.slot(1)] = 1.0;
            e.forces(&mut s, Breaking::Held);
            let rate = e.rates().next().expect("a rate").drive.to_vec();
            per_node(&e, &rate)
        };
        let (same, other) = (rates([1.0, 1.0]), rates([1.0, 3.0]));
        assert!(
            (other[0] / same[0] - mean).abs() < 1e-12,
            "{words}: {other:?} {same:?}"
        );
        assert!(
            (other[1] / same[1] - mean).abs() < 1e-12,
            "{words}: {other:?} {same:?}"
        );
        assert!((other[0] + 10.0 * other[1]).abs() < 1e-12 * other[0].abs());
    }
}

#[test]
fn no_heat_is_made_where_materials_meet() {
    for name in ["heat", "heat_state", "thermo_pmb", "thermo_lps"] {
        let law = laws::law(name);
        for flavour in [Flavour::Bar, Flavour::PlaneStress, Flavour::Solid] {
            let question = Question::at_rest(&law, bodies::cloud(flavour, 3));
            let body = mixed(&question.body);
            let set =
                |k, density| laws::params(&law, &[("k", k), ("density", density), ("cv", 3.0)]);
            let materials = [(1.0, 2.0), (1.0, 1.0), (50.0, 7.0)];
            let sets = materials.map(|(k, density)| set(k, density));
            let mut e = engine(&question, &body, question.fastest(), &sets);
            let mut s = e.state();
            let values: Vec<f64> = (0..body.x.len()).map(|i| ((i * i) % 17) as f64).collect();
            for (i, v) in values.iter().enumerate() {
                s.slots[0][e.slot(i)] = *v;
            }
            e.forces(&mut s, Breaking::Held);
            let rate = e.rates().next().expect("a rate").drive.to_vec();
            let (mut total, mut size) = (0.0, 0.0);
            for (i, rate) in per_node(&e, &rate).iter().enumerate() {
                let heat = rate * body.volume[i] * materials[body.material[i] as usize].1 * 3.0;
                total += heat;
                size += heat.abs();
            }
            assert!(
                size > 0.0 && total.abs() <= 1e-13 * size,
                "{question}: {:e}",
                total / size
            );
        }
    }
}

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

#[test]
fn wrong_materials_are_refused() {
    let law = laws::law("pmb");
    let question = Question::at_rest(&law, bodies::lattice(Flavour::Bar, [9, 1, 1], false));
    let body = Body {
        material: vec![2; 9],
        ..question.body.clone()
    };
    let settings = |materials| Settings {
        materials,
        influences: vec![],
        horizon: vec![question.horizon],
        horizon_levels: 64,
        partial_volume: false,
        lattice_constants: false,
        without: vec![],
        traversal: Traversal::Auto,
        isa: None,
    };
    let set = laws::params(&law, &[]);
    for (materials, words) in [
        (vec![], "0 materials"),
        (vec![set.clone(); 2], "of material 2"),
    ] {
        let error = Engine::new(&body, question.interpreted(), settings(materials)).unwrap_err();
        assert!(error.to_string().contains(words), "{error}");
    }
}

/// A wave long against the horizon crosses an interface as in the local theory: see the scene.
#[test]
fn a_wave_crosses_from_one_material_into_another() {
    let path = std::path::Path::new("scenes/two_materials.toml");
    let scene = Scene::read(path, &Pdlang).unwrap_or_else(|e| panic!("{e}"));
    let mut simulation = scene.simulation().unwrap_or_else(|e| panic!("{e}"));
    simulation.run(&mut ()).unwrap_or_else(|e| panic!("{e}"));
    let u = per_node(&simulation.engine, &simulation.state.u[0]);
    let peak = |from: f64, to: f64| {
        let inside = simulation.body.x.iter().zip(&u);
        inside
            .filter(|(x, _)| x[0] > from && x[0] < to)
            .fold(0.0_f64, |m, (_, u)| if u.abs() > m.abs() { *u } else { m })
    };
    // Half of the pulse runs to the right, 0.5 high: a quarter of it goes through, a quarter comes back.
    let (through, back) = (peak(620.0, 1000.0), peak(200.0, 590.0));
    println!("through {through:.5}, back {back:.5}");
    assert!((through - 0.25).abs() < 2e-3, "{through}");
    assert!((back + 0.25).abs() < 2e-3, "{back}");
}
