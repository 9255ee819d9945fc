//! Measurements of a press, from a table of depth, force and perhaps time.

use crate::error::CliError;
use std::path::Path;
use thenar_input::{quoted, read_text};

/// A file is read up to this size \[bytes\].
const BYTES_MAX: u64 = 16 << 20;
/// Deeper than any pad, by far \[m\]: whoever writes more has another unit.
const DEPTH_MAX: f64 = 0.05;
/// More than any finger presses \[N\].
const FORCE_MAX: f64 = 1000.0;
/// The longest press \[s\].
const TIME_MAX: f64 = 3600.0;

/// Depths and forces of a press, as they were measured.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PressData {
    /// Depth from first touch \[m\].
    pub depth: Vec<f64>,
    /// Force \[N\].
    pub force: Vec<f64>,
    /// Time \[s\], rising; where the table has it.
    pub time: Option<Vec<f64>>,
}

/// A column that is read.
struct Quantity {
    name: &'static str,
    /// Units and what one of them is in SI.
    units: &'static [(&'static str, f64)],
    /// Smallest and largest value in SI.
    range: [f64; 2],
}

const DEPTH: Quantity = Quantity {
    name: "depth",
    units: &[("m", 1.0), ("mm", 1e-3), ("um", 1e-6), ("µm", 1e-6)],
    range: [-DEPTH_MAX, DEPTH_MAX],
};
const FORCE: Quantity =
    Quantity { name: "force", units: &[("N", 1.0), ("mN", 1e-3)], range: [-FORCE_MAX, FORCE_MAX] };
const TIME: Quantity =
    Quantity { name: "time", units: &[("s", 1.0), ("ms", 1e-3)], range: [-TIME_MAX, TIME_MAX] };

/// Place of a quantity's column, and its unit in SI.
struct Column {
    at: usize,
    unit: f64,
    of: &'static Quantity,
}

/// Reads a file.
///
/// # Errors
/// The file cannot be read; otherwise as [`parse`].
pub fn read(file: &Path) -> Result<PressData, CliError> {
    let text = read_text(file, BYTES_MAX)
        .map_err(|e| CliError::Input(format!("{}: {e}", file.display())))?;
    parse(&text).map_err(|e| CliError::Input(format!("{}:{e}", file.display())))
}

/// Reads a table: a header such as `depth [mm],force [N],time [s]`, in any order and beside other
/// columns, which are passed over; commas, semicolons or tabs between; lines that begin with `#`
/// say nothing.
///
/// # Errors
/// `line: reason`.
pub fn parse(text: &str) -> Result<PressData, String> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    let mut lines = (1..).zip(text.lines()).filter(|(_, line)| {
        let line = line.trim();
        !line.is_empty() && !line.starts_with('#')
    });
    let Some((line, header)) = lines.next() else { return Err("1: the table is empty".into()) };
    let between = [',', ';', '\t'].into_iter().find(|c| header.contains(*c)).unwrap_or(',');
    let at_header = |e: String| format!("{line}: {e}");
    let names: Vec<&str> = header.split(between).map(unquoted).collect();
    let find = |of| column(&names, of).map_err(at_header);
    let needed = |of: &'static Quantity| {
        let missing = || {
            let names = quoted(header.trim());
            format!("{line}: no column `{} [{}]`; the header is {names}", of.name, of.units[0].0)
        };
        find(of)?.ok_or_else(missing)
    };
    let (depth, force, time) = (needed(&DEPTH)?, needed(&FORCE)?, find(&TIME)?);
    let mut out = PressData { time: time.as_ref().map(|_| Vec::new()), ..PressData::default() };
    for (line, text) in lines {
        let cells: Vec<&str> = text.split(between).map(unquoted).collect();
        if cells.len() != names.len() {
            let (found, wanted) = (cells.len(), names.len());
            return Err(format!("{line}: {found} values, but the header names {wanted} columns"));
        }
        let value = |c: &Column| number(cells[c.at], c).map_err(|e| format!("{line}: {e}"));
        out.depth.push(value(&depth)?);
        out.force.push(value(&force)?);
        if let (Some(column), Some(times)) = (&time, &mut out.time) {
            let t = value(column)?;
            if let Some(before) = times.last().filter(|before| t <= **before) {
                return Err(format!(
                    "{line}: `time` must rise from row to row, got {t} s after {before} s"
                ));
            }
            times.push(t);
        }
    }
    Ok(out)
}

fn unquoted(cell: &str) -> &str {
    let cell = cell.trim();
    cell.strip_prefix('"').and_then(|c| c.strip_suffix('"')).unwrap_or(cell).trim()
}

