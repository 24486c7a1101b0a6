//! The absorbing layer against the scheme of its papers, and the ways of stepping fields that it rests on.

use std::collections::BTreeMap;
use std::path::Path;

use pdlang_models::language::Pdlang;
use pdlang_runtime::observe::{Files, Observer, quantity};
use pdlang_runtime::scene::Scene;
use pdlang_runtime::simulate::Simulation;

fn simulation(text: &str) -> Simulation {
    let scene = Scene::parse(text, Path::new("scenes/scene.toml"), &Pdlang);
    let scene = scene.unwrap_or_else(|e| panic!("{e}"));
    scene.simulation().unwrap_or_else(|e| panic!("{e}"))
}

fn finished(text: &str) -> Simulation {
    let mut simulation = simulation(text);
    simulation.run(&mut ()).unwrap_or_else(|e| panic!("{e}"));
    simulation
}

/// In the order of the body's nodes.
fn user(simulation: &Simulation, values: &[f64]) -> Vec<f64> {
    let slots = simulation.engine.slots().iter();
    slots.map(|s| values[*s as usize]).collect()
}

fn displacements(simulation: &Simulation) -> Vec<Vec<f64>> {
    let u = simulation.state.u.iter();
    u.map(|u| user(simulation, u)).collect()
}

fn field(simulation: &Simulation, name: &str) -> Vec<f64> {
    let slots = simulation.engine.state_slots(name).expect("the field");
    let all = |k: usize| simulation.engine.spread(k, &simulation.state.slots[k]);
    let of = |k: usize| user(simulation, &all(k));
    slots.into_iter().flat_map(of).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| m.max(v.abs()))
}

fn gap(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}

/// A correspondence solid of Lame constants 0.4 and density 1 in D directions, its bonds in a list.
struct Solid<const D: usize> {
    x: Vec<[f64; D]>,
    /// Per node: the other end, influence times volume, and inverse shape tensor times bond vector.
    bonds: Vec<Vec<(usize, f64, [f64; D])>>,
    /// First Lame constant of the flavour.
    lambda: f64,
}

type Tensor<const D: usize> = [[f64; D]; D];

impl<const D: usize> Solid<D> {
    fn new(
        x: &[[f64; 3]],
        volume: f64,
        horizon: f64,
        lambda: f64,
        omega: impl Fn(f64) -> f64,
    ) -> Self {
        let x: Vec<[f64; D]> = x.iter().map(|x| std::array::from_fn(|a| x[a])).collect();
        let family = |i: usize| {
            let mut near: Vec<(usize, f64, [f64; D])> = Vec::new();
            let mut shape = [[0.0; D]; D];
            for j in (0..x.len()).filter(|j| *j != i) {
                let xi: [f64; D] = std::array::from_fn(|a| x[j][a] - x[i][a]);
                let r = xi.iter().map(|c| c * c).sum::<f64>().sqrt();
                if r <= horizon {
                    let weight = omega(r) * volume;
                    (0..D).for_each(|a| (0..D).for_each(|b| shape[a][b] += weight * xi[a] * xi[b]));
                    near.push((j, weight, xi));
                }
            }
            let inverse = inverse(shape);
            for (_, _, xi) in &mut near {
                let old = *xi;
                *xi = std::array::from_fn(|a| (0..D).map(|b| inverse[a][b] * old[b]).sum());
            }
            near
        };
        Solid {
            bonds: (0..x.len()).map(family).collect(),
            x,
            lambda,
        }
    }

    /// Derivative of a vector: component, direction.
    fn gradient(&self, v: &[[f64; D]], i: usize) -> Tensor<D> {
        let mut d = [[0.0; D]; D];
        for (j, weight, g) in &self.bonds[i] {
            for a in 0..D {
                (0..D).for_each(|b| d[a][b] += weight * (v[*j][a] - v[i][a]) * g[b]);
            }
        }
        d
    }

    fn stress(&self, e: &Tensor<D>) -> Tensor<D> {
        let trace: f64 = (0..D).map(|a| e[a][a]).sum();
        std::array::from_fn(|a| {
            std::array::from_fn(|b| {
                let volume = if a == b { self.lambda * trace } else { 0.0 };
                volume + 0.4 * (e[a][b] + e[b][a])
            })
        })
    }

