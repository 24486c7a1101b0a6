//! The explicit small body and its state.

use super::{Error, Value};
use crate::ir::{self, Home, Shape};

/// Nodes and directed bonds; every bond belongs to the ball of radius delta.
#[derive(Clone, Debug, Default)]
pub struct Body {
    pub nodes: Vec<Node>,
    pub bonds: Vec<Bond>,
}

#[derive(Clone, Copy, Debug)]
pub struct Node {
    /// Reference position [m].
    pub position: [f64; 3],
    /// Volume [m^3].
    pub volume: f64,
}

/// A directed bond i -> j, seen from i.
#[derive(Clone, Copy, Debug)]
pub struct Bond {
    pub from: usize,
    pub to: usize,
    /// Reference bond vector X_j - X_i [m]; in a periodic body that of the nearest image.
    pub xi: [f64; 3],
    /// Volume of the other end times the partial-volume factor [m^3].
    pub weight: f64,
}

impl Bond {
    /// Reference length [m].
    pub fn length(&self) -> f64 {
        self.xi.iter().map(|c| c * c).sum::<f64>().sqrt()
    }
}

/// Everything that changes.
#[derive(Clone, Debug, PartialEq)]
pub struct State {
    /// Displacement and velocity per node [m], [m/s].
    pub u: Vec<[f64; 3]>,
    pub v: Vec<[f64; 3]>,
    /// Time since the histories were committed [s].
    pub dt: f64,
    /// Per family and bond.
    pub intact: Vec<Vec<bool>>,
    /// Per field of the law and node.
    pub fields: Vec<Vec<Value<f64>>>,
    /// Committed values per history of the law and node, or bond of the body.
    pub histories: Vec<Vec<Value<f64>>>,
}

impl State {
    pub(super) fn rest(law: &ir::Law, body: &Body) -> State {
        let (nodes, bonds) = (body.nodes.len(), body.bonds.len());
        let count = |home| if home == Home::Bond { bonds } else { nodes };
        State {
            u: vec![[0.0; 3]; nodes],
            v: vec![[0.0; 3]; nodes],
            dt: 0.0,
            intact: vec![vec![true; bonds]; law.families.len()],
            fields: law
                .fields
                .iter()
                .map(|f| vec![filled(f.shape, 0.0); nodes])
                .collect(),
            histories: (law.histories.iter())
                .map(|h| vec![filled(h.shape, h.initial); count(h.home)])
                .collect(),
        }
    }

    /// Breaks the bonds of every family in both directions where `breaks(from, to)`.
    pub fn cut(&mut self, body: &Body, breaks: impl Fn(usize, usize) -> bool) {
        for family in &mut self.intact {
            for (bond, intact) in body.bonds.iter().zip(family) {
                *intact &= !(breaks(bond.from, bond.to) || breaks(bond.to, bond.from));
            }
        }
    }

    pub(super) fn fits(&self, law: &ir::Law, body: &Body) -> bool {
        let (nodes, bonds) = (body.nodes.len(), body.bonds.len());
        let count = |home| if home == Home::Bond { bonds } else { nodes };
        self.u.len() == nodes
            && self.v.len() == nodes
            && self.intact.len() == law.families.len()
            && self.intact.iter().all(|family| family.len() == bonds)
            && self.fields.len() == law.fields.len()
            && self.fields.iter().all(|field| field.len() == nodes)
            && self.histories.len() == law.histories.len()
            && (law.histories.iter().zip(&self.histories)).all(|(h, v)| v.len() == count(h.home))
    }
}

/// A value with every component equal.
fn filled(shape: Shape, value: f64) -> Value<f64> {
    match shape {
        Shape::Scalar => Value::Scalar(value),
        Shape::Vector => Value::Vector([value; 3]),
        Shape::Symmetric | Shape::Tensor => Value::Tensor([[value; 3]; 3]),
        Shape::Boolean => Value::Boolean(false),
    }
}

/// Nodes as close as the horizon are bonded, whatever rounding says.
const SLACK: f64 = 1.0 + 1e-9;

impl Body {
    /// Nodes, and bonds between all that are no further apart than the horizon [m].
    pub fn within(nodes: Vec<Node>, horizon: f64) -> Body {
        let mut bonds = Vec::new();
        for (from, a) in nodes.iter().enumerate() {
            for (to, b) in nodes.iter().enumerate() {
                let bond = Bond {
                    from,
                    to,
                    xi: std::array::from_fn(|c| b.position[c] - a.position[c]),
                    weight: b.volume,
                };
                if from != to && bond.length() <= horizon * SLACK {
                    bonds.push(bond);
                }
            }
        }
        Body { nodes, bonds }
    }

    pub(super) fn check(&self) -> Result<(), Error> {
        let count = self.nodes.len();
        if self.bonds.iter().any(|b| b.from >= count || b.to >= count) {
            return Err(Error("a bond names a node that does not exist".into()));
        }
        if self
            .nodes
            .iter()
            .any(|node| node.volume.is_nan() || node.volume <= 0.0)
        {
            return Err(Error("a node has no volume".into()));
        }
        Ok(())
    }

    pub(super) fn bonds_by_node(&self) -> Vec<Vec<usize>> {
        let mut own = vec![Vec::new(); self.nodes.len()];
        for (b, bond) in self.bonds.iter().enumerate() {
            own[bond.from].push(b);
        }
        own
    }

    /// Per bond, the bond j -> i with the opposite vector (periodic images have several bonds per pair).
    pub(super) fn reverses(&self) -> Vec<Option<usize>> {
        let own = self.bonds_by_node();
        let opposite = |a: &Bond, b: &Bond| {
            let gap: f64 = (0..3).map(|k| (a.xi[k] + b.xi[k]).abs()).sum();
            b.to == a.from && gap <= 1e-9 * a.length()
        };
        let reverse = |bond: &Bond| {
            own[bond.to]
                .iter()
                .copied()
                .find(|b| opposite(bond, &self.bonds[*b]))
        };
        self.bonds.iter().map(reverse).collect()
    }
}
