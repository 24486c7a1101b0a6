//! What must hold between laws, and for every law: equal laws agree, the derived force is the published one,
//! nothing happens where nothing is deformed.

use pdlang::ir::{BinaryOp, Expr, ExprId, ExprKind, InfluenceFn};
use pdlang_runtime::body::{Body, Flavour};
use pdlang_runtime::engine::{Breaking, Traversal};
use pdlang_runtime::spec::Stage;
use pdlang_tests::agreement::{Question, gather, spec};
use pdlang_tests::naive::{self, Lps};
use pdlang_tests::{block, bodies, laws};

/// omega(r)/r: what LPS needs to be GPMB with omega.
fn over_length((mut f, values): (InfluenceFn, Vec<f64>)) -> (InfluenceFn, Vec<f64>) {
    let body = f.exprs[f.body.index()].clone();
    let mut push = |kind| {
        f.exprs.push(Expr {
            kind,
            ..body.clone()
        });
        ExprId(f.exprs.len() as u32 - 1)
    };
    let r = push(ExprKind::Var(0));
    let quotient = push(ExprKind::Binary(BinaryOp::Div, f.body, r));
    f.body = quotient;
    (f, values)
}

/// Seleson and Parks 2011, section 3.2: with the Poisson ratio of bond-based laws the dilatation cancels, and
/// with constants from the same lattice sums the two laws are one. In bars uniaxial stress is no such case.
#[test]
fn gpmb_is_lps_at_its_poisson_ratio() {
    // G of nu = 1/4, and of nu = 1/3 in plane stress, where E = K.
    let cases = [
        (Flavour::Slab, 0.6),
        (Flavour::PlaneStress, 0.375),
        (Flavour::PlaneStrain, 0.6),
        (Flavour::Solid, 0.6),
    ];
    let (gpmb, lps) = (laws::law("gpmb"), laws::law("lps"));
    for (flavour, ratio) in cases {
        for influence in ["constant", "softened(p = 3, eps = 0.5 mm)"] {
            let shape = std::array::from_fn(|a| if a < flavour.dim() { 6 } else { 1 });
            let body = bodies::lattice(flavour, shape, true);
            let u = bodies::deformation(&body, 1e-2, 3);
            let ask = |law, params: &[(&str, f64)], influence| {
                let mut question = Question::at_rest(law, body.clone()).with(params);
                question.influences = vec![influence];
                (question.lattice_constants, question.path) = (true, vec![u.clone()]);
                question
            };
            let bond_based = ask(&gpmb, &[("K", 1e10)], laws::influence(influence));
            let state_based = ask(
                &lps,
                &[("K", 1e10), ("G", ratio * 1e10)],
                over_length(laws::influence(influence)),
            );
            let scale = bond_based
                .consult(|oracle, _, state| oracle.force_scale(state))
                .expect("a force");
            for traversal in [Traversal::Lattice, Traversal::Cloud] {
                let [a, b] = [&bond_based, &state_based]
                    .map(|q| q.ask(&mut q.engine(q.interpreted(), traversal, None)));
                let force = block::largest_difference(&a.force, &b.force) / scale;
                let gap = |(a, b): (&f64, &f64)| (a / b - 1.0).abs();
                let energy = a.energy.iter().zip(&b.energy).map(gap).fold(0.0, f64::max);
                println!("{bond_based} {traversal:?}: force {force:.1e}, energy {energy:.1e}");
                assert!(
                    force <= 1e-13 && energy <= 1e-12,
                    "force {force:e}, energy {energy:e}"
                );
            }
        }
    }
}

/// Silling et al. 2007, eq. 108, summed from both ends; with the live weighted volume of `lps`, and with that
/// of the reference family of `lps_frozen`, before and after bonds broke.
#[test]
fn the_derived_force_is_the_published_one() {
    for (name, share) in [
        ("lps", 0.0),
        ("lps", 0.2),
        ("lps_frozen", 0.0),
        ("lps_frozen", 0.2),
    ] {
        let law = laws::law(name);
        let mut question = Question::deformed(&law, bodies::cloud(Flavour::Solid, 9), 1e-2, 9);
        question.broken = bodies::broken_pairs(&question.body, share, 5);
        question.partial_volume = false;
        let (body, u) = (&question.body, &question.path[0]);
        let mut bonds = naive::bonds(&body.x, |j| body.volume[j], question.horizon, None);
        let inverse = |x: f64| 1.0 / x;
        let frozen = Lps::new(laws::K, laws::G, inverse, &bonds, u.len());
        for bond in &mut bonds {
            bond.intact = !question.broken.contains(&(bond.i, bond.j));
        }
        let live = Lps::new(laws::K, laws::G, inverse, &bonds, u.len());
        let published = if name == "lps" { live } else { frozen };
        let (expected, scale) = (published.force(&bonds, u), question.oracle().1);
        question.everywhere(|what, engine| {
            let answer = question.ask(engine);
            let error = block::largest_difference(&answer.force, &expected) / scale.force;
            assert!(error <= 1e-13, "{what}: {error:e}");
        });
    }
}

