//! Laws for small displacements: their force is the full one at rest and the slope that the oracle finds there, and
//! their energy is what that force is the gradient of.

use pdlang::assemble::{self, Kinematics};
use pdlang::ir::Law;
use pdlang_models::registry::{self, CATALOGUE};
use pdlang_runtime::body::{Body, Flavour};
use pdlang_runtime::engine::{self, Breaking, Isa, Traversal};
use pdlang_tests::agreement::{Answer, Question, spec_for};
use pdlang_tests::{block, bodies, bridge, laws};

const STRAIN: f64 = 1e-2;

/// Every function that has a slope at rest, of a quantity that is 0 there, and a choice that a field makes.
const FUNCTIONS: &str = r#"model functions "All functions" cite "Nobody, eq. 1" {
  param K : pressure > 0 "modulus"
  field T : number "chooses"
  node q = sum(x*e)/sum(x^2)
  node f = exp(2*q) + ln(3 + q) + sin(1 + q) + sin(q) + cos(1 + q) + cos(q) + tan(0.5 + q) + tan(q)
  node g = sqrt(2 + q) + (2 + q)^1.5 + 1/(1 + 2*q) + (1.5 + q)^(2 + q) + select(T > 0, q^2, 3*q) + abs(T)
  bond r = y/x + x/y
  energy W = K*(f + g)^2 + K*(f + 1)/(g + 5) + K*sum(x*r^3)/ball(x)
  break when abs(s) > 0.3 or max(s, 2*s) > 0.9
}"#;

/// A law on a lattice with holes and on a cloud, in a random state with broken bonds, in every flavour.
fn questions(law: &Law) -> Vec<Question<'_>> {
    let mut list = Vec::new();
    for flavour in laws::flavours(law) {
        for body in [bodies::carved(flavour, 1), bodies::cloud(flavour, 1)] {
            list.push(Question::deformed(law, body, STRAIN, 1));
        }
    }
    list
}

fn linearised(q: &Question) -> engine::Law {
    let dim = q.body.flavour.dim();
    engine::Law::interpreted(spec_for(q.law, dim, Kinematics::Linearised))
}

fn traversals(body: &Body) -> Vec<Traversal> {
    match body.grid {
        Some(_) => vec![Traversal::Lattice, Traversal::Cloud],
        None => vec![Traversal::Cloud],
    }
}

/// The same state with displacements times `factor`.
fn displaced<'a>(q: &Question<'a>, factor: f64) -> Question<'a> {
    let mut q = q.clone();
    for u in q.path.last_mut().expect("a path has a last state") {
        *u = u.map(|c| factor * c);
    }
    q
}

fn scaled(a: &[[f64; 3]], factor: f64, b: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let sum = |(a, b): (&[f64; 3], &[f64; 3])| std::array::from_fn(|k| a[k] + factor * b[k]);
    a.iter().zip(b).map(sum).collect()
}

/// Integral over the body of the product of two vectors.
fn work(body: &Body, a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let dot = |(a, b): (&[f64; 3], &[f64; 3])| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let parts = a.iter().zip(b).map(dot).zip(&body.volume);
    parts.map(|(d, v)| d * v).sum()
}

fn total(body: &Body, energy: &[f64]) -> f64 {
    energy.iter().zip(&body.volume).map(|(w, v)| w * v).sum()
}