    /// What a node feels of the stresses, by component and direction of derivative.
    fn divergence(&self, stress: &[Tensor<D>], i: usize) -> Tensor<D> {
        let mut t = [[0.0; D]; D];
        for (j, weight, g) in &self.bonds[i] {
            let back = self.bonds[*j]
                .iter()
                .find(|(k, ..)| *k == i)
                .expect("a bond")
                .2;
            for a in 0..D {
                for b in 0..D {
                    t[a][b] += weight * (stress[i][a][b] * g[b] - stress[*j][a][b] * back[b]);
                }
            }
        }
        t
    }

    /// Strain energy of a displacement.
    fn energy(&self, u: &[[f64; D]], volume: f64) -> f64 {
        let of = |i: usize| {
            let e = self.gradient(u, i);
            let stress = self.stress(&e);
            let product = |a: usize| (0..D).map(|b| stress[a][b] * e[a][b]).sum::<f64>();
            0.5 * volume * (0..D).map(product).sum::<f64>()
        };
        (0..self.x.len()).map(of).sum()
    }

    /// Velocity and strain, both split by the direction of derivative, from rest: staggered, damped by the
    /// trapezoidal rule.
    fn layer(&self, u: &mut [[f64; D]], phi: &[[f64; D]], dt: f64, steps: usize) {
        let nodes = 0..self.x.len();
        let factors = |phi: f64, dt: f64| {
            let h = 0.5 * phi * dt;
            ((1.0 - h) / (1.0 + h), dt / (1.0 + h))
        };
        let mut e: Vec<Tensor<D>> = nodes.clone().map(|i| self.gradient(u, i)).collect();
        let mut split = vec![[[0.0; D]; D]; self.x.len()];
        for step in 0..steps {
            let kick = if step == 0 { 0.5 * dt } else { dt };
            let stress: Vec<Tensor<D>> = e.iter().map(|e| self.stress(e)).collect();
            for i in nodes.clone() {
                let t = self.divergence(&stress, i);
                for a in 0..D {
                    for b in 0..D {
                        let (alpha, beta) = factors(phi[i][b], kick);
                        split[i][a][b] = alpha * split[i][a][b] + beta * t[a][b];
                    }
                }
            }
            let v: Vec<[f64; D]> = split
                .iter()
                .map(|v| v.map(|row| row.iter().sum()))
                .collect();
            for i in nodes.clone() {
                (0..D).for_each(|a| u[i][a] += dt * v[i][a]);
                let rate = self.gradient(&v, i);
                for a in 0..D {
                    for b in 0..D {
                        let (alpha, beta) = factors(phi[i][b], dt);
                        e[i][a][b] = alpha * e[i][a][b] + beta * rate[a][b];
                    }
                }
            }
        }
    }
}

fn inverse<const D: usize>(mut a: Tensor<D>) -> Tensor<D> {
    let mut inverse = [[0.0; D]; D];
    (0..D).for_each(|k| inverse[k][k] = 1.0);
    for k in 0..D {
        let pivot = 1.0 / a[k][k];
        (0..D).for_each(|c| (a[k][c], inverse[k][c]) = (a[k][c] * pivot, inverse[k][c] * pivot));
        for r in (0..D).filter(|r| *r != k) {
            let factor = a[r][k];
            for c in 0..D {
                a[r][c] -= factor * a[k][c];
                inverse[r][c] -= factor * inverse[k][c];
            }
        }
    }
    inverse
}

/// A body of size 1 of E = 1, nu = 1/4, density 1, pushed in its middle; `{phi}` is damping along the first axis.
fn scene(flavour: &str, law: &str, dx: f64, steps: usize, dt: f64) -> String {
    let (box_, cross, push) = match flavour {
        "bar" | "slab" => (
            "from = [0], to = [1]",
            "cross_section",
            "exp(-200*(x - 0.5)^2)/100",
        ),
        "3d" => (
            "from = [0, 0, 0], to = [1, 1, 1]",
            "",
            "exp(-50*((x - 0.5)^2 + (y - 0.4)^2 + (z - 0.6)^2))/100",
        ),
        _ => (
            "from = [0, 0], to = [1, 1]",
            "thickness",
            "exp(-100*((x - 0.5)^2 + (y - 0.4)^2))/100",
        ),
    };
    let cross = if cross.is_empty() {
        String::new()
    } else {
        format!("{cross} = 1")
    };
    let vector = |first: &str, other: &str| match flavour {
        "bar" | "slab" => format!("[\"{first}\"]"),
        "3d" => format!("[\"{first}\", \"{other}\", \"{other}\"]"),
        _ => format!("[\"{first}\", \"{other}\"]"),
    };
    let (u, anchor) = (vector(push, &format!("{push}/2")), vector("0", "0"));
    let phi = match law {
        "absorbing" => format!("phi = {}", vector("PHI_X", "PHI_Y")),
        _ => String::new(),
    };
    format!(
        "[body]\nflavour = \"{flavour}\"\nspacing = {dx}\n{cross}\nshape = {{ box = {{ {box_} }} }}\nanchor = {anchor}\n\
         [family]\nhorizon = \"2.1*dx\"\n\
         [material]\nmodel = \"{law}\"\ndensity = 1\nE = 1\nnu = 0.25\ninfluence = \"gaussian(l = 1.1*dx)\"\n\
         [[initial]]\ndisplacement = {u}\n{phi}\n\
         [time]\nsteps = {steps}\ndt = {dt}\n"
    )
}

