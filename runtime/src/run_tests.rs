use crate::body::Flavour;
use crate::carve::{Anchor, Carve, carve};
use crate::conditions::{Condition, Expression, Mirror, Parity, Quantity};
use crate::contact::{ContactLaw, Indenter};
use crate::engine::{Law, Settings, Traversal};
use crate::observe::{Files, Observer, Outputs, Picture, Row, Schedule, View};
use crate::shape::Shape;
use crate::simulate::{End, Setup, Simulation, StepRule};
use crate::spec::{Op, Tape};
use std::path::PathBuf;

#[path = "run_law.rs"]
mod law;

/// A block of n x m x l nodes with spacing 1 and bonds of length 1 (c = 1); critical stretch as given.
pub(crate) fn block(cells: [f64; 3], flavour: Flavour, s0: f64) -> Setup {
    let body = carve(&Carve {
        shape: Shape::Box {
            from: [0.0; 3],
            to: cells,
        },
        flavour,
        spacing: 1.0,
        anchor: Anchor::CellCentres,
        cross: 1.0,
        periodic: [false; 3],
        tolerance: None,
        memory: None,
    });
    Setup {
        title: "block".into(),
        body: body.unwrap(),
        law: Law::interpreted(law::pmb(flavour.dim())),
        settings: Settings {
            materials: vec![vec![1.0, s0]],
            influences: vec![],
            horizon: vec![1.5],
            partial_volume: false,
            lattice_constants: false,
            traversal: Traversal::Auto,
            isa: None,
        },
        density: vec![1.0],
        initial: vec![],
        conditions: vec![],
        cracks: vec![],
        no_fail: vec![],
        indenters: vec![],
        step: StepRule::Fixed(0.1),
        end: End::Steps(10),
        outputs: Outputs {
            history: Schedule::Steps(1),
            ..Outputs::default()
        },
    }
}

fn set(region: Shape, quantity: Quantity, value: Vec<Option<Expression>>) -> Condition {
    Condition {
        region,
        quantity,
        value,
        mirror: None,
    }
}

fn numbers(values: &[f64]) -> Vec<Option<Expression>> {
    values
        .iter()
        .map(|v| Some(Expression::constant(*v)))
        .collect()
}

/// `scale * sin(rate * variable)`.
fn sine(variable: u32, rate: f64, scale: f64) -> Option<Expression> {
    let ops = vec![
        Op::Var(variable),
        Op::Lit(rate),
        Op::Mul(0, 1),
        Op::Sin(2),
        Op::Lit(scale),
        Op::Mul(3, 4),
    ];
    Some(Expression {
        text: "sine".into(),
        tape: Tape { ops, outs: vec![5] },
    })
}

