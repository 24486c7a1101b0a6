//! Oracle = compiled tapes = engine on every traversal and instruction set, interpreted and compiled, on
//! random bodies, strains, influence functions and broken bonds, for every law and flavour.

use pdlang::ir::Law;
use pdlang_models::registry;
use pdlang_runtime::body::{Body, Flavour};
use pdlang_runtime::engine::{Isa, Traversal};
use pdlang_tests::agreement::{Answer, Difference, Question, Scale};
use pdlang_tests::{bodies, laws};

/// Random cases per law, flavour and kind of body.
const SEEDS: u64 = if cfg!(feature = "long") { 20 } else { 3 };

/// Influence functions, one per case in turn.
const INFLUENCES: [&str; 8] = [
    "constant",
    "inverse",
    "softened(p = 3, eps = 0.5 mm)",
    "power(p = 0.5)",
    "gaussian(l = 0.7 mm)",
    "linear",
    "quintic",
    "softened(p = 10, eps = 0.5 mm)",
];

fn bodies_of(flavour: Flavour, seed: u64) -> Vec<Body> {
    let wide = |a: usize| if a < flavour.dim() { [11, 5, 5][a] } else { 1 };
    let mut list = vec![bodies::carved(flavour, seed), bodies::cloud(flavour, seed)];
    if flavour.dim() < 3 || cfg!(feature = "long") {
        list.push(bodies::lattice(flavour, std::array::from_fn(wide), true));
    }
    list
}

fn questions(law: &Law, strain: f64) -> Vec<Question<'_>> {
    let mut list = Vec::new();
    for (k, flavour) in laws::flavours(law).into_iter().enumerate() {
        for seed in 0..SEEDS {
            for (n, body) in bodies_of(flavour, seed).into_iter().enumerate() {
                let mut question = Question::deformed(law, body, strain, seed + n as u64);
                let turn = 3 * k + n + seed as usize;
                question.lattice_constants = question.body.grid.is_some() && turn % 2 == 1;
                for influence in &mut question.influences {
                    *influence = laws::influence(INFLUENCES[turn % INFLUENCES.len()]);
                }
                list.push(question);
            }
        }
    }
    list
}

fn check(what: &str, got: &Answer, expected: &Answer, scale: &Scale, bound: f64) -> Difference {
    let difference = got.difference(expected, scale);
    // An energy is a sum of squares of extensions, and so twice as sensitive to their rounding.
    let worst = Difference {
        energy: difference.energy / 2.0,
        ..difference
    }
    .worst();
    assert!(worst <= bound, "{what}: {difference}");
    assert_eq!(got.breaks, expected.breaks, "{what}: bonds that break");
    difference
}

/// All answers to all questions of a law agree to 1e-15/strain of the size of their terms: an extension is a
/// difference of lengths, and its rounding weighs more the smaller it is. Where chance has strained a body
/// less than asked, the strain that it has counts.
fn agree(law: &str, strain: f64) {
    let law = laws::law(law);
    let mut worst = Difference::default();
    for question in questions(&law, strain) {
        let bound = 1e-15 / strain.min(question.largest_stretch());
        let (expected, scale) = question.oracle();
        let mut plain = question.plain();
        plain.breaks = expected.breaks;
        let what = format!("{question} plain");
        worst = worst.max(check(&what, &plain, &expected, &scale, bound));
        question.everywhere(|what, engine| {
            worst = worst.max(check(what, &question.ask(engine), &expected, &scale, bound));
        });
    }
    println!("{} at strain {strain:e}: {worst}", law.name);
}

#[test]
fn pmb() {
    agree("pmb", 1e-2);
}

#[test]
fn gpmb() {
    agree("gpmb", 1e-2);
}

#[test]
fn lps() {
    agree("lps", 1e-2);
}

#[test]
fn lps_frozen() {
    agree("lps_frozen", 1e-2);
}

#[test]
fn heat() {
    agree("heat", 1e-2);
}

#[test]
fn heat_state() {
    agree("heat_state", 1e-2);
}

#[test]
fn thermo_pmb() {
    agree("thermo_pmb", 1e-2);
}

#[test]
fn thermo_lps() {
    agree("thermo_lps", 1e-2);
}

#[test]
fn bond_heat() {
    agree("bond_heat", 1e-2);
}

#[test]
fn bond_memory() {
    agree("bond_memory", 1e-2);
}

