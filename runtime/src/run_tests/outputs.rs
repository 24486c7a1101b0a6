//! What a run writes; and that neither that nor threads change a bit.
use super::*;

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
