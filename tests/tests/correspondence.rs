//! Forces of the linear elastic correspondence solid against the same formulas written down plainly: loops over a
//! bond list, small matrices, nothing derived from an energy.
//!
//! For each node the shape tensor `Ks = sum(C xi xi V)`, the deformation gradient `F = sum(C (xi + eta) xi V) Ks^-1`,
//! the strain `sym F - I`, the stress `lambda tr(eps) I + 2 G eps` (lambda and G of the solid, in plane strain too) and
//! the force state `T<xi> = C sigma Ks^-1 xi`; on the node acts `sum((T<xi> - T'<-xi>) V')`.

use std::path::Path;

use pdlang_models::language::Pdlang;
use pdlang_runtime::body::{Body, Flavour};
use pdlang_runtime::observe::quantity;
use pdlang_runtime::scene::Scene;
use pdlang_tests::agreement::Question;
use pdlang_tests::naive::{self, Bond};
use pdlang_tests::{bodies, laws};

type Matrix = [[f64; 3]; 3];

const UNIT: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn matrix(entry: impl Fn(usize, usize) -> f64) -> Matrix {
    std::array::from_fn(|r| std::array::from_fn(|c| entry(r, c)))
}

fn product(a: &Matrix, b: &Matrix) -> Matrix {
    matrix(|r, c| (0..3).map(|k| a[r][k] * b[k][c]).sum())
}

