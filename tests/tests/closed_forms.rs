//! Laws against formulas on one node or one bond: the stress of a given deformation, the energy of a uniform
//! strain, a plastic load cycle, a relaxation.

use std::path::Path;

use pdlang::ir::Law;
use pdlang_models::language::Pdlang;
use pdlang_runtime::body::{Body, Flavour};
use pdlang_runtime::engine::{Breaking, Engine, Traversal};
use pdlang_runtime::scene::Scene;
use pdlang_runtime::simulate::Simulation;
use pdlang_tests::agreement::Question;
use pdlang_tests::bodies::{self, DX};
use pdlang_tests::laws::{self, G, K};

type Tensor = [[f64; 3]; 3];

/// Young's modulus [Pa] and Poisson's ratio of the tests' moduli.
const E: f64 = 9.0 * K * G / (3.0 * K + G);
const NU: f64 = (3.0 * K - 2.0 * G) / (6.0 * K + 2.0 * G);

/// A box of a regular grid with `n` cells along each direction that the flavour has.
fn block(flavour: Flavour, n: u32) -> Body {
    let shape = std::array::from_fn(|a| if a < flavour.dim() { n } else { 1 });
    bodies::lattice(flavour, shape, false)
}

/// The node in the middle of a box.
fn middle(body: &Body) -> usize {
    let far = |a: usize| body.x.iter().fold(0.0_f64, |m, x| m.max(x[a]));
    bodies::node_at(body, std::array::from_fn(|a| (far(a) + DX / 2.0) / 2.0))
}

fn apply(h: &Tensor, x: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|a| (0..3).map(|b| h[a][b] * x[b]).sum())
}

fn product(a: &Tensor, b: &Tensor) -> Tensor {
    std::array::from_fn(|r| std::array::from_fn(|c| (0..3).map(|k| a[r][k] * b[k][c]).sum()))
}

/// A displacement gradient in the flavour's dimensions, not symmetric, of the stated size.
fn gradient(flavour: Flavour, size: f64) -> Tensor {
    let full = [[0.7, -0.4, 0.2], [0.9, -0.5, 0.3], [-0.6, 0.1, 0.8]];
    let inside = |a: usize, b: usize| a.max(b) < flavour.dim();
    std::array::from_fn(|a| {
        std::array::from_fn(|b| if inside(a, b) { size * full[a][b] } else { 0.0 })
    })
}

/// Hooke's stress in the dimensions of the flavour, from the 3D moduli.
fn hooke(flavour: Flavour, strain: &Tensor) -> Tensor {
    let lame = match flavour {
        Flavour::Bar => E - 2.0 * G,
        Flavour::PlaneStress => E * NU / (1.0 - NU * NU),
        _ => K - 2.0 / 3.0 * G,
    };
    let trace = strain[0][0] + strain[1][1] + strain[2][2];
    std::array::from_fn(|a| {
        std::array::from_fn(|b| {
            let mean = if a == b && a < flavour.dim() {
                lame * trace
            } else {
                0.0
            };
            mean + 2.0 * G * strain[a][b]
        })
    })
}

fn small_strain(h: &Tensor) -> Tensor {
    std::array::from_fn(|a| std::array::from_fn(|b| 0.5 * (h[a][b] + h[b][a])))
}

/// The law on the body, deformed by a uniform gradient.
fn uniform<'a>(law: &'a Law, body: Body, h: &Tensor) -> Question<'a> {
    let mut question = Question::at_rest(law, body);
    question.path = vec![question.body.x.iter().map(|x| apply(h, *x)).collect()];
    question
}

/// A node quantity of the law as the engine has it after forces and energy, as a tensor.
fn tensor(question: &Question, engine: &mut Engine, name: &str, node: usize) -> Tensor {
    let mut state = question.state(engine);
    engine.forces(&mut state, Breaking::Held);
    engine.energy(&state);
    let values = engine.named(name).expect("the law has this quantity");
    let dim = question.body.flavour.dim();
    std::array::from_fn(|a| {
        std::array::from_fn(|b| {
            let inside = a.max(b) < dim;
            if inside {
                values[a * dim + b][node]
            } else {
                0.0
            }
        })
    })
}