fn check(law: &Law) {
    let (mut worst, mut worst_energy, mut worst_rate) = (0.0_f64, 0.0_f64, 0.0_f64);
    for mut question in questions(law) {
        let u = question.path[0].clone();
        question.du.clone_from(&u);
        let (rest, _) = displaced(&question, 0.0).oracle();
        let forces = question.consult(|oracle, _, state| oracle.force_scale(state));
        let forces = forces.expect("the state fits");
        let expected = scaled(&rest.force, 1.0, &rest.tangent);
        // Rates of the same velocities: the slope between two small displacements.
        let near = [1e-3, -1e-3].map(|step| match rest.rates.is_empty() {
            true => Vec::new(),
            false => displaced(&question, step).oracle().0.rates,
        });
        let body = &question.body;
        let linear = linearised(&question);
        for traversal in traversals(body) {
            let ask = |q: &Question| q.ask(&mut q.engine(linear.clone(), traversal, None));
            let what = format!("{question} {traversal:?}");
            let answer = ask(&question);
            if !answer.force.is_empty() {
                let size = forces.max(largest(&expected));
                let error = block::largest_difference(&answer.force, &expected) / size;
                assert!(error <= 1e-12, "{what}: force {error:e}");
                let slope = block::largest_difference(&answer.tangent, &rest.tangent) / size;
                assert!(slope <= 1e-12, "{what}: tangent {slope:e}");
                worst = worst.max(error).max(slope);
            }
            if !answer.energy.is_empty() {
                worst_energy = worst_energy.max(energies(&question, &what, &answer, &rest, &ask));
            }
            for (k, rates) in answer.rates.iter().enumerate() {
                let size = rest.rates[k].iter().fold(0.0, |m: f64, r| m.max(r.abs()));
                for (node, rate) in rates.iter().enumerate() {
                    let [up, down] = [&near[0], &near[1]].map(|near| near[k][node]);
                    let expected = rest.rates[k][node] + (up - down) / 2e-3;
                    let error = (rate - expected).abs() / size;
                    assert!(error <= 1e-7, "{what}: rate {error:e}");
                    worst_rate = worst_rate.max(error);
                }
            }
        }
    }
    println!(
        "{}: force {worst:.1e}, energy {worst_energy:.1e}, rates {worst_rate:.1e}",
        law.name
    );
}

fn largest(v: &[[f64; 3]]) -> f64 {
    v.as_flattened().iter().fold(0.0, |m, c| m.max(c.abs()))
}

/// The energy is the work against the force, and the force its gradient: of a polynomial of second order a difference
/// over any distance is exact.
fn energies(
    q: &Question,
    what: &str,
    answer: &Answer,
    rest: &Answer,
    ask: &dyn Fn(&Question) -> Answer,
) -> f64 {
    let (body, u) = (&q.body, &q.path[0]);
    let first = work(body, &rest.force, u);
    let second = work(body, &rest.tangent, u) / 2.0;
    let expected = total(body, &rest.energy) - first - second;
    let size = total(body, &rest.energy).abs() + first.abs() + second.abs();
    let error = (total(body, &answer.energy) - expected).abs() / size;
    assert!(error <= 1e-12, "{what}: energy {error:e}");
    let along = bodies::deformation(body, STRAIN, 99);
    let energy = |factor: f64| {
        let mut q = q.clone();
        q.path[0] = scaled(u, factor, &along);
        total(body, &ask(&q).energy)
    };
    let slope = (energy(1.0) - energy(-1.0)) / 2.0;
    let gradient = (slope + work(body, &answer.force, &along)).abs() / size;
    assert!(gradient <= 1e-11, "{what}: gradient {gradient:e}");
    error.max(gradient)
}

#[test]
fn forces_are_slopes_at_rest_and_energies_their_potentials() {
    let mut refused = Vec::new();
    for entry in CATALOGUE {
        let law = laws::law(entry.name);
        match assemble::specs(&law, Kinematics::Linearised) {
            Ok(_) => check(&law),
            Err(_) => refused.push(entry.name),
        }
    }
    // They remember displacements.
    assert_eq!(
        refused,
        ["pmb_compression", "lps_plastic", "lps_viscoelastic"]
    );
}

#[test]
fn so_they_are_with_every_function_and_weights() {
    check(&laws::parse(FUNCTIONS));
    check(&laws::law("corrected"));
}

#[test]
fn forces_are_linear() {
    for name in ["pmb", "lps", "correspondence_svk"] {
        let law = laws::law(name);
        for q in questions(&law) {
            let ask = |q: &Question| q.ask(&mut q.engine(linearised(q), Traversal::Cloud, None));
            let (once, twice) = (ask(&q), ask(&displaced(&q, 2.0)));
            // Twice a number has its bits.
            assert_eq!(twice.force, scaled(&once.force, 1.0, &once.force), "{q}");
        }
    }
}