/// A dilatation, then the force: nothing else walks over bonds at every step.
#[test]
fn the_state_based_solid_takes_two_sweeps_a_step() {
    for (name, expected) in [("pmb", 1), ("gpmb", 1), ("lps", 2), ("lps_frozen", 2)] {
        for dim in 1..=3 {
            let spec = spec(&laws::law(name), dim);
            let step = spec
                .sweeps
                .iter()
                .filter(|s| s.stage == Stage::Step && !s.bond.ops.is_empty());
            assert_eq!(step.count(), expected, "{name} in {dim} dimensions");
        }
    }
}

fn all_bodies(flavour: Flavour) -> [Body; 3] {
    let shape = std::array::from_fn(|a| if a < flavour.dim() { [11, 5, 6][a] } else { 1 });
    [
        bodies::carved(flavour, 1),
        bodies::cloud(flavour, 2),
        bodies::lattice(flavour, shape, true),
    ]
}

/// Displacements equal in every bit differ by exactly nothing.
#[test]
fn an_undeformed_or_translated_body_has_exactly_no_force() {
    for name in laws::FINITE_STRAINS
        .into_iter()
        .chain(laws::SMALL_STRAINS)
        .chain(["bond_memory"])
    {
        let law = laws::law(name);
        for flavour in laws::flavours(&law) {
            for body in all_bodies(flavour) {
                let component = |a: usize| {
                    if a < flavour.dim() {
                        [0.1, -7.3e-5, 1e3 / 3.0][a]
                    } else {
                        0.0
                    }
                };
                let shift: [f64; 3] = std::array::from_fn(component);
                let mut question = Question::at_rest(&law, body);
                question.broken = bodies::broken_pairs(&question.body, 0.1, 3);
                let nodes = question.body.x.len();
                let mut shifted = question.clone();
                shifted.path = vec![vec![shift; nodes]];
                question.everywhere(|what, engine| {
                    for question in [&question, &shifted] {
                        let answer = question.ask(engine);
                        let still = |v: &[f64]| v.iter().all(|c| *c == 0.0);
                        assert!(still(answer.force.as_flattened()), "{what}: force");
                        assert!(still(&answer.energy), "{what}: energy");
                    }
                });
            }
        }
    }
}

/// A turn by any angle leaves forces of the size of rounding: the displacements of a body of some ten spacings
/// are rounded to about 1e-15 of a spacing.
#[test]
fn a_rotated_body_has_no_force() {
    for name in laws::FINITE_STRAINS.into_iter().chain(["bond_memory"]) {
        let law = laws::law(name);
        for flavour in laws::flavours(&law).into_iter().filter(|f| f.dim() > 1) {
            for body in [bodies::carved(flavour, 1), bodies::cloud(flavour, 2)] {
                // The size of the forces if every bond were strained by about one.
                let mut question = Question::deformed(&law, body, 1e-2, 3);
                let unit = question
                    .consult(|oracle, _, state| oracle.force_scale(state))
                    .expect("a force")
                    * 1e2;
                // No thermal stress.
                question
                    .fields
                    .iter_mut()
                    .flatten()
                    .for_each(|f| f.fill(0.0));
                for angle in [1e-3, 0.7, 3.0] {
                    question.path = vec![bodies::rotation(&question.body, angle)];
                    question.everywhere(|what, engine| {
                        let force = question.ask(engine).force;
                        let error =
                            block::largest_difference(&force, &vec![[0.0; 3]; force.len()]) / unit;
                        assert!(error <= 1e-14, "{what}, {angle} rad: {error:e}");
                    });
                }
            }
        }
    }
}

/// What no sum is part of is an output as well.
#[test]
fn node_values_without_a_sum_are_outputs() {
    let law = laws::parse(
        "model plain \"Values of nodes\" cite \"The tests, eq. 1\" {
          field T : temperature \"temperature\"
          param K : pressure > 0 \"bulk modulus\"
          node turned = cos(T/(1 K))
          node both = turned*sum(s)/ball(1)
          energy W = K*sum((1 + cos(T/(1 K)))*s^2)/ball(1)
        }",
    );
    let question = Question::deformed(&law, bodies::carved(Flavour::Bar, 1), 1e-2, 3);
    question.everywhere(|what, engine| {
        let mut state = question.state(engine);
        engine.forces(&mut state, Breaking::Held);
        engine.energy(&state);
        for name in ["turned", "both"] {
            let expected = question.consult(|oracle, _, state| oracle.named(state, name));
            let expected = expected.expect("the law defines this");
            let found = &engine.named(name).expect("an output")[0];
            for (value, expected) in found.iter().zip(&expected) {
                let expected = expected.scalar().expect("a scalar");
                let gap = (value - expected).abs();
                assert!(
                    gap <= 1e-12 * expected.abs(),
                    "{what} {name}: {value} {expected}"
                );
            }
        }
    });
}

/// A stretched body does have a force: the tests above compare with something.
#[test]
fn a_deformed_body_has_forces() {
    for name in laws::FINITE_STRAINS {
        let law = laws::law(name);
        let flavour = *laws::flavours(&law).last().expect("it serves one");
        let question = Question::deformed(&law, bodies::carved(flavour, 1), 1e-2, 3);
        let mut engine = question.engine(question.fastest(), Traversal::Auto, None);
        let mut state = question.state(&mut engine);
        engine.forces(&mut state, Breaking::Held);
        assert!(
            gather(&engine, engine.force())
                .iter()
                .flatten()
                .any(|c| c.abs() > 1e6),
            "{name}"
        );
    }
}
