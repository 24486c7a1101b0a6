use super::*;

#[test]
fn boundaries_are_inside() {
    let s = Shape::Sphere {
        center: [0.0; 3],
        radius: 0.3,
    };
    assert!(s.contains([0.1 + 0.2, 0.0, 0.0], 1e-9));
    assert!(!s.contains([0.3001, 0.0, 0.0], 1e-9));
    let c = Shape::Cylinder {
        from: [0.0; 3],
        to: [0.0, 2.0, 0.0],
        radius: 1.0,
    };
    assert!(c.contains([1.0, 2.0, 0.0], 1e-9) && !c.contains([1.0, 2.1, 0.0], 1e-9));
    assert_eq!(c.bounds(), ([-1.0, 0.0, -1.0], [1.0, 2.0, 1.0]));
}

#[test]
fn the_wall_of_a_hole_belongs_to_the_body() {
    let b = Shape::Box {
        from: [-1.0; 3],
        to: [1.0; 3],
    };
    let hole = Shape::Sphere {
        center: [0.0; 3],
        radius: 0.5,
    };
    let body = Shape::Difference(Box::new(b.clone()), vec![hole.clone()]);
    assert!(body.contains([0.5, 0.0, 0.0], 1e-9) && !body.contains([0.4, 0.0, 0.0], 1e-9));
    // Taking the difference away again leaves the closed hole.
    let again = Shape::Difference(Box::new(b), vec![body]);
    assert!(again.contains([0.5, 0.0, 0.0], 1e-9) && again.contains([0.0; 3], 1e-9));
    assert!(!again.contains([0.6, 0.0, 0.0], 1e-9));
    assert!(Shape::Union(vec![hole.clone(), Shape::All]).contains([9.0; 3], 0.0));
    assert!(!Shape::Intersection(vec![hole, Shape::All]).contains([9.0; 3], 0.0));
}

#[test]
fn a_plane_through_nodes_cuts_one_side_only() {
    let p = Surface::Point { x: 0.5 };
    assert!(
        p.crosses([0.0; 3], [1.0, 0.0, 0.0], 1e-9) && p.crosses([1.0, 0.0, 0.0], [0.0; 3], 1e-9)
    );
    assert!(p.crosses([0.0; 3], [0.5 - 1e-12, 0.0, 0.0], 1e-9));
    assert!(!p.crosses([0.5 - 1e-12, 0.0, 0.0], [1.0, 0.0, 0.0], 1e-9));
    let s = Surface::Segment {
        from: [0.0, 0.0],
        to: [1.0, 0.0],
    };
    assert!(
        !s.crosses([0.0, 0.0, 0.0], [1.0, 0.0, 0.0], 1e-9),
        "in the plane"
    );
    assert!(
        s.crosses([1.0, -1.0, 0.0], [1.0, 1.0, 0.0], 1e-9),
        "through the tip"
    );
    assert!(
        !s.crosses([1.1, -1.0, 0.0], [1.1, 1.0, 0.0], 1e-9),
        "past the tip"
    );
}

#[test]
fn patches_and_discs_end_at_their_rims() {
    let patch = Surface::Patch {
        corner: [0.0; 3],
        edges: [[2.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
    };
    let through = |x: f64, y: f64| patch.crosses([x, y, -0.3], [x, y, 0.4], 1e-9);
    assert!(through(1.5, 0.5) && through(0.0, 0.0) && through(3.0, 1.0));
    assert!(!through(0.2, 0.5) && !through(2.8, 0.5) && !through(1.5, 1.01));
    let disc = Surface::Disc {
        center: [0.0; 3],
        normal: [0.0, 0.0, 3.0],
        radius: 1.0,
    };
    assert!(disc.crosses([1.0, 0.0, -1.0], [1.0, 0.0, 1.0], 1e-9));
    assert!(!disc.crosses([1.1, 0.0, -1.0], [1.1, 0.0, 1.0], 1e-9));
    assert!(
        Surface::Segment {
            from: [1.0, 1.0],
            to: [1.0, 1.0]
        }
        .check()
        .is_err()
    );
    assert!(patch.check().is_ok() && disc.check().is_ok());
}

#[test]
fn malformed_shapes_are_refused() {
    for bad in [
        Shape::Sphere {
            center: [f64::NAN, 0.0, 0.0],
            radius: 1.0,
        },
        Shape::Sphere {
            center: [0.0; 3],
            radius: -1.0,
        },
        Shape::Box {
            from: [1.0; 3],
            to: [0.0; 3],
        },
        Shape::Cylinder {
            from: [0.0; 3],
            to: [0.0; 3],
            radius: 1.0,
        },
        Shape::Union(vec![]),
    ] {
        assert!(bad.check().is_err(), "{bad:?}");
    }
}
