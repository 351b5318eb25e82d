//! Checksums of tables: one for each row group, which locates damage, and one for the whole file, which detects damage anywhere.
//!
//! The checksums are SHA-256 sums in the metadata of the file. The checksum of the whole file is computed with zeros in the place where it
//! is written.

use std::fs::File;
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::Path;

use parquet::errors::ParquetError;
use parquet::file::metadata::RowGroupMetaData;
use parquet::file::reader::{FileReader, SerializedFileReader};
use sha2::{Digest, Sha256};

use super::folder::hexadecimal;
use admire_syntax::text::open_to_read;

/// Metadata key of the row-group checksums, which are separated by spaces. The bytes of a row group extend from the end of the previous
/// group to its own end.
pub(super) const GROUPS: &str = "admire.row_groups_sha256";

/// Metadata key of the checksum of the whole file.
pub(super) const WHOLE: &str = "admire.file_sha256";

/// Placeholder for the checksum of the whole file while it is computed.
pub(super) const ZEROS: &str = "0000000000000000000000000000000000000000000000000000000000000000";

/// Reason why a table is not intact.
#[derive(Debug, thiserror::Error)]
pub enum Damage {
    /// The table cannot be read.
    #[error("{0}")]
    Unreadable(#[from] ParquetError),
    /// The bytes of the table have changed.
    #[error("the file is damaged: {0}")]
    Changed(String),
}

impl From<io::Error> for Damage {
    fn from(error: io::Error) -> Self {
        Self::Unreadable(error.into())
    }
}

/// File that computes the checksum of everything written to it.
pub(super) struct Summed {
    file: File,
    whole: Sha256,
    group: Sha256,
}

impl Summed {
    pub(super) fn new(file: File) -> Self {
        Self {
            file,
            whole: Sha256::new(),
            group: Sha256::new(),
        }
    }

    /// Returns the checksum of the bytes written since the last call of this function.
    pub(super) fn group(&mut self) -> String {
        hexadecimal(&std::mem::take(&mut self.group).finalize())
    }

    /// Writes the checksum of the whole file into its place, and syncs the file to disk.
    ///
    /// # Errors
    /// When the file cannot be read or written, or when its metadata have no place for the checksum.
    pub(super) fn finish(mut self) -> io::Result<()> {
        let place = place_of_whole(&mut self.file)?
            .ok_or_else(|| io::Error::other("the file has no place for its checksum"))?;
        let sum = hexadecimal(&self.whole.finalize());
        self.file.seek(SeekFrom::Start(place))?;
        self.file.write_all(sum.as_bytes())?;
        self.file.sync_all()
    }
}

impl Write for Summed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let count = self.file.write(bytes)?;
        self.whole.update(&bytes[..count]);
        self.group.update(&bytes[..count]);
        Ok(count)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

/// Verifies the checksums of a table.
///
/// # Errors
/// [`Damage`]: the table is unreadable, or has changed row groups, which are named.
pub(crate) fn verify(path: &Path) -> Result<(), Damage> {
    let mut file = open_to_read(path)?;
    let Some(place) = place_of_whole(&mut file)? else {
        return Err(Damage::Changed("it has no checksum".to_string()));
    };
    let length = file.metadata()?.len();
    let mut stated = vec![0; ZEROS.len()];
    file.seek(SeekFrom::Start(place))?;
    file.read_exact(&mut stated)?;
    let mut sum = Sha256::new();
    add(&mut file, 0..place, &mut sum)?;
    sum.update(ZEROS);
    add(&mut file, place + ZEROS.len() as u64..length, &mut sum)?;
    if hexadecimal(&sum.finalize()).as_bytes() == stated {
        return Ok(());
    }
    Err(Damage::Changed(changed(path, &mut file)?))
}

/// Describes the changed row groups of a table in a clause.
fn changed(path: &Path, file: &mut File) -> Result<String, Damage> {
    let reader = SerializedFileReader::new(open_to_read(path)?)?;
    let metadata = reader.metadata();
    let facts = metadata.file_metadata().key_value_metadata();
    let stated = facts.and_then(|facts| facts.iter().find(|fact| fact.key == GROUPS));
    let stated = stated.and_then(|fact| fact.value.as_deref()).unwrap_or("");
    let mut stated = stated.split(' ');
    let (mut from, mut row) = (0, 1_i64);
    let mut wrong = Vec::new();
    for (index, group) in metadata.row_groups().iter().enumerate() {
        let Some(to) = end_of(group) else {
            return Ok("its metadata has changed".to_string());
        };
        let mut sum = Sha256::new();
        let whole = to >= from && add(file, from..to, &mut sum).is_ok();
        if !whole || stated.next() != Some(&hexadecimal(&sum.finalize())) {
            let rows = row..row.saturating_add(group.num_rows());
            wrong.push(format!(
                "{} (rows {} to {})",
                index + 1,
                rows.start,
                rows.end.saturating_sub(1)
            ));
        }
        (from, row) = (to, row.saturating_add(group.num_rows()));
    }
    Ok(match wrong.len() {
        0 => "its metadata has changed".to_string(),
        1 => format!("row group {} has changed", wrong[0]),
        _ => format!("row groups {} have changed", wrong.join(", ")),
    })
}

/// Returns the byte offset at which the last column of a row group ends; `None` if its metadata are inconsistent.
fn end_of(group: &RowGroupMetaData) -> Option<u64> {
    let mut ends = group.columns().iter().map(|column| {
        let pages = column.data_page_offset();
        let start = column.dictionary_page_offset().unwrap_or(pages);
        let size = u64::try_from(column.compressed_size()).ok()?;
        u64::try_from(start).ok()?.checked_add(size)
    });
    ends.try_fold(0, |most: u64, end| Some(most.max(end?)))
}

/// Adds a range of bytes of a file to a checksum.
fn add(file: &mut File, bytes: std::ops::Range<u64>, sum: &mut Sha256) -> io::Result<()> {
    file.seek(SeekFrom::Start(bytes.start))?;
    let wanted = bytes.end - bytes.start;
    let mut left = file.take(wanted);
    let mut buffer = vec![0; 1 << 16];
    let mut got = 0;
    loop {
        let count = left.read(&mut buffer)?;
        if count == 0 {
            break;
        }
        got += count as u64;
        sum.update(&buffer[..count]);
    }
    if got == wanted {
        Ok(())
    } else {
        Err(io::ErrorKind::UnexpectedEof.into())
    }
}

/// Returns the byte offset of the whole-file checksum, which follows its key in the footer's metadata; `None` if the key is missing.
fn place_of_whole(file: &mut File) -> io::Result<Option<u64>> {
    // A Parquet file ends with its metadata, the length of the metadata in four bytes, and `PAR1`.
    const TAIL: u64 = 8;
    let length = file.metadata()?.len();
    let Some(end) = length.checked_sub(TAIL) else {
        return Ok(None);
    };
    file.seek(SeekFrom::Start(end))?;
    let mut size = [0; 4];
    file.read_exact(&mut size)?;
    let Some(start) = end.checked_sub(u64::from(u32::from_le_bytes(size))) else {
        return Ok(None);
    };
    file.seek(SeekFrom::Start(start))?;
    let mut metadata = vec![0; (end - start) as usize];
    file.read_exact(&mut metadata)?;
    // The checksum follows its key: one byte for the kind of the field, one byte for the length, then the text.
    let key = memchr::memmem::find(&metadata, WHOLE.as_bytes());
    let value = key.map(|key| key + WHOLE.len() + 2);
    let fits = |value: &usize| value + ZEROS.len() <= metadata.len();
    Ok(value.filter(fits).map(|value| start + value as u64))
}

#[cfg(test)]
mod tests {
    use super::super::row::{Row, Status};
    use super::super::table_writer::{Layout, TableWriter};
    use super::*;

