use std::io::{Result, Write};

/// A writer of text that writes the line ends of the operating system: CR LF on Windows, LF elsewhere.
#[derive(Debug)]
pub struct LineEnds<W> {
    inner: W,
    carriage_return: bool,
}

impl<W: Write> LineEnds<W> {
    /// Creates a writer that passes the text on to `inner`.
    pub const fn of_system(inner: W) -> Self {
        Self {
            inner,
            carriage_return: cfg!(windows),
        }
    }
}

impl<W: Write> Write for LineEnds<W> {
    fn write(&mut self, text: &[u8]) -> Result<usize> {
        if !self.carriage_return {
            return self.inner.write(text);
        }
        let mut out = Vec::with_capacity(text.len() + text.len() / 16);
        for line in text.split_inclusive(|byte| *byte == b'\n') {
            match line.strip_suffix(b"\n") {
                Some(line) => {
                    out.extend_from_slice(line);
                    out.extend_from_slice(b"\r\n");
                }
                None => out.extend_from_slice(line),
            }
        }
        self.inner.write_all(&out)?;
        Ok(text.len())
    }

    fn flush(&mut self) -> Result<()> {
        self.inner.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_end_as_on_the_system_however_they_are_cut() {
        for (carriage_return, wanted) in [(true, "a\r\n\r\nb c\r\nd"), (false, "a\n\nb c\nd")] {
            let mut out = Vec::new();
            let mut writer = LineEnds {
                inner: &mut out,
                carriage_return,
            };
            for piece in ["a", "\n\nb", "", " c\n", "d"] {
                writer.write_all(piece.as_bytes()).unwrap();
            }
            writer.flush().unwrap();
            assert_eq!(String::from_utf8(out).unwrap(), wanted);
        }
    }
}
