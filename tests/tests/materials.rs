//! Bodies of several materials: the force is still the derivative of the energy, momentum is kept, and what
//! meets on a bond meets as the law says.

use pdlang_models::language::Pdlang;
use pdlang_runtime::body::{Body, Flavour};
use pdlang_runtime::engine::{Breaking, Engine, Isa, Precision, Settings, State, Traversal};
use pdlang_runtime::scene::Scene;
use pdlang_tests::agreement::{Question, gather, per_node, spread};
use pdlang_tests::materials::{beyond, engine, graded, state, walked};
use pdlang_tests::{bodies, laws};

const LAWS: [&str; 5] = ["pmb", "pmb_compression", "gpmb", "lps", "lps_frozen"];

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
        precision: Precision::Double,
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
