//! Matching boundaries in scenes: what holds to the bit, and energies that are accounted for. What is left of waves,
//! against papers and independent runs, is in `docs/accuracy.md`.

use std::path::{Path, PathBuf};

use pdlang_models::language::Pdlang;
use pdlang_runtime::checkpoint;
use pdlang_runtime::observe::Observer;
use pdlang_runtime::scene::Scene;
use pdlang_runtime::simulate::Simulation;
use pdlang_tests::steps;

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

fn displacements(sim: &Simulation) -> Vec<Vec<f64>> {
    let of = |u: &Vec<f64>| sim.engine.slots().iter().map(|s| u[*s as usize]).collect();
    sim.state.u.iter().map(of).collect()
}

fn gap(a: &[Vec<f64>], b: &[Vec<f64>]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}

/// A block of any dimension with a hump in its middle; spacing, density and modulus of size 1.
fn hump(flavour: &str, size: [f64; 3], law: &str, rest: &str) -> String {
    let dim = match flavour {
        "bar" | "slab" => 1,
        "3d" => 3,
        _ => 2,
    };
    let cross = ["cross_section = 1", "thickness = 1", ""][dim - 1];
    let to: Vec<String> = size[..dim].iter().map(f64::to_string).collect();
    let middle: Vec<String> = ["x", "y", "z"]
        .iter()
        .zip(size)
        .take(dim)
        .map(|(x, s)| format!("({x} - {})^2", s / 2.0))
        .collect();
    let hump = format!("\"0.01*exp(-({})/16)\"", middle.join(" + "));
    let displacement = vec![hump; dim].join(", ");
    format!(
        "[body]\nflavour = \"{flavour}\"\nspacing = 1\n{cross}\nshape = {{ box = {{ from = [{}], to = [{}] }} }}\n\
         [family]\nhorizon = 2\n[material]\ndensity = 1\n{law}\n[[initial]]\ndisplacement = [{displacement}]\n\
         [output]\nhistory = 5\n{rest}\n",
        vec!["0"; dim].join(", "),
        to.join(", ")
    )
}

const LPS: &str = "model = \"lps\"\nlinearised = true\nK = 0.6\nG = 0.3";
const HELD: &str = "model = \"correspondence_stabilised\"\nE = 1\nnu = 0.25\nGs = 0.5";
const ALL: &str = "[[matching]]\nsides = \"all\"\n";

#[test]
fn traversals_agree_and_a_run_goes_on_to_the_same_bits() {
    let time = "[time]\nsteps = 60\ndt = 0.3\n";
    let text = hump(
        "plane_strain",
        [24.0, 20.0, 0.0],
        LPS,
        &format!("{ALL}{time}"),
    );
    let whole = finished(&text);
    let cloud = finished(&text.replace("horizon = 2\n", "horizon = 2\ntraversal = \"cloud\"\n"));
    assert!(gap(&displacements(&whole), &displacements(&cloud)) < 1e-14);
    let folder = steps::folder("matching");
    let mut saver = Saver {
        file: folder.join("half"),
    };
    let saving = text.replace("history = 5\n", "history = 5\ncheckpoint = 30\n");
    simulation(&saving).run(&mut saver).unwrap();
    let mut second = simulation(&text);
    second.resume(&saver.file).unwrap();
    assert_eq!(second.state.step, 30);
    second.run(&mut ()).unwrap();
    assert_eq!(displacements(&whole), displacements(&second));
    assert_eq!(whole.row.left, second.row.left);
    std::fs::remove_dir_all(&folder).unwrap();
}

/// Writes the checkpoint of step 30.
struct Saver {
    file: PathBuf,
}

impl Observer for Saver {
    fn checkpoint(&mut self, sim: &Simulation) -> Result<Option<PathBuf>, String> {
        if sim.state.step == 30 {
            let written = checkpoint::write(&self.file, sim.identity, &sim.snapshot());
            written.map_err(|e| e.to_string())?;
        }
        Ok(None)
    }
}

