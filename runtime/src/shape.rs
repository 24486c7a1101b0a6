//! Shapes and surfaces: where a body is, where a condition acts, what a crack cuts.
//!
//! Shapes are closed sets: a point on the boundary is inside. Every test takes a tolerance [m], normally
//! [`tolerance`] of the lattice constant, so that rounding in a coordinate never decides.

use crate::error::InputError;

/// Positions closer than this to a boundary count as lying on it [m]: a millionth of the spacing.
pub fn tolerance(spacing: f64) -> f64 {
    1e-6 * spacing
}

/// A closed set of points in reference coordinates [m].
#[derive(Clone, Debug, PartialEq)]
pub enum Shape {
    /// Everywhere; a region only, not a body.
    All,
    /// Axis-parallel box between two corners; infinite bounds are allowed in regions.
    Box {
        from: [f64; 3],
        to: [f64; 3],
    },
    /// Between two points on the axis, of any direction.
    Cylinder {
        from: [f64; 3],
        to: [f64; 3],
        radius: f64,
    },
    /// A ball; in two dimensions a disc.
    Sphere {
        center: [f64; 3],
        radius: f64,
    },
    Union(Vec<Shape>),
    Intersection(Vec<Shape>),
    /// The first without the interior of the others: the wall of a hole belongs to the body.
    Difference(Box<Shape>, Vec<Shape>),
}

impl Shape {
    /// Whether `x` lies inside or within `tolerance` of the boundary. A negative tolerance asks for the interior.
    pub fn contains(&self, x: [f64; 3], tolerance: f64) -> bool {
        match self {
            Shape::All => true,
            Shape::Box { from, to } => in_box(x, from, to, tolerance),
            Shape::Cylinder { from, to, radius } => in_cylinder(x, *from, *to, *radius, tolerance),
            Shape::Sphere { center, radius } => norm(sub(x, *center)) <= radius + tolerance,
            Shape::Union(parts) => parts.iter().any(|p| p.contains(x, tolerance)),
            Shape::Intersection(parts) => parts.iter().all(|p| p.contains(x, tolerance)),
            Shape::Difference(base, cuts) => {
                base.contains(x, tolerance) && !cuts.iter().any(|c| c.contains(x, -tolerance))
            }
        }
    }

    /// Corners of a box that holds the shape [m]; infinite where the shape is unbounded.
    pub fn bounds(&self) -> ([f64; 3], [f64; 3]) {
        match self {
            Shape::All => ([f64::NEG_INFINITY; 3], [f64::INFINITY; 3]),
            Shape::Box { from, to } => (*from, *to),
            Shape::Cylinder { from, to, radius } => cylinder_bounds(*from, *to, *radius),
            Shape::Sphere { center, radius } => {
                (center.map(|c| c - radius), center.map(|c| c + radius))
            }
            Shape::Union(parts) => fold_bounds(parts, f64::min, f64::max),
            Shape::Intersection(parts) => fold_bounds(parts, f64::max, f64::min),
            Shape::Difference(base, _) => base.bounds(),
        }
    }

    /// Refuses NaN, radii that are not positive, boxes whose corners are swapped, empty lists.
    pub fn check(&self) -> Result<(), InputError> {
        match self {
            Shape::All => Ok(()),
            Shape::Box { from, to } => check_box(from, to),
            Shape::Cylinder { from, to, radius } => {
                check_points(&[*from, *to])?;
                check_radius(*radius)?;
                if norm(sub(*to, *from)) > 0.0 {
                    return Ok(());
                }
                Err(InputError::new(
                    "a cylinder's two axis points are the same",
                    "give `from` and `to` a distance: the height of the cylinder",
                ))
            }
            Shape::Sphere { center, radius } => {
                check_points(&[*center])?;
                check_radius(*radius)
            }
            Shape::Union(parts) | Shape::Intersection(parts) => {
                if parts.is_empty() {
                    return Err(InputError::new(
                        "a union or intersection of no shapes",
                        "list at least one shape",
                    ));
                }
                parts.iter().try_for_each(Shape::check)
            }
            Shape::Difference(base, cuts) => {
                base.check()?;
                cuts.iter().try_for_each(Shape::check)
            }
        }
    }
}

