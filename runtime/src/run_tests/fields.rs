//! Fields: relaxation, mirrors, imposed values.
use super::*;

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
        let said = |what: &String| what.starts_with("strain energy: the law has none");
        assert!(summary.last.strain.is_none() && summary.left_out.iter().any(said));
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
