//! Reader of the table of a sweep, column by column.

use std::fs::File;
use std::path::Path;

use parquet::column::reader::ColumnReader;
use parquet::data_type::ByteArray;
use parquet::errors::ParquetError;
use parquet::file::reader::{FileReader, SerializedFileReader};

use super::row::{Row, Status};

/// Parquet file written by a sweep.
pub struct TableReader {
    reader: SerializedFileReader<File>,
}

impl TableReader {
    /// Opens a table.
    ///
    /// # Errors
    /// When the file cannot be read or is not a Parquet file.
    pub fn open(path: &Path) -> Result<Self, ParquetError> {
        Ok(Self {
            reader: SerializedFileReader::new(File::open(path)?)?,
        })
    }

    /// Returns the names of the table's columns.
    pub(crate) fn columns(&self) -> Vec<String> {
        let schema = self.reader.metadata().file_metadata().schema_descr();
        schema
            .columns()
            .iter()
            .map(|c| c.name().to_string())
            .collect()
    }

    /// Returns the number of rows.
    pub(crate) fn rows(&self) -> u64 {
        self.reader.metadata().file_metadata().num_rows() as u64
    }

    /// Returns the file's metadata value for a key.
    pub fn fact(&self, key: &str) -> Option<&str> {
        let all = self
            .reader
            .metadata()
            .file_metadata()
            .key_value_metadata()?;
        all.iter().find(|fact| fact.key == key)?.value.as_deref()
    }

    /// Returns all values of the column with index `column`; NaN for a missing value.
    ///
    /// # Errors
    /// When the file cannot be read or the column is not numeric.
    pub(crate) fn numbers(&self, column: usize) -> Result<Vec<f64>, ParquetError> {
        let mut all = Vec::with_capacity(self.rows() as usize);
        for group in 0..self.reader.num_row_groups() {
            self.group_numbers(group, column, &mut all)?;
        }
        Ok(all)
    }

    /// Passes all texts of a column to `take`, one row group at a time; a missing text is empty.
    ///
    /// # Errors
    /// When the file cannot be read or the column contains no texts.
    pub(crate) fn texts(
        &self,
        column: usize,
        mut take: impl FnMut(&str),
    ) -> Result<(), ParquetError> {
        for group in 0..self.reader.num_row_groups() {
            let mut texts = Vec::new();
            self.group_texts(group, column, &mut texts)?;
            for text in &texts {
                take(text);
            }
        }
        Ok(())
    }

    /// Passes every row to `take`, with the input values of its case. The first `inputs` columns after `case` are inputs.
    ///
    /// # Errors
    /// When the file cannot be read, or when `take` returns an error.
    pub fn each<E: From<ParquetError>>(
        &self,
        inputs: usize,
        outputs: usize,
        mut take: impl FnMut(Row, Vec<f64>) -> Result<(), E>,
    ) -> Result<(), E> {
        for group in 0..self.reader.num_row_groups() {
            let numbers = |column: usize| {
                let mut all = Vec::new();
                self.group_numbers(group, column, &mut all).map(|()| all)
            };
            let texts = |column: usize| {
                let mut all = Vec::new();
                self.group_texts(group, column, &mut all).map(|()| all)
            };
            let cases = numbers(0)?;
            let values = (1..=inputs + outputs)
                .map(numbers)
                .collect::<Result<Vec<_>, _>>()?;
            let behind = 1 + inputs + outputs;
            let (statuses, reasons) = (texts(behind)?, texts(behind + 1)?);
            let seconds = numbers(behind + 2)?;
            for (k, case) in cases.iter().enumerate() {
                let status = Status::of_word(&statuses[k]).ok_or_else(|| {
                    ParquetError::General(format!(
                        "the table has the unknown status `{}`",
                        statuses[k]
                    ))
                })?;
                let row = Row {
                    case: *case as u64,
                    status,
                    reason: reasons[k].clone(),
                    seconds: seconds[k],
                    outputs: values[inputs..].iter().map(|column| column[k]).collect(),
                };
                take(
                    row,
                    values[..inputs].iter().map(|column| column[k]).collect(),
                )?;
            }
        }
        Ok(())
    }