/// The same with a layer of a quarter of the size on each side, where the damping rises to `most`.
fn with_layer(scene: &str, most: f64) -> String {
    let along = |axis: &str| format!("{most}*max(max(0.25 - {axis}, {axis} - 0.75)/0.25, 0)^2");
    scene
        .replace("PHI_X", &along("x"))
        .replace("PHI_Y", &along("y"))
}

/// As [`with_layer`], on the first two axes; the scene has the damping of the second on all that follow.
fn damping<const D: usize>(x: &[f64; D], most: f64) -> [f64; D] {
    std::array::from_fn(|a| {
        let x = x[a.min(1)];
        let depth = (0.25 - x).max(x - 0.75) / 0.25;
        most * depth.max(0.0).powi(2)
    })
}

/// Compares the displacement after some steps with that of the scheme as it is printed.
fn is_the_scheme<const D: usize>(flavour: &str, lambda: f64, dx: f64, steps: usize) {
    let dt = 0.3 * dx;
    let text = with_layer(&scene(flavour, "absorbing", dx, steps, dt), 40.0);
    let mut start = simulation(&text.replace(&format!("steps = {steps}"), "steps = 0"));
    let mut u = vec![[0.0; D]; start.body.x.len()];
    for (a, values) in displacements(&start).iter().enumerate() {
        values.iter().zip(&mut u).for_each(|(v, u)| u[a] = *v);
    }
    start.run(&mut ()).expect("a run");
    let l = 1.1 * dx;
    let (volume, omega) = (start.body.volume[0], |r: f64| (-(r / l).powi(2)).exp());
    let solid = Solid::<D>::new(
        &start.body.x,
        volume,
        2.1 * dx * (1.0 + 1e-9),
        lambda,
        omega,
    );
    let phi: Vec<[f64; D]> = solid.x.iter().map(|x| damping(x, 40.0)).collect();
    solid.layer(&mut u, &phi, dt, steps);
    let found = displacements(&finished(&text));
    let expected: Vec<Vec<f64>> = (0..D).map(|a| u.iter().map(|u| u[a]).collect()).collect();
    let worst = gap(&found, &expected);
    println!(
        "{flavour}: {worst:.1e} of {:.2e}",
        largest(&expected.concat())
    );
    assert!(worst < 1e-14, "{flavour}: {worst:e}");
}

/// Wildman and Gazonas's layer, staggered and damped by the trapezoidal rule, is what the law says.
#[test]
fn the_law_is_the_scheme_of_the_layer() {
    is_the_scheme::<1>("slab", 0.4, 0.01, 300);
    // Uniaxial stress: the whole modulus is E = 1.
    is_the_scheme::<1>("bar", 0.2, 0.01, 300);
    is_the_scheme::<2>("plane_strain", 0.4, 0.05, 100);
    // 2 lambda G/(lambda + 2 G).
    is_the_scheme::<2>("plane_stress", 0.8 * 0.4 / 1.2, 0.05, 100);
    is_the_scheme::<3>("3d", 0.4, 0.1, 40);
}