fn close(what: &str, got: &Tensor, expected: &Tensor, tolerance: f64) {
    let size = expected
        .as_flattened()
        .iter()
        .fold(0.0_f64, |m, v| m.max(v.abs()));
    for (got, expected) in got.as_flattened().iter().zip(expected.as_flattened()) {
        let error = (got - expected).abs() / size;
        assert!(
            error <= tolerance,
            "{what}: {got:e} instead of {expected:e}"
        );
    }
}

/// A uniform gradient is seen exactly by every family, whatever its shape: the corner of a box as well.
#[test]
fn the_stress_of_correspondence_is_that_of_hooke() {
    for name in ["correspondence", "correspondence_stabilised"] {
        let law = laws::law(name);
        for flavour in Flavour::ALL {
            let h = gradient(flavour, 1e-2);
            let question = uniform(&law, block(flavour, 7), &h);
            let sigma = hooke(flavour, &small_strain(&h));
            let strain = small_strain(&h);
            let energy: f64 = (sigma.as_flattened().iter().zip(strain.as_flattened()))
                .map(|(s, e)| 0.5 * s * e)
                .sum();
            question.everywhere(|what, engine| {
                for node in [0, middle(&question.body)] {
                    close(
                        what,
                        &tensor(&question, engine, "sigma", node),
                        &sigma,
                        1e-12,
                    );
                }
                for w in question.ask(engine).energy {
                    assert!(
                        (w / energy - 1.0).abs() <= 1e-12,
                        "{what}: {w:e} for {energy:e}"
                    );
                }
            });
        }
    }
}

/// P = F S of Green's strain, at strains of a fifth and a turn by two radians.
#[test]
fn the_stress_of_st_venant_and_kirchhoff_turns_with_the_body() {
    let law = laws::law("correspondence_svk");
    for flavour in Flavour::ALL {
        let mut f = gradient(flavour, 0.2);
        (0..3).for_each(|a| f[a][a] += 1.0);
        if flavour.dim() > 1 {
            let (sin, cos) = 2.0_f64.sin_cos();
            f = product(&[[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]], &f);
        }
        let mut green = product(
            &std::array::from_fn(|a| std::array::from_fn(|b| f[b][a])),
            &f,
        );
        (0..3).for_each(|a| green[a][a] -= 1.0);
        green.as_flattened_mut().iter_mut().for_each(|e| *e *= 0.5);
        let stress = product(&f, &hooke(flavour, &green));
        (0..3).for_each(|a| f[a][a] -= 1.0);
        let question = uniform(&law, block(flavour, 7), &f);
        question.everywhere(|what, engine| {
            for node in [0, middle(&question.body)] {
                close(what, &tensor(&question, engine, "P", node), &stress, 1e-11);
            }
        });
    }
}

