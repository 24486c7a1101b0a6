//! `history.csv`: one row per due step. A resumed run keeps the rows before its checkpoint.

use super::Row;
use std::fs::File;
use std::io::{BufRead, BufReader, BufWriter, Write};
use std::path::Path;

pub struct History {
    out: BufWriter<File>,
}

impl History {
    /// A new file, or one that keeps the rows of steps before `resumed`.
    pub fn create(path: &Path, columns: &[String], resumed: u64) -> std::io::Result<History> {
        let kept = if resumed > 0 {
            before(path, resumed)?
        } else {
            Vec::new()
        };
        let mut out = BufWriter::new(File::create(path)?);
        writeln!(out, "{}", columns.join(","))?;
        for line in kept {
            writeln!(out, "{line}")?;
        }
        Ok(History { out })
    }

    pub fn write(&mut self, row: &Row) -> std::io::Result<()> {
        writeln!(self.out, "{}", row.values().join(","))?;
        // Rows are few and people watch the file.
        self.out.flush()
    }
}

fn before(path: &Path, step: u64) -> std::io::Result<Vec<String>> {
    if !path.exists() {
        return Ok(Vec::new());
    }
    let mut kept = Vec::new();
    for line in BufReader::new(File::open(path)?).lines() {
        let line = line?;
        let number = line.split(',').next().and_then(|n| n.parse::<u64>().ok());
        if number.is_some_and(|n| n < step) {
            kept.push(line);
        }
    }
    Ok(kept)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observe::FieldRow;

    #[test]
    fn a_resumed_history_has_no_gap_and_no_double_row() {
        let dir = std::env::temp_dir().join(format!("history-{}", std::process::id()));
        std::fs::create_dir_all(&dir).unwrap();
        let path = dir.join("history.csv");
        let row = |step| Row {
            step,
            kinetic: 0.1,
            fields: vec![FieldRow {
                name: "T".into(),
                unit: "K".into(),
                ..FieldRow::default()
            }],
            ..Row::default()
        };
        let columns = row(0).columns();
        let mut h = History::create(&path, &columns, 0).unwrap();
        (0..4).for_each(|s| h.write(&row(s)).unwrap());
        drop(h);
        let mut h = History::create(&path, &columns, 2).unwrap();
        (2..4).for_each(|s| h.write(&row(s)).unwrap());
        let text = std::fs::read_to_string(&path).unwrap();
        let steps: Vec<&str> = text.lines().map(|l| l.split(',').next().unwrap()).collect();
        assert_eq!(steps, ["step", "0", "1", "2", "3"]);
        assert!(
            text.lines()
                .all(|l| l.split(',').count() == Row::COLUMNS.len() + 4)
        );
        // A law without energy has no strain energy: that cell is empty.
        assert!(text.contains("\n3,0e0,1e-1,,0e0,"));
        assert!(text.contains(",T_min_K,T_mean_K,T_max_K,T_total_K_m3\n"));
        std::fs::remove_dir_all(dir).unwrap();
    }
}