/// What leaves is what was there, less what is left.
#[test]
fn energies_are_accounted_for() {
    for (flavour, size, law, share) in [
        ("slab", [60.0, 0.0, 0.0], LPS, 1e-3),
        ("plane_strain", [40.0, 36.0, 0.0], LPS, 0.05),
        ("3d", [22.0, 20.0, 18.0], LPS, 0.1),
    ] {
        let time = "[time]\nuntil = 60\nsafety = 0.1\n";
        let sim = finished(&hump(flavour, size, law, &format!("{ALL}{time}")));
        let first = {
            let mut start = simulation(&hump(flavour, size, law, "[time]\nsteps = 0\n"));
            start.run(&mut ()).unwrap();
            start.row.kinetic + start.row.strain.unwrap()
        };
        let row = &sim.row;
        let rest = row.kinetic + row.strain.unwrap();
        assert!(rest < share * first, "{flavour}: {rest} of {first}");
        assert!(row.left > (1.0 - 3.0 * share) * first, "{flavour}: {row:?}");
        assert!(row.lost.abs() < 2e-3 * first, "{flavour}: {row:?}");
        // Free ends keep it all.
        let free = finished(&hump(flavour, size, law, time));
        let kept = free.row.kinetic + free.row.strain.unwrap();
        assert!(
            (kept - first).abs() < 2e-2 * first,
            "{flavour}: {kept} of {first}"
        );
    }
}

/// Laws whose short waves run backwards: without a strip their energy is back after some crossings, as the control shows,
/// which is stopped for that or ends with more.
#[test]
fn waves_at_all_angles_leave_for_good() {
    let pmb = "model = \"pmb\"\nlinearised = true\nK = 0.6";
    for (law, horizon) in [(LPS, "2"), (pmb, "3.1")] {
        let time = "[time]\nuntil = 900\n";
        let text = hump(
            "plane_stress",
            [26.0, 24.0, 0.0],
            law,
            &format!("{ALL}{time}"),
        );
        let text = text.replace("horizon = 2\n", &format!("horizon = {horizon}\n"));
        let sim = finished(&text);
        let energy = |sim: &Simulation| sim.row.kinetic + sim.row.strain.unwrap_or(0.0);
        let rest = energy(&sim) / sim.row.left;
        assert!((0.0..1e-6).contains(&rest), "{law}: {rest}");
        let bare = text.replace("sides = \"all\"", "sides = \"all\"\nsmooth = 0");
        let mut bare = simulation(&bare);
        let grown = bare.run(&mut ()).is_err() || energy(&bare) > 1e3 * energy(&sim);
        assert!(grown, "{law}: {:?}", bare.row);
    }
}

/// The shortest waves lose 0.3 of their velocity while the fastest wave travels a spacing, less and less inwards. In so
/// short a step forces change nothing yet.
#[test]
fn the_strip_takes_what_it_says() {
    for (flavour, size, signs) in [
        ("bar", [40.0, 0.0, 0.0], "cos(pi*x)"),
        ("plane_stress", [40.0, 12.0, 0.0], "cos(pi*x)*cos(pi*y)"),
    ] {
        let dim = if flavour == "bar" { 1 } else { 2 };
        let velocity = vec![format!("\"{signs}\""); dim].join(", ");
        let rest = format!(
            "[[initial]]\nvelocity = [{velocity}]\n[[matching]]\nsides = \"-x\"\nsmooth = 10\n\
             [time]\nsteps = 1\ndt = 1e-6\n"
        );
        let text = hump(flavour, size, LPS, &rest).replace("0.01*exp", "0*exp");
        let text = match dim {
            1 => text.replace("flavour", "anchor = [0]\nflavour"),
            _ => text.replace("flavour", "anchor = [0, 0]\nperiodic = [\"y\"]\nflavour"),
        };
        let sim = finished(&text);
        let face = &sim.faces[0];
        let c = face.components[0].chain.series(1)[0];
        let cells = &sim.body.grid.as_ref().expect("a lattice").cell;
        let (mut inside, mut first) = (0, f64::NAN);
        for (node, cell) in cells.iter().enumerate() {
            let Some(deep) = (cell[0] as usize).checked_sub(face.layers) else {
                continue;
            };
            for v in &sim.state.v {
                let v = v[sim.engine.slot(node)].abs();
                let share = (10.0 - deep as f64).max(0.0) / 10.0;
                let lost = (1.0 - v) / (0.3 * c * 1e-6);
                // The last plane has no neighbour behind it, and the share of the boundary is that of the first.
                if deep > 0 && deep != 9 {
                    assert!((lost - share).abs() < 1e-3, "{flavour} {deep}: {lost}");
                    inside += 1;
                }
                first = if deep == 1 { lost } else { first };
            }
        }
        assert!(inside > 20 && first > 0.8, "{flavour}: {inside} {first}");
    }
}

