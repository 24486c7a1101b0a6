//! Sums over bonds by convolution are those over the bonds one by one: forces, rates and tangents of every law that has
//! them, on boxes, bodies with holes and periodic bodies, of one to three dimensions.

use std::collections::{BTreeSet, HashSet};
use std::path::Path;
use std::sync::Arc;

use pdlang::assemble::{self, Kinematics};
use pdlang::ir::Law;
use pdlang_models::language::Pdlang;
use pdlang_models::registry::CATALOGUE;
use pdlang_runtime::body::Flavour;
use pdlang_runtime::engine::{self, Breaking, Isa, SetupError, Traversal};
use pdlang_runtime::scene::Scene;
use pdlang_runtime::simulate::Simulation;
use pdlang_tests::agreement::{Answer, Question, spec_for};
use pdlang_tests::{block, bodies, laws};

const STRAIN: f64 = 1e-2;

/// In a random state, all bonds whole and without limits.
fn questions(law: &Law) -> Vec<Question<'_>> {
    let mut list = Vec::new();
    for flavour in laws::flavours(law) {
        let shape = [[23, 1, 1], [11, 14, 1], [9, 8, 7]][flavour.dim() - 1];
        let bodies = [
            bodies::lattice(flavour, shape, false),
            bodies::carved(flavour, 1),
            bodies::lattice(flavour, shape, true),
        ];
        for (seed, body) in bodies.into_iter().enumerate() {
            let mut q = Question::deformed(law, body, STRAIN, seed as u64);
            q.broken = HashSet::new();
            q.horizon = 3.015 * q.body.spacing;
            for (value, param) in q.params.iter_mut().zip(&law.params) {
                if param.default == Some(f64::INFINITY) {
                    *value = f64::INFINITY;
                }
            }
            list.push(q);
        }
    }
    list
}

/// Largest difference relative to the largest number.
fn apart(a: &[f64], b: &[f64]) -> f64 {
    assert_eq!(a.len(), b.len());
    let size = a.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
    let apart = a
        .iter()
        .zip(b)
        .fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
    if apart == 0.0 { 0.0 } else { apart / size }
}

fn differences(a: &Answer, b: &Answer) -> [f64; 3] {
    let rates = a.rates.iter().zip(&b.rates);
    [
        apart(a.force.as_flattened(), b.force.as_flattened()),
        rates.fold(0.0, |m, (a, b)| m.max(apart(a, b))),
        apart(a.tangent.as_flattened(), b.tangent.as_flattened()),
    ]
}

/// What the sums of the law by convolution are, as far as it has any: the number of bodies that it took.
fn check(law: &Law, kinematics: Kinematics) -> usize {
    let (mut taken, mut worst) = (0, [0.0_f64; 3]);
    for q in questions(law) {
        let tapes = engine::Law::interpreted(spec_for(q.law, q.body.flavour.dim(), kinematics));
        let Ok(mut engine) = q.try_engine(tapes.clone(), Traversal::Convolution, None) else {
            continue;
        };
        taken += 1;
        assert_eq!(engine.report().traversal, "convolution");
        let answer = q.ask(&mut engine);
        let expected = q.ask(&mut q.engine(tapes, Traversal::Lattice, None));
        let found = differences(&expected, &answer);
        assert!(found.iter().all(|d| *d <= 1e-12), "{q}: {found:?}");
        worst = std::array::from_fn(|k| worst[k].max(found[k]));
        // The same energies, bond by bond, up to what they read of the force.
        assert!(apart(&expected.energy, &answer.energy) <= 1e-12, "{q}");
    }
    println!("{} {kinematics:?}: {taken} bodies, {worst:?}", law.name);
    taken
}

