//! Journal of a shard. It holds every finished case in order of completion, so that a killed run loses no finished case.

use std::fs::{File, OpenOptions};
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use super::row::{Row, Status};

/// Interval after which written records are forced to disk.
const SYNC: Duration = Duration::from_secs(1);

/// First bytes of a journal.
const MAGIC: &[u8; 8] = b"ADMJRNL1";

/// Largest length of a record in bytes; a greater length is damage.
const LONGEST: u32 = 1 << 24;

/// Reason why a journal cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum JournalError {
    /// The journal cannot be read or written.
    #[error("`{}` cannot be read or written: {error}", path.display())]
    Io {
        /// Path of the journal.
        path: PathBuf,
        /// Error of the operating system.
        error: io::Error,
    },
    /// Another process uses the journal.
    #[error("another process is using `{}`", .0.display())]
    Locked(PathBuf),
    /// The file is not a journal, or belongs to another sweep.
    #[error("`{}` is not a journal of this sweep, written by this version of admire", .0.display())]
    Foreign(PathBuf),
}

/// Journal open for appending.
#[derive(Debug)]
pub(crate) struct Journal {
    path: PathBuf,
    file: BufWriter<File>,
    /// Case number and byte offset of every record, in order of completion.
    index: Vec<(u64, u64)>,
    end: u64,
    synced: Instant,
}

impl Journal {
    /// Opens the journal of a shard, or creates it. `key` identifies sweep, shard and version. A truncated record at the end, left by a
    /// killed run, is removed, and its case counts as unfinished.
    ///
    /// # Errors
    /// A [`JournalError`] if the journal cannot be used.
    pub(crate) fn open(path: &Path, key: &[u8]) -> Result<Self, JournalError> {
        let io = |error| JournalError::Io {
            path: path.to_path_buf(),
            error,
        };
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(io)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(std::fs::TryLockError::WouldBlock) => {
                return Err(JournalError::Locked(path.to_path_buf()));
            }
            // Some network file systems have no locks. The user must then ensure that no shard is run twice at the same time.
            Err(std::fs::TryLockError::Error(error))
                if error.kind() == io::ErrorKind::Unsupported => {}
            Err(std::fs::TryLockError::Error(error)) => return Err(io(error)),
        }
        let length = file.metadata().map_err(io)?.len();
        let mut head = MAGIC.to_vec();
        head.extend((key.len() as u32).to_le_bytes());
        head.extend(key);
        let mut journal = Self {
            path: path.to_path_buf(),
            file: BufWriter::with_capacity(1 << 16, file),
            index: Vec::new(),
            end: head.len() as u64,
            synced: Instant::now(),
        };
        let mut reader = BufReader::new(journal.file.get_ref().try_clone().map_err(io)?);
        reader.seek(SeekFrom::Start(0)).map_err(io)?;
        let mut there = vec![0; head.len().min(length as usize)];
        reader.read_exact(&mut there).map_err(io)?;
        if there != head[..there.len()] {
            return Err(JournalError::Foreign(path.to_path_buf()));
        }
        if there.len() < head.len() {
            // The run was killed while it wrote the header, so the journal is empty.
            let file = journal.file.get_mut();
            file.set_len(0).map_err(io)?;
            file.seek(SeekFrom::Start(0)).map_err(io)?;
            journal.file.write_all(&head).map_err(io)?;
            journal.file.flush().map_err(io)?;
            return Ok(journal);
        }
        while let Some((row, size)) = next(&mut reader) {
            journal.index.push((row.case, journal.end));
            journal.end += size;
        }
        let file = journal.file.get_mut();
        file.set_len(journal.end).map_err(io)?;
        file.seek(SeekFrom::Start(journal.end)).map_err(io)?;
        Ok(journal)
    }

    /// Iterates over the numbers of the finished cases, in order of completion.
    pub(crate) fn cases(&self) -> impl Iterator<Item = u64> + '_ {
        self.index.iter().map(|(case, _)| *case)
    }

    /// Appends the row of a case.
    ///
    /// # Errors
    /// When the row cannot be written.
    pub(crate) fn add(&mut self, row: &Row) -> Result<(), JournalError> {
        let mut payload = Vec::with_capacity(32 + 8 * row.outputs.len() + row.reason.len());
        payload.extend(row.case.to_le_bytes());
        payload.push(row.status as u8);
        payload.extend(row.seconds.to_le_bytes());
        payload.extend((row.outputs.len() as u32).to_le_bytes());
        for value in &row.outputs {
            payload.extend(value.to_le_bytes());
        }
        payload.extend(row.reason.as_bytes());
        let mut record = Vec::with_capacity(payload.len() + 12);
        record.extend((payload.len() as u32).to_le_bytes());
        record.extend(checksum(&payload).to_le_bytes());
        record.extend(payload);
        self.file
            .write_all(&record)
            .map_err(|error| self.failed(error))?;
        self.index.push((row.case, self.end));
        self.end += record.len() as u64;
        Ok(())
    }

    /// Passes the appended records to the operating system, and at intervals to the disk.
    ///
    /// # Errors
    /// When writing fails.
    pub(crate) fn flush(&mut self) -> Result<(), JournalError> {
        self.file.flush().map_err(|error| self.failed(error))?;
        if self.synced.elapsed() >= SYNC {
            self.sync()?;
        }
        Ok(())
    }

    /// Forces the appended records to disk.
    ///
    /// # Errors
    /// When writing fails.
    pub(crate) fn sync(&mut self) -> Result<(), JournalError> {
        self.file.flush().map_err(|error| self.failed(error))?;
        self.file
            .get_ref()
            .sync_data()
            .map_err(|error| self.failed(error))?;
        self.synced = Instant::now();
        Ok(())
    }

    /// Passes the row of every case to `take` once, in order of the case numbers.
    ///
    /// # Errors
    /// When the file cannot be read, or when `take` returns an error.
    pub(crate) fn in_order<E: From<JournalError>>(
        &mut self,
        mut take: impl FnMut(Row) -> Result<(), E>,
    ) -> Result<(), E> {
        self.sync()?;
        let mut index = std::mem::take(&mut self.index);
        index.sort_unstable();
        index.dedup_by_key(|(case, _)| *case);
        let file = File::open(&self.path).map_err(|error| self.failed(error))?;
        let mut reader = BufReader::new(file);
        let mut at = 0;
        for (_, place) in &index {
            // Records are mostly adjacent, so the buffer is rarely discarded.
            reader
                .seek_relative(*place as i64 - at as i64)
                .map_err(|error| self.failed(error))?;
            let Some((row, size)) = next(&mut reader) else {
                let cut = io::Error::from(io::ErrorKind::UnexpectedEof);
                return Err(self.failed(cut).into());
            };
            at = place + size;
            take(row)?;
        }
        self.index = index;
        Ok(())
    }

    fn failed(&self, error: io::Error) -> JournalError {
        JournalError::Io {
            path: self.path.clone(),
            error,
        }
    }
}