#[test]
fn moving_fields() {
    agree("moving_fields", 1e-2);
}

#[test]
fn layered() {
    agree("layered", 1e-2);
}

#[test]
fn absorbing() {
    agree("absorbing", 1e-2);
}

#[test]
fn correspondence() {
    agree("correspondence", 1e-2);
}

#[test]
fn correspondence_stabilised() {
    agree("correspondence_stabilised", 1e-2);
}

#[test]
fn correspondence_svk() {
    agree("correspondence_svk", 1e-2);
}

#[test]
fn lps_plastic() {
    agree("lps_plastic", 1e-2);
}

#[test]
fn lps_viscoelastic() {
    agree("lps_viscoelastic", 1e-2);
}

#[test]
fn lamina() {
    agree("lamina", 1e-2);
}

#[test]
fn laminate() {
    agree("laminate", 1e-2);
}

#[test]
fn solid() {
    agree("solid", 1e-2);
}

#[test]
fn corrected() {
    agree("corrected", 1e-2);
}

#[test]
fn rounding_grows_as_the_strain_falls_and_no_faster() {
    for strain in [1e-1, 1e-3, 1e-5] {
        agree("gpmb", strain);
    }
}

/// Machine code and tapes differ in speed only: on one traversal and instruction set every answer has the same bits.
#[test]
fn compiled_and_interpreted_give_the_same_bits() {
    for name in registry::names() {
        let law = laws::law(name);
        for flavour in laws::flavours(&law) {
            for body in [bodies::carved(flavour, 2), bodies::cloud(flavour, 2)] {
                let question = Question::deformed(&law, body, 1e-2, 2);
                let mut compiled: Vec<Answer> = Vec::new();
                let mut interpreted: Vec<Answer> = Vec::new();
                question.everywhere(|what, engine| {
                    let list = match what.contains(" compiled ") {
                        true => &mut compiled,
                        false => &mut interpreted,
                    };
                    list.push(question.ask(engine));
                });
                assert_eq!(compiled.len(), interpreted.len(), "{question}");
                for (c, i) in compiled.iter().zip(&interpreted) {
                    assert_eq!(c.force, i.force, "{question}: force");
                    assert_eq!(c.energy, i.energy, "{question}: energy");
                    assert_eq!(c.rates, i.rates, "{question}: rates");
                    assert_eq!(c.tangent, i.tangent, "{question}: tangent");
                    assert_eq!(c.breaks, i.breaks, "{question}: breaks");
                }
            }
        }
    }
}

/// Components that are the same expression are one slot, and each is an answer.
#[test]
fn equal_components_of_a_force() {
    let text = r#"
model twin "One force along every axis"
  cite "A test, eq. 1"
{
  param c : [N/m^4]  "stiffness"
  node w   = mean(norm(eta))
  node a   = diag(c*w*I)
  force f  = a
}
"#;
    let came = pdlang_tests::fuzz::language(text);
    assert_eq!((came.laws, came.compared > 0), (1, true), "{came:?}");
}

/// An inverse of a shape at the other end of a bond, in a plate and in one line of nodes, whose shapes are flat.
#[test]
fn an_inverse_at_the_other_end() {
    let text = r#"
model inverse "The shape of a neighbour"
  cite "A test, eq. 1"
{
  influence omega
  param c : [J/m^3]  "stiffness"
  node K  = sum(omega * outer(xi, xi))
  bond B  = inverse(K') * K
  state T = c/(ball(1)*x) * s*tr(B)
}
"#;
    let checked = pdlang::front::file(text);
    assert!(!checked.has_errors(), "{:?}", checked.diagnostics);
    for shape in [[5, 1, 1], [4, 3, 1]] {
        let body = bodies::lattice(Flavour::PlaneStrain, shape, false);
        let question = Question::deformed(&checked.laws[0], body, 1e-2, 1);
        let (expected, scale) = question.oracle();
        let moves = expected.force.iter().flatten().any(|f| f.abs() > 0.0);
        assert_eq!(moves, shape[1] > 1, "a flat shape has no inverse");
        for traversal in [Traversal::Lattice, Traversal::Cloud] {
            let made = question.try_engine(question.interpreted(), traversal, Some(Isa::Scalar));
            let mut engine = made.expect("an engine");
            check(
                "inverse",
                &question.ask(&mut engine),
                &expected,
                &scale,
                1e-12,
            );
        }
    }
}
