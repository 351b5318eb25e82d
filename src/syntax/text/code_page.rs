use std::borrow::Cow;
use std::io::{Result, Write};

use encoding_rs::Encoding;
use oem_cp::code_table::ENCODING_TABLE_CP_MAP;

/// Environment variable with the code page that is expected by a program that reads the output of `admire` from a pipe.
const VARIABLE: &str = "ADMIRE_CODE_PAGE";

/// Encoding of output that does not go to a console.
#[derive(Clone, Copy, Debug)]
pub enum CodePage {
    /// UTF-8: texts are written unchanged.
    Utf8,
    /// A console (OEM) code page of Windows: 437, 850, 852 and so on.
    Oem(u16),
    /// An ANSI code page of Windows: 1250 to 1258.
    Ansi(&'static Encoding),
}

impl CodePage {
    /// Returns the code page named by the environment variable `ADMIRE_CODE_PAGE`, or UTF-8 if it is not set.
    ///
    /// # Errors
    /// Returns a message if the code page is unknown.
    pub fn of_environment() -> std::result::Result<Self, String> {
        let named = std::env::var(VARIABLE).unwrap_or_default();
        Self::named(&named).ok_or_else(|| {
            format!("{VARIABLE}: `{named}` is not a code page; examples are 1252, 850 and utf-8")
        })
    }

    fn named(name: &str) -> Option<Self> {
        let lower = name.trim().to_ascii_lowercase();
        let number = lower
            .trim_start_matches("cp")
            .trim_start_matches("windows-");
        if ["", "65001", "utf-8", "utf8"].contains(&number) {
            return Some(Self::Utf8);
        }
        let number: u16 = number.parse().ok()?;
        if ENCODING_TABLE_CP_MAP.contains_key(&number) {
            return Some(Self::Oem(number));
        }
        Encoding::for_label(format!("windows-{number}").as_bytes()).map(Self::Ansi)
    }

    /// Encodes a text in this code page. A character that the code page lacks is replaced by similar ASCII characters, or by `?`.
    pub fn encode(self, text: &str) -> Cow<'_, [u8]> {
        if text.is_ascii() || matches!(self, Self::Utf8) {
            return Cow::Borrowed(text.as_bytes());
        }
        let mut out = Vec::with_capacity(text.len());
        for c in text.chars() {
            if !self.push(c, &mut out) {
                out.extend_from_slice(like(c).as_bytes());
            }
        }
        Cow::Owned(out)
    }

    /// Appends a character if the code page contains it; returns true if it does.
    fn push(self, c: char, out: &mut Vec<u8>) -> bool {
        if c.is_ascii() {
            out.push(c as u8);
            return true;
        }
        match self {
            Self::Utf8 => out.extend_from_slice(c.encode_utf8(&mut [0; 4]).as_bytes()),
            Self::Oem(number) => {
                let table = ENCODING_TABLE_CP_MAP.get(&number);
                let Some(byte) = table.and_then(|table| table.get(&c)) else {
                    return false;
                };
                out.push(*byte);
            }
            Self::Ansi(encoding) => {
                let mut buffer = [0; 4];
                let (bytes, _, lacks) = encoding.encode(c.encode_utf8(&mut buffer));
                if lacks {
                    return false;
                }
                out.extend_from_slice(&bytes);
            }
        }
        true
    }
}

/// Returns ASCII characters that resemble a character in the output of `admire`, or `?`.
const fn like(c: char) -> &'static str {
    match c {
        '\u{2502}' | '\u{2506}' | '\u{250a}' => "|",
        '\u{250c}'..='\u{257f}' => "+",
        '\u{2500}' | '\u{2013}' | '\u{2014}' | '\u{2212}' => "-",
        '\u{2018}' | '\u{2019}' => "'",
        '\u{201c}' | '\u{201d}' => "\"",
        '\u{2026}' => "...",
        '\u{2192}' | '\u{25b6}' => ">",
        '\u{b1}' => "+/-",
        '\u{d7}' | '\u{2716}' => "x",
        '\u{b5}' | '\u{3bc}' => "u",
        '\u{b7}' | '\u{2022}' => ".",
        '\u{26a0}' => "!",
        _ => "?",
    }
}

/// A writer that accepts UTF-8 text and passes it on in a code page.
#[derive(Debug)]
pub struct Encoded<W> {
    inner: W,
    page: CodePage,
}

impl<W: Write> Encoded<W> {
    /// Creates a writer that passes the encoded text on to `inner`.
    pub const fn new(inner: W, page: CodePage) -> Self {
        Self { inner, page }
    }
}

impl<W: Write> Write for Encoded<W> {
    fn write(&mut self, text: &[u8]) -> Result<usize> {
        let shown = String::from_utf8_lossy(text);
        self.inner.write_all(&self.page.encode(&shown))?;
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
    fn texts_are_encoded_as_the_code_pages_have_them() {
        let text = "Längslenker ± 2 µm \u{256d}\u{2500} \u{4e2d}";
        for (name, wanted) in [
            ("", text.as_bytes()),
            ("UTF-8", text.as_bytes()),
            // CP850 encodes ä as 0x84, ± as 0xF1, µ as 0xE6, ─ as 0xC4.
            ("850", b"L\x84ngslenker \xf1 2 \xe6m +\xc4 ?"),
            ("cp437", b"L\x84ngslenker \xf1 2 \xe6m +\xc4 ?"),
            // Windows-1252 encodes ä as 0xE4, ± as 0xB1, µ as 0xB5.
            ("1252", b"L\xe4ngslenker \xb1 2 \xb5m +- ?"),
            ("windows-1252", b"L\xe4ngslenker \xb1 2 \xb5m +- ?"),
        ] {
            let page = CodePage::named(name).unwrap();
            assert_eq!(&*page.encode(text), wanted, "{name}");
            let mut out = Vec::new();
            Encoded::new(&mut out, page)
                .write_all(text.as_bytes())
                .unwrap();
            assert_eq!(out, wanted, "{name}");
        }
        for name in ["latin", "99", "1", "utf-16"] {
            assert!(CodePage::named(name).is_none(), "{name}");
        }
    }
}
