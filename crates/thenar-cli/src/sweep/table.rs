//! Cases from a CSV file (RFC 4180): the first line names keys, each other one is a case.

use super::axis::tidy;
use crate::error::CliError;
use std::path::Path;
use thenar_input::{quoted, read_text};

/// A file is read up to this size \[bytes\]: a million cases of a few keys.
const BYTES_MAX: u64 = 256 << 20;

/// Keys and cases.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Table {
    pub keys: Vec<String>,
    /// Rows with as many values as there are keys.
    pub rows: Vec<Vec<String>>,
}

/// Reads a file.
///
/// # Errors
/// The file cannot be read, or is no table of cases.
pub fn read(file: &Path) -> Result<Table, CliError> {
    let wrong = |what: String| CliError::Input(format!("{}{what}", file.display()));
    let text = read_text(file, BYTES_MAX).map_err(|e| wrong(format!(": {e}")))?;
    thenar_output::protect(file);
    parse(&text).map_err(|(line, what)| wrong(format!(":{line}: {what}")))
}

/// Line and what is wrong in it.
type LineError = (usize, String);

fn parse(text: &str) -> Result<Table, LineError> {
    let mut records = records(text.trim_start_matches('\u{feff}'))?.into_iter();
    let Some((line, keys)) = records.next() else {
        return Err((1, "the table is empty; its first line names keys".into()));
    };
    let keys: Vec<String> = keys.iter().map(|key| tidy(key)).collect();
    if let Some(column) = keys.iter().position(String::is_empty) {
        return Err((line, format!("column {} has no key", column + 1)));
    }
    let mut rows = Vec::new();
    for (line, row) in records {
        if row.len() != keys.len() {
            return Err((line, format!("{} values for {} keys", row.len(), keys.len())));
        }
        let row: Vec<String> = row.iter().map(|value| value.trim().to_string()).collect();
        if let Some(column) = row.iter().position(String::is_empty) {
            return Err((line, format!("{} has no value", quoted(&keys[column]))));
        }
        rows.push(row);
    }
    match rows.is_empty() {
        true => Err((line, "the table has no cases".into())),
        false => Ok(Table { keys, rows }),
    }
}

/// Splits into records and fields; lines that are empty are left out. Numbers are of each record's
/// first line.
fn records(text: &str) -> Result<Vec<(usize, Vec<String>)>, LineError> {
    let mut records = Vec::new();
    let (mut line, mut first) = (1, 1);
    let (mut fields, mut field) = (Vec::new(), String::new());
    let mut quoted = false;
    let mut chars = text.chars().peekable();
    while let Some(c) = chars.next() {
        line += usize::from(c == '\n');
        match c {
            '"' if quoted && chars.next_if_eq(&'"').is_some() => field.push('"'),
            '"' if quoted => quoted = false,
            _ if quoted => field.push(c),
            '"' if field.trim().is_empty() => {
                field.clear();
                quoted = true;
            }
            ',' => fields.push(std::mem::take(&mut field)),
            '\r' if chars.peek() == Some(&'\n') => {}
            '\n' => {
                end(&mut records, first, &mut fields, &mut field);
                first = line;
            }
            _ => field.push(c),
        }
    }
    if quoted {
        return Err((first, "a quote does not end".into()));
    }
    end(&mut records, first, &mut fields, &mut field);
    Ok(records)
}

fn end(
    records: &mut Vec<(usize, Vec<String>)>,
    first: usize,
    fields: &mut Vec<String>,
    field: &mut String,
) {
    let last = std::mem::take(field);
    if !fields.is_empty() || !last.trim().is_empty() {
        fields.push(last);
        records.push((first, std::mem::take(fields)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_quotes_and_line_ends() {
        let table = parse("a.b, c\r\n1,\"[1, 2]\"\n\n 2 ,\"x \"\"y\"\"\nz\"").unwrap();
        assert_eq!(table.keys, ["a.b", "c"]);
        assert_eq!(table.rows, [["1", "[1, 2]"], ["2", "x \"y\"\nz"]]);
    }

    #[test]
    fn what_is_no_table_is_refused_with_its_line() {
        for (text, line, told) in [
            ("", 1, "empty"),
            ("a\n", 1, "no cases"),
            ("a,\n1,2", 1, "column 2 has no key"),
            ("a,b\n1,2\n\n3", 4, "1 values for 2 keys"),
            ("a,b\n1,", 2, "\"b\" has no value"),
            ("a\n\"1", 2, "a quote does not end"),
        ] {
            let (at, what) = parse(text).unwrap_err();
            assert!(at == line && what.contains(told), "{text:?}: {at} {what}");
        }
    }
}