/// One node displaced by v in the middle of an undeformed lattice: its own gradient sees nothing, its neighbours
/// see v. With the shape tensor k I, N bonds of volume V and the stiffness g of the stabilisation, the force is
/// -v (V/k (lame + (dim + 1) G) + g V (2 N - dim)): the first part is all that the plain law has.
#[test]
fn a_displaced_node_is_driven_back_by_the_stabilisation() {
    for flavour in Flavour::ALL {
        let dim = flavour.dim();
        let body = block(flavour, 9);
        let node = middle(&body);
        let volume = body.volume[0];
        let v = 1e-7;
        let mut path = vec![[0.0; 3]; body.x.len()];
        path[node][0] = v;
        let gap = |x: &[f64; 3]| std::array::from_fn::<f64, 3, _>(|a| x[a] - body.x[node][a]);
        let family: Vec<[f64; 3]> = (body.x.iter().map(gap))
            .filter(|xi| {
                (1..=4)
                    .contains(&((xi.iter().map(|c| c * c).sum::<f64>() / (DX * DX)).round() as u32))
            })
            .collect();
        let (n, k) = (
            family.len() as f64,
            family.iter().map(|xi| xi[0] * xi[0] * volume).sum::<f64>(),
        );
        let lame = hooke(flavour, &[[1.0, 0.0, 0.0], [0.0; 3], [0.0; 3]])[0][0] - 2.0 * G;
        let delta = 2.2 * DX;
        // Nicely, Tang and Qian 2018, eq. 10, by flavour: 2E/(A delta^3), 12K'/(pi h delta^4), 18K/(pi delta^5).
        let pi = std::f64::consts::PI;
        let micromodulus = match flavour {
            Flavour::Bar => 2.0 * E / (body.cross * delta.powi(3)),
            Flavour::Slab => 2.0 * (K + 4.0 / 3.0 * G) / (body.cross * delta.powi(3)),
            Flavour::PlaneStress => {
                12.0 * E / (2.0 * (1.0 - NU)) / (pi * body.cross * delta.powi(4))
            }
            Flavour::PlaneStrain => 12.0 * (K + G / 3.0) / (pi * body.cross * delta.powi(4)),
            Flavour::Solid => 18.0 * K / (pi * delta.powi(5)),
        };
        for (name, gs) in [
            ("correspondence", 0.0),
            ("correspondence_stabilised", 0.0),
            ("correspondence_stabilised", 1.5),
        ] {
            let law = laws::law(name);
            let mut question = Question::at_rest(&law, body.clone()).with(&[("Gs", gs)]);
            question.path = vec![path.clone()];
            let plain = volume / k * (lame + (dim as f64 + 1.0) * G);
            let stabilised = gs * micromodulus / n * volume * (2.0 * n - dim as f64);
            let expected = -v * (plain + stabilised);
            question.everywhere(|what, engine| {
                let force = question.ask(engine).force[node];
                let error = (force[0] / expected - 1.0).abs();
                assert!(
                    error <= 1e-8,
                    "{what}: {:e} instead of {expected:e}",
                    force[0]
                );
            });
        }
    }
}

/// A node with one neighbour on each side along every axis of the flavour.
fn star(flavour: Flavour) -> Body {
    let mut body = block(flavour, 3);
    let grid = body.grid.as_mut().expect("a lattice has a grid");
    let arm = |cell: &[u32; 3]| (0..flavour.dim()).filter(|a| cell[*a] != 1).count() <= 1;
    let keep: Vec<bool> = grid.cell.iter().map(arm).collect();
    let mut kept = keep.iter();
    grid.cell.retain(|_| *kept.next().expect("as many"));
    let mut kept = keep.iter();
    body.x.retain(|_| *kept.next().expect("as many"));
    body.volume.truncate(body.x.len());
    body
}

/// The star, its arms along x longer by `e` and those along y shorter: the middle node has no dilatation, and the
/// deviatoric extensions of its bonds are e, -e and 0.
fn pulled(body: &Body, e: f64) -> Vec<[f64; 3]> {
    let center = body.x[middle(body)];
    let move_out = |x: &[f64; 3]| {
        let side = |a: usize| (x[a] - center[a]) / DX;
        [e * side(0), -e * side(1), 0.0]
    };
    body.x.iter().map(move_out).collect()
}

/// The force state that the middle node holds its arm along +x with [N/m^6], after the displacements of the path:
/// what is left of the force on that arm when the arm's own state, which is elastic, is taken away.
fn state_of_the_middle(question: &Question, engine: &mut Engine, e: f64) -> f64 {
    let (body, dim) = (&question.body, question.body.flavour.dim() as f64);
    let center = body.x[middle(body)];
    let arm = bodies::node_at(body, [center[0] + DX, center[1], center[2]]);
    let volume = body.volume[arm];
    let modulus = if dim == 3.0 { K } else { K + G / 3.0 };
    let own = dim * dim * modulus * e / (DX * DX * volume);
    -question.ask(engine).force[arm][0] / volume - own
}

