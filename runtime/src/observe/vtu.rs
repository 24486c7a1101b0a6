//! Fields as VTK unstructured grids of points (`.vtu`), and their series (`.pvd`).
//!
//! Binary data is appended raw and compressed block by block, as ParaView and VTK read it.

use super::Values;
use flate2::{Compression, write::ZlibEncoder};
use rayon::prelude::*;
use std::io::Write;
use std::path::Path;

/// Bytes of one compressed block.
const BLOCK: usize = 1 << 18;

/// A data array before it is written.
struct Array<'a> {
    name: &'a str,
    kind: &'static str,
    components: usize,
    bytes: Vec<u8>,
}

/// One file: points at `x`, one vertex cell per point, and the quantities on the points.
///
/// Vectors get three components, as readers expect; symmetric and general tensors keep theirs.
pub fn write(path: &Path, time: f64, x: &[[f64; 3]], quantities: &[Values]) -> std::io::Result<()> {
    let n = x.len();
    let points = floats("Points", 3, x.iter().flatten().copied());
    let cells = [
        ints("connectivity", (0..n as i32).collect()),
        ints("offsets", (1..=n as i32).collect()),
        Array {
            name: "types",
            kind: "UInt8",
            components: 1,
            bytes: vec![1; n],
        },
    ];
    let data: Vec<Array> = quantities.iter().map(|q| values(q, n)).collect();
    let (mut head, mut appended) = (String::new(), Vec::new());
    head.push_str(&format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n<FieldData>\n\
         <DataArray type=\"Float64\" Name=\"TimeValue\" NumberOfTuples=\"1\" format=\"ascii\">{time:e}</DataArray>\n\
         </FieldData>\n<Piece NumberOfPoints=\"{n}\" NumberOfCells=\"{n}\">\n"
    ));
    section(&mut head, &mut appended, "Points", &[points])?;
    section(&mut head, &mut appended, "Cells", &cells)?;
    section(&mut head, &mut appended, "PointData", &data)?;
    head.push_str("</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_");
    let mut bytes = head.into_bytes();
    bytes.extend(appended);
    bytes.extend(b"\n</AppendedData>\n</VTKFile>\n");
    crate::checkpoint::replace(path, &bytes)
}

fn floats(name: &str, components: usize, values: impl Iterator<Item = f64>) -> Array<'_> {
    Array {
        name,
        kind: "Float64",
        components,
        bytes: values.flat_map(f64::to_le_bytes).collect(),
    }
}

fn ints(name: &str, values: Vec<i32>) -> Array<'_> {
    Array {
        name,
        kind: "Int32",
        components: 1,
        bytes: values.into_iter().flat_map(i32::to_le_bytes).collect(),
    }
}

fn values(q: &Values, n: usize) -> Array<'_> {
    // Two components are a vector in the plane, whose third is 0.
    let width = if q.components.len() == 2 {
        3
    } else {
        q.components.len()
    };
    let at = |i: usize, c: usize| q.components.get(c).map_or(0.0, |v| v[i]);
    floats(
        &q.name,
        width,
        (0..n)
            .flat_map(|i| (0..width).map(move |c| (i, c)))
            .map(|(i, c)| at(i, c)),
    )
}

fn section(
    head: &mut String,
    appended: &mut Vec<u8>,
    tag: &str,
    arrays: &[Array],
) -> std::io::Result<()> {
    head.push_str(&format!("<{tag}>\n"));
    for a in arrays {
        head.push_str(&format!(
            "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"appended\" offset=\"{}\"/>\n",
            a.kind,
            escaped(a.name),
            a.components,
            appended.len()
        ));
        compress(&a.bytes, appended)?;
    }
    head.push_str(&format!("</{tag}>\n"));
    Ok(())
}

fn escaped(name: &str) -> String {
    name.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('"', "&quot;")
}

