use std::borrow::Cow;
use std::io::Read;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use super::Span;

/// The bytes of one file, with a name for messages. Cloning is cheap.
#[derive(Clone, Debug)]
pub struct Source {
    name: Arc<str>,
    // The vector is kept as read; a conversion to another type would take twice the memory for a large file.
    bytes: Arc<Vec<u8>>,
    /// Offsets at which the lines begin. They are computed on first use, because a file may have thousands of diagnostics that need them.
    line_starts: Arc<OnceLock<Vec<usize>>>,
}

/// A position in a text: line and column, both counted from 1. The column is counted in bytes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LineColumn {
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1, counted in bytes.
    pub column: usize,
}

impl Source {
    /// Largest size of a file that is read as a whole, in bytes. Offsets in a larger file would not fit into a [`Span`].
    pub const LARGEST: u64 = u32::MAX as u64;

    /// Creates a source from a name for messages and its bytes.
    pub fn new(name: impl Into<Arc<str>>, bytes: impl Into<Vec<u8>>) -> Self {
        Self {
            name: name.into(),
            bytes: Arc::new(bytes.into()),
            line_starts: Arc::default(),
        }
    }

    /// Reads a file as a whole.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read or is larger than [`LARGEST`](Self::LARGEST).
    pub fn read(path: &Path) -> std::io::Result<Self> {
        let bytes = read_at_most(path, Self::LARGEST)?;
        Ok(Self::new(path.display().to_string(), bytes))
    }

    /// Returns the name for messages, which is usually a path.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Returns all bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Returns the bytes of a span.
    pub fn slice(&self, span: Span) -> &[u8] {
        &self.bytes[span.range()]
    }

    /// Returns the text of a span for display. If the bytes are not valid UTF-8, they are decoded as Latin-1.
    pub fn text(&self, span: Span) -> Cow<'_, str> {
        let bytes = self.slice(span);
        match std::str::from_utf8(bytes) {
            Ok(text) => Cow::Borrowed(text),
            Err(_) => Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()),
        }
    }

    /// Encodes a text in the encoding of the file: one byte per character for a Latin-1 file, UTF-8 otherwise.
    pub fn encoded(&self, text: &str) -> Vec<u8> {
        let latin1: Option<Vec<u8>> = text.chars().map(|c| u8::try_from(c).ok()).collect();
        match latin1 {
            Some(bytes) if !text.is_ascii() && std::str::from_utf8(self.bytes()).is_err() => bytes,
            _ => text.as_bytes().to_vec(),
        }
    }

    /// Returns the whole file as text, for file formats that require UTF-8.
    ///
    /// # Errors
    /// Returns the span of the first byte that is not UTF-8.
    pub fn utf8(&self) -> Result<&str, Span> {
        std::str::from_utf8(&self.bytes).map_err(|error| {
            let at = error.valid_up_to();
            Span::new(at, at + 1)
        })
    }

    /// Converts a UTF-16 file to UTF-8; any other file stays unchanged.
    ///
    /// UTF-16 is recognised by its byte order mark, or by zero bytes beside its first two letters.
    #[must_use]
    pub fn in_utf8(self) -> Self {
        let encoding = match self.bytes[..] {
            [0xff, 0xfe, ..] => encoding_rs::UTF_16LE,
            [0xfe, 0xff, ..] => encoding_rs::UTF_16BE,
            [a, 0, b, 0, ..] if a > 0 && b > 0 => encoding_rs::UTF_16LE,
            [0, a, 0, b, ..] if a > 0 && b > 0 => encoding_rs::UTF_16BE,
            _ => return self,
        };
        let (text, _) = encoding.decode_with_bom_removal(&self.bytes);
        Self::new(self.name, text.into_owned())
    }

    /// Returns the line and column of an offset. Lines end at LF; a CR before the LF belongs to the line.
    pub fn line_column(&self, offset: usize) -> LineColumn {
        let offset = offset.min(self.bytes.len());
        let starts = self.line_starts.get_or_init(|| {
            let ends = memchr::memchr_iter(b'\n', &self.bytes);
            std::iter::once(0).chain(ends.map(|end| end + 1)).collect()
        });
        let line = starts.partition_point(|start| *start <= offset);
        LineColumn {
            line,
            column: offset - starts[line - 1] + 1,
        }
    }
}

/// Opens a file for reading.
///
/// # Errors
/// Returns an error if the file cannot be opened, or if it is a named pipe or a device: reading from these might never end. Pipes of a
/// shell are accepted; they have no path in the file system.
pub fn open_to_read(path: &Path) -> std::io::Result<std::fs::File> {
    let there = std::fs::metadata(path)?;
    if !there.is_file() && !there.is_dir() && path.canonicalize().is_ok() {
        return Err(std::io::Error::new(
            std::io::ErrorKind::InvalidInput,
            "it is a named pipe or a device, not a file",
        ));
    }
    std::fs::File::open(path)
}

/// Reads a file of at most `most` bytes.
///
/// # Errors
/// Returns an error if the file cannot be read or is larger than `most`.
pub fn read_at_most(path: &Path, most: u64) -> std::io::Result<Vec<u8>> {
    let size = std::fs::metadata(path)?.len();
    check_size(size, most)?;
    let mut bytes = Vec::new();
    // With a few spare bytes, the read detects the end of the file without doubling the buffer.
    let room = usize::try_from(size)
        .unwrap_or(usize::MAX)
        .saturating_add(64);
    bytes
        .try_reserve_exact(room)
        .map_err(|_| std::io::Error::from(std::io::ErrorKind::OutOfMemory))?;
    // A file of unknown size is read up to one byte beyond the limit, and rejected below if it is too large.
    open_to_read(path)?
        .take(most.saturating_add(1))
        .read_to_end(&mut bytes)?;
    check_size(bytes.len() as u64, most)?;
    Ok(bytes)
}

/// Checks the size of a file against a limit.
///
/// # Errors
/// Returns an error if `size` exceeds `most`.
pub fn check_size(size: u64, most: u64) -> std::io::Result<()> {
    if size <= most {
        return Ok(());
    }
    Err(std::io::Error::new(
        std::io::ErrorKind::FileTooLarge,
        format!("it has {size} bytes, more than the limit of {most}"),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_and_columns_are_those_counted_from_the_start() {
        for bytes in [&b""[..], b"\n", b"a\nbc\r\n\nd", b"\n\n\n", b"no end"] {
            let source = Source::new("a", bytes);
            for offset in 0..bytes.len() + 3 {
                let before = &bytes[..offset.min(bytes.len())];
                let line = before.iter().filter(|byte| **byte == b'\n').count() + 1;
                let start = before.iter().rposition(|byte| *byte == b'\n');
                let column = before.len() - start.map_or(0, |at| at + 1) + 1;
                assert_eq!(source.line_column(offset), LineColumn { line, column });
            }
        }
    }
}