#[test]
fn sums_are_those_over_bonds() {
    let mut found = [Kinematics::General, Kinematics::Linearised].map(|_| BTreeSet::new());
    for entry in CATALOGUE {
        let law = laws::law(entry.name);
        for (kinematics, found) in [Kinematics::General, Kinematics::Linearised]
            .into_iter()
            .zip(&mut found)
        {
            if assemble::specs(&law, kinematics).is_ok() && check(&law, kinematics) > 0 {
                found.insert(entry.name);
            }
        }
    }
    println!("{found:#?}");
    for name in ["pmb", "lps", "heat", "correspondence_stabilised"] {
        assert!(found[1].contains(name), "{name}");
    }
    // Correspondence is not linear, but what it adds up over bonds is.
    assert!(found[0].contains("correspondence_svk"));
    assert!(!found[0].contains("pmb"));
}

fn linearised_lps(law: &Law) -> (Question<'_>, engine::Law) {
    let mut list = questions(law);
    let q = list.remove(list.len() - 2);
    let tapes =
        engine::Law::interpreted(spec_for(law, q.body.flavour.dim(), Kinematics::Linearised));
    (q, tapes)
}

#[test]
fn every_instruction_set_agrees() {
    let law = laws::law("lps");
    let (q, tapes) = linearised_lps(&law);
    let expected = q.ask(&mut q.engine(tapes.clone(), Traversal::Lattice, None));
    for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
        let answer = q.ask(&mut q.engine(tapes.clone(), Traversal::Convolution, Some(isa)));
        let found = differences(&expected, &answer);
        assert!(found.iter().all(|d| *d <= 1e-12), "{isa:?}: {found:?}");
    }
}

#[test]
fn bits_do_not_depend_on_threads() {
    let law = laws::law("lps");
    let (q, tapes) = linearised_lps(&law);
    let [a, b] = [1, 3].map(|threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("a pool");
        pool.install(|| q.ask(&mut q.engine(tapes.clone(), Traversal::Convolution, None)))
    });
    assert_eq!(a, b);
}

/// What a body does to itself adds up to nothing.
#[test]
fn momentum_is_kept() {
    for name in ["pmb", "lps", "correspondence_stabilised"] {
        let law = laws::law(name);
        for q in questions(&law) {
            let tapes = engine::Law::interpreted(spec_for(
                &law,
                q.body.flavour.dim(),
                Kinematics::Linearised,
            ));
            let force = q
                .ask(&mut q.engine(tapes, Traversal::Convolution, None))
                .force;
            let size: f64 = force.as_flattened().iter().map(|f| f.abs()).sum();
            for a in 0..3 {
                let sum: f64 = force.iter().map(|f| f[a]).sum();
                assert!(sum.abs() <= 1e-13 * size, "{q}: {:e}", sum / size);
            }
        }
    }
}

/// A convolution takes all bonds as they were. Where some are broken, they are walked one by one, to the same bits.
#[test]
fn broken_bonds_are_walked() {
    let law = laws::law("lps");
    let (mut q, tapes) = linearised_lps(&law);
    q.broken = bodies::broken_pairs(&q.body, 0.1, 5);
    let [a, b] = [Traversal::Lattice, Traversal::Convolution]
        .map(|t| q.ask(&mut q.engine(tapes.clone(), t, None)));
    assert_eq!(a, b);
    // And when a whole state comes again, it is convolved again.
    let mut engine = q.engine(tapes.clone(), Traversal::Convolution, None);
    q.ask(&mut engine);
    q.broken.clear();
    let again = q.ask(&mut engine);
    assert_eq!(
        again,
        q.ask(&mut q.engine(tapes, Traversal::Convolution, None))
    );
}

/// A translation strains nothing; here, unlike bond by bond, that holds up to rounding.
#[test]
fn translations_leave_rounding() {
    let law = laws::law("lps");
    let (mut q, tapes) = linearised_lps(&law);
    let u = q.path[0].clone();
    let mut engine = q.engine(tapes, Traversal::Convolution, None);
    let expected = q.ask(&mut engine).force;
    let by = 10.0 * q.body.spacing;
    q.path[0] = u.iter().map(|u| u.map(|c| c + by)).collect();
    let moved = q.ask(&mut engine).force;
    let size = expected
        .as_flattened()
        .iter()
        .fold(0.0, |m: f64, f| m.max(f.abs()));
    assert!(block::largest_difference(&moved, &expected) <= 1e-11 * size);
}