/// Without damping the law is `correspondence` in velocity Verlet.
#[test]
fn without_damping_nothing_is_different() {
    for flavour in ["bar", "slab", "plane_stress", "plane_strain", "3d"] {
        let (dx, steps) = (0.1, 200);
        let of = |law: &str| {
            let text = scene(flavour, law, dx, steps, 0.3 * dx);
            finished(&text.replace("PHI_X", "0").replace("PHI_Y", "0"))
        };
        let (layer, plain) = (of("absorbing"), of("correspondence"));
        let worst = gap(&displacements(&layer), &displacements(&plain));
        println!("{flavour}: {worst:.1e}");
        assert!(worst < 1e-14, "{flavour}: {worst:e}");
        assert_eq!(largest(&field(&layer, "lost")), 0.0);
        assert_eq!(largest(&field(&layer, "drag")), 0.0);
    }
}

/// Kinetic and strain energy, the latter by the law `correspondence`.
fn energy(simulation: &Simulation, dx: f64) -> f64 {
    let u = displacements(simulation);
    let x = &simulation.body.x;
    let l = 1.1 * dx;
    let omega = |r: f64| (-(r / l).powi(2)).exp();
    let volume = simulation.body.volume[0];
    let strain = match u.len() {
        1 => {
            let u: Vec<[f64; 1]> = u[0].iter().map(|u| [*u]).collect();
            Solid::<1>::new(x, volume, 2.1 * dx * (1.0 + 1e-9), 0.4, omega).energy(&u, volume)
        }
        _ => {
            let u: Vec<[f64; 2]> = u[0].iter().zip(&u[1]).map(|(x, y)| [*x, *y]).collect();
            Solid::<2>::new(x, volume, 2.1 * dx * (1.0 + 1e-9), 0.4, omega).energy(&u, volume)
        }
    };
    simulation.row.kinetic + strain
}

#[test]
fn waves_leave() {
    for (flavour, dx, least) in [("slab", 0.005, 1e5), ("plane_strain", 0.025, 200.0)] {
        // Two crossings of the body at c = 1.095.
        let dt = 0.3 * dx;
        let steps = (2.0 / dt) as usize;
        let text = scene(flavour, "absorbing", dx, steps, dt);
        let open = energy(&finished(&with_layer(&text, 60.0)), dx);
        let closed = energy(&finished(&with_layer(&text, 0.0)), dx);
        println!("{flavour}: {closed:.3e} -> {open:.3e}");
        assert!(open * least < closed, "{flavour}: {open:e} of {closed:e}");
    }
}

/// The layer takes nothing from the stable step: it is that of the undamped body, below which a run stays small and
/// above which it does not. Much longer runs grow slowly at any step, as the equations of the layer themselves do.
#[test]
fn the_layer_leaves_the_stable_step_as_it_is() {
    let text = scene("plane_strain", "absorbing", 0.1, 200, 1.0);
    let of = |text: &str, rule: &str| simulation(&text.replace("dt = 1\n", rule));
    let undamped = with_layer(&text, 0.0);
    let limit = of(&undamped, "safety = 1\n").dt;
    for most in [10.0, 1000.0] {
        let damped = with_layer(&text, most);
        assert_eq!(of(&damped, "safety = 1\n").dt, limit, "damping {most}");
        let mut below = of(&damped, &format!("dt = {}\n", 0.99 * limit));
        below.run(&mut ()).expect("a stable run");
        let size = largest(&displacements(&below).concat());
        println!("damping {most}: {size:.1e} after 200 steps");
        assert!(size < 0.01, "damping {most}: {size:e}");
    }
    let mut above = of(
        &with_layer(&text, 10.0),
        &format!("dt = {}\n", 1.05 * limit),
    );
    let outcome = above.run(&mut ());
    let size = largest(&displacements(&above).concat());
    assert!(outcome.is_err() || size > 1.0, "{size:e}");
}

/// Gaussian influence, a layer of 0.3: the strain energy after one second is 1.46e-3 (an independent run of the
/// same scheme), and after none 1.19787.
#[test]
fn the_square_of_the_example_drains() {
    let text = std::fs::read_to_string("../examples/absorbing-layer.toml").expect("the example");
    let began = std::time::Instant::now();
    let start = finished(&text.replace("until = 1 ", "steps = 0 "));
    let end = finished(&text);
    assert_eq!(end.body.x.len(), 101 * 101);
    let solid = Solid::<2>::new(&end.body.x, 1e-4, 3.71692 * 0.011, 0.4, |r| {
        (-(r / 0.011).powi(2)).exp()
    });
    let of = |simulation: &Simulation| {
        let u = displacements(simulation);
        let u: Vec<[f64; 2]> = u[0].iter().zip(&u[1]).map(|(x, y)| [*x, *y]).collect();
        // The example starts with a hundredth of the displacement.
        1e4 * solid.energy(&u, 1e-4)
    };
    let (first, last) = (of(&start), of(&end));
    // The law says the same of its displacement.
    for (mut simulation, energy) in [(start, first), (end, last)] {
        let density = quantity(&mut simulation, "W").expect("the energy density");
        let sum: f64 = density.components[0].iter().sum();
        assert!(
            (sum / energy - 1.0).abs() < 1e-10,
            "{sum} instead of {energy}"
        );
    }
    println!("{first:.6} -> {last:.4e} in {:.1?}", began.elapsed());
    assert!((first - 1.19787).abs() < 5e-6, "{first}");
    assert!((last / 1.46e-3 - 1.0).abs() < 0.02, "{last:e}");
}

