//! `under(H, q)` is `q` of a body at rest that has been displaced by `H X`; vectors, `diag` and cases of any shape
//! are what they say.

use pdlang::oracle::Value;
use pdlang_runtime::body::Flavour;
use pdlang_runtime::engine::{Breaking, Traversal};
use pdlang_tests::agreement::Question;
use pdlang_tests::{bodies, laws};

/// Each quantity, and the same under a gradient.
const TEXT: &str = "
model graded \"Quantities under a gradient\" cite \"The tests, eq. 1\" {
  influence omega = 1/x
  param K : pressure > 0 \"bulk modulus\"
  let H = 0.01*outer((1, 2, 0.5), (0.3, -1, 2)) + diag((0.02, -0.01, 0.03))
  node shape : symmetric = sum(omega*outer(xi, xi))
  node a = dim/sum(omega*x^2)*sum(omega*x*e)
  bond z : vector = Y - F*xi
  node F : tensor = sum(omega*outer(Y, xi))*inverse(shape)
  node b : tensor = F + K/K*I
  node c = sum0(omega*norm(z' - z)*x)/sum0(omega*x^2) + max(abs(s)) + count(s > 0.005)
  node d : vector = mean(a'*Y/delta)
  node under_a = under(H, a)
  node under_b : tensor = under(H, b)
  node under_c = under(H, c)
  node under_d : vector = under(H, d)
  energy W = K*sum(s^2)/ball(1) + K*sum0(under(H, a'*e)^2*s^2)/(delta^2*ball(1))
}";

fn gradient(question: &Question) -> [[f64; 3]; 3] {
    let dim = question.body.flavour.dim();
    let (p, q, s) = ([1.0, 2.0, 0.5], [0.3, -1.0, 2.0], [0.02, -0.01, 0.03]);
    std::array::from_fn(|i| {
        std::array::from_fn(|k| match i < dim && k < dim {
            true => 0.01 * p[i] * q[k] + if i == k { s[i] } else { 0.0 },
            false => 0.0,
        })
    })
}

fn components(value: &Value<f64>) -> Vec<f64> {
    match value {
        Value::Scalar(a) => vec![*a],
        Value::Vector(v) => v.to_vec(),
        Value::Tensor(t) => t.concat(),
        Value::Boolean(_) => unreachable!("no quantity here is a condition"),
    }
}

#[test]
fn a_gradient_is_a_displacement() {
    let law = laws::parse(TEXT);
    for flavour in Flavour::ALL {
        for body in [bodies::carved(flavour, 3), bodies::cloud(flavour, 3)] {
            let question = Question::at_rest(&law, body);
            let h = gradient(&question);
            let moved = |x: &[f64; 3]| -> [f64; 3] {
                std::array::from_fn(|a| (0..3).map(|b| h[a][b] * x[b]).sum())
            };
            let u: Vec<[f64; 3]> = question.body.x.iter().map(moved).collect();
            for name in ["a", "b", "c", "d"] {
                let (direct, under) = question.consult(|oracle, _, state| {
                    let ask = |state: &_, name: &str| {
                        let found = oracle.named(state, name).expect("the law defines this");
                        found.iter().flat_map(components).collect::<Vec<_>>()
                    };
                    let under = ask(state, &format!("under_{name}"));
                    state.u.clone_from(&u);
                    (ask(state, name), under)
                });
                let size = direct.iter().fold(0.0_f64, |m, v| m.max(v.abs()));
                assert!(size > 1e-6, "{question}: `{name}` is {size}");
                for (d, u) in direct.iter().zip(&under) {
                    assert!((d - u).abs() <= 1e-12 * size, "{question} {name}: {d} {u}");
                }
                let mut engine = question.engine(question.interpreted(), Traversal::Auto, None);
                let mut state = question.state(&mut engine);
                engine.forces(&mut state, Breaking::Held);
                engine.energy(&state);
                let found = engine.named(&format!("under_{name}")).expect("an output");
                let dim = flavour.dim();
                let stored = |value: &[f64]| -> Vec<f64> {
                    match value.len() {
                        1 => value.to_vec(),
                        3 => value[..dim].to_vec(),
                        _ => (0..dim * dim)
                            .map(|k| value[3 * (k / dim) + k % dim])
                            .collect(),
                    }
                };
                let width = direct.len() / question.body.x.len();
                for (node, value) in under.chunks(width).enumerate() {
                    for (component, expected) in found.iter().zip(stored(value)) {
                        let gap = (component[node] - expected).abs();
                        assert!(
                            gap <= 1e-11 * size,
                            "{question} {name}: {gap:e} of {size:e}"
                        );
                    }
                }
            }
        }
    }
}

/// A case chooses among vectors and among values that differ from node to node.
#[test]
fn cases_are_of_any_shape() {
    let law = laws::parse(
        "model choice \"Cases\" cite \"The tests, eq. 1\" {
          param K : pressure > 0 \"bulk modulus\"
          node one = sum(e)/ball(1)
          node two = sum(e^2/x)/ball(1)
          node a : vector = case flavour { bar: (1, 2), slab: (3, 4), plane_stress: (5, 6), plane_strain: (5, 8), 3d: (7, 8, 9) }
          node b = case flavour { bar: one, slab: 2*two, plane_stress: one, plane_strain: two, 3d: 3*one }
          node c : vector = diag(outer((1, 2, 3), (4, 5, 6)))
          energy W = K*sum(s^2)/ball(1) + K*(a.y*b/delta)^2
        }",
    );
    let expected = [
        (Flavour::Bar, [1.0, 0.0, 0.0]),
        (Flavour::Slab, [3.0, 0.0, 0.0]),
        (Flavour::PlaneStress, [5.0, 6.0, 0.0]),
        (Flavour::PlaneStrain, [5.0, 8.0, 0.0]),
        (Flavour::Solid, [7.0, 8.0, 9.0]),
    ];
    for (flavour, a) in expected {
        let question = Question::deformed(&law, bodies::carved(flavour, 3), 1e-2, 4);
        let (named, other, c) = question.consult(|oracle, _, state| {
            let at = |name| oracle.named(state, name).expect("the law defines this")[0];
            (
                at("a"),
                [at("one"), at("two"), at("b")].map(|v| v.scalar().expect("a scalar")),
                at("c"),
            )
        });
        assert_eq!(named, Value::Vector(a));
        let dim = flavour.dim();
        let diagonal = std::array::from_fn(|k| if k < dim { [4.0, 10.0, 18.0][k] } else { 0.0 });
        assert_eq!(c, Value::Vector(diagonal));
        let [one, two, b] = other;
        let chosen = match flavour {
            Flavour::Bar | Flavour::PlaneStress => one,
            Flavour::Slab => 2.0 * two,
            Flavour::PlaneStrain => two,
            Flavour::Solid => 3.0 * one,
        };
        assert_eq!(b, chosen);
        let (answer, scale) = question.oracle();
        question.everywhere(|what, engine| {
            let gap = question.ask(engine).difference(&answer, &scale).worst();
            assert!(gap < 1e-12, "{what}: {gap:e}");
        });
    }
}