fn scratch(name: &str) -> PathBuf {
    let dir = std::env::temp_dir().join(format!("pdlang-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&dir);
    dir
}

/// Keeps the rows.
#[derive(Default)]
struct Rows(Vec<Row>);

impl Observer for Rows {
    fn row(&mut self, _: &Simulation, row: &Row) -> Result<(), String> {
        self.0.push(row.clone());
        Ok(())
    }
}

#[test]
fn two_nodes_swing_as_verlet_does() {
    // r'' = -2 r for r = u_2 - u_1; Verlet gives r_n = r_0 cos(n theta) with cos(theta) = 1 - dt^2.
    let mut setup = block([2.0, 1.0, 1.0], Flavour::Bar, 1.0);
    setup.initial = vec![set(
        Shape::Box {
            from: [1.0, -1.0, -1.0],
            to: [2.0, 1.0, 1.0],
        },
        Quantity::Displacement,
        numbers(&[0.01]),
    )];
    setup.end = End::Steps(1000);
    let mut sim = Simulation::new(setup).unwrap();
    let mut rows = Rows::default();
    sim.run(&mut rows).unwrap();
    let r = sim.state.u[0][sim.engine.slot(1)] - sim.state.u[0][sim.engine.slot(0)];
    let theta = (1.0 - 0.1_f64.powi(2)).acos();
    assert!((r - 0.01 * (1000.0 * theta).cos()).abs() < 1e-12, "{r}");
    assert_eq!(rows.0.len(), 1001);
    // Kinetic and strain energy together swing by dt^2 omega^2 / 4 at most.
    let energy: Vec<f64> = rows
        .0
        .iter()
        .map(|r| (r.kinetic + r.strain) / 5e-5)
        .collect();
    assert!(
        energy.iter().all(|e| (e - 1.0).abs() < 0.006),
        "{:?}",
        &energy[..3]
    );
}

#[test]
fn the_stable_step_is_that_of_the_body() {
    let mut setup = block([2.0, 1.0, 1.0], Flavour::Bar, 1.0);
    setup.step = StepRule::default();
    setup.end = End::Time(10.0);
    let sim = Simulation::new(setup).unwrap();
    let omega = sim.stable.as_ref().unwrap().omega;
    assert!((omega - 2.0_f64.sqrt()).abs() < 1e-6, "{omega}");
    let limit = 0.8 * 2.0 / omega;
    assert!(sim.dt <= limit && sim.dt > 0.8 * limit);
    assert!((sim.dt * sim.steps as f64 - 10.0).abs() < 1e-12);
}

#[test]
fn momentum_is_kept_and_energy_balanced() {
    let mut setup = block([6.0, 5.0, 4.0], Flavour::Solid, 0.02);
    setup.initial = vec![set(
        Shape::All,
        Quantity::Velocity,
        vec![
            sine(1, 0.7, 0.05),
            sine(2, 0.9, -0.03),
            Some(Expression::constant(0.01)),
        ],
    )];
    setup.end = End::Steps(200);
    let mut rows = Rows::default();
    let summary = Simulation::new(setup).unwrap().run(&mut rows).unwrap();
    let (first, last) = (&rows.0[0], &summary.last);
    for d in 0..3 {
        assert!((first.momentum[d] - last.momentum[d]).abs() < 1e-12);
        assert!((first.angular_momentum[d] - last.angular_momentum[d]).abs() < 1e-11);
    }
    assert!(last.broken > 0 && last.lost > 0.0, "{last:?}");
    assert_eq!(first.lost, 0.0);
}

#[test]
fn imposed_motion_is_exact_and_its_work_is_known() {
    let mut setup = block([8.0, 1.0, 1.0], Flavour::Bar, 1.0);
    let end = |k: f64| Shape::Box {
        from: [k, -1.0, -1.0],
        to: [k + 1.0, 1.0, 1.0],
    };
    setup.conditions = vec![
        set(end(0.0), Quantity::Velocity, numbers(&[0.0])),
        set(end(7.0), Quantity::Displacement, vec![sine(3, 0.3, 0.02)]),
        set(end(4.0), Quantity::Force, numbers(&[1e-3])),
    ];
    setup.step = StepRule::Fixed(0.01);
    setup.end = End::Steps(1500);
    let mut sim = Simulation::new(setup).unwrap();
    let mut rows = Rows::default();
    sim.run(&mut rows).unwrap();
    for row in &rows.0 {
        // Nothing breaks: what is missing in the balance is the error of the integration.
        assert!(
            row.lost.abs() < 2e-8,
            "{} {}",
            row.lost,
            row.work_conditions
        );
    }
    assert!(rows.0.iter().any(|r| r.work_conditions > 1e-5));
    assert_eq!(
        sim.state.u[0][sim.engine.slot(7)],
        0.02 * (0.3 * sim.state.time).sin()
    );
    assert_eq!(sim.state.u[0][sim.engine.slot(0)], 0.0);
}

#[test]
fn the_later_of_two_conditions_wins() {
    let mut setup = block([3.0, 1.0, 1.0], Flavour::Bar, 1.0);
    setup.conditions = vec![
        set(Shape::All, Quantity::Displacement, numbers(&[0.5])),
        set(
            Shape::Sphere {
                center: [0.5, 0.0, 0.0],
                radius: 0.1,
            },
            Quantity::Velocity,
            numbers(&[2.0]),
        ),
    ];
    let mut sim = Simulation::new(setup).unwrap();
    sim.run(&mut ()).unwrap();
    assert!((sim.state.u[0][sim.engine.slot(0)] - 2.0).abs() < 1e-12);
    assert_eq!(sim.state.u[0][sim.engine.slot(1)], 0.5);
}

/// A plate that a sphere hits from above; bonds break.
fn impact(law: ContactLaw) -> Setup {
    let mut setup = block([9.0, 9.0, 3.0], Flavour::Solid, 0.05);
    setup.indenters = vec![Indenter {
        center: [4.5, 4.5, 6.5],
        velocity: [0.0, 0.0, -0.3],
        radius: 3.0,
        law,
    }];
    setup.step = StepRule::Stable { safety: 0.5 };
    setup.end = End::Steps(60);
    setup.outputs.checkpoints = Schedule::Steps(25);
    setup
}

#[test]
fn a_sphere_gives_the_momentum_that_it_loses() {
    for law in [
        ContactLaw::Penalty { stiffness: 2.0 },
        ContactLaw::Relocation,
    ] {
        let mut rows = Rows::default();
        let summary = Simulation::new(impact(law))
            .unwrap()
            .run(&mut rows)
            .unwrap();
        let last = &summary.last;
        assert!(
            last.broken > 0 && last.contact_impulse[2] > 0.1,
            "{law:?} {last:?}"
        );
        for d in 0..3 {
            assert!(
                (last.momentum[d] + last.contact_impulse[d]).abs() < 1e-12,
                "{law:?} {last:?}"
            );
        }
        assert!(
            last.work_contact > 0.0 && last.lost > -0.02 * last.work_contact,
            "{law:?} {last:?}"
        );
        assert!(summary.contact[0].depth > 0.0);
        assert_eq!(rows.0[0].contact_force, [0.0; 3]);
    }
}

#[test]
fn a_resumed_run_has_the_same_bits() {
    for (k, law) in [
        ContactLaw::Penalty { stiffness: 2.0 },
        ContactLaw::Relocation,
    ]
    .into_iter()
    .enumerate()
    {
        let dir = scratch(&format!("resume-{k}"));
        let setup = || {
            let mut s = impact(law);
            let rim = Shape::Box {
                from: [0.0; 3],
                to: [1.0, 9.0, 3.0],
            };
            s.conditions = vec![set(
                rim,
                Quantity::Displacement,
                vec![sine(3, 0.2, 0.1), None, None],
            )];
            s
        };
        let mut whole = Simulation::new(setup()).unwrap();
        let one = whole.run(&mut Files::new(&dir)).unwrap();
        let history = std::fs::read_to_string(dir.join("history.csv")).unwrap();
        let mut again = Simulation::new(setup()).unwrap();
        again
            .resume(&dir.join("checkpoints/step-000000025.ckpt"))
            .unwrap();
        let two = again.run(&mut Files::new(&dir)).unwrap();
        assert_eq!(whole.state, again.state);
        assert_eq!((one.last, one.contact), (two.last, two.contact));
        assert_eq!(
            history,
            std::fs::read_to_string(dir.join("history.csv")).unwrap()
        );
        std::fs::remove_dir_all(dir).unwrap();
    }
}

#[test]
fn a_checkpoint_of_another_scene_is_refused() {
    let dir = scratch("other");
    Simulation::new(impact(ContactLaw::Relocation))
        .unwrap()
        .run(&mut Files::new(&dir))
        .unwrap();
    let mut other = Simulation::new(impact(ContactLaw::Penalty { stiffness: 2.0 })).unwrap();
    let e = other
        .resume(&dir.join("checkpoints/step-000000025.ckpt"))
        .unwrap_err();
    assert!(e.to_string().contains("another scene"), "{e}");
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn an_unstable_run_stops_where_it_happens() {
    let dir = scratch("unstable");
    let mut setup = block([6.0, 1.0, 1.0], Flavour::Bar, f64::INFINITY);
    setup.initial = vec![set(
        Shape::All,
        Quantity::Displacement,
        vec![sine(0, 3.0, 1e-3)],
    )];
    // The limit is 2 / omega with omega just below 2.
    setup.step = StepRule::Fixed(1.3);
    setup.end = End::Steps(500);
    let stopped = Simulation::new(setup)
        .unwrap()
        .run(&mut Files::new(&dir))
        .unwrap_err();
    assert!(stopped.step < 50 && stopped.node.is_some(), "{stopped}");
    assert!(stopped.reason.contains("step is too large"), "{stopped}");
    assert!(stopped.checkpoint.is_some_and(|p| p.exists()));
    let summary = std::fs::read_to_string(dir.join("summary.json")).unwrap();
    assert!(summary.contains("stopped at step"));
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn a_runaway_node_is_named() {
    let mut setup = block([6.0, 1.0, 1.0], Flavour::Bar, f64::INFINITY);
    let last = Shape::Sphere {
        center: [5.5, 0.0, 0.0],
        radius: 0.1,
    };
    setup.initial = vec![set(last, Quantity::Velocity, numbers(&[20.0]))];
    let stopped = Simulation::new(setup).unwrap().run(&mut ()).unwrap_err();
    assert_eq!(stopped.node, Some((5, [5.5, 0.0, 0.0])));
    assert!(
        stopped.reason.contains("more than the horizon"),
        "{stopped}"
    );
}

#[test]
fn no_steps_evaluate_the_forces_once() {
    let mut setup = block([2.0, 1.0, 1.0], Flavour::Bar, f64::INFINITY);
    setup.initial = vec![set(
        Shape::All,
        Quantity::Displacement,
        vec![sine(0, 1.0, 0.1)],
    )];
    setup.step = StepRule::default();
    setup.end = End::Steps(0);
    let mut sim = Simulation::new(setup).unwrap();
    let summary = sim.run(&mut ()).unwrap();
    let stretch = 0.1 * (1.5_f64.sin() - 0.5_f64.sin());
    assert!((sim.engine.force()[0][sim.engine.slot(0)] - stretch).abs() < 1e-15);
    assert_eq!((summary.steps, summary.stable), (0, None));
}

#[test]
fn files_hold_what_was_asked_for() {
    let dir = scratch("files");
    let mut setup = impact(ContactLaw::Penalty { stiffness: 2.0 });
    setup.outputs.fields = Schedule::Steps(30);
    setup.outputs.quantities = ["damage", "displacement", "energy"]
        .map(String::from)
        .to_vec();
    setup.outputs.pictures = Schedule::Ends;
    setup.outputs.views = vec![Picture {
        name: "top".into(),
        quantity: "damage".into(),
        view: View::Top,
        range: None,
        width: 300,
        deformed: true,
        region: None,
    }];
    Simulation::new(setup)
        .unwrap()
        .run(&mut Files::new(&dir))
        .unwrap();
    let series = std::fs::read_to_string(dir.join("fields.pvd")).unwrap();
    assert_eq!(series.matches("<DataSet").count(), 3);
    for file in [
        "fields/fields-000000030.vtu",
        "pictures/top-000000060.png",
        "summary.json",
    ] {
        assert!(dir.join(file).exists(), "{file}");
    }
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn wrong_input_is_refused_before_anything_runs() {
    let fault = |change: &dyn Fn(&mut Setup)| {
        let mut setup = block([3.0, 3.0, 1.0], Flavour::PlaneStress, 1.0);
        change(&mut setup);
        Simulation::new(setup)
            .err()
            .map(|e| e.to_string())
            .unwrap_or_default()
    };
    let far = Shape::Sphere {
        center: [99.0; 3],
        radius: 1.0,
    };
    assert!(fault(&|s| s.density = vec![-1.0]).contains("density is -1"));
    assert!(fault(&|s| s.step = StepRule::Fixed(0.0)).contains("time step is 0"));
    assert!(fault(&|s| s.step = StepRule::Stable { safety: 1.5 }).contains("safety factor"));
    assert!(fault(&|s| s.no_fail = vec![far.clone()]).contains("no-fail region holds no node"));
    assert!(
        fault(&|s| s.initial = vec![set(far.clone(), Quantity::Velocity, numbers(&[0.0, 0.0]))])
            .contains("holds no node")
    );
    assert!(
        fault(&|s| s.initial = vec![set(Shape::All, Quantity::Velocity, numbers(&[0.0]))])
            .contains("1 components instead of 2")
    );
    assert!(
        fault(&|s| s.initial = vec![set(Shape::All, Quantity::Force, numbers(&[0.0, 0.0]))])
            .contains("force density")
    );
    assert!(
        fault(&|s| s.conditions = vec![set(
            Shape::All,
            Quantity::Field("T".into()),
            numbers(&[0.0])
        )])
        .contains("no field `T`")
    );
    assert!(
        fault(&|s| s.conditions = vec![set(
            Shape::All,
            Quantity::Velocity,
            numbers(&[f64::NAN, 0.0])
        )])
        .contains("is NaN at node 0")
    );
    assert!(
        fault(&|s| s.outputs.quantities = vec!["demage".into()])
            .contains("choose from displacement")
    );
    assert!(fault(&|s| s.outputs.quantities = vec!["velocity.z".into()]).contains("2 component"));
    let view = |name: &str, width| Picture {
        name: name.into(),
        quantity: "damage".into(),
        view: View::Top,
        range: None,
        width,
        deformed: false,
        region: None,
    };
    assert!(
        fault(&|s| s.outputs.views = vec![view("a", 300), view("a", 300)]).contains("two pictures")
    );
    assert!(fault(&|s| s.outputs.views = vec![view("../a", 300)]).contains("file name"));
    assert!(fault(&|s| s.outputs.views = vec![view("a", 9)]).contains("9 pixels"));
    assert!(fault(&|s| s.outputs.history = Schedule::Steps(0)).contains("positive interval"));
}

#[test]
fn a_field_relaxes_at_the_rate_of_its_matrix() {
    // Two nodes exchange: d(T2 - T1)/dt = -2 k V (T2 - T1), so the fastest rate is 2 for k = V = 1.
    let mut setup = block([2.0, 1.0, 1.0], Flavour::Bar, 1.0);
    setup.law = Law::interpreted(law::heat(1));
    setup.settings.materials = vec![vec![1.0]];
    let hot = Shape::Sphere {
        center: [1.5, 0.0, 0.0],
        radius: 0.1,
    };
    setup.initial = vec![set(
        hot.clone(),
        Quantity::Field("T".into()),
        numbers(&[1.0]),
    )];
    setup.step = StepRule::default();
    setup.end = End::Steps(10);
    setup.outputs.quantities = vec!["T".into()];
    let sim = Simulation::new(again(&setup)).unwrap();
    let stable = sim.stable.as_ref().unwrap();
    assert!((stable.rate - 2.0).abs() < 0.01, "{}", stable.rate);
    assert_eq!(sim.stages, crate::relax::USUAL);
    assert!((sim.dt - 0.8 * 14.0 / stable.rate).abs() < 1e-12);
    // Of second order, and the total stays.
    setup.end = End::Time(1.0);
    let error = |dt: f64| {
        let mut setup = again(&setup);
        setup.step = StepRule::Fixed(dt);
        let mut sim = Simulation::new(setup).unwrap();
        let summary = sim.run(&mut ()).unwrap();
        let t = crate::observe::quantity(&mut sim, "T").unwrap().scalar();
        assert!((t[0] + t[1] - 1.0).abs() < 1e-14, "{t:?}");
        let row = &summary.last.fields[0];
        assert_eq!((row.min, row.max, row.total), (t[0], t[1], t[0] + t[1]));
        assert_eq!(row.mean, 0.5 * row.total);
        (t[1] - t[0] - (-2.0_f64).exp()).abs()
    };
    let (coarse, fine) = (error(0.1), error(0.05));
    assert!(
        coarse < 3e-3 && (coarse / fine - 4.0).abs() < 0.6,
        "{coarse:e} {fine:e}"
    );
    // A step far beyond the usual limit takes more stages; one beyond all measure is refused.
    assert!(error(1.0) < 0.4);
    setup.step = StepRule::Fixed(1e5);
    let fault = Simulation::new(setup).err().unwrap().to_string();
    assert!(fault.contains("too long for the fields"), "{fault}");
}

/// The same heat problem once more.
fn again(setup: &Setup) -> Setup {
    Setup {
        title: setup.title.clone(),
        body: setup.body.clone(),
        law: setup.law.clone(),
        settings: setup.settings.clone(),
        initial: setup.initial.clone(),
        conditions: setup.conditions.clone(),
        cracks: setup.cracks.clone(),
        no_fail: setup.no_fail.clone(),
        indenters: setup.indenters.clone(),
        outputs: setup.outputs.clone(),
        density: setup.density.clone(),
        ..*setup
    }
}

#[test]
fn mirrors_hold_a_surface_or_close_it() {
    // Six nodes; the first two are the images of the next two across x = 2.
    let mut setup = block([6.0, 1.0, 1.0], Flavour::Bar, 1.0);
    setup.law = Law::interpreted(law::heat(1));
    setup.settings.materials = vec![vec![1.0]];
    setup.settings.horizon = vec![2.5];
    let outside = Shape::Box {
        from: [0.0, -1.0, -1.0],
        to: [2.0, 1.0, 1.0],
    };
    let temperature = || Quantity::Field("T".into());
    setup.initial = vec![set(Shape::All, temperature(), vec![sine(0, 0.4, 3.0)])];
    let mirrored = |parity, value: Vec<Option<Expression>>| Condition {
        mirror: Some(Mirror {
            point: [2.0, 0.0, 0.0],
            normal: [-2.0, 0.0, 0.0],
            parity,
        }),
        ..set(outside.clone(), temperature(), value)
    };
    let finished = |condition: Condition| {
        let mut setup = again(&setup);
        setup.conditions = vec![condition];
        let mut sim = Simulation::new(setup).unwrap();
        sim.run(&mut ()).unwrap();
        let t = crate::observe::quantity(&mut sim, "T").unwrap().scalar();
        (sim.state.time, t)
    };
    let (time, t) = finished(mirrored(Parity::Odd, vec![sine(3, 0.1, 5.0)]));
    let held = 5.0 * (0.1 * time).sin();
    assert_eq!((t[1], t[0]), (2.0 * held - t[2], 2.0 * held - t[3]));
    let (_, t) = finished(mirrored(Parity::Even, numbers(&[0.0])));
    assert_eq!((t[1], t[0]), (t[2], t[3]));
    // The inner nodes are half of a symmetric body, which keeps its heat.
    let start = |k: usize| 3.0 * (0.4 * (k as f64 + 0.5)).sin();
    let before: f64 = (2..6).map(start).sum();
    let whole = t[2..].iter().sum::<f64>();
    assert!((before - whole).abs() < 1e-12, "{before} {whole}");
    let fault = |condition: Condition| {
        let mut setup = again(&setup);
        setup.conditions = vec![condition];
        Simulation::new(setup).err().unwrap().to_string()
    };
    let mut far = mirrored(Parity::Odd, numbers(&[0.0]));
    far.mirror.as_mut().unwrap().point[0] = 2.3;
    assert!(fault(far).contains("has no mirror image"));
    let mut wide = mirrored(Parity::Odd, numbers(&[0.0]));
    wide.region = Shape::All;
    assert!(fault(wide).contains("outside of the region"));
    let mut flat = mirrored(Parity::Odd, numbers(&[0.0]));
    flat.mirror.as_mut().unwrap().normal = [0.0; 3];
    assert!(fault(flat).contains("has no direction"));
}

#[test]
fn motion_means_nothing_to_a_law_without_force() {
    let mut setup = block([3.0, 1.0, 1.0], Flavour::Bar, 1.0);
    setup.law = Law::interpreted(law::heat(1));
    setup.settings.materials = vec![vec![1.0]];
    setup.density = vec![0.0];
    let mut moving = again(&setup);
    moving.conditions = vec![set(Shape::All, Quantity::Velocity, numbers(&[1.0]))];
    let fault = Simulation::new(moving).err().unwrap().to_string();
    assert!(fault.contains("has no force"), "{fault}");
    setup.outputs.quantities = vec!["velocity".into()];
    let fault = Simulation::new(setup).err().unwrap().to_string();
    assert!(fault.contains("choose from position"), "{fault}");
}

#[test]
fn a_field_goes_on_from_a_checkpoint_to_the_same_bits() {
    let dir = scratch("resume-field");
    let mut setup = block([9.0, 1.0, 1.0], Flavour::Bar, 1.0);
    setup.law = Law::interpreted(law::heat(1));
    setup.settings.materials = vec![vec![1.0]];
    let temperature = Quantity::Field("T".into());
    setup.initial = vec![set(Shape::All, temperature, vec![sine(0, 0.4, 3.0)])];
    setup.outputs.checkpoints = Schedule::Steps(4);
    setup.step = StepRule::Fixed(1.7);
    let mut whole = Simulation::new(again(&setup)).unwrap();
    whole.run(&mut Files::new(&dir)).unwrap();
    let mut rest = Simulation::new(setup).unwrap();
    rest.resume(&dir.join("checkpoints/step-000000004.ckpt"))
        .unwrap();
    rest.run(&mut Files::new(&dir)).unwrap();
    assert!(whole.stages > 2);
    assert_eq!(whole.state, rest.state);
    let history = std::fs::read_to_string(dir.join("history.csv")).unwrap();
    let header = history.lines().next().unwrap();
    assert!(
        header.ends_with(",T_min,T_mean,T_max,T_total_m3"),
        "{header}"
    );
    assert_eq!(history.lines().count(), 12);
    std::fs::remove_dir_all(dir).unwrap();
}

#[test]
fn an_imposed_field_stays() {
    let mut setup = block([4.0, 1.0, 1.0], Flavour::Bar, 1.0);
    setup.law = Law::interpreted(law::heat(1));
    setup.settings.materials = vec![vec![1.0]];
    let hot = Shape::Sphere {
        center: [3.5, 0.0, 0.0],
        radius: 0.1,
    };
    setup.conditions = vec![set(
        hot,
        Quantity::Field("T".into()),
        vec![sine(3, 0.1, 5.0)],
    )];
    let mut sim = Simulation::new(setup).unwrap();
    sim.run(&mut ()).unwrap();
    let k = sim.engine.state_slots("T").unwrap()[0];
    assert_eq!(
        sim.state.slots[k][sim.engine.slot(3)],
        5.0 * (0.1 * sim.state.time).sin()
    );
    assert!(sim.state.slots[k][sim.engine.slot(2)] > 0.0);
}

#[test]
fn threads_do_not_change_a_bit() {
    let run = |threads| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let mut setup = impact(ContactLaw::Penalty { stiffness: 2.0 });
            setup.end = End::Steps(40);
            let mut sim = Simulation::new(setup).unwrap();
            let summary = sim.run(&mut ()).unwrap();
            (sim.state, summary.last, sim.stable)
        })
    };
    let one = run(1);
    assert!(one.1.broken > 0);
    assert_eq!(one, run(3));
}

#[test]
fn outputs_do_not_change_a_bit() {
    let run = |history| {
        let mut setup = impact(ContactLaw::Relocation);
        setup.outputs = Outputs {
            history,
            ..Outputs::default()
        };
        let mut sim = Simulation::new(setup).unwrap();
        sim.run(&mut ()).unwrap();
        sim.state
    };
    assert_eq!(run(Schedule::Never), run(Schedule::Steps(3)));
}
