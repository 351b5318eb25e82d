//! Parser for the subset of XML that results files use; it needs constant memory.
//!
//! The subset consists of tags, attributes, comments and the five predefined entities. Document types, declared entities and CDATA sections
//! are rejected: results files do not contain them, but attacks on XML readers do.

use std::io::{self, Read};
use std::ops::Range;

/// Maximum length, in bytes, of a tag, a comment, or a text of the header.
pub(super) const LIMIT: usize = 1 << 20;
const CHUNK: usize = 1 << 16;

/// Reason why XML input is rejected.
#[derive(Clone, Copy, PartialEq, Eq, Debug, thiserror::Error)]
pub(super) enum Refusal {
    #[error("a results file cannot have a document type or entity declaration")]
    Declaration,
    #[error("a results file cannot have a CDATA section")]
    CharacterData,
    #[error("this entity reference is not predefined in XML")]
    Entity,
    #[error("this text is longer than any text of a results file")]
    TooLong,
    #[error("this tag cannot be read")]
    Tag,
}

/// A tag of the stream. Byte ranges are indices in the window of the [`Scanner`].
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) enum Tag {
    /// An opening tag: `<name attributes>` or `<name attributes />`.
    Open {
        name: Range<usize>,
        attributes: Range<usize>,
        empty: bool,
    },
    /// A closing tag: `</name>`.
    Close { name: Range<usize> },
}

/// Outcome of a search in the stream: found, end of the stream, or rejected input.
pub(super) enum Found<T> {
    Yes(T),
    EndOfFile,
    Refused(Refusal),
}

/// A buffered window on a stream of bytes. Returned ranges stay valid until the next call that may read more bytes.
#[derive(Debug)]
pub(super) struct Scanner<R> {
    input: R,
    buffer: Vec<u8>,
    start: usize,
    end: usize,
    base: u64,
}

impl<R: Read> Scanner<R> {
    pub(super) fn new(input: R) -> Self {
        Self {
            input,
            buffer: Vec::new(),
            start: 0,
            end: 0,
            base: 0,
        }
    }

    pub(super) fn bytes(&self, range: Range<usize>) -> &[u8] {
        &self.buffer[range]
    }

    /// Converts an index in the window to an offset in the stream.
    pub(super) fn offset_of(&self, index: usize) -> u64 {
        self.base + index as u64
    }

    /// Returns the offset in the stream of the next unread byte.
    pub(super) fn offset(&self) -> u64 {
        self.offset_of(self.start)
    }

    /// Returns the unread bytes of the window. Before that, reads until at least `wanted` bytes are available or the stream ends.
    pub(super) fn peek(&mut self, wanted: usize) -> io::Result<&[u8]> {
        while self.end - self.start < wanted && self.fill()? {}
        Ok(&self.buffer[self.start..self.end])
    }

    pub(super) fn skip(&mut self, count: usize) {
        self.start = (self.start + count).min(self.end);
    }

    /// Reads more bytes into the window; returns false at the end of the stream.
    fn fill(&mut self) -> io::Result<bool> {
        if self.start > 0 && (self.start == self.end || self.buffer.len() - self.end < CHUNK) {
            self.buffer.copy_within(self.start..self.end, 0);
            self.base += self.start as u64;
            self.end -= self.start;
            self.start = 0;
        }
        if self.buffer.len() - self.end < CHUNK {
            let more = (self.buffer.len() * 2).max(2 * CHUNK);
            self.buffer.resize(more, 0);
        }
        loop {
            match self.input.read(&mut self.buffer[self.end..]) {
                Ok(0) => return Ok(false),
                Ok(count) => {
                    self.end += count;
                    return Ok(true);
                }
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(error),
            }
        }
    }

    /// Returns the index in the window of the first byte that `search` finds. The search starts `from` bytes after the first unread byte.
    ///
    /// The input is rejected if more than `limit` unread bytes contain no match. After each read, the last `overlap` bytes are searched
    /// again.
    fn find(
        &mut self,
        from: usize,
        limit: usize,
        search: impl Fn(&[u8]) -> Option<usize>,
        overlap: usize,
    ) -> io::Result<Found<usize>> {
        let mut done = from;
        loop {
            if self.start + done < self.end
                && let Some(at) = search(&self.buffer[self.start + done..self.end])
            {
                return Ok(Found::Yes(self.start + done + at));
            }
            let unread = self.end - self.start;
            if unread > limit {
                return Ok(Found::Refused(Refusal::TooLong));
            }
            done = unread.saturating_sub(overlap).max(from);
            if !self.fill()? {
                return Ok(Found::EndOfFile);
            }
        }
    }

