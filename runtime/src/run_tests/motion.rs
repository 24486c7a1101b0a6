//! Motion: swings, steps, momentum and energy, imposed values.
use super::*;

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
    let energy: Vec<f64> = rows.0.iter().map(|r| r.energy() / 5e-5).collect();
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