/// The usual strip has eight planes behind four of the boundary; twenty planes have room for five at either end, so that one
/// at least is left as it is.
#[test]
fn a_thin_body_keeps_its_middle() {
    let of = |matching: &str| {
        let rest = format!("{matching}[time]\nsteps = 1\n");
        let sim = simulation(&hump("plane_stress", [20.0, 40.0, 0.0], LPS, &rest));
        let one = |f: &pdlang_runtime::matching::Face| (f.strip.planes, f.to_string());
        sim.faces.iter().map(one).collect::<Vec<_>>()
    };
    let faces = of(ALL);
    let planes: Vec<usize> = faces.iter().map(|f| f.0).collect();
    assert_eq!(planes, [5, 5, 8, 8]);
    for (planes, text) in &faces {
        let cramped = text.contains("as many as there is room for");
        assert_eq!(cramped, *planes == 5, "{text}");
    }
    // The other end is free: its half is there too.
    assert_eq!(of("[[matching]]\nsides = \"-x\"\n")[0].0, 8);
    assert_eq!(of("[[matching]]\nsides = \"-x\"\nsmooth = 15\n")[0].0, 15);
}

/// The halves of a cut body know nothing of each other, although they are neighbours in the strip.
#[test]
fn no_velocity_goes_across_a_crack() {
    let rest = "[[crack]]\nsegment = { from = [-1, 10], to = [41, 10] }\n[[matching]]\nsides = [\"-x\", \"+x\"]\n\
                [time]\nuntil = 30\n";
    let text = hump("plane_stress", [40.0, 20.0, 0.0], LPS, rest);
    let above = text.replace("\"0.01*exp", "\"select(y > 10, 1, 0)*0.01*exp");
    assert_ne!(text, above);
    let largest = |text: &str, below: bool| {
        let sim = finished(text);
        let u = displacements(&sim);
        let nodes = sim.body.x.iter().enumerate();
        let here = nodes.filter(|(_, x)| (x[1] < 10.0) == below);
        let of = |n: usize| u.iter().map(move |u| u[n].abs());
        here.flat_map(|(n, _)| of(n).collect::<Vec<_>>())
            .fold(0.0, f64::max)
    };
    assert!(largest(&above, false) > 1e-5);
    assert_eq!(largest(&above, true), 0.0);
}

/// A bond that breaks in the strip during a run: what is inside of it goes on as if alone.
#[test]
fn no_velocity_goes_across_a_bond_that_broke() {
    let bar = |s0: f64| {
        let law = format!("model = \"pmb\"\nK = 0.6\ns0 = {s0}");
        let rest = "[[initial]]\nregion = { box = { from = [6], to = [40] } }\nvelocity = [0.1]\n\
                    [[matching]]\nsides = \"-x\"\nsmooth = 20\n[time]\nsteps = 20\ndt = 0.1\n";
        let text = hump("bar", [40.0, 0.0, 0.0], &law, rest).replace("0.01*exp", "0*exp");
        let sim = finished(&text.replace("horizon = 2\n", "horizon = 1.1\n"));
        let slots = sim.engine.slots().iter();
        let v: Vec<f64> = slots.map(|s| sim.state.v[0][*s as usize]).collect();
        (v, sim.row.left)
    };
    let (v, left) = bar(1e-4);
    assert!(v[..6].iter().all(|v| *v == 0.0), "{v:?}");
    assert!(v[6..].iter().all(|v| *v == 0.1), "{v:?}");
    assert_eq!(left, 0.0);
    let (v, left) = bar(1.0);
    assert!(v[5] > 0.01 && v[6] < 0.09 && left > 0.0, "{v:?} {left}");
}

/// A strip of several tasks: sums do not depend on who computes them.
#[test]
fn threads_change_no_bit() {
    let time = "smooth = 20\n[time]\nsteps = 10\ndt = 0.3\n";
    let text = hump(
        "plane_stress",
        [150.0, 90.0, 0.0],
        LPS,
        &format!("{ALL}{time}"),
    );
    let of = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let sim = pool.build().expect("threads").install(|| finished(&text));
        (displacements(&sim), sim.row.left)
    };
    let (one, four) = (of(1), of(4));
    assert!(one == four && one.1 > 0.0, "{} {}", one.1, four.1);
}