    /// Returns the text up to the next `<` and moves to that `<`. The input is rejected if the text is longer than `limit` bytes.
    pub(super) fn text(&mut self, limit: usize) -> io::Result<Found<Range<usize>>> {
        Ok(
            match self.find(0, limit, |bytes| memchr::memchr(b'<', bytes), 0)? {
                Found::Yes(at) => {
                    let from = self.start;
                    self.start = at;
                    Found::Yes(from..at)
                }
                Found::EndOfFile => Found::EndOfFile,
                Found::Refused(refusal) => Found::Refused(refusal),
            },
        )
    }

    /// Skips the text up to the next `<` in constant memory.
    pub(super) fn skip_text(&mut self) -> io::Result<Found<()>> {
        loop {
            let window = &self.buffer[self.start..self.end];
            if let Some(at) = memchr::memchr(b'<', window) {
                self.start += at;
                return Ok(Found::Yes(()));
            }
            self.start = self.end;
            if !self.fill()? {
                return Ok(Found::EndOfFile);
            }
        }
    }

    /// Reads the tag at the next `<`. Comments and processing instructions before the tag are skipped, and so is the text between them.
    pub(super) fn tag(&mut self) -> io::Result<Found<Tag>> {
        loop {
            let head = self.peek(9)?;
            let skipped = if head.starts_with(b"<!--") {
                self.find(
                    4,
                    LIMIT,
                    |bytes| memchr::memmem::find(bytes, b"-->").map(|at| at + 2),
                    2,
                )?
            } else if head.starts_with(b"<?") {
                self.find(
                    2,
                    LIMIT,
                    |bytes| memchr::memmem::find(bytes, b"?>").map(|at| at + 1),
                    1,
                )?
            } else if head.starts_with(b"<![CDATA[") {
                return Ok(Found::Refused(Refusal::CharacterData));
            } else if head.starts_with(b"<!") {
                return Ok(Found::Refused(Refusal::Declaration));
            } else {
                return self.element();
            };
            match skipped {
                Found::Yes(end) => self.start = end + 1,
                Found::EndOfFile => return Ok(Found::EndOfFile),
                Found::Refused(refusal) => return Ok(Found::Refused(refusal)),
            }
            match self.skip_text()? {
                Found::Yes(()) => {}
                Found::EndOfFile => return Ok(Found::EndOfFile),
                Found::Refused(refusal) => return Ok(Found::Refused(refusal)),
            }
        }
    }

    /// Consumes the closing tag `</name>`, which must directly follow `text`, and returns the new range of `text` in the window. Any other
    /// tag is rejected.
    pub(super) fn closing(
        &mut self,
        text: Range<usize>,
        name: &[u8],
    ) -> io::Result<Found<Range<usize>>> {
        // The scanner returns to the start of the text, so that the text stays in the window while more bytes are read.
        let lead = text.len();
        self.start = text.start;
        let end = match self.find(lead, lead + LIMIT, |bytes| memchr::memchr(b'>', bytes), 0)? {
            Found::Yes(end) => end,
            Found::EndOfFile => {
                self.start += lead;
                return Ok(Found::EndOfFile);
            }
            Found::Refused(refusal) => return Ok(Found::Refused(refusal)),
        };
        let text = self.start..self.start + lead;
        let tag = &self.buffer[text.end..=end];
        let matches = tag
            .strip_prefix(b"</")
            .and_then(|tag| tag.strip_prefix(name))
            .is_some_and(|rest| rest.trim_ascii_start() == b">");
        self.start = end + 1;
        Ok(if matches {
            Found::Yes(text)
        } else {
            Found::Refused(Refusal::Tag)
        })
    }

    fn element(&mut self) -> io::Result<Found<Tag>> {
        let mut done = 1;
        let mut quote = None;
        let end = loop {
            let window = &self.buffer[self.start..self.end];
            let mut close = None;
            while done < window.len() {
                let hit = match quote {
                    Some(quote) => memchr::memchr(quote, &window[done..]),
                    None => memchr::memchr3(b'>', b'"', b'\'', &window[done..]),
                };
                let Some(hit) = hit else {
                    done = window.len();
                    break;
                };
                let byte = window[done + hit];
                done += hit + 1;
                match quote {
                    Some(_) => quote = None,
                    None if byte == b'>' => {
                        close = Some(done - 1);
                        break;
                    }
                    None => quote = Some(byte),
                }
            }
            if let Some(close) = close {
                break self.start + close;
            }
            if window.len() > LIMIT {
                return Ok(Found::Refused(Refusal::TooLong));
            }
            if !self.fill()? {
                return Ok(Found::EndOfFile);
            }
        };
        let from = self.start + 1;
        self.start = end + 1;
        let inner = &self.buffer[from..end];
        let closing = inner.first() == Some(&b'/');
        let name_from = from + usize::from(closing);
        let name_len = self.buffer[name_from..end]
            .iter()
            .position(|&byte| !is_name(byte))
            .unwrap_or(end - name_from);
        let name = name_from..name_from + name_len;
        if name.is_empty() {
            return Ok(Found::Refused(Refusal::Tag));
        }
        if closing {
            return Ok(Found::Yes(Tag::Close { name }));
        }
        let empty = inner.last() == Some(&b'/');
        let attributes = name.end..end - usize::from(empty && end > name.end);
        Ok(Found::Yes(Tag::Open {
            name,
            attributes,
            empty,
        }))
    }
}

