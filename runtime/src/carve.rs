//! Bodies carved out of a regular grid.

use crate::body::{Body, Flavour, Grid};
use crate::error::InputError;
use crate::shape::{Shape, tolerance};

/// Where the lattice stands.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Anchor {
    /// Nodes at the centres of cells that fill the shape's bounding box, centred where they do not fit.
    #[default]
    CellCentres,
    /// A lattice point at this position [m]; nodes on the boundary belong to the body.
    Node([f64; 3]),
}

/// What to carve.
#[derive(Clone, Debug, PartialEq)]
pub struct Carve {
    pub shape: Shape,
    pub flavour: Flavour,
    /// Lattice constant [m].
    pub spacing: f64,
    pub anchor: Anchor,
    /// Thickness (2D) [m] or cross-section (1D) [m^2]; ignored in 3D.
    pub cross: f64,
    /// Directions in which the body repeats itself; the period is the extent of the shape's bounding box.
    pub periodic: [bool; 3],
    /// Nodes this close to the boundary belong to the body [m]; `None` is [`tolerance`] of the spacing. With 0
    /// the comparison is that of floating-point numbers, which leaves out nodes that rounding puts outside: other
    /// codes do so, and node counts then agree with theirs.
    pub tolerance: Option<f64>,
    /// Memory that the nodes may take [bytes]; `None` is what the machine has available.
    pub memory: Option<u64>,
}

/// Bytes that a node costs here: position, volume, cell.
const NODE_BYTES: u64 = 44;

