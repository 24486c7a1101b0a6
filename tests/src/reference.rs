//! Reference data of other codes; `tests/data/README.md` says where it comes from.

use flate2::read::GzDecoder;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

/// A table with named columns, one row per node of [`crate::block`].
pub struct Table {
    columns: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Table {
    /// Reads `tests/data/<name>.txt.gz`.
    ///
    /// # Errors
    /// When the file is missing, is not compressed text, or a row is not numbers.
    pub fn read(name: &str) -> io::Result<Table> {
        let path = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("data")
            .join(format!("{name}.txt.gz"));
        let mut text = String::new();
        GzDecoder::new(File::open(path)?).read_to_string(&mut text)?;
        let mut lines = text.lines();
        let columns = lines
            .next()
            .unwrap_or("")
            .split(' ')
            .map(String::from)
            .collect();
        let rows: io::Result<Vec<Vec<f64>>> = lines.map(numbers).collect();
        Ok(Table {
            columns,
            rows: rows?,
        })
    }

    /// One column, by name.
    pub fn column(&self, name: &str) -> Vec<f64> {
        let k = self
            .columns
            .iter()
            .position(|c| c == name)
            .expect("the file has this column");
        self.rows.iter().map(|row| row[k]).collect()
    }

    /// Three columns as vectors.
    pub fn vectors(&self, names: [&str; 3]) -> Vec<[f64; 3]> {
        let [a, b, c] = names.map(|name| self.column(name));
        (0..self.rows.len()).map(|i| [a[i], b[i], c[i]]).collect()
    }
}

fn numbers(line: &str) -> io::Result<Vec<f64>> {
    let number = |word: &str| {
        word.parse()
            .map_err(|e| io::Error::new(io::ErrorKind::InvalidData, e))
    };
    line.split(' ').map(number).collect()
}
