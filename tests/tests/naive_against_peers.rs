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

/// Bonds of LAMMPS break after their force was added, where the stretch exceeds the smaller s0 of its ends. The
/// s0 of a node is 0.003 - 0.25 times the least stretch of its bonds, as the call before found it.
struct Fracture {
    bonds: Vec<naive::Bond>,
    s0: Vec<f64>,
}

impl Fracture {
    fn force(&mut self, u: &[[f64; 3]], c: f64) -> Vec<[f64; 3]> {
        let force = naive::pmb_force(&self.bonds, u, c);
        let mut least = vec![f64::INFINITY; u.len()];
        for bond in self.bonds.iter_mut().filter(|bond| bond.intact) {
            let stretch = naive::kinematics(bond, u).1 / bond.x;
            least[bond.i] = least[bond.i].min(stretch);
            bond.intact = stretch <= self.s0[bond.i].min(self.s0[bond.j]);
        }
        self.s0 = least.iter().map(|s| 0.003 - 0.25 * s).collect();
        force
    }

    fn damage(&self) -> Vec<f64> {
        let whole = naive::node_sum(&self.all(), self.s0.len(), |bond| VOLUME / bond.weight);
        let left = naive::node_sum(&self.bonds, self.s0.len(), |bond| VOLUME / bond.weight);
        whole
            .iter()
            .zip(left)
            .map(|(whole, left)| 1.0 - left / whole)
            .collect()
    }

    fn all(&self) -> Vec<naive::Bond> {
        self.bonds
            .iter()
            .map(|bond| naive::Bond {
                intact: true,
                ..*bond
            })
            .collect()
    }
}

#[test]
fn fracture_of_lammps() {
    let (bonds, c) = (bonds(true), naive::pmb_constant(K, DELTA));
    let table = |step: usize| Table::read(&format!("lammps/pmb_frac.{step}")).unwrap();
    let mut u = lammps_displacements(&table(0));
    // The block was at rest in the call before, so that every s0 was 0.003.
    let s0 = vec![0.003; u.len()];
    let mut fracture = Fracture { bonds, s0 };
    let mut calls = 0;
    naive::verlet(&mut u, RHO, DT, 100, |u| {
        let force = fracture.force(u, c);
        if [0, 20, 100].contains(&calls) {
            let table = table(calls);
            let expected = lammps_displacements(&table);
            let error = block::largest_difference(u, &expected) / AMPLITUDE;
            below(&format!("u after {calls} steps / A"), error, 1e-11);
            let forces = table.vectors(["fx", "fy", "fz"]);
            below("force", relative_error(&force, &forces), 1e-11);
            compare("damage", &fracture.damage(), &table.column("damage"), 1e-14);
        }
        calls += 1;
        force
    });
}
