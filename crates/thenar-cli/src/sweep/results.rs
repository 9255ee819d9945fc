//! Records of a shard as one Parquet table.

use super::cell::{ColumnKind, count, number, truth, word};
use super::manifest::Manifest;
use super::plan::Plan;
use super::record::{Record, Row};
use super::{Shard, ShardFiles};
use crate::error::CliError;
use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{BoolType, ByteArray, ByteArrayType, DataType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;
use std::collections::HashMap;
use std::sync::Arc;
use thenar_scene::session::Figure;

/// Name of the manifest in the file's metadata.
const METADATA: &str = "thenar.sweep";

/// A column, a cell for each row.
enum Cells {
    Truth(Vec<Option<bool>>),
    Count(Vec<Option<i64>>),
    Number(Vec<Option<f64>>),
    Word(Vec<Option<ByteArray>>),
}

struct Column {
    name: String,
    unit: String,
    cells: Cells,
}

/// Writes the table of a shard, then its figures; its columns begin with those of this row.
///
/// # Errors
/// A record is missing, or a file cannot be written.
pub fn write(
    plan: &Plan,
    place: &ShardFiles,
    shard: Shard,
    manifest: &Manifest,
    row: &Row,
) -> Result<(), CliError> {
    let read = |case| {
        Record::read(&place.cases, case)
            .ok_or_else(|| CliError::Other(format!("the record of case {case} is gone")))
    };
    let records = shard.cases(plan.cases).map(read).collect::<Result<Vec<_>, _>>()?;
    let columns = columns(plan, &records, row);
    let units: Vec<_> = columns.iter().map(|c| (c.name.clone(), c.unit.clone())).collect();
    let figures = manifest.of_shard(shard, &records, &units);
    let bytes = encode(&columns, manifest)
        .map_err(|e| CliError::Other(format!("cannot write {}: {e}", place.results.display())))?;
    // Whoever sees the table finds its figures too.
    thenar_output::write_whole(&place.figures, figures.as_bytes())?;
    Ok(thenar_output::write_whole(&place.results, &bytes)?)
}

/// Number of the case, its keys, why it failed, and its figures.
fn columns(plan: &Plan, records: &[Record], row: &Row) -> Vec<Column> {
    let column =
        |name: &str, unit: &str, cells| Column { name: name.into(), unit: unit.into(), cells };
    let cases = records.iter().map(|r| i64::try_from(r.case).ok()).collect();
    let mut columns = vec![column("case", "1", Cells::Count(cases))];
    for (i, (key, kind)) in plan.columns.iter().enumerate() {
        let values = records.iter().map(|record| plan.values(record.case)[i]);
        let cells = match kind {
            ColumnKind::Truth => Cells::Truth(values.map(truth).collect()),
            ColumnKind::Count => Cells::Count(values.map(count).collect()),
            ColumnKind::Number => Cells::Number(values.map(number).collect()),
            ColumnKind::Word => Cells::Word(values.map(|v| Some(text(&word(v)))).collect()),
        };
        columns.push(column(key, "", cells));
    }
    let reasons = records.iter().map(|record| record.failed.as_deref().map(text));
    columns.push(column("failed", "", Cells::Word(reasons.collect())));
    columns.extend(figures(records, row));
    columns
}

/// A column for each figure of this row and of any record, in the order in which they first come.
fn figures(records: &[Record], row: &Row) -> Vec<Column> {
    let mut columns: Vec<Column> = Vec::new();
    let mut known: HashMap<String, usize> = HashMap::new();
    let rows = records.len();
    let mut at = |columns: &mut Vec<Column>, name: &str, unit: &str, figure: &Figure| {
        let name = match unit {
            "" | "1" => name.to_string(),
            unit => format!("{name} [{unit}]"),
        };
        *known.entry(name.clone()).or_insert_with(|| {
            let cells = match figure {
                Figure::Number(_) => Cells::Number(vec![None; rows]),
                Figure::Count(_) => Cells::Count(vec![None; rows]),
                Figure::Word(_) => Cells::Word(vec![None; rows]),
            };
            columns.push(Column { name, unit: unit.into(), cells });
            columns.len() - 1
        })
    };
    for (name, unit, figure) in row {
        at(&mut columns, name, unit, figure);
    }
    for (row, record) in records.iter().enumerate() {
        for (name, unit, figure) in &record.row {
            let at = at(&mut columns, name, unit, figure);
            match (&mut columns[at].cells, figure) {
                (Cells::Number(cells), Figure::Number(x)) => cells[row] = Some(*x),
                (Cells::Count(cells), Figure::Count(n)) => cells[row] = i64::try_from(*n).ok(),
                (Cells::Word(cells), Figure::Word(word)) => cells[row] = Some(text(word)),
                _ => {}
            }
        }
    }
    columns
}

fn text(text: &str) -> ByteArray {
    ByteArray::from(text.as_bytes().to_vec())
}

fn encode(columns: &[Column], manifest: &Manifest) -> Result<Vec<u8>, ParquetError> {
    let fields = columns.iter().map(|c| c.field().map(Arc::new)).collect::<Result<_, _>>()?;
    let schema = Type::group_type_builder("sweep").with_fields(fields).build()?;
    let about = KeyValue::new(METADATA.to_string(), manifest.text());
    let properties = WriterProperties::builder()
        .set_created_by(format!("thenar {}", env!("CARGO_PKG_VERSION")))
        .set_key_value_metadata(Some(vec![about]))
        .build();
    let mut writer = SerializedFileWriter::new(Vec::new(), Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for column in columns {
        match &column.cells {
            Cells::Truth(cells) => put::<BoolType>(&mut group, cells)?,
            Cells::Count(cells) => put::<Int64Type>(&mut group, cells)?,
            Cells::Number(cells) => put::<DoubleType>(&mut group, cells)?,
            Cells::Word(cells) => put::<ByteArrayType>(&mut group, cells)?,
        }
    }
    group.close()?;
    writer.into_inner()
}

impl Column {
    fn field(&self) -> Result<Type, ParquetError> {
        let (physical, logical) = match &self.cells {
            Cells::Truth(_) => (Physical::BOOLEAN, None),
            Cells::Count(_) => (Physical::INT64, None),
            Cells::Number(_) => (Physical::DOUBLE, None),
            Cells::Word(_) => (Physical::BYTE_ARRAY, Some(LogicalType::String)),
        };
        Type::primitive_type_builder(&self.name, physical)
            .with_repetition(Repetition::OPTIONAL)
            .with_logical_type(logical)
            .build()
    }
}

/// Writes a column: its cells that are there, and 1 or 0 for each that is or is not.
fn put<T: DataType>(
    group: &mut SerializedRowGroupWriter<'_, Vec<u8>>,
    cells: &[Option<T::T>],
) -> Result<(), ParquetError> {
    let there: Vec<T::T> = cells.iter().flatten().cloned().collect();
    let levels: Vec<i16> = cells.iter().map(|cell| i16::from(cell.is_some())).collect();
    let column = group.next_column()?;
    let mut column = column.ok_or_else(|| ParquetError::General("a column too many".into()))?;
    column.typed::<T>().write_batch(&there, Some(&levels), None)?;
    column.close()
}