/// A run that stops in its middle goes on to the same bits: fields at half steps, and velocities that follow their
/// neighbours.
#[test]
fn a_resumed_run_has_the_same_bits() {
    let layer = with_layer(&scene("plane_strain", "absorbing", 0.1, 40, 0.03), 40.0);
    let dragged = scene(
        "plane_stress",
        "../fixtures/laws/dragging.pd",
        0.1,
        40,
        0.03,
    );
    let material = "E = 1\nnu = 0.25\ninfluence = \"gaussian(l = 1.1*dx)\"\n";
    let dragged = dragged.replace(material, "c = 100\nD = 0.1\n");
    for (name, text) in [("layer", layer), ("drag", dragged)] {
        let text = format!("{text}[output]\ncheckpoint = 17\n");
        let dir =
            std::env::temp_dir().join(format!("pdlang-absorbing-{name}-{}", std::process::id()));
        let mut whole = simulation(&text);
        whole.run(&mut Files::new(&dir)).expect("a run");
        let mut rest = simulation(&text);
        rest.resume(&dir.join("checkpoints/step-000000017.ckpt"))
            .unwrap_or_else(|e| panic!("{e}"));
        rest.run(&mut ()).expect("a run");
        assert!(whole.state == rest.state, "{name}");
        std::fs::remove_dir_all(dir).expect("the folder");
    }
}

/// A rule after the step: every velocity is read before any is replaced, and nodes without bonds keep theirs.
#[test]
fn velocities_follow_their_neighbours() {
    let text = "[body]\nflavour = \"bar\"\nspacing = 1\ncross_section = 1\n\
        shape = { union = [{ box = { from = [0], to = [2] } }, { box = { from = [4], to = [4.2] } }] }\n\
        anchor = [0]\n[family]\nhorizon = 1.1\n[material]\nmodel = \"../fixtures/laws/dragging.pd\"\ndensity = 1\n\
        c = 1e-30\nD = 0.25\n\
        [[initial]]\nvelocity = [\"1 + x^2\"]\n[time]\nsteps = 0\ndt = 1e-9\n";
    let v = |steps: &str| {
        let text = text.replace("steps = 0", steps);
        let end = finished(&text);
        user(&end, &end.state.v[0])
    };
    // Of 1, 2, 5 and 17 the last has no bond.
    let once = [1.0 + 0.25, 2.0 + 0.25, 5.0 - 0.75, 17.0];
    assert_eq!(v("steps = 0"), once);
    let mean = 0.5 * (once[0] + once[2]);
    let again = [
        0.75 * once[0] + 0.25 * once[1],
        0.75 * once[1] + 0.25 * mean,
        0.75 * once[2] + 0.25 * once[1],
        17.0,
    ];
    let found = v("steps = 1");
    let worst = found
        .iter()
        .zip(again)
        .fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    assert!(worst < 1e-14, "{found:?}");
}

