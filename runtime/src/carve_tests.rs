use super::*;

fn solid(shape: Shape, spacing: f64, anchor: Anchor) -> Carve {
    Carve {
        shape,
        flavour: Flavour::Solid,
        spacing,
        anchor,
        cross: 1.0,
        periodic: [false; 3],
        tolerance: None,
        memory: None,
    }
}

#[test]
fn the_reference_block_has_nodes_at_multiples_of_dx() {
    // ../shared reference block: 11 nodes a side at X = i dx, dx = 0.5 mm (peer conventions, last section).
    let dx = 5e-4;
    let block = Shape::Box {
        from: [0.0; 3],
        to: [10.0 * dx; 3],
    };
    let body = carve(&solid(block, dx, Anchor::Node([0.0; 3]))).unwrap();
    assert_eq!(body.x.len(), 1331);
    assert_eq!(body.x[13], [2.0 * dx, dx, 0.0]);
    assert_eq!(body.volume[0], dx * dx * dx);
    assert_eq!(body.grid.as_ref().unwrap().shape, [11; 3]);
}

#[test]
fn cells_fill_a_box() {
    let body = carve(&solid(
        Shape::Box {
            from: [0.0; 3],
            to: [1.0, 0.5, 0.25],
        },
        0.25,
        Anchor::CellCentres,
    ))
    .unwrap();
    assert_eq!(body.x.len(), 4 * 2);
    assert_eq!(body.x[0], [0.125; 3]);
    assert_eq!(body.volume.iter().sum::<f64>(), 0.125);
}

#[test]
fn the_disc_has_103110_nodes() {
    // Parks et al. 2008: six layers of the lattice points within 37 mm of one of them, a = 0.5 mm. Twelve points of
    // a layer lie on the circle (74^2 = 70^2 + 24^2); LAMMPS loses eight of them to rounding.
    let disc = Shape::Cylinder {
        from: [0.0, 0.0, -2.5e-3],
        to: [0.0; 3],
        radius: 0.037,
    };
    let mut c = solid(disc, 5e-4, Anchor::Node([0.0; 3]));
    assert_eq!(carve(&c).unwrap().x.len(), 103_110 + 6 * 8);
    c.tolerance = Some(0.0);
    let body = carve(&c).unwrap();
    assert_eq!(body.x.len(), 103_110);
    assert_eq!(body.grid.unwrap().shape, [149, 149, 6]);
}

#[test]
fn the_box_of_cells_is_tight() {
    let shape = Shape::Intersection(vec![
        Shape::Box {
            from: [0.0; 3],
            to: [1.0; 3],
        },
        Shape::Sphere {
            center: [0.5; 3],
            radius: 0.2,
        },
    ]);
    let body = carve(&solid(shape, 0.1, Anchor::Node([0.5; 3]))).unwrap();
    let grid = body.grid.unwrap();
    assert_eq!(grid.shape, [5; 3]);
    assert!((grid.origin[0] - 0.3).abs() < 1e-12);
}

#[test]
fn a_period_is_the_extent() {
    let mut c = solid(
        Shape::Box {
            from: [0.0; 3],
            to: [1.0; 3],
        },
        0.25,
        Anchor::Node([0.0; 3]),
    );
    c.periodic = [true, false, false];
    let body = carve(&c).unwrap();
    assert_eq!(body.grid.unwrap().shape, [4, 5, 5]);
    assert_eq!(body.periodic, [Some(1.0), None, None]);
    c.spacing = 0.3;
    assert!(
        carve(&c)
            .unwrap_err()
            .to_string()
            .contains("multiple of the spacing")
    );
}

#[test]
fn two_dimensional_volumes_have_the_thickness() {
    let mut c = solid(
        Shape::Box {
            from: [0.0; 3],
            to: [1.0; 3],
        },
        0.5,
        Anchor::CellCentres,
    );
    c.flavour = Flavour::PlaneStress;
    c.cross = 0.1;
    let body = carve(&c);
    assert_eq!(body.unwrap().volume, vec![0.025; 4]);
}

#[test]
fn impossible_bodies_are_refused() {
    let ball = Shape::Sphere {
        center: [0.0; 3],
        radius: 1.0,
    };
    let message = |c: Carve| carve(&c).unwrap_err().to_string();
    assert!(
        message(solid(ball.clone(), -0.1, Anchor::CellCentres)).contains("positive, finite length")
    );
    assert!(message(solid(ball.clone(), f64::NAN, Anchor::CellCentres)).contains("spacing is NaN"));
    assert!(message(solid(ball.clone(), 1e-7, Anchor::CellCentres)).contains("larger spacing"));
    assert!(message(solid(ball, 3.0, Anchor::Node([1.4; 3]))).contains("no node"));
    assert!(message(solid(Shape::All, 0.1, Anchor::CellCentres)).contains("not bounded"));
}
