//! The plain reference implementations against LAMMPS and CabanaPD: the data and the formulas are right.

use pdlang_tests::block::{self, *};
use pdlang_tests::naive::{self, Lps};
use pdlang_tests::reference::Table;

fn bonds(partial: bool) -> Vec<naive::Bond> {
    naive::bonds(&positions(), |_| VOLUME, DELTA, partial.then_some(DX))
}

/// Prints and bounds one measured error.
fn below(what: &str, error: f64, bound: f64) {
    println!("{what}: {error:.2e}");
    assert!(error <= bound, "{what}: {error:e} exceeds {bound:e}");
}

fn compare(what: &str, got: &[f64], expected: &[f64], bound: f64) {
    let size = expected.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let difference = got
        .iter()
        .zip(expected)
        .fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    below(what, difference / size, bound);
}

#[test]
fn the_block_has_the_bonds_of_the_peers() {
    assert_eq!(bonds(true).len(), 116_294);
}

#[test]
fn pmb_of_lammps() {
    let (bonds, c) = (bonds(true), naive::pmb_constant(K, DELTA));
    let start = Table::read("lammps/pmb_wave.0").unwrap();
    let end = Table::read("lammps/pmb_wave.100").unwrap();
    let mut u = lammps_displacements(&start);
    let force = naive::pmb_force(&bonds, &u, c);
    below(
        "force",
        relative_error(&force, &start.vectors(["fx", "fy", "fz"])),
        1e-12,
    );
    compare(
        "energy",
        &naive::pmb_energy(&bonds, &u, c),
        &start.column("energy"),
        1e-12,
    );
    naive::verlet(&mut u, RHO, DT, 100, |u| naive::pmb_force(&bonds, u, c));
    let expected = lammps_displacements(&end);
    below(
        "u after 100 steps / A",
        block::largest_difference(&u, &expected) / AMPLITUDE,
        1e-11,
    );
}

#[test]
fn lps_of_lammps() {
    let bonds = bonds(true);
    let lps = Lps::new(K, G, |x| 1.0 / x, &bonds, CELLS.pow(3));
    let start = Table::read("lammps/lps_wave.0").unwrap();
    let end = Table::read("lammps/lps_wave.100").unwrap();
    let mut u = lammps_displacements(&start);
    let force = lps.force(&bonds, &u);
    below(
        "force",
        relative_error(&force, &start.vectors(["fx", "fy", "fz"])),
        1e-12,
    );
    compare(
        "theta",
        &lps.theta(&bonds, &u),
        &start.column("theta"),
        1e-12,
    );
    naive::verlet(&mut u, RHO, DT, 100, |u| lps.force(&bonds, u));
    let expected = lammps_displacements(&end);
    below(
        "u after 100 steps / A",
        block::largest_difference(&u, &expected) / AMPLITUDE,
        1e-11,
    );
}

#[test]
fn pmb_of_cabanapd() {
    let (bonds, c) = (bonds(false), naive::pmb_constant(K, DELTA));
    let start = Table::read("cabanapd/pmb.0").unwrap();
    let end = Table::read("cabanapd/pmb.100").unwrap();
    let mut u = start.vectors(["ux", "uy", "uz"]);
    let force = naive::pmb_force(&bonds, &u, c);
    below(
        "force",
        relative_error(&force, &start.vectors(["fx", "fy", "fz"])),
        1e-12,
    );
    compare(
        "energy",
        &naive::pmb_energy(&bonds, &u, c),
        &start.column("energy"),
        1e-12,
    );
    naive::verlet(&mut u, RHO, DT, 100, |u| naive::pmb_force(&bonds, u, c));
    let expected = end.vectors(["ux", "uy", "uz"]);
    below(
        "u after 100 steps / A",
        block::largest_difference(&u, &expected) / AMPLITUDE,
        1e-11,
    );
}

fn lps_of_cabanapd(name: &str, omega: impl Fn(f64) -> f64) {
    let bonds = bonds(false);
    let lps = Lps::new(K, G, omega, &bonds, CELLS.pow(3));
    let start = Table::read(&format!("cabanapd/{name}.0")).unwrap();
    let end = Table::read(&format!("cabanapd/{name}.100")).unwrap();
    let mut u = start.vectors(["ux", "uy", "uz"]);
    let force = lps.force(&bonds, &u);
    below(
        "force",
        relative_error(&force, &start.vectors(["fx", "fy", "fz"])),
        1e-12,
    );
    compare(
        "energy",
        &lps.energy(&bonds, &u),
        &start.column("energy"),
        1e-12,
    );
    naive::verlet(&mut u, RHO, DT, 100, |u| lps.force(&bonds, u));
    let expected = end.vectors(["ux", "uy", "uz"]);
    below(
        "u after 100 steps / A",
        block::largest_difference(&u, &expected) / AMPLITUDE,
        1e-11,
    );
}

#[test]
fn lps_of_cabanapd_with_influence_one() {
    lps_of_cabanapd("lps_infl0", |_| 1.0);
}

#[test]
fn lps_of_cabanapd_with_influence_one_over_r() {
    lps_of_cabanapd("lps_infl1", |x| 1.0 / x);
}