/// Reads the next record. Returns its row and its size in bytes; `None` at the end, or if the record is truncated or damaged.
fn next(reader: &mut impl Read) -> Option<(Row, u64)> {
    let mut head = [0; 12];
    reader.read_exact(&mut head).ok()?;
    let length = u32::from_le_bytes(head[..4].try_into().ok()?);
    let sum = u64::from_le_bytes(head[4..].try_into().ok()?);
    if length > LONGEST {
        return None;
    }
    let mut payload = vec![0; length as usize];
    reader.read_exact(&mut payload).ok()?;
    if checksum(&payload) != sum {
        return None;
    }
    let number = |at: usize| {
        Some(f64::from_le_bytes(
            payload.get(at..at + 8)?.try_into().ok()?,
        ))
    };
    let case = u64::from_le_bytes(payload.get(..8)?.try_into().ok()?);
    let status = *Status::ALL.get(usize::from(*payload.get(8)?))?;
    let seconds = number(9)?;
    let count = u32::from_le_bytes(payload.get(17..21)?.try_into().ok()?) as usize;
    let outputs = (0..count)
        .map(|k| number(21 + 8 * k))
        .collect::<Option<_>>()?;
    let reason = String::from_utf8(payload.get(21 + 8 * count..)?.to_vec()).ok()?;
    let row = Row {
        case,
        status,
        reason,
        seconds,
        outputs,
    };
    Some((row, u64::from(length) + 12))
}

/// FNV-1a checksum of 64 bits, which distinguishes intact records from truncated ones.
fn checksum(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |sum, byte| {
        (sum ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(case: u64) -> Row {
        Row {
            case,
            status: if case.is_multiple_of(3) {
                Status::NoAnswer
            } else {
                Status::Ok
            },
            reason: if case.is_multiple_of(3) {
                format!("why {case}")
            } else {
                String::new()
            },
            seconds: 0.25,
            outputs: vec![case as f64, f64::NAN, -1.0 / 3.0],
        }
    }

    fn all(journal: &mut Journal) -> Vec<u64> {
        let mut found = Vec::new();
        journal
            .in_order(|row| -> Result<(), JournalError> {
                assert_eq!(row.outputs[0], row.case as f64);
                assert!(row.outputs[1].is_nan());
                assert_eq!(row.reason.is_empty(), row.case % 3 != 0);
                found.push(row.case);
                Ok(())
            })
            .unwrap();
        found
    }

    #[test]
    fn a_journal_cut_anywhere_gives_the_whole_records_before() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("j");
        let mut ends = Vec::new();
        {
            let mut journal = Journal::open(&path, b"key").unwrap();
            for case in [4, 0, 3, 1] {
                ends.push(journal.end);
                journal.add(&row(case)).unwrap();
            }
            ends.push(journal.end);
            assert_eq!(all(&mut journal), [0, 1, 3, 4]);
        }
        let whole = std::fs::read(&path).unwrap();
        for cut in 0..=whole.len() {
            std::fs::write(&path, &whole[..cut]).unwrap();
            let mut journal = Journal::open(&path, b"key").unwrap();
            let kept = ends
                .iter()
                .filter(|end| **end <= cut as u64)
                .count()
                .saturating_sub(1);
            assert_eq!(journal.cases().collect::<Vec<_>>(), [4, 0, 3, 1][..kept]);
            journal.add(&row(9)).unwrap();
            let mut expected: Vec<u64> = [4, 0, 3, 1][..kept].to_vec();
            expected.push(9);
            expected.sort_unstable();
            assert_eq!(all(&mut journal), expected);
        }
    }

    #[test]
    fn a_journal_of_another_sweep_or_process_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("j");
        let first = Journal::open(&path, b"key").unwrap();
        assert!(matches!(
            Journal::open(&path, b"key"),
            Err(JournalError::Locked(_))
        ));
        drop(first);
        assert!(matches!(
            Journal::open(&path, b"yek"),
            Err(JournalError::Foreign(_))
        ));
    }
}
