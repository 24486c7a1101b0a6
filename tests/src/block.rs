//! The block of the reference data: 11 x 11 x 11 nodes, free on all sides (`tests/data/README.md`).

use crate::reference::Table;

pub const CELLS: usize = 11;
/// Lattice constant [m].
pub const DX: f64 = 5e-4;
/// Horizon [m].
pub const DELTA: f64 = 3.015 * DX;
/// Node volume [m^3].
pub const VOLUME: f64 = DX * DX * DX;
/// Bulk and shear modulus [Pa], density [kg/m^3].
pub const K: f64 = 14.9e9;
pub const G: f64 = 6.0e9;
pub const RHO: f64 = 2200.0;
/// Time step [s].
pub const DT: f64 = 5e-8;
/// Amplitude of the displacement field [m].
pub const AMPLITUDE: f64 = 0.02 * DX;

/// Reference positions [m], x running fastest.
pub fn positions() -> Vec<[f64; 3]> {
    let at = |k: usize| k as f64 * DX;
    (0..CELLS.pow(3))
        .map(|n| [at(n % CELLS), at(n / CELLS % CELLS), at(n / CELLS / CELLS)])
        .collect()
}

/// The displacements that LAMMPS had, exactly: current minus reference position [m].
pub fn lammps_displacements(table: &Table) -> Vec<[f64; 3]> {
    let current = table.vectors(["x", "y", "z"]);
    let u = |(y, x): (&[f64; 3], &[f64; 3])| std::array::from_fn(|a| y[a] - x[a]);
    current.iter().zip(&positions()).map(u).collect()
}

/// Largest difference of a component, divided by the largest component of `expected`.
pub fn relative_error(got: &[[f64; 3]], expected: &[[f64; 3]]) -> f64 {
    largest_difference(got, expected)
        / largest_difference(expected, &vec![[0.0; 3]; expected.len()])
}

/// Largest difference of a component.
pub fn largest_difference(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter()
        .flatten()
        .zip(b.iter().flatten())
        .fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}