/// The column of a quantity, if the header has one.
fn column(names: &[&str], of: &'static Quantity) -> Result<Option<Column>, String> {
    let word = |name: &str| name.split('[').next().unwrap_or_default().trim().to_ascii_lowercase();
    let mut places = (0..names.len()).filter(|&i| word(names[i]) == of.name);
    let Some(at) = places.next() else { return Ok(None) };
    if places.next().is_some() {
        return Err(format!("two columns are named `{}`", of.name));
    }
    let known: Vec<&str> = of.units.iter().map(|(unit, _)| *unit).collect();
    let known = known.join("`, `");
    let unit = names[at].split_once('[').and_then(|(_, rest)| rest.trim_end().strip_suffix(']'));
    let Some(unit) = unit.map(str::trim) else {
        let name = of.name;
        return Err(format!(
            "`{name}` has no unit; write `{name} [{}]`; units are `{known}`",
            of.units[0].0
        ));
    };
    match of.units.iter().find(|(known, _)| *known == unit) {
        Some((_, in_si)) => Ok(Some(Column { at, unit: *in_si, of })),
        None => {
            let unit = quoted(unit);
            Err(format!("the unit {unit} of `{}` is not known; units are `{known}`", of.name))
        }
    }
}

fn number(cell: &str, column: &Column) -> Result<f64, String> {
    let name = column.of.name;
    let value: f64 =
        cell.parse().map_err(|_| format!("`{name}` is {}, not a number", quoted(cell)))?;
    let ([low, high], value) = (column.of.range, value * column.unit);
    if !value.is_finite() {
        return Err(format!("`{name}` is {cell}, not a finite number"));
    }
    if !(low..=high).contains(&value) {
        let unit = column.of.units[0].0;
        return Err(format!(
            "`{name}` is {value} {unit}, not from {low} to {high}: is its unit right?"
        ));
    }
    Ok(value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_order_and_separators_are_the_table_s_own() {
        let want = PressData {
            depth: vec![0.0, 1e-3],
            force: vec![0.01, 0.5],
            time: Some(vec![0.0, 0.2]),
        };
        for text in [
            "depth [mm],force [N],time [s]\n0,0.01,0\n1,0.5,0.2\n",
            "# a finger\n\n\"Time [ms]\";\"Force [mN]\";note [1];\"Depth [um]\"\n0;10;x;0\n200;500;y;1000",
            "\u{feff}force [N]\tdepth [m]\ttime [s]\r\n0.01\t0\t0\r\n0.5\t1e-3\t0.2\r\n",
        ] {
            let got = parse(text).unwrap_or_else(|e| panic!("{text}: {e}"));
            let near = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-15);
            assert!(near(&got.depth, &want.depth) && near(&got.force, &want.force), "{got:?}");
            assert!(near(got.time.as_ref().unwrap(), want.time.as_ref().unwrap()), "{got:?}");
        }
        assert_eq!(parse("depth [mm],force [N]\n1,2").unwrap().time, None);
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (text, reason) in [
            ("", "1: the table is empty"),
            ("# nothing\n\n", "1: the table is empty"),
            ("depth [mm],time [s]\n0,0", "1: no column `force [N]`"),
            ("force [N]\n0", "1: no column `depth [m]`"),
            ("\ndepth,force [N]\n0,0", "2: `depth` has no unit; write `depth [m]`"),
            (
                "depth [inch],force [N]\n0,0",
                "1: the unit \"inch\" of `depth` is not known; units are `m`, `mm`",
            ),
            ("depth [mm],force [kg]\n0,0", "of `force` is not known"),
            ("depth [mm],force [N],depth [m]\n0,0,0", "1: two columns are named `depth`"),
            ("depth [mm],force [N]\n0,0\n1,NaN", "3: `force` is NaN, not a finite number"),
            ("depth [mm],force [N]\n0,0\ninf,1", "3: `depth` is inf, not a finite number"),
            ("depth [mm],force [N]\n0,0\n1", "3: 1 values, but the header names 2 columns"),
            ("depth [mm],force [N]\n0,0\n1,", "3: `force` is \"\", not a number"),
            ("depth [mm],force [N]\n0,0\n1,1 N", "3: `force` is \"1 N\", not a number"),
            (
                "depth [m],force [N]\n0,0\n1.5,1",
                "3: `depth` is 1.5 m, not from -0.05 to 0.05: is its unit right?",
            ),
            (
                "depth [m],force [N],time [s]\n0,0,0\n0,1,1\n0,1,1",
                "4: `time` must rise from row to row, got 1 s after 1 s",
            ),
        ] {
            let error = parse(text).unwrap_err();
            assert!(error.starts_with(reason) || error.contains(reason), "{text:?}: {error}");
        }
    }
}