/// Memory that is free for use on this machine [bytes], where the system tells.
pub fn available_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|l| l.strip_prefix("MemAvailable:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}

/// The nodes of a regular grid that lie in the shape, x fastest, then y, then z.
///
/// Errors: a spacing or thickness that is not positive, a shape that is malformed, unbounded or holds no
/// node, a period that is no multiple of the spacing, a body that does not fit in memory (before any allocation).
pub fn carve(c: &Carve) -> Result<Body, InputError> {
    check(c)?;
    let ranges = ranges(c)?;
    check_memory(c, &ranges)?;
    let cells = cells(c, &ranges);
    if cells.is_empty() {
        return Err(InputError::new(
            format!(
                "no node of the lattice with spacing {} m lies in the body",
                c.spacing
            ),
            "use a smaller spacing or move the anchor",
        ));
    }
    Ok(body(c, &ranges, cells))
}

/// Lattice points along one direction: `anchor + spacing * (first + k)`, k = 0 .. count.
#[derive(Clone, Copy, Debug)]
struct Range {
    anchor: f64,
    first: f64,
    count: f64,
    period: Option<f64>,
}

fn check(c: &Carve) -> Result<(), InputError> {
    c.shape.check()?;
    if !(c.spacing > 0.0 && c.spacing.is_finite()) {
        return Err(InputError::new(
            format!("the spacing is {} m", c.spacing),
            "a spacing is a positive, finite length",
        ));
    }
    if c.flavour.dim() < 3 && !(c.cross > 0.0 && c.cross.is_finite()) {
        return Err(InputError::new(
            format!("the thickness or cross-section is {}", c.cross),
            "give a positive thickness (2D) or cross-section (1D)",
        ));
    }
    if let Anchor::Node(p) = c.anchor
        && !p.iter().all(|x| x.is_finite())
    {
        return Err(InputError::new(
            "the anchor is not a finite position",
            "give it as a position",
        ));
    }
    Ok(())
}

fn ranges(c: &Carve) -> Result<[Range; 3], InputError> {
    let (low, high) = c.shape.bounds();
    let mut out = [Range {
        anchor: 0.0,
        first: 0.0,
        count: 1.0,
        period: None,
    }; 3];
    for d in 0..c.flavour.dim() {
        if !(low[d].is_finite() && high[d].is_finite()) {
            return Err(InputError::new(
                "the body is not bounded",
                "a body needs a finite box, cylinder, sphere or combination of them",
            ));
        }
        out[d] = range(c, d, low[d], high[d])?;
    }
    Ok(out)
}

fn range(c: &Carve, d: usize, low: f64, high: f64) -> Result<Range, InputError> {
    let a = c.spacing;
    let cells = (high - low) / a;
    if c.periodic[d]
        && (cells.round() < 1.0 || (cells - cells.round()).abs() > 1e-6 * cells.max(1.0))
    {
        return Err(InputError::new(
            format!(
                "the body is periodic along {} with {cells} cells",
                ["x", "y", "z"][d]
            ),
            "make its extent a multiple of the spacing",
        ));
    }
    let period = c.periodic[d].then_some(cells.round() * a);
    Ok(match c.anchor {
        Anchor::CellCentres => {
            let count = cells.round().max(1.0);
            let rest = (high - low) - count * a;
            let rest = if rest.abs() < tolerance(a) { 0.0 } else { rest };
            Range {
                anchor: low + 0.5 * (rest + a),
                first: 0.0,
                count,
                period,
            }
        }
        Anchor::Node(p) => {
            let first = ((low - p[d]) / a - 1e-6).ceil();
            let last = ((high - p[d]) / a + 1e-6).floor();
            let count = if c.periodic[d] {
                cells.round()
            } else {
                (last - first + 1.0).max(0.0)
            };
            Range {
                anchor: p[d],
                first,
                count,
                period,
            }
        }
    })
}

fn check_memory(c: &Carve, ranges: &[Range; 3]) -> Result<(), InputError> {
    let nodes = ranges.iter().map(|r| r.count).product::<f64>();
    let need = nodes * NODE_BYTES as f64;
    let have = c.memory.or_else(available_memory).unwrap_or(1 << 34) as f64;
    if need <= have && ranges.iter().all(|r| r.count < f64::from(u32::MAX)) {
        return Ok(());
    }
    Err(InputError::new(
        format!(
            "the body spans {nodes:.3e} lattice cells, whose nodes alone take {:.1} GB; {:.1} GB are available",
            need / 1e9,
            have / 1e9
        ),
        "use a larger spacing or a smaller body",
    ))
}

fn cells(c: &Carve, ranges: &[Range; 3]) -> Vec<[u32; 3]> {
    let n = ranges.map(|r| r.count as u32);
    let margin = c.tolerance.unwrap_or(tolerance(c.spacing));
    let mut cells = Vec::new();
    for k in 0..n[2] {
        for j in 0..n[1] {
            for i in 0..n[0] {
                if c.shape.contains(position(c, ranges, [i, j, k]), margin) {
                    cells.push([i, j, k]);
                }
            }
        }
    }
    cells
}

fn position(c: &Carve, ranges: &[Range; 3], cell: [u32; 3]) -> [f64; 3] {
    [0, 1, 2].map(|d| {
        if d < c.flavour.dim() {
            ranges[d].anchor + c.spacing * (ranges[d].first + f64::from(cell[d]))
        } else {
            0.0
        }
    })
}

fn body(c: &Carve, ranges: &[Range; 3], mut cells: Vec<[u32; 3]>) -> Body {
    let (low, shape) = tight(ranges, &cells);
    for cell in &mut cells {
        *cell = [0, 1, 2].map(|d| cell[d] - low[d]);
    }
    let origin = position(c, ranges, low);
    let cross = if c.flavour.dim() == 3 { 1.0 } else { c.cross };
    let volume = c.spacing.powi(c.flavour.dim() as i32) * cross;
    // Positions follow from the grid by its own formula, so that both say the same to the last bit.
    let x: Vec<[f64; 3]> = cells
        .iter()
        .map(|cell| on_grid(origin, c.spacing, *cell))
        .collect();
    Body {
        flavour: c.flavour,
        volume: vec![volume; x.len()],
        x,
        material: vec![],
        regions: vec![],
        horizon: vec![],
        cross,
        grid: Some(Grid {
            origin,
            spacing: c.spacing,
            shape,
            cell: cells,
        }),
        spacing: c.spacing,
        periodic: ranges.map(|r| r.period),
    }
}

fn on_grid(origin: [f64; 3], spacing: f64, cell: [u32; 3]) -> [f64; 3] {
    [0, 1, 2].map(|d| origin[d] + spacing * f64::from(cell[d]))
}

/// First cell and number of cells per direction that hold all nodes; whole periods stay whole.
fn tight(ranges: &[Range; 3], cells: &[[u32; 3]]) -> ([u32; 3], [u32; 3]) {
    let (mut low, mut high) = ([u32::MAX; 3], [0; 3]);
    for cell in cells {
        for d in 0..3 {
            low[d] = low[d].min(cell[d]);
            high[d] = high[d].max(cell[d]);
        }
    }
    for d in 0..3 {
        if ranges[d].period.is_some() {
            (low[d], high[d]) = (0, ranges[d].count as u32 - 1);
        }
    }
    (low, [0, 1, 2].map(|d| high[d] - low[d] + 1))
}

#[cfg(test)]
#[path = "carve_tests.rs"]
mod tests;
