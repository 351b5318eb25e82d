//! Writer of the table of results, a Parquet file with one row for each case.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use parquet::basic::{Compression, LogicalType, Repetition, Type as PhysicalType};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType, Int64Type};
use parquet::errors::ParquetError;
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::{Type, TypePtr};

use super::checksum::{GROUPS, Summed, WHOLE, ZEROS};
use super::row::Row;

/// Number of rows in a row group. A row group is held in memory until it is written.
const GROUP: usize = 8192;

/// Names of a table's columns, and the constants written with them.
#[derive(Clone, PartialEq, Debug)]
pub struct Layout {
    /// Names of the varied parameters.
    pub inputs: Vec<String>,
    /// Names of the recorded outputs.
    pub outputs: Vec<String>,
    /// Version of the program, for the column `admire`.
    pub version: String,
    /// SHA-256 of all inputs, for the column `inputs_sha256`.
    pub hash: String,
    /// Further metadata of the file.
    pub facts: Vec<(String, String)>,
}

/// Columns other than inputs and outputs. `case` is the first column of the table, the others are the last.
pub(crate) const OTHER_COLUMNS: [&str; 6] = [
    "case",
    "status",
    "reason",
    "seconds",
    "admire",
    "inputs_sha256",
];

/// Writer of rows in case order. The file gets its final name only when [`finish`](Self::finish) succeeds.
pub(crate) struct TableWriter {
    path: PathBuf,
    temporary: PathBuf,
    writer: SerializedFileWriter<Summed>,
    /// Checksums of the row groups written so far.
    sums: Vec<String>,
    layout: Layout,
    rows: Vec<(Row, Vec<f64>)>,
}

impl TableWriter {
    /// Creates a file under a temporary name.
    ///
    /// # Errors
    /// When the file cannot be created.
    pub(crate) fn create(path: &Path, layout: Layout) -> Result<Self, ParquetError> {
        let mut temporary = path.as_os_str().to_owned();
        temporary.push(".tmp");
        let temporary = PathBuf::from(temporary);
        let facts: Vec<KeyValue> = layout
            .facts
            .iter()
            .map(|(key, value)| KeyValue::new(key.clone(), value.clone()))
            .collect();
        let properties = WriterProperties::builder()
            .set_compression(Compression::SNAPPY)
            .set_created_by(format!("admire {}", layout.version))
            .set_key_value_metadata(Some(facts))
            .build();
        let mut options = File::options();
        options.read(true).write(true).create(true).truncate(true);
        let file = Summed::new(options.open(&temporary)?);
        let writer = SerializedFileWriter::new(file, schema(&layout)?, Arc::new(properties))?;
        Ok(Self {
            path: path.to_path_buf(),
            temporary,
            writer,
            sums: Vec::new(),
            layout,
            rows: Vec::new(),
        })
    }

    /// Adds the row of a case with its input values.
    ///
    /// # Errors
    /// When a row group cannot be written.
    pub(crate) fn add(&mut self, row: Row, inputs: Vec<f64>) -> Result<(), ParquetError> {
        self.rows.push((row, inputs));
        if self.rows.len() == GROUP {
            self.write_group()?;
        }
        Ok(())
    }

