//! The scenes of `scenes/` reproduce other codes and the exact solution of the pulse.

use std::path::Path;

use pdlang_models::language::Pdlang;
use pdlang_runtime::engine::Breaking;
use pdlang_runtime::observe::Observer;
use pdlang_runtime::scene::Scene;
use pdlang_runtime::simulate::Simulation;
use pdlang_tests::block::{AMPLITUDE, lammps_displacements, largest_difference, relative_error};
use pdlang_tests::pulse;
use pdlang_tests::reference::Table;

fn finished(scene: &str) -> Simulation {
    let path = format!("scenes/{scene}.toml");
    let scene = Scene::read(Path::new(&path), &Pdlang).unwrap_or_else(|e| panic!("{e}"));
    let mut simulation = scene.simulation().unwrap_or_else(|e| panic!("{e}"));
    simulation
        .run(&mut ())
        .unwrap_or_else(|e| panic!("{path}: {e}"));
    simulation
}

/// Three components per node, in the order of the body.
fn per_node(simulation: &Simulation, arrays: &[Vec<f64>]) -> Vec<[f64; 3]> {
    let slot = |node| simulation.engine.slot(node);
    let nodes = simulation.body.x.len();
    (0..nodes)
        .map(|n| std::array::from_fn(|d| arrays[d][slot(n)]))
        .collect()
}

fn forces(scene: &str) -> Vec<[f64; 3]> {
    let mut simulation = finished(scene);
    let Simulation { engine, state, .. } = &mut simulation;
    engine.forces(state, Breaking::Held);
    let force = engine.force().to_vec();
    per_node(&simulation, &force)
}

fn displacements(scene: &str) -> Vec<[f64; 3]> {
    let simulation = finished(scene);
    per_node(&simulation, &simulation.state.u)
}

/// The bounds are those of the comparison with a plain implementation: 1e-12 of the largest force, 1e-11 of
/// the amplitude after 100 steps.
fn reproduces(scene: &str, data: &str, displacement: impl Fn(&Table) -> Vec<[f64; 3]>) {
    let start = Table::read(&format!("{data}.0")).expect("reference data");
    let error = relative_error(
        &forces(&format!("{scene}_0")),
        &start.vectors(["fx", "fy", "fz"]),
    );
    println!("{scene}, force: {error:.2e}");
    assert!(error <= 1e-12, "{scene}: the forces differ by {error:e}");
    let end = Table::read(&format!("{data}.100")).expect("reference data");
    let u = displacements(&format!("{scene}_100"));
    let error = largest_difference(&u, &displacement(&end)) / AMPLITUDE;
    println!("{scene}, displacement: {error:.2e}");
    assert!(
        error <= 1e-11,
        "{scene}: the displacements differ by {error:e} of the amplitude"
    );
}

#[test]
fn pmb_of_lammps() {
    reproduces("lammps_pmb", "lammps/pmb_wave", lammps_displacements);
}

#[test]
fn lps_of_lammps() {
    reproduces("lammps_lps", "lammps/lps_wave", lammps_displacements);
}

fn cabanapd(scene: &str, data: &str) {
    reproduces(scene, data, |t| t.vectors(["ux", "uy", "uz"]));
}

#[test]
fn pmb_of_cabanapd() {
    cabanapd("cabanapd_pmb", "cabanapd/pmb");
}

#[test]
fn lps_of_cabanapd_with_a_constant_influence() {
    cabanapd("cabanapd_lps_constant", "cabanapd/lps_infl0");
}

#[test]
fn lps_of_cabanapd_with_inverse_length() {
    cabanapd("cabanapd_lps_inverse", "cabanapd/lps_infl1");
}

#[test]
fn the_pulse_after_2000_steps() {
    for (column, p) in pulse::EXPONENTS.iter().enumerate() {
        let simulation = finished(&format!("pulse_p{p}"));
        for probe in pulse::PROBES.iter().filter(|probe| probe.step == 2000) {
            let node = (probe.x / pulse::DX) as usize;
            assert_eq!(simulation.body.x[node][0], probe.x);
            let u = simulation.state.u[0][simulation.engine.slot(node)];
            let error = (u - probe.u[column]).abs();
            // The tolerance that the reference states for its Verlet columns.
            assert!(
                error < 1e-9,
                "p = {p}, x = {}: {u} instead of {}",
                probe.x,
                probe.u[column]
            );
        }
    }
}

