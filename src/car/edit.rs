//! Edits of single values. All other bytes are unchanged.

use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::number::parse_number;
use admire_syntax::property::{Cell, PropertyFile};
use admire_syntax::spell_like;
use admire_syntax::text::Edit;

use crate::entry::Entry;
use crate::settings::WRITTEN_DIGITS;

/// Returns the edits that replace the text of a value. A number is written as typed. A text keeps its quotes, and the blanks that pad it to the width
/// of its column.
///
/// # Errors
/// `bad-number` if a number would become something else; `wrong-type` if a text contains a quote, a line end or another control character, or if a
/// word without quotes would become several words.
pub fn set(file: &PropertyFile, entry: &Entry, text: &str) -> Result<Vec<Edit>, Diagnostic> {
    let span = entry.cell.span();
    let source = file.source();
    let refused = |code, message: String| {
        Err(Diagnostic::error(code, message).label(source.name(), span, ""))
    };
    let number = parse_number(text.trim().as_bytes());
    let is_number = number.is_some_and(|(value, degrees)| value.is_finite() && !degrees);
    match entry.cell {
        Cell::Number(_) if is_number => Ok(vec![Edit::new(span, text.trim().as_bytes())]),
        Cell::Number(_) => refused(
            Code::BadNumber,
            format!("{} is a number and cannot be `{text}`", entry.address),
        ),
        Cell::Text(_) => {
            let typed = text.trim();
            let inner = typed
                .strip_prefix('\'')
                .and_then(|rest| rest.strip_suffix('\''));
            let new = inner.unwrap_or(typed);
            if new.contains(|c: char| c == '\'' || c.is_control()) {
                let message = format!(
                    "{} cannot contain a quote or a control character",
                    entry.address
                );
                return refused(Code::WrongType, message);
            }
            let before = span.start().checked_sub(1);
            let is_quoted = before.is_some_and(|at| source.bytes().get(at) == Some(&b'\''));
            if is_quoted {
                if source.bytes().get(span.end()) != Some(&b'\'') {
                    let message = format!("{} has no closing quote", entry.address);
                    return refused(Code::WrongType, message);
                }
                let padded = padded(new, source.slice(span));
                return Ok(vec![Edit::new(span, source.encoded(&padded))]);
            }
            if span.is_empty() {
                let value = if is_number {
                    format!(" {new}")
                } else {
                    format!(" '{new}'")
                };
                return Ok(vec![Edit::new(span, source.encoded(&value))]);
            }
            let is_word = !new.is_empty()
                && !new.contains(|c: char| c.is_whitespace() || ",=$!'[](){}".contains(c));
            if is_word {
                Ok(vec![Edit::new(span, source.encoded(new))])
            } else {
                refused(
                    Code::WrongType,
                    format!(
                        "{} is a word without quotes and cannot be `{new}`",
                        entry.address
                    ),
                )
            }
        }
    }
}

/// Returns a text padded with blanks to the width of the old text, if the old text was padded.
fn padded(new: &str, old: &[u8]) -> String {
    let width = if old.last() == Some(&b' ') {
        old.len()
    } else {
        0
    };
    with_blanks(new, width)
}

/// Returns a text followed by blanks up to a number of characters. The width of a format string is limited, and a hostile file may need more.
pub(crate) fn with_blanks(text: &str, width: usize) -> String {
    let missing = width.saturating_sub(text.chars().count());
    format!("{text}{}", " ".repeat(missing))
}

/// Returns the edit that replaces a number. The new number has the spelling style of the old one.
///
/// # Errors
/// `bad-number` if the value is not finite; `wrong-type` if the present value is a text.
pub fn set_number(file: &PropertyFile, entry: &Entry, value: f64) -> Result<Vec<Edit>, Diagnostic> {
    let span = entry.cell.span();
    let refused = |code, message: String| {
        Err(Diagnostic::error(code, message).label(file.source().name(), span, ""))
    };
    match entry.cell {
        Cell::Text(_) => refused(
            Code::WrongType,
            format!("{} is a string, not a number", entry.address),
        ),
        Cell::Number(_) if !value.is_finite() => refused(
            Code::BadNumber,
            format!("{} must be a finite number, not {value}", entry.address),
        ),
        Cell::Number(number) => Ok(vec![Edit::new(
            number.span,
            spelled(value, file.source().slice(number.span)),
        )]),
    }
}