/// Up to the moment at which the first waves of a wider body would be back nothing tells the two apart: boundaries of the
/// order 1 send back a part in a hundred of waves this short.
#[test]
fn it_is_as_if_the_body_went_on() {
    for law in [LPS, HELD] {
        let time = "[time]\nuntil = 40\ndt = 0.1\n";
        let small = finished(&hump(
            "slab",
            [48.0, 0.0, 0.0],
            law,
            &format!("{ALL}{time}"),
        ));
        let large = finished(&hump("slab", [248.0, 0.0, 0.0], law, time));
        let free = finished(&hump("slab", [48.0, 0.0, 0.0], law, time));
        let inner = |sim: &Simulation, from: usize| displacements(sim)[0][from..from + 40].to_vec();
        let with = gap(&[inner(&small, 4)], &[inner(&large, 104)]);
        let without = gap(&[inner(&free, 4)], &[inner(&large, 104)]);
        assert!(with < 1.5e-4, "{law}: {with}");
        assert!(without > 20.0 * with, "{law}: {without} {with}");
    }
}

#[test]
fn a_body_at_rest_elsewhere_stays_there() {
    let text = hump(
        "plane_strain",
        [20.0, 20.0, 0.0],
        LPS,
        &format!("{ALL}[time]\nsteps = 20\n"),
    );
    let start = text.find("displacement = [").unwrap();
    let end = start + text[start..].find('\n').unwrap();
    let text = text.replace(&text[start..end], "displacement = [0.1, -0.2]");
    let u = displacements(&finished(&text));
    assert!(u[0].iter().all(|u| *u == 0.1) && u[1].iter().all(|u| *u == -0.2));
}

/// Where the motion is prescribed it holds, until it ends.
#[test]
fn conditions_come_first_and_may_end() {
    let rest = "[[condition]]\nregion = { box = { from = [0], to = [1] } }\ndisplacement = [\"0.01*t\"]\n\
                [[condition]]\nregion = { box = { from = [20], to = [21] } }\ndisplacement = [\"0.02*t\"]\nuntil = 3\n";
    let time = |until: f64| format!("[time]\nuntil = {until}\ndt = 0.1\n");
    let at = |until: f64| {
        let text = hump(
            "slab",
            [40.0, 0.0, 0.0],
            LPS,
            &format!("{ALL}{rest}{}", time(until)),
        );
        displacements(&finished(&text))[0].clone()
    };
    let (early, late) = (at(3.0), at(9.0));
    assert!((early[20] - 0.06).abs() < 1e-12 && (early[0] - 0.03).abs() < 1e-12);
    assert!((late[0] - 0.09).abs() < 1e-12);
    assert!((late[20] - 0.18).abs() > 0.01, "{}", late[20]);
}

/// Heat goes its way beside the waves.
#[test]
fn fields_go_on_at_a_boundary() {
    let names = "alpha = 1e-3\nT0 = 0\nk = 0.1\ncv = 1\n";
    let law = format!("model = \"thermo_pmb\"\nK = 0.6\n{names}");
    let time = "[time]\nuntil = 120\nsafety = 0.3\n";
    let sim = finished(&hump(
        "bar",
        [60.0, 0.0, 0.0],
        &law,
        &format!("{ALL}{time}"),
    ));
    let row = &sim.row;
    assert!(row.left > 0.0 && row.kinetic < 1e-2 * row.left, "{row:?}");
}

/// Coefficients that the engine's own tangent gives are those of the closed forms (eq. 41 and Table 1 of the paper, as
/// corrected): n = 2, Gs = 0.5.
#[test]
fn coefficients_follow_from_the_law() {
    let bar = |order: usize, gs: f64| {
        let law = format!("model = \"correspondence_stabilised\"\nE = 1\nnu = 0\nGs = {gs}");
        let matching = format!("[[matching]]\nsides = \"-x\"\norder = {order}\nunstable = true\n");
        simulation(&hump(
            "bar",
            [40.0, 0.0, 0.0],
            &law,
            &format!("{matching}[time]\nsteps = 1\n"),
        ))
    };
    let near = |a: f64, b: f64| assert!((a - b).abs() < 1e-10 * b.abs().max(1.0), "{a} {b}");
    let sim = bar(2, 0.5);
    assert_eq!(sim.faces[0].layers, 4);
    let (a1, a3) = (1.0, 17.0 / 30.0 - 17.0 * 0.5 / 64.0);
    let found = &sim.faces[0].components[0].conditions[0];
    near(found.c[1], 4.0 * (a1 + 3.0 * a3) / (a1 - 6.0 * a3));
    near(found.b[0], -3.0 * a1 * a1 / (a1 - 6.0 * a3));
    let sim = bar(2, 0.0);
    near(sim.faces[0].components[0].conditions[0].c[1], -4.5);
    near(sim.faces[0].components[0].conditions[0].b[0], 1.25);
}
