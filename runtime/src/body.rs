//! A body: nodes with reference positions and volumes.

use crate::shape::Shape;

/// Dimension and the constraint in the directions that are left out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Flavour {
    Bar,
    Slab,
    PlaneStress,
    PlaneStrain,
    Solid,
}

impl Flavour {
    pub const ALL: [Flavour; 5] = [
        Flavour::Bar,
        Flavour::Slab,
        Flavour::PlaneStress,
        Flavour::PlaneStrain,
        Flavour::Solid,
    ];

    pub fn dim(self) -> usize {
        match self {
            Flavour::Bar | Flavour::Slab => 1,
            Flavour::PlaneStress | Flavour::PlaneStrain => 2,
            Flavour::Solid => 3,
        }
    }

    pub fn name(self) -> &'static str {
        match self {
            Flavour::Bar => "bar",
            Flavour::Slab => "slab",
            Flavour::PlaneStress => "plane_stress",
            Flavour::PlaneStrain => "plane_strain",
            Flavour::Solid => "3d",
        }
    }
}

/// Nodes in the order in which the user gave or carved them; every output uses this order.
#[derive(Clone, Debug)]
pub struct Body {
    pub flavour: Flavour,
    /// Reference positions [m]; components beyond the dimension are 0.
    pub x: Vec<[f64; 3]>,
    /// Node volumes [m^3]: in 2D area times thickness, in 1D length times cross-section.
    pub volume: Vec<f64>,
    /// Material of every node, by its position among the parameter sets; empty: the first one everywhere.
    pub material: Vec<u8>,
    /// Where the body has other material values, for laws that ask how much of a bond lies in either of two materials;
    /// of several that hold a point the last counts. Empty: not known, and bonds have half in each.
    pub regions: Vec<Shape>,
    /// Horizon of every node [m], 0 for that of its material; empty: of all nodes that of their material.
    pub horizon: Vec<f64>,
    /// Thickness (2D) [m] or cross-section (1D) [m^2]; 1 in 3D.
    pub cross: f64,
    /// Set when every node sits on a cell of one regular grid; the lattice traversal needs it.
    pub grid: Option<Grid>,
    /// Lattice constant, or the typical distance of neighbours in a cloud [m].
    pub spacing: f64,
    /// Period per direction [m].
    pub periodic: [Option<f64>; 3],
}

/// A regular grid: node i sits at `origin + spacing * cell[i]`.
#[derive(Clone, Debug)]
pub struct Grid {
    pub origin: [f64; 3],
    pub spacing: f64,
    /// Cells per direction; 1 beyond the dimension. Along a periodic direction the period is `shape * spacing`.
    pub shape: [u32; 3],
    pub cell: Vec<[u32; 3]>,
}