/// Formats a number in the style of an old one, with the number of digits that files of Adams/Car contain.
pub(crate) fn spelled(value: f64, old: &[u8]) -> String {
    spell_like(rounded(value), old)
}

/// Rounds a number to the digits that are written.
pub(crate) fn rounded(value: f64) -> f64 {
    format!("{value:.*e}", WRITTEN_DIGITS - 1)
        .parse()
        .unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::entry::{entries, select};
    use admire_syntax::text::{Source, apply_edits};
    use proptest::prelude::*;

    fn changed(text: &[u8], address: &str, value: &str) -> Result<Vec<u8>, Code> {
        let file = PropertyFile::parse(Source::new("a.sub", text)).value;
        let entry = select(&file, address).expect("an address").remove(0);
        let edits = set(&file, &entry, value).map_err(|refused| refused.code)?;
        Ok(apply_edits(text, &edits).expect("one place"))
    }

    #[test]
    fn only_the_bytes_of_the_value_change() {
        let text = b"[A]\r\n X\t=  1.50  $ caf\xe9\r\n T = 'ab   '\r\n W = word ! note\r\n E =\r\n";
        for (address, value, old, new) in [
            ("A.X", "2", "1.50", "2"),
            ("A.T", "abc", "'ab   '", "'abc  '"),
            ("A.T", "'longer'", "'ab   '", "'longer'"),
            ("A.W", "other", "word", "other"),
            ("A.E", "5", "E =", "E = 5"),
            ("A.E", "a b", "E =", "E = 'a b'"),
        ] {
            let text: String = text.iter().map(|byte| char::from(*byte)).collect();
            let expected = text.replace(old, new);
            let bytes: Vec<u8> = text.chars().map(|c| c as u8).collect();
            let got = changed(&bytes, address, value).expect("a change");
            let got: String = got.iter().map(|byte| char::from(*byte)).collect();
            assert_eq!(got, expected, "{address}");
        }
        // A Latin-1 file stays Latin-1.
        let new = changed(text, "A.T", "\u{e9}").expect("a change");
        assert!(new.windows(3).any(|bytes| bytes == b"'\xe9 "));
    }

    #[test]
    fn a_text_with_a_hundred_thousand_blanks_is_edited() {
        let text = format!("[A]\nT = 'a{}'\n", " ".repeat(100_000));
        let new = changed(text.as_bytes(), "A.T", "b").expect("a change");
        assert_eq!(new.len(), text.len());
    }

    #[test]
    fn what_would_break_the_line_is_refused() {
        let text = b"[A]\nX = 1\nT = 'a'\nW = w\n";
        for (address, value, code) in [
            ("A.X", "one", Code::BadNumber),
            ("A.X", "1e999", Code::BadNumber),
            ("A.X", "10D", Code::BadNumber),
            ("A.X", "", Code::BadNumber),
            ("A.T", "it's", Code::WrongType),
            ("A.T", "a\nb", Code::WrongType),
            ("A.W", "a b", Code::WrongType),
            ("A.W", "", Code::WrongType),
        ] {
            assert_eq!(
                changed(text, address, value),
                Err(code),
                "{address}={value}"
            );
        }
    }

    proptest! {
        /// In any file, an accepted edit of one value preserves the number and the addresses of all other values.
        #[test]
        fn an_edit_changes_one_value_of_any_file(
            lines in prop::collection::vec("[\\[\\](){}'$!= ,a-c1.\\-\u{e9}]{0,12}", 0..12),
            which in any::<prop::sample::Index>(),
            value in "[a1.' ]{0,4}",
        ) {
            let text = lines.join("\n").into_bytes();
            let file = PropertyFile::parse(Source::new("a", text.as_slice())).value;
            let before = entries(&file);
            if let Some(entry) = (!before.is_empty()).then(|| &before[which.index(before.len())])
                && let Ok(edits) = set(&file, entry, &value)
            {
                let new = apply_edits(&text, &edits).expect("one place");
                let after = PropertyFile::parse(Source::new("a", new)).value;
                prop_assert_eq!(entries(&after).len(), before.len());
            }
        }
    }
}