    fn group_numbers(
        &self,
        group: usize,
        column: usize,
        all: &mut Vec<f64>,
    ) -> Result<(), ParquetError> {
        let group = self.reader.get_row_group(group)?;
        let rows = group.metadata().num_rows() as usize;
        match group.get_column_reader(column)? {
            ColumnReader::DoubleColumnReader(mut reader) => {
                let (mut values, mut levels) = (Vec::new(), Vec::new());
                reader.read_records(rows, Some(&mut levels), None, &mut values)?;
                spread(&levels, values, f64::NAN, all);
            }
            ColumnReader::Int64ColumnReader(mut reader) => {
                let mut values = Vec::new();
                reader.read_records(rows, None, None, &mut values)?;
                all.extend(values.into_iter().map(|value| value as f64));
            }
            _ => {
                return Err(ParquetError::General(
                    "a column does not contain numbers".to_string(),
                ));
            }
        }
        Ok(())
    }

    fn group_texts(
        &self,
        group: usize,
        column: usize,
        all: &mut Vec<String>,
    ) -> Result<(), ParquetError> {
        let group = self.reader.get_row_group(group)?;
        let rows = group.metadata().num_rows() as usize;
        let ColumnReader::ByteArrayColumnReader(mut reader) = group.get_column_reader(column)?
        else {
            return Err(ParquetError::General(
                "a column does not contain strings".to_string(),
            ));
        };
        let (mut values, mut levels): (Vec<ByteArray>, _) = (Vec::new(), Vec::new());
        reader.read_records(rows, Some(&mut levels), None, &mut values)?;
        let texts = values
            .iter()
            .map(|value| value.as_utf8().map(str::to_string))
            .collect::<Result<Vec<_>, _>>()?;
        spread(&levels, texts, String::new(), all);
        Ok(())
    }
}

/// Appends one element per definition level to `all`: the next value where the level is not 0, and `none` where it is 0.
fn spread<T: Clone>(levels: &[i16], values: Vec<T>, none: T, all: &mut Vec<T>) {
    if levels.is_empty() {
        all.extend(values);
        return;
    }
    let mut values = values.into_iter();
    all.extend(levels.iter().map(|level| match level {
        0 => none.clone(),
        _ => values.next().unwrap_or_else(|| none.clone()),
    }));
}

#[cfg(test)]
mod tests {
    use super::super::table_writer::{Layout, TableWriter};
    use super::*;

    #[test]
    fn what_is_written_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.parquet");
        let layout = Layout {
            inputs: vec!["BUSHING/1.K.1".to_string(), "b".to_string()],
            outputs: vec!["arm.X".to_string()],
            version: "1".to_string(),
            hash: "abc".to_string(),
            facts: vec![("admire.shard".to_string(), "1/1".to_string())],
        };
        let count = 20_000;
        let row = |case: u64| Row {
            case,
            status: if case.is_multiple_of(7) {
                Status::NoAnswer
            } else {
                Status::Ok
            },
            reason: if case.is_multiple_of(7) {
                "no".to_string()
            } else {
                String::new()
            },
            seconds: 0.5,
            outputs: if case.is_multiple_of(7) {
                Vec::new()
            } else {
                vec![case as f64 / 3.0]
            },
        };
        let mut writer = TableWriter::create(&path, layout).unwrap();
        for case in 0..count {
            assert!(!path.exists());
            writer.add(row(case), vec![case as f64, -0.0]).unwrap();
        }
        writer.finish().unwrap();
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let reader = TableReader::open(&path).unwrap();
        assert_eq!(
            (reader.rows(), reader.fact("admire.shard")),
            (count, Some("1/1"))
        );
        assert_eq!(
            reader.columns(),
            [
                "case",
                "BUSHING/1.K.1",
                "b",
                "arm.X",
                "status",
                "reason",
                "seconds",
                "admire",
                "inputs_sha256"
            ]
        );
        let mut next = 0;
        reader
            .each(2, 1, |found, inputs| -> Result<(), ParquetError> {
                let expected = row(next);
                assert_eq!(
                    (found.case, found.status, &found.reason),
                    (next, expected.status, &expected.reason)
                );
                let value = expected.outputs.first().copied().unwrap_or(f64::NAN);
                assert_eq!(found.outputs[0].to_bits(), value.to_bits());
                assert_eq!(inputs[0].to_bits(), (next as f64).to_bits());
                assert_eq!(inputs[1].to_bits(), (-0.0_f64).to_bits());
                next += 1;
                Ok(())
            })
            .unwrap();
        assert_eq!(next, count);
    }
}
