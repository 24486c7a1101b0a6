//! Balance of momentum and energy, the tangent as a derivative, and bits that do not depend on threads.

use pdlang_runtime::body::Flavour;
use pdlang_runtime::engine::{Breaking, Engine, State, Traversal};
use pdlang_tests::agreement::{Question, gather, per_node, spread};
use pdlang_tests::{bodies, laws};

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| {
        let (m, n) = ((k + 1) % 3, (k + 2) % 3);
        a[m] * b[n] - a[n] * b[m]
    })
}

/// Sum over the nodes of a vector, and the sum of its magnitudes.
fn total(vectors: impl Iterator<Item = [f64; 3]>) -> ([f64; 3], f64) {
    vectors.fold(([0.0; 3], 0.0), |(sum, size), v| {
        let norm = v.iter().map(|c| c * c).sum::<f64>().sqrt();
        (std::array::from_fn(|a| sum[a] + v[a]), size + norm)
    })
}

#[test]
fn forces_and_their_moments_sum_to_nothing() {
    for name in laws::moving().chain(["bond_memory"]) {
        let law = laws::law(name);
        for flavour in laws::flavours(&law) {
            for body in [bodies::carved(flavour, 1), bodies::cloud(flavour, 2)] {
                let question = Question::deformed(&law, body, 1e-2, 3);
                let (body, u) = (&question.body, question.path.last().expect("a deformation"));
                let scale = question
                    .consult(|oracle, _, state| oracle.force_scale(state))
                    .expect("a force");
                question.everywhere(|what, engine| {
                    let force = question.ask(engine).force;
                    let loads = |i: usize| force[i].map(|c| c * body.volume[i]);
                    let place = |i: usize| std::array::from_fn(|a| body.x[i][a] + u[i][a]);
                    let nodes = 0..force.len();
                    let volume: f64 = body.volume.iter().sum();
                    let (sum, _) = total(nodes.clone().map(loads));
                    let worst = sum.iter().fold(0.0_f64, |m, c| m.max(c.abs())) / (scale * volume);
                    assert!(worst <= 1e-14, "{what}: momentum {worst:e}");
                    if laws::SMALL_STRAINS.contains(&name) {
                        return;
                    }
                    let (moment, _) = total(nodes.map(|i| cross(place(i), loads(i))));
                    let arm = 10.0 * body.spacing;
                    let worst =
                        moment.iter().fold(0.0_f64, |m, c| m.max(c.abs())) / (scale * volume * arm);
                    assert!(worst <= 1e-14, "{what}: angular momentum {worst:e}");
                });
            }
        }
    }
}

fn dot(a: &[Vec<f64>], b: &[Vec<f64>], volume: &[f64]) -> f64 {
    a.iter()
        .zip(b)
        .map(|(a, b)| {
            a.iter()
                .zip(b)
                .zip(volume)
                .map(|((a, b), v)| a * b * v)
                .sum::<f64>()
        })
        .sum()
}

/// The tangent is a derivative: it is the limit of force differences, and of an energy it is symmetric.
#[test]
fn the_tangent_is_the_derivative_of_the_force() {
    for name in laws::moving().chain(["bond_memory"]) {
        let law = laws::law(name);
        for flavour in laws::flavours(&law) {
            let question = Question::deformed(&law, bodies::cloud(flavour, 4), 1e-2, 5);
            let mut engine = question.engine(question.fastest(), Traversal::Cloud, None);
            let mut state = question.state(&mut engine);
            let mut du = state.u.clone();
            spread(&engine, &question.du, &mut du);
            let h = 1e-5;
            let [plus, minus] = [h, -h].map(|h| moved(&mut engine, &state, &du, h));
            engine.forces(&mut state, Breaking::Held);
            let tangent = engine.tangent(&state, &du).to_vec();
            let (mut gap, mut size) = (0.0_f64, 0.0_f64);
            for (a, t) in tangent.iter().enumerate() {
                for slot in engine.slots().iter().map(|s| *s as usize) {
                    gap = gap.max((t[slot] - (plus[a][slot] - minus[a][slot]) / (2.0 * h)).abs());
                    size = size.max(t[slot].abs());
                }
            }
            // Rounding of forces 1e-14/h, third derivatives h^2.
            assert!(gap <= 1e-8 * size, "{question}: {:e}", gap / size);
            if engine.spec().energy.is_some() {
                symmetric(&question, &mut engine, &mut state, &du);
            }
        }
    }
}

fn moved(engine: &mut Engine, state: &State, du: &[Vec<f64>], h: f64) -> Vec<Vec<f64>> {
    let mut moved = state.clone();
    for (u, d) in moved.u.iter_mut().zip(du) {
        u.iter_mut().zip(d).for_each(|(u, d)| *u += h * d);
    }
    engine.forces(&mut moved, Breaking::Held);
    engine.force().to_vec()
}

fn symmetric(question: &Question, engine: &mut Engine, state: &mut State, du: &[Vec<f64>]) {
    let mut dv = state.u.clone();
    spread(
        engine,
        &bodies::deformation(&question.body, 1e-2, 123),
        &mut dv,
    );
    engine.forces(state, Breaking::Held);
    let a = engine.tangent(state, du).to_vec();
    let b = engine.tangent(state, &dv).to_vec();
    let volume = engine.volume().to_vec();
    let (left, right) = (dot(&a, &dv, &volume), dot(&b, du, &volume));
    let size = (dot(&a, &a, &volume) * dot(&dv, &dv, &volume)).sqrt();
    assert!(
        (left - right).abs() <= 1e-13 * size,
        "{question}: {left:e} and {right:e} of {size:e}"
    );
}