    fn write_group(&mut self) -> Result<(), ParquetError> {
        let rows = std::mem::take(&mut self.rows);
        let mut group = self.writer.next_row_group()?;
        let cases: Vec<i64> = rows.iter().map(|(row, _)| row.case as i64).collect();
        let mut column = next(&mut group)?;
        column
            .typed::<Int64Type>()
            .write_batch(&cases, None, None)?;
        column.close()?;
        for k in 0..self.layout.inputs.len() {
            let values: Vec<f64> = rows.iter().map(|(_, inputs)| inputs[k]).collect();
            doubles(&mut group, &values, None)?;
        }
        for k in 0..self.layout.outputs.len() {
            let value = |row: &Row| row.outputs.get(k).copied().filter(|v| v.is_finite());
            let there: Vec<i16> = rows
                .iter()
                .map(|(row, _)| i16::from(value(row).is_some()))
                .collect();
            let values: Vec<f64> = rows.iter().filter_map(|(row, _)| value(row)).collect();
            doubles(&mut group, &values, Some(&there))?;
        }
        let statuses = rows.iter().map(|(row, _)| row.status.word());
        texts(&mut group, statuses, None)?;
        let there: Vec<i16> = rows
            .iter()
            .map(|(row, _)| i16::from(!row.reason.is_empty()))
            .collect();
        let reasons = rows.iter().map(|(row, _)| row.reason.as_str());
        texts(
            &mut group,
            reasons.filter(|text| !text.is_empty()),
            Some(&there),
        )?;
        let seconds: Vec<f64> = rows.iter().map(|(row, _)| row.seconds).collect();
        doubles(&mut group, &seconds, None)?;
        for text in [&self.layout.version, &self.layout.hash] {
            texts(&mut group, rows.iter().map(|_| text.as_str()), None)?;
        }
        group.close()?;
        self.writer.flush()?;
        self.sums.push(self.writer.inner_mut().group());
        // The buffer of a row group is reused for the next row group.
        self.rows = rows;
        self.rows.clear();
        Ok(())
    }

    /// Completes the file and moves it to its final name.
    ///
    /// # Errors
    /// When the file cannot be written or renamed.
    pub(crate) fn finish(mut self) -> Result<(), ParquetError> {
        if !self.rows.is_empty() {
            self.write_group()?;
        }
        for (key, value) in [(GROUPS, self.sums.join(" ")), (WHOLE, ZEROS.to_string())] {
            self.writer
                .append_key_value_metadata(KeyValue::new(key.to_string(), value));
        }
        self.writer.into_inner()?.finish()?;
        std::fs::rename(&self.temporary, &self.path)?;
        Ok(())
    }
}

type Group<'g> = SerializedRowGroupWriter<'g, Summed>;

fn next<'c>(
    group: &'c mut Group<'_>,
) -> Result<parquet::file::writer::SerializedColumnWriter<'c>, ParquetError> {
    group
        .next_column()?
        .ok_or_else(|| ParquetError::General("one column too many".to_string()))
}

fn doubles(
    group: &mut Group<'_>,
    values: &[f64],
    there: Option<&[i16]>,
) -> Result<(), ParquetError> {
    let mut column = next(group)?;
    column
        .typed::<DoubleType>()
        .write_batch(values, there, None)?;
    column.close()
}

fn texts<'t>(
    group: &mut Group<'_>,
    texts: impl Iterator<Item = &'t str>,
    there: Option<&[i16]>,
) -> Result<(), ParquetError> {
    let values: Vec<ByteArray> = texts.map(ByteArray::from).collect();
    let mut column = next(group)?;
    column
        .typed::<ByteArrayType>()
        .write_batch(&values, there, None)?;
    column.close()
}

fn schema(layout: &Layout) -> Result<TypePtr, ParquetError> {
    let field = |name: &str, kind: PhysicalType, repetition: Repetition| {
        let text = (kind == PhysicalType::BYTE_ARRAY).then_some(LogicalType::String);
        let built = Type::primitive_type_builder(name, kind)
            .with_repetition(repetition)
            .with_logical_type(text)
            .build();
        built.map(Arc::new)
    };
    let (given, maybe) = (Repetition::REQUIRED, Repetition::OPTIONAL);
    let (number, text) = (PhysicalType::DOUBLE, PhysicalType::BYTE_ARRAY);
    let mut fields = vec![field("case", PhysicalType::INT64, given)?];
    for name in &layout.inputs {
        fields.push(field(name, number, given)?);
    }
    for name in &layout.outputs {
        fields.push(field(name, number, maybe)?);
    }
    fields.push(field("status", text, given)?);
    fields.push(field("reason", text, maybe)?);
    fields.push(field("seconds", number, given)?);
    fields.push(field("admire", text, given)?);
    fields.push(field("inputs_sha256", text, given)?);
    let root = Type::group_type_builder("sweep")
        .with_fields(fields)
        .build()?;
    Ok(Arc::new(root))
}