/// A position is that of the node and the bond: also of an image, and of images of one node.
#[test]
fn positions_at_the_other_end_are_those_of_images() {
    let text = r#"model placed "Reads positions" cite "Nobody, eq. 1" {
  field T : temperature "temperature"
  param k : [1/(m^4*s)] > 0 "factor"
  rate T = k*sum(X'.x*(T' - T))
}"#;
    let law = laws::parse(text);
    assert!(check(&law, Kinematics::General) > 0);
}

/// Bonds of which the opposite is not one, products of numbers of one end and of both, and powers.
#[test]
fn bonds_may_lead_one_way() {
    let text = r#"model one_way "Upwind" cite "Nobody, eq. 1" {
  field T : number "transported"
  field v : number "speed"
  param k : [1/(m^3*s)] > 0 "factor"
  family behind = horizon where xi.x < 0.3*x
  rate T = k*sum[behind](v*T' - v'*T^2 + 2*T'^2*v' + exp(-x/delta)*T)
}"#;
    assert!(check(&laws::parse(text), Kinematics::General) > 0);
}

/// A wave in a plate with a hole.
fn scene(traversal: &str, law: &str, material: &str) -> Simulation {
    let text = format!(
        r#"
[let]
L = "60 mm"
[body]
flavour = "plane_strain"
spacing = "1 mm"
thickness = "1 mm"
shape = {{ difference = [{{ box = {{ from = [0, 0], to = ["L", "L/2"] }} }}, {{ disc = {{ center = ["L/3", "L/4"], radius = "5 mm" }} }}] }}
[family]
horizon = "5.015 dx"
traversal = "{traversal}"
[material]
model = "{law}"
density = "2200 kg/m^3"
{material}
linearised = true
[[initial]]
velocity = ["1 [m/s]*exp(-((x - L/2)^2 + (y - L/5)^2)/(3 [mm])^2)", "0.3 [m/s]*exp(-((x - L/2)^2 + (y - L/5)^2)/(3 [mm])^2)"]
[[condition]]
region = {{ box = {{ from = [0, 0], to = ["2*dx", "L"] }} }}
velocity = [0, 0]
[time]
steps = 400
"#
    );
    let scene = Scene::parse(&text, Path::new("wave.toml"), &Pdlang);
    let scene = scene.unwrap_or_else(|e| panic!("{}", e.render(false)));
    scene
        .simulation()
        .unwrap_or_else(|e| panic!("{}", e.render(false)))
}

#[test]
fn runs_go_the_same_way() {
    for (law, material) in [
        ("pmb", "K = \"14.9 GPa\""),
        ("lps", "K = \"14.9 GPa\"\nG = \"8 GPa\""),
    ] {
        let [direct, convolved] = ["lattice", "convolution"].map(|traversal| {
            let mut simulation = scene(traversal, law, material);
            simulation.run(&mut ()).unwrap_or_else(|e| panic!("{e}"));
            simulation
        });
        assert_eq!(direct.state.step, 400);
        for (a, b) in direct.state.u.iter().zip(&convolved.state.u) {
            let found = apart(a, b);
            println!("{law}: {found:e}");
            assert!(found <= 1e-10, "{law}: {found:e}");
        }
        let energies =
            [&direct, &convolved].map(|s| s.row.kinetic + s.row.strain.expect("an energy"));
        assert!(
            (energies[0] - energies[1]).abs() <= 1e-10 * energies[0],
            "{energies:?}"
        );
    }
}

