//! Checkpoints: runs that go on from one have the same bits.
use super::*;

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