fn in_box(x: [f64; 3], from: &[f64; 3], to: &[f64; 3], tolerance: f64) -> bool {
    (0..3).all(|d| x[d] >= from[d] - tolerance && x[d] <= to[d] + tolerance)
}

fn in_cylinder(x: [f64; 3], from: [f64; 3], to: [f64; 3], radius: f64, tolerance: f64) -> bool {
    let axis = sub(to, from);
    let height = norm(axis);
    let along = dot(sub(x, from), axis) / height;
    let foot = [0, 1, 2].map(|d| from[d] + axis[d] * (along / height));
    along >= -tolerance && along <= height + tolerance && norm(sub(x, foot)) <= radius + tolerance
}

fn cylinder_bounds(from: [f64; 3], to: [f64; 3], radius: f64) -> ([f64; 3], [f64; 3]) {
    let axis = sub(to, from);
    let height = norm(axis);
    // A disc with normal n reaches radius * sqrt(1 - n_d^2) along direction d.
    let reach = axis.map(|a| radius * (1.0 - (a / height).powi(2)).max(0.0).sqrt());
    (
        [0, 1, 2].map(|d| from[d].min(to[d]) - reach[d]),
        [0, 1, 2].map(|d| from[d].max(to[d]) + reach[d]),
    )
}

fn fold_bounds(
    parts: &[Shape],
    low: fn(f64, f64) -> f64,
    high: fn(f64, f64) -> f64,
) -> ([f64; 3], [f64; 3]) {
    let mut bounds = parts.iter().map(Shape::bounds);
    let first = bounds.next().unwrap_or(([0.0; 3], [0.0; 3]));
    bounds.fold(first, |a, b| {
        (
            [0, 1, 2].map(|d| low(a.0[d], b.0[d])),
            [0, 1, 2].map(|d| high(a.1[d], b.1[d])),
        )
    })
}

fn check_box(from: &[f64; 3], to: &[f64; 3]) -> Result<(), InputError> {
    for d in 0..3 {
        if from[d].is_nan() || to[d].is_nan() {
            return Err(not_a_number());
        }
        if from[d] > to[d] {
            return Err(InputError::new(
                format!(
                    "a box runs from {} to {} along {}",
                    from[d],
                    to[d],
                    ["x", "y", "z"][d]
                ),
                "swap the two: `from` is the smaller corner",
            ));
        }
    }
    Ok(())
}

fn check_points(points: &[[f64; 3]]) -> Result<(), InputError> {
    if points.iter().flatten().all(|c| c.is_finite()) {
        Ok(())
    } else {
        Err(not_a_number())
    }
}

fn check_radius(radius: f64) -> Result<(), InputError> {
    if radius > 0.0 && radius.is_finite() {
        return Ok(());
    }
    Err(InputError::new(
        format!("a radius is {radius}"),
        "a radius is a positive, finite length",
    ))
}

fn not_a_number() -> InputError {
    InputError::new(
        "a coordinate of a shape is not a finite number",
        "give every coordinate as a length",
    )
}

/// What a precrack is made of: a flat patch that bonds may cross.
///
/// A node within tolerance of the patch's plane counts as lying on its positive side (that of `normal`).
/// So a bond in the plane is never cut, a bond from the plane to the negative side is, and one to the
/// positive side is not: every node has exactly one side, and a crack through a lattice row separates it
/// from one neighbour row only. A bond through the rim of the patch is cut.
#[derive(Clone, Debug, PartialEq)]
pub enum Surface {
    /// Unbounded.
    Plane { point: [f64; 3], normal: [f64; 3] },
    /// Parallelogram with one corner and two edges; the normal is the cross product of the edges.
    Patch {
        corner: [f64; 3],
        edges: [[f64; 3]; 2],
    },
    Disc {
        center: [f64; 3],
        normal: [f64; 3],
        radius: f64,
    },
    /// In two dimensions; the normal is the direction turned by +90 degrees.
    Segment { from: [f64; 2], to: [f64; 2] },
    /// In one dimension; the normal is +x.
    Point { x: f64 },
}

