//! A case that is whole, as a file.

use crate::error::CliError;
use serde_json::{Value, json};
use std::path::Path;
use thenar_scene::session::{Figure, NamedFigure};

/// Largest record \[bytes\].
const BYTES_MAX: u64 = 64 << 20;

/// Figures of a case: name, unit, cell.
pub type Row = Vec<(String, String, Figure)>;

/// Outcome of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    pub case: u64,
    /// Why it failed, if it did.
    pub failed: Option<String>,
    /// Empty where the case could not be built.
    pub row: Row,
}

impl Record {
    /// Record of a case that came to its end.
    pub fn new(case: u64, failed: Option<String>, row: Vec<NamedFigure>) -> Self {
        let row = row.into_iter().map(|f| (f.name, f.unit.into(), f.value)).collect();
        Self { case, failed, row }
    }

    /// Path of a case's record.
    pub fn file(folder: &Path, case: u64) -> std::path::PathBuf {
        folder.join(format!("{case}.json"))
    }

    /// Writes it, whole or not at all.
    ///
    /// # Errors
    /// The disk is full, or the system refuses otherwise.
    pub fn write(&self, folder: &Path) -> Result<(), CliError> {
        // Numbers are text with all their digits: they come back with the same bits, finite or not.
        let cell = |(name, unit, figure): &(String, String, Figure)| match figure {
            Figure::Number(x) => json!([name, unit, "number", format!("{x:?}")]),
            Figure::Count(n) => json!([name, unit, "count", n.to_string()]),
            Figure::Word(word) => json!([name, unit, "word", word]),
        };
        let row: Vec<Value> = self.row.iter().map(cell).collect();
        let text = json!({ "case": self.case, "failed": self.failed, "row": row }).to_string();
        Ok(thenar_output::write_whole(&Self::file(folder, self.case), text.as_bytes())?)
    }

    /// Reads the record of a case; none where there is none, or one that is damaged.
    pub fn read(folder: &Path, case: u64) -> Option<Self> {
        let text = thenar_input::read_text(Self::file(folder, case), BYTES_MAX).ok()?;
        let value: Value = serde_json::from_str(&text).ok()?;
        if value.get("case")?.as_u64()? != case {
            return None;
        }
        let failed = match value.get("failed")? {
            Value::Null => None,
            reason => Some(reason.as_str()?.to_string()),
        };
        let row = value.get("row")?.as_array()?.iter().map(cell).collect::<Option<Vec<_>>>()?;
        Some(Self { case, failed, row })
    }
}

fn cell(cell: &Value) -> Option<(String, String, Figure)> {
    let [name, unit, kind, text] = cell.as_array()?.as_slice() else { return None };
    let text = text.as_str()?;
    let figure = match kind.as_str()? {
        "number" => Figure::Number(text.parse().ok()?),
        "count" => Figure::Count(text.parse().ok()?),
        "word" => Figure::Word(text.into()),
        _ => return None,
    };
    Some((name.as_str()?.into(), unit.as_str()?.into(), figure))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_comes_back_and_damage_is_no_record() {
        let folder = thenar_output::TemporaryFolder::new("thenar-record").unwrap();
        let numbers = [0.1, -0.0, 1e-310, 1.7e308, f64::INFINITY, 1.0 / 3.0];
        let named = |x: f64| ("x".to_string(), "N".to_string(), Figure::Number(x));
        let mut row: Vec<_> = numbers.map(named).into();
        row.push(("n".into(), "1".into(), Figure::Count(u64::MAX)));
        row.push(("h".into(), String::new(), Figure::Word("\"a\"\n".into())));
        let record = Record { case: 3, failed: Some("it\nburst".into()), row };
        record.write(folder.path()).unwrap();
        let read = Record::read(folder.path(), 3).unwrap();
        assert_eq!(read, record);
        let bits = |r: &Record| -> Vec<u64> {
            let bits = |(_, _, f): &(String, String, Figure)| match f {
                Figure::Number(x) => x.to_bits(),
                _ => 0,
            };
            r.row.iter().map(bits).collect()
        };
        assert_eq!(bits(&read), bits(&record));

        let file = Record::file(folder.path(), 3);
        let text = std::fs::read_to_string(&file).unwrap();
        for cut in [0, 1, text.len() / 2, text.len() - 1] {
            std::fs::write(&file, &text[..cut]).unwrap();
            assert_eq!(Record::read(folder.path(), 3), None, "{cut}");
        }
        std::fs::write(Record::file(folder.path(), 4), &text).unwrap();
        assert_eq!(Record::read(folder.path(), 4), None, "another case's record");
    }
}