#[test]
fn flat_bodies_are_taken() {
    let law = laws::law("pmb");
    for shape in [
        [20, 1, 1],
        [1, 20, 1],
        [1, 1, 20],
        [1, 12, 9],
        [12, 1, 9],
        [12, 9, 1],
        [2, 3, 4],
    ] {
        let body = bodies::lattice(Flavour::Solid, shape, false);
        let mut q = Question::deformed(&law, body, STRAIN, 3);
        q.broken.clear();
        q.params = laws::params(&law, &[("s0", f64::INFINITY)]);
        let tapes = engine::Law::interpreted(spec_for(&law, 3, Kinematics::Linearised));
        let [a, b] = [Traversal::Lattice, Traversal::Convolution]
            .map(|t| q.ask(&mut q.engine(tapes.clone(), t, None)));
        let found = differences(&a, &b);
        assert!(found.iter().all(|d| *d <= 1e-12), "{shape:?}: {found:?}");
    }
}

/// Two evaluations of one engine, of different states.
#[test]
fn nothing_is_left_of_the_state_before() {
    let law = laws::law("lps");
    let (q, tapes) = linearised_lps(&law);
    let mut engine = q.engine(tapes, Traversal::Convolution, None);
    let mut state = q.state(&mut engine);
    engine.forces(&mut state, Breaking::Held);
    let first = engine.force().to_vec();
    for u in state.u.iter_mut().flatten() {
        *u *= 2.0;
    }
    engine.forces(&mut state, Breaking::Held);
    for (a, b) in first.iter().flatten().zip(engine.force().iter().flatten()) {
        assert_eq!(2.0 * a, *b);
    }
}

/// Why the law is refused in the first body in question, and what to do about it.
fn refusal(law: &Law, kinematics: Kinematics) -> Option<String> {
    let q = questions(law).swap_remove(0);
    let tapes = engine::Law::interpreted(spec_for(law, q.body.flavour.dim(), kinematics));
    let made = q.try_engine(tapes, Traversal::Convolution, None);
    made.err().map(|e| match e {
        SetupError::Traversal(why, remedy) => format!("{why}: {remedy}"),
        other => panic!("{other}"),
    })
}

const LINEARISED: &str = "try `linearised = true` in [material], or use `lattice`";

/// Laws of the catalogue: why not, as they are and at small displacements, and whether these are worth a try.
#[test]
fn refusals_say_why() {
    let cases = [
        ("pmb", "`force` of `pmb` takes a root", true, None),
        ("lps", "`theta` of `lps` takes a root", true, None),
        ("correspondence_svk", "", false, None),
        ("heat", "", false, None),
        // Memories of a layer are stored where they live, and a convolution has all nodes at once.
        (
            "absorbing",
            "takes a field that lives on a part of the body",
            false,
            Some("a field that lives on a part"),
        ),
        // How many fibre bonds a node has is summed at every step, as the angle may change, and divided by.
        (
            "laminate",
            "takes the inverse of a sum",
            false,
            Some("the inverse of a sum"),
        ),
        (
            "solid",
            "takes a history, a weight or a reverse value of single bonds",
            false,
            Some("a history, a weight"),
        ),
        ("lps_plastic", "takes a root of a sum", false, None),
        ("lps_viscoelastic", "takes a root", false, None),
    ];
    for (name, general, deformed, small) in cases {
        let law = laws::law(name);
        match refusal(&law, Kinematics::General) {
            None => assert!(general.is_empty(), "{name} is taken"),
            Some(why) => {
                assert!(
                    !general.is_empty() && why.contains(general),
                    "{name}: {why}"
                );
                assert_eq!(why.ends_with(LINEARISED), deformed, "{why}");
            }
        }
        if assemble::specs(&law, Kinematics::Linearised).is_ok() {
            let why = refusal(&law, Kinematics::Linearised);
            assert_eq!(why.is_some(), small.is_some(), "{name}: {why:?}");
            let contains = |what: &str| why.is_some_and(|why| why.contains(what));
            assert!(small.is_none_or(contains), "{name}");
        }
    }
}

/// A law of one temperature-like field `T` and the displacement, with these definitions.
fn coupled(rest: &str) -> Law {
    laws::parse(&format!(
        "model coupled \"Of both\" cite \"Nobody, eq. 1\" {{
  influence omega = constant
  field T : number \"number\"
  param k : [N/m^7] > 0 \"stiffness\"
  param h : [1/(m^3*s)] > 0 \"factor\"
  node ext : number = sum(omega*dot(xi, eta)/x^2)/sum(omega)
  {rest}
}}"
    ))
}

