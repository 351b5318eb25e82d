use std::borrow::Cow;
use std::io::Read;
use std::path::Path;
use std::sync::{Arc, OnceLock};

use super::Span;

/// The bytes of one file with a name to show, cheap to clone.
#[derive(Clone, Debug)]
pub struct Source {
    name: Arc<str>,
    // As it was read: to move the bytes of a large file would need their room twice.
    bytes: Arc<Vec<u8>>,
    /// Where lines begin, once somebody asked: thousands of complaints about one file ask again and again.
    line_starts: Arc<OnceLock<Vec<usize>>>,
}

/// A 1-based line and a 1-based column counted in bytes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct LineColumn {
    /// Line, from 1.
    pub line: usize,
    /// Column in bytes, from 1.
    pub column: usize,
}

impl Source {
    /// More bytes are not read as a whole: their places would not fit a [`Span`].
    pub const LARGEST: u64 = u32::MAX as u64;

    /// A source from a name to show and its bytes.
    pub fn new(name: impl Into<Arc<str>>, bytes: impl Into<Vec<u8>>) -> Self {
        Self {
            name: name.into(),
            bytes: Arc::new(bytes.into()),
            line_starts: Arc::default(),
        }
    }

    /// The bytes of a file.
    ///
    /// # Errors
    /// When the file cannot be read, or is larger than [`LARGEST`](Self::LARGEST).
    pub fn read(path: &Path) -> std::io::Result<Self> {
        let bytes = read_at_most(path, Self::LARGEST)?;
        Ok(Self::new(path.display().to_string(), bytes))
    }

    /// The name to show: usually a path.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// All bytes.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// The bytes of a span.
    pub fn slice(&self, span: Span) -> &[u8] {
        &self.bytes[span.range()]
    }

    /// The text of a span to show to a person: bytes that are not UTF-8 are read as Latin-1.
    pub fn text(&self, span: Span) -> Cow<'_, str> {
        let bytes = self.slice(span);
        match std::str::from_utf8(bytes) {
            Ok(text) => Cow::Borrowed(text),
            Err(_) => Cow::Owned(bytes.iter().map(|&byte| char::from(byte)).collect()),
        }
    }

    /// The whole file, of a format that is UTF-8.
    ///
    /// # Errors
    /// The place of the first byte that is not.
    pub fn utf8(&self) -> Result<&str, Span> {
        std::str::from_utf8(&self.bytes).map_err(|error| {
            let at = error.valid_up_to();
            Span::new(at, at + 1)
        })
    }

    /// The same text in UTF-8 where the file is UTF-16: by its byte order mark, or by zeros beside its first letters.
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

    /// Line and column of an offset. Lines end at LF; a CR before it belongs to the line.
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

/// Opens a file to read it.
///
/// # Errors
/// When it cannot be opened. A named pipe or a device is refused: the one waits for its writer, if need be for ever, the other may not end.
/// Pipes of a shell have a writer; they have no place in the file system.
pub fn open_to_read(path: &Path) -> std::io::Result<std::fs::File> {
    let there = std::fs::metadata(path)?;
    if !there.is_file() && !there.is_dir() && path.canonicalize().is_ok() {
        return Err(std::io::Error::new(
            std::io::ErrorKind::InvalidInput,
            "it is a named pipe or a device, which may never end",
        ));
    }
    std::fs::File::open(path)
}

/// The bytes of a file that has at most so many.
///
/// # Errors
/// When the file cannot be read, or is larger.
pub fn read_at_most(path: &Path, most: u64) -> std::io::Result<Vec<u8>> {
    let size = std::fs::metadata(path)?.len();
    check_size(size, most)?;
    let mut bytes = Vec::new();
    // A few bytes more: to see the end must not double the room.
    let room = usize::try_from(size)
        .unwrap_or(usize::MAX)
        .saturating_add(64);
    bytes
        .try_reserve_exact(room)
        .map_err(|_| std::io::Error::from(std::io::ErrorKind::OutOfMemory))?;
    // What has no size beforehand (a pipe, a device) is cut off.
    open_to_read(path)?
        .take(most.saturating_add(1))
        .read_to_end(&mut bytes)?;
    check_size(bytes.len() as u64, most)?;
    Ok(bytes)
}

/// An error if a file has more bytes than are read.
///
/// # Errors
/// In that case.
pub fn check_size(size: u64, most: u64) -> std::io::Result<()> {
    if size <= most {
        return Ok(());
    }
    Err(std::io::Error::new(
        std::io::ErrorKind::FileTooLarge,
        format!("its {size} bytes are more than the {most} that are read"),
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