/// Sums over the steps of a run: of u_x against x and of u_y against y, in the middle of a plate.
#[derive(Default)]
struct MeanStrain {
    along: f64,
    across: f64,
    steps: f64,
}

/// Slope of the least squares through displacement component `a` against position, over the nodes that `gauge` chooses.
fn slope(sim: &Simulation, a: usize, gauge: impl Fn(&[f64; 3]) -> bool) -> f64 {
    let (mut n, mut x1, mut u1, mut xx, mut xu) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for (node, x) in sim.body.x.iter().enumerate().filter(|(_, x)| gauge(x)) {
        let u = sim.state.u[a][sim.engine.slot(node)];
        n += 1.0;
        x1 += x[a];
        u1 += u;
        xx += x[a] * x[a];
        xu += x[a] * u;
    }
    (xu - x1 * u1 / n) / (xx - x1 * x1 / n)
}

impl Observer for MeanStrain {
    fn step(&mut self, sim: &Simulation) {
        let extent = |a: usize| sim.body.x.iter().fold(0.0_f64, |m, x| m.max(x[a].abs()));
        let (length, width) = (extent(0), extent(1));
        self.along += slope(sim, 0, |x| x[0].abs() <= 0.6 * length);
        self.across += slope(sim, 1, |x| x[1].abs() <= 0.6 * width);
        self.steps += 1.0;
    }
}

/// Madenci and Oterkus 2014, section 8.4: p0/E1 along the fibres, -nu12 p0/E1 across, on the mean of a vibration.
/// Along, nearly all of the stiffness are fibre bonds, whose sums are exact for every node; across there is the
/// matrix, with the soft surfaces of a plate of 30 nodes.
#[test]
fn a_lamina_in_tension_has_the_strains_of_its_moduli() {
    let path = "scenes/lamina_tension.toml";
    let scene = Scene::read(Path::new(path), &Pdlang).unwrap_or_else(|e| panic!("{e}"));
    let mut simulation = scene.simulation().unwrap_or_else(|e| panic!("{e}"));
    let mut mean = MeanStrain::default();
    simulation
        .run(&mut mean)
        .unwrap_or_else(|e| panic!("{path}: {e}"));
    let (along, across) = (mean.along / mean.steps, mean.across / mean.steps);
    let (along, across) = (along / 1e-3, across / (-1e-3 / 3.0));
    println!("strain along {along:.4}, across {across:.4} of the classical ones");
    assert!((along - 1.0).abs() <= 0.01, "along: {along}");
    assert!((across - 1.0).abs() <= 0.05, "across: {across}");
}

/// Sums over the steps of a run: of the strains along x of the two halves.
#[derive(Default)]
struct TwoHalves([f64; 2], f64);

impl Observer for TwoHalves {
    fn step(&mut self, sim: &Simulation) {
        for (sum, side) in self.0.iter_mut().zip([-1.0, 1.0]) {
            *sum += slope(sim, 0, |x| (0.01..0.04).contains(&(side * x[0])));
        }
        self.1 += 1.0;
    }
}

/// Springs in series: each half is strained by the common stress over its own modulus, here on the mean of a vibration
/// and a centimetre away from the joint and from the loaded edges. The free sides are a few per cent too soft.
#[test]
fn two_materials_in_tension_are_springs_in_series() {
    let path = "../examples/two-materials.toml";
    let scene = Scene::read(Path::new(path), &Pdlang).unwrap_or_else(|e| panic!("{e}"));
    let mut simulation = scene.simulation().unwrap_or_else(|e| panic!("{e}"));
    let mut halves = TwoHalves::default();
    simulation
        .run(&mut halves)
        .unwrap_or_else(|e| panic!("{path}: {e}"));
    let TwoHalves([soft, stiff], steps) = halves;
    let (soft, stiff) = (soft / steps / 1e-3, stiff / steps / 0.25e-3);
    println!("strain of the soft half {soft:.4}, of the stiff half {stiff:.4} of the springs'");
    assert!((soft - 1.0).abs() <= 0.04, "soft half: {soft}");
    assert!((stiff - 1.0).abs() <= 0.04, "stiff half: {stiff}");
    assert!((soft / stiff - 1.0).abs() <= 0.02, "{soft} and {stiff}");
}
