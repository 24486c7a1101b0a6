//! Tables on the terminal, and the same rows as JSON.

use serde_json::{Map, Value};

/// Columns with a heading each; cells are text or numbers.
pub struct Table {
    columns: Vec<&'static str>,
    rows: Vec<Vec<Value>>,
}

impl Table {
    pub fn new(columns: &[&'static str]) -> Table {
        Table {
            columns: columns.to_vec(),
            rows: Vec::new(),
        }
    }

    /// Adds a row; as many cells as there are columns.
    pub fn row(&mut self, cells: Vec<Value>) {
        self.rows.push(cells);
    }

    /// An array of objects, one per row.
    pub fn json(&self) -> Value {
        let object = |row: &Vec<Value>| {
            let pairs = self.columns.iter().zip(row);
            Value::Object(
                pairs
                    .map(|(c, v)| (c.to_string(), v.clone()))
                    .collect::<Map<_, _>>(),
            )
        };
        Value::Array(self.rows.iter().map(object).collect())
    }

    /// Prints as JSON or as aligned columns.
    pub fn print(&self, json: bool) {
        match json {
            true => println!("{:#}", self.json()),
            false => print!("{}", self.text()),
        }
    }

    pub fn text(&self) -> String {
        let headings: Vec<String> = self.columns.iter().map(|c| c.to_string()).collect();
        let mut lines = vec![headings];
        lines.extend(self.rows.iter().map(|row| row.iter().map(cell).collect()));
        let width = |k: usize| {
            lines
                .iter()
                .map(|l| l[k].chars().count())
                .max()
                .unwrap_or(0)
        };
        let widths: Vec<usize> = (0..self.columns.len()).map(width).collect();
        lines.iter().map(|line| aligned(line, &widths)).collect()
    }
}

fn aligned(line: &[String], widths: &[usize]) -> String {
    let cells: Vec<String> = line
        .iter()
        .zip(widths)
        .map(|(c, w)| format!("{c:<w$}"))
        .collect();
    format!("{}\n", cells.join("  ").trim_end())
}

fn cell(value: &Value) -> String {
    match value {
        Value::String(s) => s.clone(),
        Value::Null => String::new(),
        other => other.to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_aligned_and_json_names_them() {
        let mut table = Table::new(&["law", "terms"]);
        table.row(vec!["pmb".into(), 3.into()]);
        table.row(vec!["lps_frozen".into(), Value::Null]);
        assert_eq!(
            table.text(),
            "law         terms\npmb         3\nlps_frozen\n"
        );
        assert_eq!(table.json()[0]["terms"], 3);
    }
}
