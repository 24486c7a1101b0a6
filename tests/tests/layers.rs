//! `[[absorbing]]`: the damping rates of layers, and where they hold: beside free sides, where a crack runs into them, and where
//! one does not.

use std::path::Path;

use pdlang_models::language::Pdlang;
use pdlang_runtime::scene::Scene;
use pdlang_runtime::simulate::Simulation;

fn simulation(text: &str) -> Simulation {
    let scene = Scene::parse(text, Path::new("scenes/scene.toml"), &Pdlang);
    let scene = scene.unwrap_or_else(|e| panic!("{e}"));
    scene.simulation().unwrap_or_else(|e| panic!("{e}"))
}

/// Of size 1, with 20 neighbours a node and what else is said.
fn scene(law: &str, from: [f64; 2], to: [f64; 2], push: &str, rest: &str) -> String {
    format!(
        "[body]\nflavour = \"plane_strain\"\nspacing = 0.01\nthickness = 1\nanchor = [0, 0]\n\
         shape = {{ box = {{ from = {from:?}, to = {to:?} }} }}\n[family]\nhorizon = \"2.8 dx\"\n\
         [material]\nmodel = \"{law}\"\ndensity = 1\nE = 1\nnu = 0.25\ninfluence = \"gaussian(l = 0.75*dx)\"\n\
         [[initial]]\ndisplacement = [0, \"{push}\"]\n{rest}"
    )
}

fn field(sim: &Simulation, name: &str) -> Vec<Vec<f64>> {
    let slots = sim.engine.state_slots(name).expect("the field");
    let of = |k: usize| {
        let all = sim.engine.spread(k, &sim.state.slots[k]);
        let slots = sim.engine.slots().iter();
        slots.map(|s| all[*s as usize]).collect()
    };
    slots.into_iter().map(of).collect()
}

/// Rates as Wildman and Gazonas have them, and as a square; a part of them along the sides, where two layers meet both.
#[test]
fn rates_rise_from_the_inner_edge() {
    for (profile, across) in [("gaussian", 0.0), ("quadratic", 0.1)] {
        let layers = format!(
            "[[absorbing]]\nsides = [\"-x\", \"+y\"]\nthickness = 0.3\nramp = 0.2\nrate = 50\nprofile = \"{profile}\"\n\
             across = {across}\n[[absorbing]]\nsides = \"+x\"\nthickness = 0.1\nrate = 20\nacross = 0\n[time]\nsteps = 0\n"
        );
        let sim = simulation(&scene("absorbing", [0.0; 2], [1.0, 0.6], "0", &layers));
        let rise = |depth: f64, ramp: f64, most: f64, profile: &str| {
            let rest = (1.0 - depth / ramp).max(0.0);
            match profile {
                _ if depth <= 1e-12 => 0.0,
                "gaussian" => most * (-(1e6_f64.ln()) * rest * rest).exp(),
                _ => most * (1.0 - rest).powi(2),
            }
        };
        let found = field(&sim, "phi");
        let mut damped = 0;
        for (n, x) in sim.body.x.iter().enumerate() {
            let left = rise(0.3 - x[0], 0.2, 50.0, profile);
            let right = rise(x[0] - 0.9, 0.1, 20.0, "gaussian");
            let top = rise(x[1] - 0.3, 0.2, 50.0, profile);
            let known = [left + right + across * top, top + across * left];
            for a in 0..2 {
                let off = (found[a][n] - known[a]).abs();
                // At the inner edge a Gaussian jumps to a millionth.
                assert!(
                    off < 1e-4,
                    "{profile} {a} at {x:?}: {} {}",
                    found[a][n],
                    known[a]
                );
            }
            damped += usize::from(known[0] > 1.0 && known[1] > 1.0);
        }
        assert!(damped > 100, "{damped}");
    }
}

/// At the end of a run, or why there was none.
fn kinetic(text: &str) -> Result<f64, String> {
    let mut sim = simulation(text);
    sim.run(&mut ()).map_err(|e| e.to_string())?;
    Ok(sim.row.kinetic)
}

/// A plate with free sides along the layer has waves that run backwards: a layer that damps in one direction only makes
/// them grow beyond all bounds, one that damps a twentieth along its side does not.
#[test]
fn free_sides_do_not_make_a_layer_grow() {
    let push = "exp(-200*((x - 0.3)^2 + (y - 0.36)^2))/100";
    let of = |across: &str| {
        let rest = format!(
            "[[absorbing]]\nsides = [\"+x\"]\nthickness = 0.3\nramp = 0.2\nrate = 50\n{across}\n[time]\nuntil = 8\ndt = 0.004\n"
        );
        kinetic(&scene("absorbing", [0.0; 2], [1.0, 0.6], push, &rest))
    };
    let (usual, one_way) = (of(""), of("across = 0"));
    println!("{usual:?}, {one_way:?}");
    // At the start 1.2e-4 of strain energy; the plate leads its slow waves out in the end.
    assert!(usual.as_ref().is_ok_and(|e| *e < 1e-5), "{usual:?}");
    let grown = match &one_way {
        Ok(kinetic) => *kinetic > 1e-3,
        Err(why) => why.contains("finite") || why.contains("moved"),
    };
    assert!(grown, "{one_way:?}");
}