/// What flows from node to node is conserved, whatever the law of the flow, and capacities may differ.
#[test]
fn flows_conserve() {
    struct Total(BTreeMap<u64, f64>);
    impl Observer for Total {
        fn step(&mut self, simulation: &Simulation) {
            let (a, c) = (field(simulation, "a"), field(simulation, "capacity"));
            let volume = &simulation.body.volume;
            let total = a
                .iter()
                .zip(&c)
                .zip(volume)
                .map(|((a, c), v)| a * c * v)
                .sum();
            self.0.insert(simulation.state.step, total);
        }
    }
    let text = "[body]\nflavour = \"plane_stress\"\nspacing = 0.1\nthickness = 1\n\
        shape = { box = { from = [0, 0], to = [1, 1] } }\n[family]\nhorizon = \"2.1*dx\"\npartial_volume = true\n\
        [material]\nmodel = \"../fixtures/laws/leaking.pd\"\nk = 0.05\n\
        [[initial]]\na = \"sin(7*x)*cos(5*y) + 2\"\ncapacity = \"1 + x*y\"\n[time]\nsteps = 100\n";
    let mut totals = Total(BTreeMap::new());
    let mut run = simulation(text);
    run.run(&mut totals).expect("a run");
    let spread = |v: &[f64]| v.iter().fold(0.0_f64, |m, x| m.max((x - v[0]).abs()));
    let start = totals.0[&0];
    let drift = totals
        .0
        .values()
        .fold(0.0_f64, |m, t| m.max((t / start - 1.0).abs()));
    println!("drift {drift:.1e} of {start}");
    assert!(drift < 1e-13, "{drift:e}");
    assert!(spread(&field(&run, "a")) > 0.1 && run.stages >= 2);
}

/// Fields alone: a relaxation that the trapezoidal rule steps, in closed form, at a step far beyond the rate.
#[test]
fn a_damping_is_stepped_at_once() {
    for dt in [0.1_f64, 10.0] {
        let text = format!(
            "[body]\nflavour = \"slab\"\nspacing = 1\ncross_section = 1\nshape = {{ box = {{ from = [0], to = [4] }} }}\n\
             [family]\nhorizon = 1.1\n[material]\nmodel = \"../fixtures/laws/relaxing.pd\"\ntau = 0.5\n\
             [[initial]]\nq = [\"x\"]\ngoal = [3]\n[time]\nsteps = 7\ndt = {dt}\n"
        );
        let end = finished(&text);
        let c = 2.0;
        let alpha = (1.0 - 0.5 * c * dt) / (1.0 + 0.5 * c * dt);
        for (x, q) in end.body.x.iter().zip(field(&end, "q")) {
            let expected = 3.0 + (x[0] - 3.0) * alpha.powi(7);
            assert!((q - expected).abs() < 1e-13, "{dt}: {q} and {expected}");
        }
    }
}

/// A wave in two fields, one at full and one at half steps: on a ring, after n steps the first is cos(n theta) of
/// what it was, with sin(theta/2) = omega dt/2.
#[test]
fn staggered_fields_are_a_leapfrog() {
    let (nodes, dt, steps) = (40.0, 0.4, 333);
    let text = format!(
        "[body]\nflavour = \"slab\"\nspacing = 1\ncross_section = 1\nperiodic = [\"x\"]\n\
         shape = {{ box = {{ from = [0], to = [{nodes}] }} }}\n\
         [family]\nhorizon = 1.1\n[material]\nmodel = \"../fixtures/laws/sound.pd\"\nc = 1\n\
         [[initial]]\np = \"cos(2*pi*3*x/{nodes})\"\n[time]\nsteps = {steps}\ndt = {dt}\n"
    );
    let end = finished(&text);
    // The gradient of the law is a central difference.
    let omega: f64 = (2.0 * std::f64::consts::PI * 3.0 / nodes).sin();
    let theta = 2.0 * (0.5 * omega * dt).asin();
    let expected = (f64::from(steps) * theta).cos();
    for (x, p) in end.body.x.iter().zip(field(&end, "p")) {
        let shape = (2.0 * std::f64::consts::PI * 3.0 * x[0] / nodes).cos();
        assert!((p - expected * shape).abs() < 1e-12, "{p} at {}", x[0]);
    }
}

/// Without motion, the waves that fields at full and at half steps make of each other decide: on the ring of `sound`
/// the fastest has sin k = 1, so that the limit is 2/c per spacing.
#[test]
fn staggered_fields_have_a_stable_step() {
    let text = "[body]\nflavour = \"slab\"\nspacing = 1\ncross_section = 1\nperiodic = [\"x\"]\n\
        shape = { box = { from = [0], to = [40] } }\n[family]\nhorizon = 1.1\n\
        [material]\nmodel = \"../fixtures/laws/sound.pd\"\nc = 3\n[time]\nsteps = 1\nsafety = 1\n";
    let dt = simulation(text).dt;
    assert!(dt <= 2.0 / 3.0 && dt > 0.98 * 2.0 / 3.0, "{dt}");
}