/// What a sum's last digits decide, and products of displacements: refused, with a way out where there is one.
#[test]
fn what_rounding_decides_is_refused() {
    let force = |of: &str| format!("state t : vector = k*({of})*xi");
    let rate = |of: &str| format!("rate T = h*sum({of})");
    let cases = [
        (force("ext/(1 + ext)"), "the inverse of a sum", true),
        (force("ext*sqrt(1 + ext)"), "a root of a sum", true),
        (force("ln(1 + ext)"), "the logarithm of a sum", true),
        (
            force("select(ext > 0, 2, 1)*ext"),
            "a choice by a sum",
            true,
        ),
        (
            rate("dot(eta, eta)/x^2"),
            "a product of displacements",
            true,
        ),
        (rate("norm(eta)/x"), "a root", true),
        (rate("T'/(1 + T'^2)"), "a division", false),
        (rate("select(T' > T, T', T)"), "a choice", false),
    ];
    for (rest, what, deformed) in cases {
        let law = coupled(&rest);
        let why = refusal(&law, Kinematics::General).unwrap_or_else(|| panic!("{rest} is taken"));
        assert!(why.contains(&format!(" takes {what}: ")), "{rest}: {why}");
        assert_eq!(why.ends_with(LINEARISED), deformed, "{rest}: {why}");
    }
    // The same without what is rough.
    assert!(check(&coupled(&force("ext")), Kinematics::General) > 0);
    assert!(check(&coupled(&rate("T' + ext*T")), Kinematics::General) > 0);
    // At small displacements they are polynomials.
    for rest in [
        force("ext/(1 + ext)"),
        force("ext*sqrt(1 + ext)"),
        force("ln(1 + ext)"),
    ] {
        assert!(check(&coupled(&rest), Kinematics::Linearised) > 0, "{rest}");
    }
}

/// A bond of another family than the first: all sums are walked, as those of the first may have steady sums of the other in them.
#[test]
fn a_broken_second_family_is_walked() {
    let law = laws::parse(
        r#"model two "Of two families" cite "Nobody, eq. 1" {
  field T : number "number"
  param k : [1/(m^6*s)] > 0 "factor"
  family near = horizon where x < 0.6*delta
  node w = sum[near](x)/sum0[near](x)
  rate T = k*(sum(w*T' - w'*T)*sum[near](1) + sum[near](T' - T)*sum(1))
}"#,
    );
    for q in questions(&law) {
        let tapes =
            engine::Law::interpreted(spec_for(&law, q.body.flavour.dim(), Kinematics::General));
        let mut engines =
            [Traversal::Lattice, Traversal::Convolution].map(|t| q.engine(tapes.clone(), t, None));
        let [direct, convolved] = engines.each_mut().map(|engine| {
            let mut state = q.state(engine);
            let mut rates = vec![];
            // Whole, a row of bonds of the second family broken at its first node, and whole again.
            for broken in [false, true, false] {
                let mut at = state.clone();
                if broken {
                    let near = &mut at.families[1];
                    let row = near.intact.iter().position(|bits| *bits != 0);
                    Arc::make_mut(&mut near.intact)[row.expect("a bond")] = 0;
                    near.touch();
                }
                engine.forces(&mut at, Breaking::Held);
                let rate = engine.rates().next().expect("a rate");
                rates.push(engine.spread(rate.slot, &rate.whole(&at)).into_owned());
            }
            state.step += 1;
            rates
        });
        assert_eq!(direct[1], convolved[1], "{q}: walked to the same bits");
        assert!(
            apart(&direct[0], &direct[1]) > 1e-6,
            "{q}: what is broken is missed"
        );
        assert!(apart(&direct[2], &convolved[2]) <= 1e-12, "{q}");
        assert_eq!(convolved[0], convolved[2], "{q}");
    }
}
