//! Bodies from a file of points: CSV with the columns x, y, z, volume.

use crate::body::{Body, Flavour};
use crate::error::InputError;
use std::collections::HashMap;
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

/// Reads a body from a CSV file with a header; columns may stand in any order, columns beyond the dimension
/// may be absent, further columns are ignored.
pub fn read(path: &Path, points: &Points) -> Result<Body, InputError> {
    parse(
        std::io::BufReader::new(open(path)?),
        &path.display().to_string(),
        points,
    )
}

/// As [`read`], from any source; `name` stands in messages.
pub fn parse(source: impl Read, name: &str, points: &Points) -> Result<Body, InputError> {
    check(points)?;
    let mut reader = reader(source);
    let columns = columns(&mut reader, name, points.flavour.dim())?;
    let mut body = empty(points);
    let mut seen = HashMap::new();
    for record in reader.records() {
        let record = record.map_err(|e| malformed(name, &e))?;
        let line = record.position().map_or(0, csv::Position::line);
        let (x, volume) = point(&record, &columns, name, line, points)?;
        if let Some(first) = seen.insert(x.map(f64::to_bits), line) {
            return Err(InputError::new(
                format!("{name}:{line}: this point lies where the point of line {first} lies"),
                "remove one of them: the bond between them has no length",
            ));
        }
        body.x.push(x);
        body.volume.push(volume);
    }
    finish(body, name, points)
}

/// One more column of a point file [SI], a number per point.
pub fn column(path: &Path, wanted: &str) -> Result<Vec<f64>, InputError> {
    let name = path.display().to_string();
    let file = open(path)?;
    let mut reader = reader(std::io::BufReader::new(file));
    let header = reader.headers().map_err(|e| malformed(&name, &e))?;
    let found = header.iter().position(|h| h.eq_ignore_ascii_case(wanted));
    if found.is_none() {
        let have: Vec<&str> = header.iter().collect();
        return Err(InputError::new(
            format!(
                "{name}:1: there is no column `{wanted}` among `{}`",
                have.join("`, `")
            ),
            "the first line names the columns",
        ));
    }
    let mut values = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|e| malformed(&name, &e))?;
        let line = record.position().map_or(0, csv::Position::line);
        values.push(number(&record, found, wanted, &name, line)?);
    }
    Ok(values)
}

fn open(path: &Path) -> Result<std::fs::File, InputError> {
    std::fs::File::open(path).map_err(|e| {
        InputError::new(
            format!("cannot read {}: {e}", path.display()),
            "check the path of the point file",
        )
    })
}

fn reader<R: Read>(source: R) -> csv::Reader<R> {
    csv::ReaderBuilder::new()
        .trim(csv::Trim::All)
        .comment(Some(b'#'))
        .from_reader(source)
}

const COLUMNS: [&str; 4] = ["x", "y", "z", "volume"];

fn check(points: &Points) -> Result<(), InputError> {
    let positive = |v: f64| v > 0.0 && v.is_finite();
    if positive(points.length)
        && points.spacing.is_none_or(positive)
        && (points.flavour.dim() == 3 || positive(points.cross))
    {
        return Ok(());
    }
    Err(InputError::new(
        "the unit of length, the spacing or the thickness of a point file is not positive",
        "give positive, finite numbers",
    ))
}

fn empty(points: &Points) -> Body {
    Body {
        flavour: points.flavour,
        x: Vec::new(),
        volume: Vec::new(),
        material: vec![],
        regions: vec![],
        horizon: vec![],
        cross: if points.flavour.dim() == 3 {
            1.0
        } else {
            points.cross
        },
        grid: None,
        spacing: 0.0,
        periodic: points.periodic,
    }
}

/// Position of each of [`COLUMNS`] in the file.
fn columns<R: Read>(
    reader: &mut csv::Reader<R>,
    name: &str,
    dim: usize,
) -> Result<[Option<usize>; 4], InputError> {
    let header = reader.headers().map_err(|e| malformed(name, &e))?;
    let found = COLUMNS.map(|c| header.iter().position(|h| h.eq_ignore_ascii_case(c)));
    for (k, column) in COLUMNS.iter().enumerate() {
        if found[k].is_none() && (k < dim || k == 3) {
            let have: Vec<&str> = header.iter().collect();
            return Err(InputError::new(
                format!(
                    "{name}:1: there is no column `{column}` among `{}`",
                    have.join("`, `")
                ),
                "the first line names the columns: x,y,z,volume",
            ));
        }
    }
    Ok(found)
}