impl Surface {
    /// Whether the bond between `a` and `b` is cut; the same for both directions of the bond.
    pub fn crosses(&self, a: [f64; 3], b: [f64; 3], tolerance: f64) -> bool {
        let (point, normal) = self.plane();
        let side = |x| dot(sub(x, point), normal);
        let (sa, sb) = (side(a), side(b));
        // The negative end first, so that a -> b and b -> a compute the same bits.
        let (neg, pos, sn, sp) = match (sa < -tolerance, sb < -tolerance) {
            (true, false) => (a, b, sa, sb.max(0.0)),
            (false, true) => (b, a, sb, sa.max(0.0)),
            _ => return false,
        };
        let t = sn / (sn - sp);
        let foot = [0, 1, 2].map(|d| neg[d] + t * (pos[d] - neg[d]));
        self.covers(foot, tolerance)
    }

    /// Refuses NaN and patches without extent.
    pub fn check(&self) -> Result<(), InputError> {
        let (point, normal) = self.plane();
        if !point.iter().all(|c| c.is_finite()) {
            return Err(not_a_number());
        }
        let radius = if let Surface::Disc { radius, .. } = self {
            *radius
        } else {
            1.0
        };
        if normal.iter().all(|c| c.is_finite()) && radius > 0.0 {
            return Ok(());
        }
        Err(InputError::new(
            "a crack has no extent",
            "give it a length, two edges that are not parallel, a normal other than 0 or a positive radius",
        ))
    }

    /// A point of the plane and its unit normal; the normal is NaN when the patch has no extent.
    fn plane(&self) -> ([f64; 3], [f64; 3]) {
        match self {
            Surface::Plane { point, normal } => (*point, unit(*normal)),
            Surface::Patch { corner, edges } => (*corner, unit(cross(edges[0], edges[1]))),
            Surface::Disc { center, normal, .. } => (*center, unit(*normal)),
            Surface::Segment { from, to } => (
                [from[0], from[1], 0.0],
                unit([from[1] - to[1], to[0] - from[0], 0.0]),
            ),
            Surface::Point { x } => ([*x, 0.0, 0.0], [1.0, 0.0, 0.0]),
        }
    }

    /// Whether a point of the plane belongs to the patch.
    fn covers(&self, x: [f64; 3], tolerance: f64) -> bool {
        match self {
            Surface::Plane { .. } | Surface::Point { .. } => true,
            Surface::Patch { corner, edges } => in_patch(sub(x, *corner), edges, tolerance),
            Surface::Disc { center, radius, .. } => norm(sub(x, *center)) <= radius + tolerance,
            Surface::Segment { from, to } => {
                let edge = [to[0] - from[0], to[1] - from[1], 0.0];
                let along = dot(sub(x, [from[0], from[1], 0.0]), unit(edge));
                along >= -tolerance && along <= norm(edge) + tolerance
            }
        }
    }
}

/// Whether `x = a e0 + b e1` with both distances from the edges inside or within tolerance.
fn in_patch(x: [f64; 3], edges: &[[f64; 3]; 2], tolerance: f64) -> bool {
    let normal = unit(cross(edges[0], edges[1]));
    [(edges[0], edges[1]), (edges[1], edges[0])]
        .iter()
        .all(|(edge, other)| {
            // Distance from the line of `other`, measured inwards, and the extent of the patch that way.
            let mut inward = unit(cross(normal, *other));
            if dot(inward, *edge) < 0.0 {
                inward = inward.map(|c| -c);
            }
            let along = dot(x, inward);
            along >= -tolerance && along <= dot(*edge, inward) + tolerance
        })
}

fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [
        a[1] * b[2] - a[2] * b[1],
        a[2] * b[0] - a[0] * b[2],
        a[0] * b[1] - a[1] * b[0],
    ]
}

fn norm(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let n = norm(a);
    a.map(|c| c / n)
}

#[cfg(test)]
#[path = "shape_tests.rs"]
mod tests;
