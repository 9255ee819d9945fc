//! Probe tables as CSV or JSON lines.

use super::Column;
use serde_json::{Map, Value, json};
use std::io::{self, Write};

/// Version of the tables. 2: `contact` and `finger` give sums of sizes and mean pressure, `fingers`
/// the mean pressure; what version 1 gave is there under the same names.
const VERSION: u32 = 2;

/// Format of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TableFormat {
    /// A header `time [s],name [unit],…`, then one line per row.
    Csv,
    /// A line with the format's version and the units, then one object per row.
    JsonLines,
}

/// Writes a table row by row.
#[derive(Debug)]
pub struct TableWriter<W: Write> {
    out: W,
    format: TableFormat,
    keys: Vec<String>,
}

impl<W: Write> TableWriter<W> {
    /// Starts a table and writes its header.
    ///
    /// # Errors
    /// Writing fails.
    pub fn new(mut out: W, format: TableFormat, columns: &[Column]) -> io::Result<Self> {
        let keys: Vec<String> = columns.iter().map(|c| c.name.clone()).collect();
        match format {
            TableFormat::Csv => {
                write!(out, "time [s]")?;
                for column in columns {
                    write!(out, ",{} [{}]", column.name, column.unit)?;
                }
                writeln!(out)?;
            }
            TableFormat::JsonLines => {
                let mut units = Map::new();
                units.insert("time".into(), json!("s"));
                units.extend(columns.iter().map(|c| (c.name.clone(), json!(c.unit))));
                writeln!(out, "{}", json!({ "version": VERSION, "units": units }))?;
            }
        }
        Ok(Self { out, format, keys })
    }

    /// Writes a row. Numbers keep all their digits.
    ///
    /// # Errors
    /// Writing fails.
    pub fn row(&mut self, time: f64, values: &[f64]) -> io::Result<()> {
        match self.format {
            TableFormat::Csv => {
                write!(self.out, "{time}")?;
                for value in values {
                    write!(self.out, ",{value}")?;
                }
                writeln!(self.out)
            }
            TableFormat::JsonLines => {
                let mut row = Map::new();
                row.insert("time".into(), json!(time));
                let cells = self.keys.iter().zip(values);
                row.extend(cells.map(|(key, value)| (key.clone(), json!(value))));
                writeln!(self.out, "{}", Value::Object(row))
            }
        }
    }

    /// Ends the table.
    ///
    /// # Errors
    /// Writing fails.
    pub fn finish(mut self) -> io::Result<W> {
        self.out.flush()?;
        Ok(self.out)
    }
}