fn point(
    record: &csv::StringRecord,
    columns: &[Option<usize>; 4],
    name: &str,
    line: u64,
    points: &Points,
) -> Result<([f64; 3], f64), InputError> {
    let mut x = [0.0; 3];
    for d in 0..points.flavour.dim() {
        x[d] = number(record, columns[d], COLUMNS[d], name, line)? * points.length;
    }
    let volume = number(record, columns[3], "volume", name, line)?;
    if volume > 0.0 {
        return Ok((x, volume * points.length.powi(3)));
    }
    Err(InputError::new(
        format!("{name}:{line}: the volume is {volume}"),
        "a node has a positive volume",
    ))
}

fn number(
    record: &csv::StringRecord,
    column: Option<usize>,
    what: &str,
    name: &str,
    line: u64,
) -> Result<f64, InputError> {
    let column = column.unwrap_or(usize::MAX);
    let text = record.get(column).unwrap_or("");
    match text.parse::<f64>() {
        Ok(v) if v.is_finite() => Ok(v),
        _ => Err(InputError::new(
            format!(
                "{name}:{line}: column {} ({what}) holds `{text}`, which is not a finite number",
                column + 1
            ),
            "write numbers such as 1.5e-3, without units",
        )),
    }
}

fn finish(mut body: Body, name: &str, points: &Points) -> Result<Body, InputError> {
    if body.x.is_empty() {
        return Err(InputError::new(
            format!("{name}: there are no points"),
            "give one point per line below the header",
        ));
    }
    let mean = body.volume.iter().sum::<f64>() / body.volume.len() as f64;
    body.spacing = points
        .spacing
        .unwrap_or_else(|| (mean / body.cross).powf(1.0 / points.flavour.dim() as f64));
    Ok(body)
}

fn malformed(name: &str, error: &csv::Error) -> InputError {
    InputError::new(
        format!("{name}: {error}"),
        "the file is CSV text with the same number of columns in every line",
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOLID: Points = Points {
        flavour: Flavour::Solid,
        cross: 1.0,
        spacing: None,
        length: 1e-3,
        periodic: [None; 3],
    };

    fn message(text: &str) -> String {
        parse(text.as_bytes(), "p.csv", &SOLID)
            .unwrap_err()
            .to_string()
    }

    #[test]
    fn columns_stand_in_any_order() {
        let text = "volume, z, y, x, tag\n8, 3, 2, 1, a\n8, 6, 5, 4, b\n";
        let body = parse(text.as_bytes(), "p.csv", &SOLID).unwrap();
        assert_eq!(body.x, [[1e-3, 2e-3, 3e-3], [4e-3, 5e-3, 6e-3]]);
        assert!((body.spacing - 2e-3).abs() < 1e-15 && (body.volume[1] - 8e-9).abs() < 1e-20);
    }

    #[test]
    fn faults_name_line_and_column() {
        assert!(message("x,y,volume\n1,2,3\n").starts_with("p.csv:1: there is no column `z`"));
        assert!(
            message("x,y,z,volume\n1,2,3,1\n1,two,3,1\n")
                .contains("p.csv:3: column 2 (y) holds `two`")
        );
        assert!(message("x,y,z,volume\n1,2,NaN,1\n").contains("column 3 (z) holds `NaN`"));
        assert!(message("x,y,z,volume\n1,2,3,-1\n").contains("p.csv:2: the volume is -1"));
        assert!(
            message("x,y,z,volume\n1,2,3,1\n4,5,6,1\n1,2,3,1\n")
                .contains("p.csv:4: this point lies where the point of line 2")
        );
        assert!(message("x,y,z,volume\n").contains("no points"));
        assert!(message("x,y,z,volume\n1,2\n").contains("line: 2"));
        assert!(message("").contains("no column `x`"));
        assert!(message("x,y,z,volume\n\u{0}\n").starts_with("p.csv"));
    }

    #[test]
    fn one_dimension_needs_x_only() {
        let bar = Points {
            flavour: Flavour::Bar,
            cross: 0.5,
            ..SOLID
        };
        let body = parse("x,volume\n1,1e9\n2,1e9\n".as_bytes(), "bar.csv", &bar).unwrap();
        assert_eq!(body.x[1], [2e-3, 0.0, 0.0]);
        assert_eq!(body.spacing, 2.0);
    }
}
