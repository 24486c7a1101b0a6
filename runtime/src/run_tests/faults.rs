//! What a run refuses, and where it stops.
use super::*;

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