/// A bond breaks by its stretch to first order, the change of length along itself.
#[test]
fn bonds_break_by_their_small_stretch() {
    let law = laws::law("pmb");
    for q in questions(&law) {
        let limit = STRAIN / 3.0;
        let q = q.with(&[("s0", limit)]);
        let body = bridge::oracle_body(&q.body, q.horizon, q.partial_volume);
        let u = &q.path[0];
        let breaks = body.bonds.iter().filter(|b| {
            let along: f64 = (0..3).map(|a| b.xi[a] * (u[b.to][a] - u[b.from][a])).sum();
            along > limit * b.length().powi(2) && !q.broken.contains(&(b.from, b.to))
        });
        let expected = breaks.count();
        assert!(expected > 0);
        for traversal in traversals(&q.body) {
            let answer = q.ask(&mut q.engine(linearised(&q), traversal, None));
            assert_eq!(answer.breaks, expected, "{q} {traversal:?}");
        }
    }
}

#[test]
fn compiled_or_interpreted_the_bits_are_the_same() {
    for name in ["pmb", "lps"] {
        let law = laws::law(name);
        for q in questions(&law) {
            let compiled = registry::find(name)
                .and_then(|entry| entry.compiled_linearised(q.body.flavour.dim()))
                .expect("a law of the catalogue");
            assert_eq!(compiled.spec, linearised(&q).spec);
            for traversal in traversals(&q.body) {
                for isa in Isa::ALL.into_iter().filter(|isa| isa.available()) {
                    let [a, b] = [compiled.clone(), linearised(&q)]
                        .map(|law| q.ask(&mut q.engine(law, traversal, Some(isa))));
                    assert_eq!(a, b, "{q} {traversal:?} {isa:?}");
                }
            }
        }
    }
}

pdlang_macros::model! {
    linearised model spring "Bond-based elastic solid"
      cite "Silling and Askari 2005, Comput. Struct. 83, 1526-1535, eq. 9"
    {
        param K : pressure > 0 "bulk modulus"
        let c = 2*dim^2*K_bb(K) / ball(x)
        energy W = c/4 * sum(x*s^2)
    }
}

#[test]
fn a_law_in_rust_may_be_linearised() {
    for dim in 1..=3 {
        let law = engine::Law::compiled(&spring::LAW, dim).expect("the law is compiled");
        assert!(law.spec.linearised && law.kernel.is_some());
    }
}

/// What is shown is what the force reads: a turn by a right angle about z strains nothing, but xi.eta is then
/// -(xi.x^2 + xi.y^2), two thirds of -x^2 on average, and the dilatation is three times that.
#[test]
fn dilatation_is_shown_to_first_order() {
    let law = laws::law("lps");
    let mut q = Question::at_rest(&law, bodies::lattice(Flavour::Solid, [6, 6, 6], false));
    let turned = |x: &[f64; 3]| [-x[0] - x[1], x[0] - x[1], 0.0];
    q.path[0] = q.body.x.iter().map(turned).collect();
    let mut engine = q.engine(linearised(&q), Traversal::Lattice, None);
    let mut state = q.state(&mut engine);
    engine.forces(&mut state, Breaking::Held);
    let theta = engine.named("theta").expect("a definition").swap_remove(0);
    let grid = q.body.grid.as_ref().expect("a lattice");
    let inside = |cell: &[u32; 3]| cell.iter().all(|c| (2..4).contains(c));
    let full = grid.cell.iter().zip(theta).filter(|(cell, _)| inside(cell));
    let full: Vec<f64> = full.map(|(_, theta)| theta).collect();
    assert_eq!(full.len(), 8);
    for theta in full {
        assert!((theta + 2.0).abs() < 1e-13, "{theta}");
    }
}