/// A crack that goes straight on to the outer edge of a layer is as if it had no end: what comes back is that of a body
/// three times as large. One that ends in front of the layer scatters.
#[test]
fn a_crack_runs_into_a_layer() {
    let push = "exp(-200*((x - 0.5)^2 + (y - 0.65)^2))/100";
    let of = |law: &str, size: [f64; 2], tip: f64, layer: &str| {
        let crack =
            format!("[[crack]]\nsegment = {{ from = [0.45, 0.505], to = [{tip}, 0.505] }}\n");
        let rest = format!("{crack}{layer}[time]\nuntil = 1.6\ndt = 0.004\n");
        let mut sim = simulation(&scene(law, [size[0]; 2], [size[1]; 2], push, &rest));
        sim.run(&mut ()).unwrap_or_else(|e| panic!("{e}"));
        let mut nodes: Vec<usize> = (0..sim.body.x.len()).collect();
        nodes.retain(|n| sim.body.x[*n][..2].iter().all(|x| *x > 0.305 && *x < 0.665));
        nodes.sort_by(|a, b| {
            sim.body.x[*a]
                .partial_cmp(&sim.body.x[*b])
                .expect("numbers")
        });
        let slots = nodes.iter().map(|n| sim.engine.slot(*n));
        let u: Vec<f64> = slots
            .flat_map(|s| [sim.state.u[0][s], sim.state.u[1][s]])
            .collect();
        u
    };
    let gap = |a: &[f64], b: &[f64]| {
        assert_eq!(a.len(), b.len());
        a.iter()
            .zip(b)
            .fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()))
            / 0.01
    };
    let layer = "[[absorbing]]\nsides = \"all\"\nthickness = 0.3\nramp = 0.2\nrate = 50\n";
    let large = of("correspondence", [-0.8, 1.8], 1.9, "");
    let through = gap(&of("absorbing", [0.0, 1.0], 1.1, layer), &large);
    let short = gap(&of("absorbing", [0.0, 1.0], 0.695, layer), &large);
    println!("through {through:.1e}, in front {short:.1e}");
    assert!(through < 3e-3, "{through}");
    assert!(short > 4.0 * through, "{short} {through}");
}

/// A crack that grows towards a layer ends at its inner edge; damping rates that the scene sets itself are no layer, and
/// the crack runs into them. Other bonds hold but for a band, which keeps it straight.
#[test]
fn a_crack_does_not_grow_into_a_layer() {
    let law = "../../examples/indentation.pd";
    let stretched = "6e-3*(y - 0.155)";
    let held = |from: f64, to: f64| {
        format!(
            "[[condition]]\nregion = {{ box = {{ from = [0, {from}], to = [0.6, {to}] }} }}\n\
             displacement = [0, \"{stretched}\"]\n"
        )
    };
    let of = |layer: &str| {
        let rest = format!(
            "[[crack]]\nsegment = {{ from = [-0.1, 0.155], to = [0.2, 0.155] }}\n{}{}{layer}[time]\nuntil = 1.5\n",
            held(0.0, 0.02),
            held(0.28, 0.3)
        );
        let text = scene(law, [0.0; 2], [0.6, 0.3], stretched, &rest);
        let band = "s0 = 1\nfollow = 10\n[[material.part]]\n\
                    region = { box = { from = [0, 0.12], to = [0.6, 0.19] } }\ns0 = 0.02\n[[initial]]";
        let mut sim = simulation(&text.replacen("[[initial]]", band, 1));
        sim.run(&mut ()).unwrap_or_else(|e| panic!("{e}"));
        let damage = sim.engine.damage(&sim.state);
        let most = |inside: &dyn Fn(f64) -> bool| {
            let nodes = sim.body.x.iter().zip(&damage);
            let here = nodes.filter(|(x, _)| inside(x[0])).map(|(_, d)| *d);
            here.fold(0.0, f64::max)
        };
        // In front of the inner edge, at its planes and beyond.
        (
            sim.held,
            most(&|x| (0.41..0.445).contains(&x)),
            most(&|x| x > 0.445),
        )
    };
    let across = "thickness = 0.15\nrate = 20\nprofile = \"quadratic\"\nacross = 0\n";
    let (held, front, inside) = of(&format!("[[absorbing]]\nsides = \"+x\"\n{across}"));
    assert_eq!((held, inside), (16 * 31, 0.0));
    assert!(front > 0.4, "{front}");
    let by_hand = "[[initial]]\nphi = [\"20*(max(x - 0.45, 0)/0.15)^2\", 0]\n";
    let (held, front, inside) = of(by_hand);
    assert_eq!(held, 0);
    assert!(front > 0.4 && inside > 0.4, "{front} {inside}");
}