fn on_a_star<'a>(law: &'a Law, flavour: Flavour) -> Question<'a> {
    let mut question = Question::at_rest(law, star(flavour));
    (question.horizon, question.lattice_constants) = (1.1 * DX, true);
    question
}

/// Deviatoric stiffness of a bond of the middle node [N/m^7].
fn stiffness(body: &Body) -> f64 {
    (body.flavour.dim() as f64 + 2.0) * G / (2.0 * DX * DX * body.volume[0])
}

/// Four bonds share the norm, and the bond yields where e = tauy dx/(G sqrt(2 (dim + 2))). Loaded to 3 times that
/// it keeps its force and remembers 2; the way back is elastic until the other side of the yield surface.
#[test]
fn a_plastic_bond_goes_through_its_load_cycle() {
    let law = laws::law("lps_plastic");
    let tauy = 1e6;
    for flavour in [Flavour::PlaneStrain, Flavour::Solid] {
        let mut question = on_a_star(&law, flavour).with(&[("tauy", tauy)]);
        let limit = tauy * DX / (G * (2.0 * (flavour.dim() as f64 + 2.0)).sqrt());
        let cycle = [
            (0.5, 0.5),
            (3.0, 1.0),
            (2.5, 0.5),
            (1.2, -0.8),
            (-1.0, -1.0),
            (0.4, 0.4),
            (0.0, 0.0),
        ];
        question.path.clear();
        for (load, answer) in cycle {
            let e = load * limit;
            question.path.push(pulled(&question.body, e));
            question.everywhere(|what, engine| {
                let got = state_of_the_middle(&question, engine, e);
                let got = got / (stiffness(&question.body) * limit);
                assert!(
                    (got - answer).abs() <= 1e-9,
                    "{what} at {load}: {got} instead of {answer}"
                );
            });
        }
    }
}

/// In pure shear beyond the limit the family keeps the force state that the yield stress has: k = tauy/(G gamma).
#[test]
fn a_plastic_node_yields_at_the_shear_stress_that_it_is_given() {
    let law = laws::law("lps_plastic");
    for (flavour, n) in [(Flavour::PlaneStrain, 13), (Flavour::Solid, 11)] {
        for (ratio, expected) in [(0.95, 1.0), (2.0, 0.5)] {
            let gamma = 1e-4;
            let h = [[0.0, gamma, 0.0], [0.0; 3], [0.0; 3]];
            let mut question = uniform(&law, block(flavour, n), &h);
            question.params = laws::params(&law, &[("tauy", G * gamma / ratio)]);
            (question.horizon, question.lattice_constants) = (5.01 * DX, true);
            let mut engine = question.engine(question.fastest(), Traversal::Auto, None);
            let mut state = question.state(&mut engine);
            engine.forces(&mut state, Breaking::Held);
            let k = engine.named("k").expect("the law has it")[0][middle(&question.body)];
            println!("{question}: k = {k}");
            // What the lattice lacks of isotropy at five spacings.
            assert!(
                (k / expected - 1.0).abs() <= 0.02,
                "{question}: {k} instead of {expected}"
            );
        }
    }
}

/// A bond that is pulled in one step and held relaxes as the exponential from the middle of that step on.
#[test]
fn a_viscoelastic_bond_relaxes() {
    let law = laws::law("lps_viscoelastic");
    let (share, tau, dt, e) = (0.6, 1e-6, 2.5e-7, 1e-4 * DX);
    for flavour in [Flavour::PlaneStrain, Flavour::Solid] {
        for steps in [0, 1, 7, 60] {
            let mut question = on_a_star(&law, flavour).with(&[("share", share), ("tau", tau)]);
            question.dt = dt;
            question.path = vec![pulled(&question.body, e); steps + 1];
            let time = (steps as f64 + 0.5) * dt;
            let expected = 1.0 - share + share * (-time / tau).exp();
            question.everywhere(|what, engine| {
                let got = state_of_the_middle(&question, engine, e);
                let got = got / (stiffness(&question.body) * e);
                assert!(
                    (got - expected).abs() <= 1e-9,
                    "{what}: {got} instead of {expected}"
                );
            });
        }
    }
}