fn is_name(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-' | b':' | b'.') || byte >= 0x80
}

/// Parses attributes `name="value"` and resolves character references. Bytes that are not UTF-8 are decoded as Latin-1.
pub(super) fn attributes(mut text: &[u8]) -> Result<Vec<(String, String)>, Refusal> {
    let mut all = Vec::new();
    loop {
        text = text.trim_ascii_start();
        if text.is_empty() {
            return Ok(all);
        }
        let name_len = text.iter().take_while(|&&byte| is_name(byte)).count();
        let name = decode(&text[..name_len])?;
        text = text[name_len..].trim_ascii_start();
        let Some(rest) = text.strip_prefix(b"=") else {
            return Err(Refusal::Tag);
        };
        let rest = rest.trim_ascii_start();
        let quote = match rest.first() {
            Some(&quote @ (b'"' | b'\'')) if name_len > 0 => quote,
            _ => return Err(Refusal::Tag),
        };
        let Some(end) = memchr::memchr(quote, &rest[1..]) else {
            return Err(Refusal::Tag);
        };
        all.push((name, decode(&rest[1..=end])?));
        text = &rest[end + 2..];
    }
}

/// Converts bytes to text and resolves character references.
pub(super) fn decode(bytes: &[u8]) -> Result<String, Refusal> {
    let text = match std::str::from_utf8(bytes) {
        Ok(text) => text.to_string(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    };
    if !text.contains('&') {
        return Ok(text);
    }
    let mut out = String::with_capacity(text.len());
    let mut pieces = text.split('&');
    out.push_str(pieces.next().unwrap_or_default());
    for piece in pieces {
        let (reference, rest) = piece.split_once(';').ok_or(Refusal::Entity)?;
        let character = match reference {
            "amp" => '&',
            "lt" => '<',
            "gt" => '>',
            "quot" => '"',
            "apos" => '\'',
            other => {
                let number = other.strip_prefix('#').ok_or(Refusal::Entity)?;
                match number.strip_prefix('x') {
                    Some(hex) => u32::from_str_radix(hex, 16).ok(),
                    None => number.parse().ok(),
                }
                .and_then(char::from_u32)
                .ok_or(Refusal::Entity)?
            }
        };
        out.push(character);
        out.push_str(rest);
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn attributes_resolve_the_predefined_references_only() {
        let all = attributes(b" a=\"x &lt;&amp;&#65;&#x42;\" b = 'it \"is\"' ").unwrap();
        assert_eq!(all[0], ("a".to_string(), "x <&AB".to_string()));
        assert_eq!(all[1], ("b".to_string(), "it \"is\"".to_string()));
        assert_eq!(attributes(b"a=\"&lol9;\""), Err(Refusal::Entity));
        assert_eq!(attributes(b"a=\"&#1114112;\""), Err(Refusal::Entity));
        assert_eq!(attributes(b"a"), Err(Refusal::Tag));
        assert_eq!(attributes(b"a=\"x"), Err(Refusal::Tag));
        assert_eq!(attributes(b"=\"x\""), Err(Refusal::Tag));
    }

    #[test]
    fn tags_keep_quoted_angle_brackets() {
        let mut scanner = Scanner::new(&b"<?xml?> <!-- <x> --> <E n=\"a>b\" /></E>"[..]);
        let Found::Yes(Tag::Open {
            name,
            attributes,
            empty,
        }) = scanner.tag().unwrap()
        else {
            panic!("no tag");
        };
        assert!(empty);
        assert_eq!(scanner.bytes(name), b"E");
        assert_eq!(scanner.bytes(attributes), b" n=\"a>b\" ");
        assert!(matches!(
            scanner.tag().unwrap(),
            Found::Yes(Tag::Close { .. })
        ));
        assert!(matches!(scanner.tag().unwrap(), Found::EndOfFile));
    }
}