fn applied(a: &Matrix, v: [f64; 3]) -> [f64; 3] {
    a.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Cramer's rule.
fn inverse(a: &Matrix) -> Matrix {
    let minor = |r: usize, c: usize| {
        let (p, q, s, t) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        a[p][s] * a[q][t] - a[p][t] * a[q][s]
    };
    let det: f64 = (0..3).map(|c| a[0][c] * minor(0, c)).sum();
    matrix(|r, c| minor(c, r) / det)
}

/// Force densities [N/m^3]; directions that the body does not have are the identity of its tensors.
fn forces(
    body: &Body,
    bonds: &[Bond],
    u: &[[f64; 3]],
    weight: &dyn Fn(f64) -> f64,
    (e, nu): (f64, f64),
) -> Vec<[f64; 3]> {
    let (lambda, g) = (e * nu / (1.0 + nu) / (1.0 - 2.0 * nu), e / 2.0 / (1.0 + nu));
    let (nodes, dim) = (body.x.len(), body.flavour.dim());
    let apart = matrix(|r, c| if r == c && r >= dim { 1.0 } else { 0.0 });
    let (mut shape, mut moved) = (vec![apart; nodes], vec![apart; nodes]);
    for b in bonds {
        let w = weight(b.x) * b.weight;
        let y: [f64; 3] = std::array::from_fn(|a| b.xi[a] + u[b.j][a] - u[b.i][a]);
        for r in 0..3 {
            for c in 0..3 {
                shape[b.i][r][c] += w * b.xi[r] * b.xi[c];
                moved[b.i][r][c] += w * y[r] * b.xi[c];
            }
        }
    }
    // sigma Ks^-1 of every node.
    let state: Vec<Matrix> = shape
        .iter()
        .zip(&moved)
        .map(|(shape, moved)| {
            let inverse = inverse(shape);
            let f = product(moved, &inverse);
            let strain = matrix(|r, c| 0.5 * (f[r][c] + f[c][r]) - UNIT[r][c]);
            let trace: f64 = (0..3).map(|k| strain[k][k]).sum();
            let stress = matrix(|r, c| lambda * trace * UNIT[r][c] + 2.0 * g * strain[r][c]);
            product(&stress, &inverse)
        })
        .collect();
    let mut force = vec![[0.0; 3]; nodes];
    for b in bonds {
        let w = weight(b.x) * b.weight;
        let (here, there) = (applied(&state[b.i], b.xi), applied(&state[b.j], b.xi));
        for a in 0..dim {
            force[b.i][a] += w * (here[a] + there[a]);
        }
    }
    force
}

#[test]
fn forces_are_those_of_the_formulas() {
    let law = laws::law("correspondence");
    let mut worst = 0.0_f64;
    for flavour in [Flavour::PlaneStrain, Flavour::Solid] {
        for seed in 0..4 {
            for influence in ["constant", "gaussian(l = 1 mm)"] {
                // A jittered body under a displacement that is not uniform.
                let mut question = Question::at_rest(&law, bodies::cloud(flavour, seed));
                question.path = vec![bodies::deformation(&question.body, 1e-2, seed + 5)];
                question.influences = vec![laws::influence(influence)];
                let body = &question.body;
                let bonds = naive::bonds(&body.x, |j| body.volume[j], question.horizon, None);
                let weight = |r: f64| match influence {
                    "constant" => 1.0,
                    _ => (-(r / 1e-3).powi(2)).exp(),
                };
                let value = |name: &str| {
                    let k = law.params.iter().position(|p| p.name == name);
                    question.params[k.expect("a parameter")]
                };
                let moduli = (value("E"), value("nu"));
                let expected = forces(body, &bonds, &question.path[0], &weight, moduli);
                let size = expected.as_flattened().iter();
                let size = size.fold(0.0_f64, |m, f| m.max(f.abs()));
                assert!(size > 0.0);
                question.everywhere(|what, engine| {
                    let found = question.ask(engine).force;
                    for (f, e) in found.as_flattened().iter().zip(expected.as_flattened()) {
                        let miss = (f - e).abs() / size;
                        worst = worst.max(miss);
                        assert!(miss <= 1e-12, "{what}: {f:e} instead of {e:e}");
                    }
                });
            }
        }
    }
    println!("largest difference {worst:.1e} of the largest force");
}

/// Shape tensor and gradient have the same influence function, so that the stress of a uniform gradient knows nothing of
/// it, in whole families and in those that a surface, a hole or a crack has cut.
#[test]
fn the_stress_of_a_uniform_gradient_does_not_depend_on_the_influence() {
    const H: Matrix = [
        [2e-3, -1e-3, 5e-4],
        [3e-3, -1e-3, 2e-3],
        [-4e-4, 1e-3, 1.5e-3],
    ];
    let names = [
        ("correspondence", "sigma"),
        ("correspondence_stabilised", "sigma"),
        ("correspondence_svk", "P"),
    ];
    let influences = [
        "constant",
        "1/x",
        "gaussian(l = 1 mm)",
        "softened(p = 5, eps = 1 mm)",
    ];
    let mut worst = 0.0_f64;
    for (name, stress) in names {
        let law = laws::law(name);
        for flavour in Flavour::ALL {
            let bodies = [bodies::carved(flavour, 3), bodies::cloud(flavour, 4)];
            for body in bodies {
                let horizon = 3.1 * body.spacing;
                let broken = bodies::half_broken(&body, horizon, 5);
                let dim = flavour.dim();
                let moved = |x: &[f64; 3]| {
                    let u = applied(
                        &H,
                        std::array::from_fn(|a| if a < dim { x[a] } else { 0.0 }),
                    );
                    std::array::from_fn(|a| if a < dim { u[a] } else { 0.0 })
                };
                let u: Vec<[f64; 3]> = body.x.iter().map(moved).collect();
                let mut first: Option<Vec<Vec<f64>>> = None;
                for influence in influences {
                    let mut question = Question::at_rest(&law, body.clone());
                    question.horizon = horizon;
                    question.path = vec![u.clone()];
                    question.broken.clone_from(&broken);
                    question.influences = vec![laws::influence(influence)];
                    question.everywhere(|what, engine| {
                        question.ask(engine);
                        let found = engine.named(stress).expect("the stress");
                        let known = first.get_or_insert_with(|| found.clone());
                        let size = known.iter().flatten().fold(0.0_f64, |m, s| m.max(s.abs()));
                        assert!(size > 0.0, "{what}");
                        for (a, b) in found.iter().flatten().zip(known.iter().flatten()) {
                            let miss = (a - b).abs() / size;
                            worst = worst.max(miss);
                            assert!(miss <= 1e-12, "{what}: {a:e} instead of {b:e}");
                        }
                    });
                }
            }
        }
    }
    println!("largest difference {worst:.1e} of the largest stress");
}

/// Nodes along an oblique line, or in an oblique plane, `bent` spacings off it.
fn flat(flavour: Flavour, plane: bool, bent: f64) -> Body {
    let like = bodies::cloud(flavour, 1);
    let (dim, dx) = (flavour.dim(), like.spacing);
    let rows = if plane { 4 } else { 1 };
    let at = |n: usize| {
        let (k, l) = ((n / rows) as f64 * dx, (n % rows) as f64 * dx);
        let off = if n.is_multiple_of(2) {
            bent * dx
        } else {
            -bent * dx
        };
        let x = [
            0.6 * k - 0.48 * l - off,
            0.64 * k + 0.6 * l + off,
            0.48 * k + 0.64 * l + off,
        ];
        std::array::from_fn(|a| if a < dim { x[a] } else { 0.0 })
    };
    let x: Vec<[f64; 3]> = (0..6 * rows).map(at).collect();
    Body {
        volume: vec![like.volume[0]; x.len()],
        x,
        ..like
    }
}

/// Families on an oblique line or plane, or nearly so, have no gradient: the same everywhere, from the oracle on, and
/// without stabilisation no force.
#[test]
fn flat_families_have_no_gradient() {
    for name in [
        "correspondence",
        "correspondence_stabilised",
        "correspondence_svk",
    ] {
        let law = laws::law(name);
        for flavour in [Flavour::PlaneStress, Flavour::PlaneStrain, Flavour::Solid] {
            for (plane, bent) in [(false, 0.0), (false, 1e-6), (true, 0.0), (true, 1e-6)] {
                if plane && flavour != Flavour::Solid {
                    continue;
                }
                let body = flat(flavour, plane, bent);
                let question = Question::deformed(&law, body, 1e-2, 7);
                let (expected, scale) = question.oracle();
                let stabilised = name == "correspondence_stabilised";
                let none = |values: &[[f64; 3]]| values.as_flattened().iter().all(|f| *f == 0.0);
                assert_eq!(none(&expected.force), !stabilised, "{question}");
                question.everywhere(|what, engine| {
                    let answer = question.ask(engine);
                    let gradient = engine.named("H").expect("the gradient");
                    assert!(gradient.iter().flatten().all(|h| *h == 0.0), "{what}");
                    assert!(answer.energy.iter().all(|w| *w == 0.0), "{what}");
                    assert_eq!(none(&answer.force), !stabilised, "{what}");
                    assert_eq!(none(&answer.tangent), !stabilised, "{what}");
                    if stabilised {
                        let difference = answer.difference(&expected, &scale);
                        let worst = difference.force.max(difference.tangent);
                        assert!(worst <= 1e-12, "{what}: {worst:e}");
                    }
                });
            }
        }
    }
}

/// A body that tears itself into pieces: whatever is left of families, every answer is a number.
#[test]
fn what_is_torn_stays_finite() {
    for (flavour, to, pull) in [
        ("plane_stress", "[20, 12]", "[\"x/8\", \"-y/30\"]"),
        ("3d", "[9, 7, 6]", "[\"x/4\", \"y/20\", \"z/9\"]"),
    ] {
        let (from, cross) = match flavour {
            "3d" => ("[0, 0, 0]", ""),
            _ => ("[0, 0]", "thickness = 1\n"),
        };
        for law in ["correspondence", "correspondence_stabilised"] {
            let text = format!(
                "[body]\nflavour = \"{flavour}\"\nspacing = 1\n{cross}shape = {{ box = {{ from = {from}, to = {to} }} }}\n\
                 [family]\nhorizon = 2.1\n[material]\nmodel = \"{law}\"\ndensity = 1\nE = 1\nnu = 0.25\ns0 = 0.04\n\
                 [[initial]]\nvelocity = {pull}\n[time]\nsteps = 150\ndt = 0.05\n"
            );
            let scene = Scene::parse(&text, Path::new("scenes/torn.toml"), &Pdlang);
            let scene = scene.unwrap_or_else(|e| panic!("{e}"));
            let mut simulation = scene.simulation().unwrap_or_else(|e| panic!("{e}"));
            simulation
                .run(&mut ())
                .unwrap_or_else(|e| panic!("{law}, {flavour}: {e}"));
            let broken = simulation.row.broken_fraction;
            println!(
                "{law}, {flavour}: {:.0} % of the bonds broke",
                100.0 * broken
            );
            assert!(broken > 0.2, "{law}, {flavour}: {broken}");
            for name in ["displacement", "force", "energy", "H", "sigma"] {
                let Ok(values) = quantity(&mut simulation, name) else {
                    continue;
                };
                let finite = values.components.iter().flatten().all(|v| v.is_finite());
                assert!(finite, "{law}, {flavour}: {name}");
            }
        }
    }
}