/// Velocity Verlet from rest, by hand; calls `watch` with the kinetic and the strain energy [J] every ten steps.
fn run(question: &Question, dt: f64, steps: usize, mut watch: impl FnMut(f64, f64)) {
    const RHO: f64 = 2200.0;
    let mut engine = question.engine(question.fastest(), Traversal::Auto, None);
    let mut state = question.state(&mut engine);
    engine.forces(&mut state, Breaking::Held);
    let kick = |engine: &Engine, state: &mut State| {
        for (v, f) in state.v.iter_mut().zip(engine.force()) {
            v.iter_mut()
                .zip(f)
                .for_each(|(v, f)| *v += 0.5 * dt * f / RHO);
        }
    };
    for step in 0..=steps {
        if step % 10 == 0 {
            let kinetic = 0.5 * RHO * dot(&state.v, &state.v, engine.volume());
            let density = engine.energy(&state).to_vec();
            watch(
                kinetic,
                density
                    .iter()
                    .zip(engine.volume())
                    .map(|(w, v)| w * v)
                    .sum(),
            );
        }
        kick(&engine, &mut state);
        for (u, v) in state.u.iter_mut().zip(&state.v) {
            u.iter_mut().zip(v).for_each(|(u, v)| *u += dt * v);
        }
        engine.forces(&mut state, Breaking::Held);
        kick(&engine, &mut state);
    }
}

/// Over 10,000 steps at about a quarter of the stable step the total energy of a shaken block wavers by less than
/// one percent, as Verlet's does, and does not drift: its mean over each tenth of the run stays within 5e-4.
#[test]
fn energy_neither_grows_nor_fades() {
    for name in ["pmb", "lps"] {
        let law = laws::law(name);
        let body = bodies::lattice(Flavour::Solid, [6, 6, 6], false);
        let mut question = Question::at_rest(&law, body);
        question.path = vec![bodies::deformation(&question.body, 1e-2, 3)];
        // The stable step of the block, dx/c with c = 3500 m/s, is about 1.5e-7 s.
        let mut totals = Vec::new();
        run(&question, 4e-8, 10_000, |kinetic, strain| {
            totals.push(kinetic + strain)
        });
        let mean = |part: &[f64]| part.iter().sum::<f64>() / part.len() as f64;
        let means: Vec<f64> = totals.chunks_exact(totals.len() / 10).map(mean).collect();
        let first = means[0];
        let wavering = totals
            .iter()
            .fold(0.0_f64, |m, e| m.max((e / first - 1.0).abs()));
        let drift = means
            .iter()
            .fold(0.0_f64, |m, e| m.max((e / first - 1.0).abs()));
        println!("{name}: wavering {wavering:.2e}, drift {drift:.2e}");
        assert!(
            wavering <= 1e-2,
            "{name}: the energy wavers by {wavering:e}"
        );
        assert!(drift <= 5e-4, "{name}: the energy drifts by {drift:e}");
    }
}

/// Ten steps with breaking bonds on a body large enough to be shared out, with one and with two threads.
#[test]
fn bits_do_not_depend_on_threads() {
    for name in ["pmb", "lps", "bond_memory"] {
        let law = laws::law(name);
        for traversal in [Traversal::Lattice, Traversal::Cloud] {
            let body = bodies::lattice(Flavour::Solid, [24, 22, 20], false);
            let mut question = Question::at_rest(&law, body).with(&[("s0", 0.004)]);
            question.path = vec![bodies::deformation(&question.body, 5e-3, 3)];
            let [one, two] = [1, 2].map(|threads| {
                let pool = rayon::ThreadPoolBuilder::new()
                    .num_threads(threads)
                    .build()
                    .expect("threads");
                pool.install(|| ten_steps(&question, traversal))
            });
            assert!(one.0 > 0, "{name}: nothing breaks");
            assert!(
                one == two,
                "{name} {traversal:?}: the bits depend on the number of threads"
            );
        }
    }
}

/// Broken bonds, the state, forces and energies after ten steps.
fn ten_steps(question: &Question, traversal: Traversal) -> (usize, State, Vec<[f64; 3]>, Vec<f64>) {
    let mut engine = question.engine(question.fastest(), traversal, None);
    let mut state = question.state(&mut engine);
    let mut broken = 0;
    for _ in 0..10 {
        broken += engine.forces(&mut state, Breaking::Armed);
        engine.commit(&mut state);
        for (v, f) in state.v.iter_mut().zip(engine.force()) {
            v.iter_mut()
                .zip(f)
                .for_each(|(v, f)| *v += 5e-8 * f / 2200.0);
        }
        for (u, v) in state.u.iter_mut().zip(&state.v) {
            u.iter_mut().zip(v).for_each(|(u, v)| *u += 5e-8 * v);
        }
    }
    engine.forces(&mut state, Breaking::Held);
    let force = gather(&engine, engine.force());
    let energy = engine.energy(&state).to_vec();
    let energy = if energy.is_empty() {
        energy
    } else {
        per_node(&engine, &energy)
    };
    (broken, state, force, energy)
}
