//! The body of a probe, and its deformation.

use super::{Node, Place, Probe};
use crate::ir::{FieldId, Law, Shape};
use crate::oracle::{Body, Node as BodyNode, State, Value};

/// Nodes as close as the horizon are bonded, whatever rounding says.
const SLACK: f64 = 1.0 + 1e-9;

/// The body of a probe, and what makes its state of the one at rest.
pub(super) fn build(law: &Law, probe: &Probe) -> (Body, impl Fn(State) -> State) {
    let (nodes, cuts) = match &probe.place {
        Place::Nodes(nodes, cuts) => (nodes.clone(), cuts.clone()),
        Place::Lattice {
            spacing,
            gradient,
            fields,
        } => (lattice(probe, *spacing, gradient, fields), Vec::new()),
    };
    let placed = nodes.iter().map(|node| BodyNode {
        position: node.position,
        volume: node.volume,
    });
    let body = Body::within(placed.collect(), probe.horizon);
    let shapes: Vec<Shape> = law.fields.iter().map(|field| field.shape).collect();
    let (dim, own) = (probe.flavour.dim(), body.clone());
    let deform = move |mut state: State| {
        for (k, node) in nodes.iter().enumerate() {
            (state.u[k], state.v[k]) = (node.u, node.v);
            for (field, value) in &node.fields {
                state.fields[field.index()][k] = shaped(shapes[field.index()], value, dim);
            }
        }
        state.cut(&own, |from, to| cuts.contains(&(from, to)));
        state
    };
    (body, deform)
}

/// Whether two nodes of a probe are bonded.
pub(crate) fn bonded(a: &Node, b: &Node, horizon: f64) -> bool {
    length(between(a, b)) <= horizon * SLACK
}

fn between(a: &Node, b: &Node) -> [f64; 3] {
    std::array::from_fn(|c| b.position[c] - a.position[c])
}

fn length(xi: [f64; 3]) -> f64 {
    xi.iter().map(|c| c * c).sum::<f64>().sqrt()
}

/// A node with its full family, and around it the full families of its neighbours. It is number 0.
fn lattice(
    probe: &Probe,
    spacing: f64,
    gradient: &[[f64; 3]; 3],
    fields: &[(FieldId, Vec<f64>)],
) -> Vec<Node> {
    let dim = probe.flavour.dim();
    let radius = 2.0 * probe.horizon * SLACK;
    let last = (radius / spacing).floor() as i32;
    let reach = |axis: usize| if axis < dim { -last..=last } else { 0..=0 };
    let mut nodes = Vec::new();
    for i in reach(0) {
        for j in reach(1) {
            for k in reach(2) {
                let position = [i, j, k].map(|c| f64::from(c) * spacing);
                if length(position) > radius {
                    continue;
                }
                let u = gradient.map(|row| (0..3).map(|c| row[c] * position[c]).sum());
                nodes.push(Node {
                    name: String::new(),
                    position,
                    volume: spacing.powi(dim as i32) * probe.cross,
                    u,
                    v: [0.0; 3],
                    fields: fields.to_vec(),
                });
            }
        }
    }
    let centre = nodes.len() / 2;
    nodes.swap(0, centre);
    nodes
}

fn shaped(shape: Shape, values: &[f64], dim: usize) -> Value<f64> {
    let at = |k: usize| values.get(k).copied().unwrap_or_default();
    match shape {
        Shape::Scalar | Shape::Boolean => Value::Scalar(at(0)),
        Shape::Vector => Value::Vector(std::array::from_fn(|a| if a < dim { at(a) } else { 0.0 })),
        Shape::Symmetric | Shape::Tensor => Value::Tensor(std::array::from_fn(|a| {
            std::array::from_fn(|b| {
                if a < dim && b < dim {
                    at(a * dim + b)
                } else {
                    0.0
                }
            })
        })),
    }
}
