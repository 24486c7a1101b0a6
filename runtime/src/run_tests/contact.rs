//! A sphere and what it hits.
use super::*;

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