    fn table(path: &Path, rows: u64) {
        let layout = Layout {
            inputs: vec!["BUSHING/1.K.1".to_string()],
            outputs: vec!["arm.X".to_string()],
            version: "1".to_string(),
            hash: "abc".to_string(),
            facts: vec![("admire.nominal".to_string(), "{\"arm.X\":12.5}".to_string())],
        };
        let mut writer = TableWriter::create(path, layout).unwrap();
        for case in 0..rows {
            let row = Row {
                case,
                status: Status::Ok,
                reason: String::new(),
                seconds: 0.5,
                outputs: vec![case as f64 / 3.0],
            };
            writer.add(row, vec![case as f64]).unwrap();
        }
        writer.finish().unwrap();
    }

    #[test]
    fn a_flipped_bit_of_any_byte_is_found() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.parquet");
        table(&path, 40);
        verify(&path).unwrap();
        let whole = std::fs::read(&path).unwrap();
        for at in 0..whole.len() {
            let mut bytes = whole.clone();
            // The flipped bit differs from byte to byte, so that all eight bits are tested in every part of the file.
            bytes[at] ^= 1 << (3 * at % 8);
            std::fs::write(&path, &bytes).unwrap();
            assert!(verify(&path).is_err(), "bit {} of byte {at}", 3 * at % 8);
        }
        for length in [0, 7, 100, whole.len() - 1] {
            std::fs::write(&path, &whole[..length]).unwrap();
            assert!(verify(&path).is_err(), "{length} bytes");
        }
    }

    #[test]
    fn the_row_group_that_has_changed_is_named() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.parquet");
        table(&path, 20_000);
        verify(&path).unwrap();
        let reader = SerializedFileReader::new(File::open(&path).unwrap()).unwrap();
        let second = reader.metadata().row_group(1).column(1).byte_range().0 as usize;
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[second + 40] ^= 4;
        std::fs::write(&path, &bytes).unwrap();
        let said = verify(&path).unwrap_err().to_string();
        assert!(
            said.contains("row group 2 (rows 8193 to 16384) has changed"),
            "{said}"
        );
        let at = memchr::memmem::rfind(&bytes, b"12.5").unwrap();
        bytes[second + 40] ^= 4;
        bytes[at] ^= 1;
        std::fs::write(&path, &bytes).unwrap();
        let said = verify(&path).unwrap_err().to_string();
        assert!(said.contains("its metadata has changed"), "{said}");
    }
}