/// VTK's layout: number of blocks, size of a block, size of the last if smaller, compressed sizes, blocks.
fn compress(bytes: &[u8], out: &mut Vec<u8>) -> std::io::Result<()> {
    let pack = |chunk: &[u8]| {
        let mut z = ZlibEncoder::new(Vec::new(), Compression::fast());
        z.write_all(chunk)?;
        z.finish()
    };
    let blocks: Vec<Vec<u8>> = bytes
        .par_chunks(BLOCK)
        .map(pack)
        .collect::<std::io::Result<_>>()?;
    let head = [blocks.len(), BLOCK, bytes.len() % BLOCK];
    head.iter()
        .copied()
        .chain(blocks.iter().map(Vec::len))
        .for_each(|n| out.extend((n as u64).to_le_bytes()));
    blocks.iter().for_each(|b| out.extend(b));
    Ok(())
}

/// A series: (time [s], file beside the `.pvd`).
pub fn series(path: &Path, frames: &[(f64, String)]) -> std::io::Result<()> {
    let mut text = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" byte_order=\"LittleEndian\">\n<Collection>\n",
    );
    for (time, file) in frames {
        text.push_str(&format!(
            "<DataSet timestep=\"{time:e}\" part=\"0\" file=\"{file}\"/>\n"
        ));
    }
    text.push_str("</Collection>\n</VTKFile>\n");
    crate::checkpoint::replace(path, text.as_bytes())
}

/// The frames of a series that this module wrote, up to and without `time`.
pub fn frames_before(path: &Path, time: f64) -> Vec<(f64, String)> {
    let text = std::fs::read_to_string(path).unwrap_or_default();
    let quoted = |line: &str, key: &str| {
        let rest = line.split_once(&format!("{key}=\""))?.1;
        Some(rest.split_once('"')?.0.to_string())
    };
    let frame = |line: &str| {
        Some((
            quoted(line, "timestep")?.parse::<f64>().ok()?,
            quoted(line, "file")?,
        ))
    };
    text.lines()
        .filter_map(frame)
        .filter(|(t, _)| *t < time)
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn arrays_come_back() {
        let path = std::env::temp_dir().join(format!("fields-{}.vtu", std::process::id()));
        let x: Vec<[f64; 3]> = (0..20_000).map(|i| [i as f64, 0.5, -1.0]).collect();
        let plane = Values {
            name: "u<".into(),
            unit: String::new(),
            components: vec![vec![1.5; x.len()], vec![2.5; x.len()]],
        };
        write(&path, 0.25, &x, &[plane]).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        let start = bytes
            .windows(15)
            .position(|w| w == b"encoding=\"raw\">")
            .unwrap()
            + 17;
        let word = |at: usize| {
            u64::from_le_bytes(bytes[start + at..start + at + 8].try_into().unwrap()) as usize
        };
        // 480,000 bytes of points in blocks of 262,144.
        assert_eq!((word(0), word(8), word(16)), (2, BLOCK, 480_000 - BLOCK));
        let first = start + 8 * 5;
        let mut plain = Vec::new();
        flate2::read::ZlibDecoder::new(&bytes[first..first + word(24)])
            .read_to_end(&mut plain)
            .unwrap();
        assert_eq!(plain.len(), BLOCK);
        assert_eq!(f64::from_le_bytes(plain[24..32].try_into().unwrap()), 1.0);
        let text = String::from_utf8_lossy(&bytes[..start]);
        assert!(
            text.contains("Name=\"u&lt;\" NumberOfComponents=\"3\""),
            "{text}"
        );
    }

    #[test]
    fn a_series_is_read_back_up_to_a_time() {
        let path = std::env::temp_dir().join(format!("series-{}.pvd", std::process::id()));
        let frames: Vec<(f64, String)> = (0..3)
            .map(|k| (k as f64 * 1e-6, format!("fields/{k}.vtu")))
            .collect();
        series(&path, &frames).unwrap();
        assert_eq!(frames_before(&path, 2e-6), frames[..2]);
        std::fs::remove_file(&path).unwrap();
        assert!(frames_before(&path, 1.0).is_empty());
    }
}