/// At a constant rate the Maxwell branch carries tau (1 - exp(-t/tau)) times the rate; half the step, a quarter of
/// the error.
#[test]
fn the_relaxation_is_of_second_order() {
    let law = laws::law("lps_viscoelastic");
    let (tau, e) = (1e-6, 1e-4 * DX);
    let error = |steps: usize| {
        let mut question =
            on_a_star(&law, Flavour::PlaneStrain).with(&[("share", 1.0), ("tau", tau)]);
        question.dt = tau / steps as f64;
        let share = |k: usize| (k + 1) as f64 / steps as f64;
        question.path = (0..steps)
            .map(|k| pulled(&question.body, e * share(k)))
            .collect();
        let mut engine = question.engine(question.fastest(), Traversal::Auto, None);
        let got = state_of_the_middle(&question, &mut engine, e);
        got / (stiffness(&question.body) * e) - (1.0 - (-1.0_f64).exp())
    };
    let [coarse, fine] = [8, 16].map(error);
    println!("errors {coarse:.3e}, {fine:.3e}");
    assert!(coarse.abs() < 1e-3 && (coarse / fine - 4.0).abs() < 0.05);
}

/// The definition, summed by hand over a full family with its lattice constants.
fn lamina_energy(h: &Tensor, body: &Body, horizon: f64, angle: f64) -> f64 {
    // The values that `laws::params` gives.
    let (e1, e2, g12, nu12) = (40e9, 10e9, 2.5e9, 0.3);
    let q22 = e2 / (1.0 - nu12 * nu12 * e2 / e1);
    let (q11, q12) = (q22 * e1 / e2, nu12 * q22);
    let center = body.x[middle(body)];
    let volume = body.volume[0];
    // Sums of V, x V, s V and x s^2 V; of x and x s^2 along and across the fibres.
    let (mut all, mut along, mut across) = ([0.0; 4], [0.0; 2], [0.0; 2]);
    for x in &body.x {
        let xi: [f64; 3] = std::array::from_fn(|a| x[a] - center[a]);
        let length = xi.iter().map(|c| c * c).sum::<f64>().sqrt();
        if length == 0.0 || length > horizon {
            continue;
        }
        let moved = apply(h, xi);
        let y = (0..3)
            .map(|a| (xi[a] + moved[a]).powi(2))
            .sum::<f64>()
            .sqrt();
        let s = y / length - 1.0;
        all = [
            all[0] + volume,
            all[1] + length * volume,
            all[2] + s * volume,
            all[3] + length * s * s * volume,
        ];
        let turned = xi[1].atan2(xi[0]) - angle;
        for (sums, sine) in [(&mut along, turned.sin()), (&mut across, turned.cos())] {
            if sine.abs() < 1e-3 {
                *sums = [sums[0] + length * volume, sums[1] + length * s * s * volume];
            }
        }
    }
    let theta = 2.0 / all[0] * all[2];
    0.5 * (q12 - g12) * theta * theta
        + 4.0 * g12 / all[1] * all[3]
        + 0.5 * (q11 - q12 - 2.0 * g12) * along[1] / along[0]
        + 0.5 * (q22 - q12 - 2.0 * g12) * across[1] / across[0]
}

/// As its bonds add up; and as the stiffness of the ply says (Madenci and Oterkus 2014, eq. 5.1), but for what a
/// lattice of five spacings lacks of isotropy: 6.4 % in shear of the matrix.
#[test]
fn the_energy_of_a_lamina_is_that_of_its_stiffness() {
    let law = laws::law("lamina");
    let z = 0.0;
    for quarter in 0..4 {
        let angle = f64::from(quarter) * std::f64::consts::FRAC_PI_4;
        for h in [
            [[1e-4, 0.0, z], [0.0, 0.0, z], [z; 3]],
            [[0.0, 0.0, z], [0.0, 1e-4, z], [z; 3]],
            [[0.0, 1e-4, z], [1e-4, 0.0, z], [z; 3]],
            [[1e-4, 0.5e-4, z], [-0.2e-4, -0.7e-4, z], [z; 3]],
        ] {
            let mut question = uniform(&law, block(Flavour::PlaneStress, 13), &h);
            question.params = laws::params(&law, &[("angle", angle)]);
            (question.horizon, question.lattice_constants) = (5.01 * DX, true);
            let node = middle(&question.body);
            let summed = lamina_energy(&h, &question.body, question.horizon, angle);
            let ply = ply_energy(&h, angle);
            println!(
                "{:.0} degrees: {:.4} of the ply's",
                angle.to_degrees(),
                summed / ply
            );
            assert!(
                (summed / ply - 1.0).abs() <= 0.07,
                "{summed:e} instead of {ply:e}"
            );
            question.everywhere(|what, engine| {
                let w = question.ask(engine).energy[node];
                assert!(
                    (w / summed - 1.0).abs() <= 1e-10,
                    "{what}: {w:e}, not {summed:e}"
                );
            });
        }
    }
}

/// (Q11 e1^2 + 2 Q12 e1 e2 + Q22 e2^2 + G12 g12^2)/2 of the strains in the axes of the ply.
fn ply_energy(h: &Tensor, angle: f64) -> f64 {
    let (e1, e2, g12, nu12) = (40e9, 10e9, 2.5e9, 0.3);
    let q22 = e2 / (1.0 - nu12 * nu12 * e2 / e1);
    let (q11, q12) = (q22 * e1 / e2, nu12 * q22);
    let (sin, cos) = angle.sin_cos();
    let strain = small_strain(h);
    let along = |u: [f64; 2], v: [f64; 2]| -> f64 {
        (0..2)
            .map(|a| (0..2).map(|b| u[a] * strain[a][b] * v[b]).sum::<f64>())
            .sum()
    };
    let (m, n) = ([cos, sin], [-sin, cos]);
    let (x, y, shear) = (along(m, m), along(n, n), 2.0 * along(m, n));
    0.5 * (q11 * x * x + 2.0 * q12 * x * y + q22 * y * y + g12 * shear * shear)
}

/// A block held in shear for ten steps of a run: what relaxes has done so from the middle of the step at t = 0, when
/// the shear came, and on to the evaluation that is made here, one step beyond the last.
#[test]
fn a_run_tells_the_law_its_time_step() {
    let text = |share: f64, tau: f64| {
        format!(
            "[body]\nflavour = '3d'\nspacing = 1\nshape = {{ box = {{ from = [0, 0, 0], to = [5, 5, 5] }} }}\n\
             [family]\nhorizon = 2.2\n\
             [material]\nmodel = 'lps_viscoelastic'\ndensity = 1\nK = 2\nG = 1\nshare = {share:e}\ntau = {tau:e}\n\
             [[condition]]\ndisplacement = ['1e-4*y', 0, 0]\n\
             [time]\nsteps = 10\ndt = 0.03\n[output]\nevery = 'never'\n"
        )
    };
    let force = |share: f64, tau: f64| {
        let path = Path::new("tests/sheared.toml");
        let scene =
            Scene::parse(&text(share, tau), path, &Pdlang).unwrap_or_else(|e| panic!("{e}"));
        let mut simulation = scene.simulation().unwrap_or_else(|e| panic!("{e}"));
        simulation.run(&mut ()).unwrap_or_else(|e| panic!("{e}"));
        let Simulation { engine, state, .. } = &mut simulation;
        engine.forces(state, Breaking::Held);
        engine.force()[0][engine.slot(0)]
    };
    let [elastic, relaxed, viscous] = [force(0.0, 1.0), force(1.0, 1e-6), force(1.0, 0.5)];
    let left = (viscous - relaxed) / (elastic - relaxed);
    let expected = (-11.5 * 0.03_f64 / 0.5).exp();
    assert!(
        (left / expected - 1.0).abs() <= 1e-8,
        "{left} instead of {expected}"
    );
}
