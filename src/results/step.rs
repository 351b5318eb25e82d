use std::ops::Range;

use admire_syntax::diagnostic::Code;

use super::{ResultsError, StepKind};

/// One complete output step of a results file; it has one value for each column of the file.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    pub(super) file: &'a str,
    /// Position of the output step in the file, from 0.
    pub index: usize,
    /// Kind of analysis in which the step was computed.
    pub kind: StepKind,
    /// Name of the Data block that contains the step, for example `quasiStatic_001`.
    pub block: &'a str,
    pub(super) values: Values<'a>,
}

/// The values of an output step, as text or as numbers.
#[derive(Clone, Copy, Debug)]
pub(super) enum Values<'a> {
    /// Text of an XRF file, not yet parsed.
    Text {
        /// Offset of the text in the file, in bytes.
        offset: u64,
        /// Text between the opening and the closing tag of the step.
        text: &'a [u8],
    },
    /// Numbers in memory; the value at index i belongs to the column with id i + 1.
    Numbers(&'a [f64]),
}

impl<'a> Step<'a> {
    /// Replaces the content of `values` by all values of the output step; the value at index i belongs to the column with id i + 1.
    ///
    /// # Errors
    /// Returns an error with its position in the file if a token is not a number.
    pub fn values(&self, values: &mut Vec<f64>) -> Result<(), ResultsError> {
        values.clear();
        match self.values {
            Values::Numbers(numbers) => values.extend_from_slice(numbers),
            Values::Text { text, .. } => {
                for token in tokens(text) {
                    values.push(self.number(text, token)?);
                }
            }
        }
        Ok(())
    }

    /// Appends the values of the columns `ids`, which must be in increasing order, to `values`. The text is read only up to the last of
    /// these values.
    ///
    /// # Errors
    /// Returns an error with its position in the file if a token is not a number or an id does not exist.
    pub fn pick(&self, ids: &[usize], values: &mut Vec<f64>) -> Result<(), ResultsError> {
        let missing = |id: usize| {
            let message = format!("there is no column {id}");
            self.refused(Code::OutOfRange, 0..0, message)
        };
        let text = match self.values {
            Values::Text { text, .. } => text,
            Values::Numbers(numbers) => {
                for &id in ids {
                    let value = id.checked_sub(1).and_then(|at| numbers.get(at));
                    values.push(*value.ok_or_else(|| missing(id))?);
                }
                return Ok(());
            }
        };
        let mut all = tokens(text);
        let mut next = 1;
        for &id in ids {
            let token = id.checked_sub(next).and_then(|skip| all.nth(skip));
            values.push(self.number(text, token.ok_or_else(|| missing(id))?)?);
            next = id + 1;
        }
        Ok(())
    }

    /// Returns the text between the tags of the step, or an empty text if the values are in memory.
    pub(super) fn text(&self) -> &'a [u8] {
        match self.values {
            Values::Text { text, .. } => text,
            Values::Numbers(_) => &[],
        }
    }

    /// Returns the byte offset of the text in the file, or 0 if the values are in memory.
    pub(super) fn offset(&self) -> u64 {
        match self.values {
            Values::Text { offset, .. } => offset,
            Values::Numbers(_) => 0,
        }
    }

    fn number(&self, text: &[u8], token: Range<usize>) -> Result<f64, ResultsError> {
        parse_number(&text[token.clone()]).ok_or_else(|| {
            let shown = &text[token.start..token.end.min(token.start + 40)];
            let message = format!("`{}` is not a number", shown.escape_ascii());
            self.refused(Code::BadNumber, token.clone(), message)
        })
    }

    fn refused(&self, code: Code, token: Range<usize>, message: String) -> ResultsError {
        let (from, to) = (token.start as u64, token.end as u64);
        ResultsError::refused(
            code,
            self.file,
            self.offset() + from,
            self.offset() + to,
            message,
        )
    }
}

const fn is_blank(byte: u8) -> bool {
    byte <= b' '
}

/// Iterates over the byte ranges of the numbers in a text. Blanks and line ends separate the numbers.
pub(super) fn tokens(text: &[u8]) -> impl Iterator<Item = Range<usize>> {
    let mut at = 0;
    std::iter::from_fn(move || {
        while at < text.len() && is_blank(text[at]) {
            at += 1;
        }
        if at == text.len() {
            return None;
        }
        let from = at;
        while at < text.len() && !is_blank(text[at]) {
            at += 1;
        }
        Some(from..at)
    })
}

/// Returns the number of values in a text: the number of positions at which a non-blank byte follows a blank or begins the text.
pub(super) fn count_tokens(text: &[u8]) -> usize {
    let Some((&first, rest)) = text.split_first() else {
        return 0;
    };
    // Counts are summed as bytes over short runs, so that the compiler can use wide registers.
    let mut count = usize::from(!is_blank(first));
    for (before, after) in text.chunks(255).zip(rest.chunks(255)) {
        let starts: u8 = before
            .iter()
            .zip(after)
            .map(|(&b, &a)| u8::from(is_blank(b) & !is_blank(a)))
            .fold(0, u8::wrapping_add);
        count += usize::from(starts);
    }
    count
}

/// Parses a number as printed by C libraries. Infinities and NaN values, which a diverged run may contain, are accepted.
pub(super) fn parse_number(token: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(token).ok()?;
    match text.parse() {
        Ok(value) => Some(value),
        Err(_) if text.contains('#') => {
            // The C libraries of Windows before 2015 print 1.#INF, -1.#IND and 1.#QNAN.
            let negative = text.starts_with('-');
            let rest = text.trim_start_matches(['-', '+']);
            match rest.get(..5) {
                Some("1.#IN") if rest.starts_with("1.#INF") => Some(if negative {
                    f64::NEG_INFINITY
                } else {
                    f64::INFINITY
                }),
                Some("1.#IN" | "1.#QN" | "1.#SN") => Some(f64::NAN),
                _ => None,
            }
        }
        Err(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counting_finds_what_splitting_finds() {
        for text in ["", " ", "1", "\r\n0\r\n1 2  3\n", " -1.E+05\t7 "] {
            assert_eq!(
                count_tokens(text.as_bytes()),
                text.split_whitespace().count()
            );
        }
        let long = "12 3\n".repeat(1000);
        assert_eq!(count_tokens(long.as_bytes()), 2000);
    }

    #[test]
    fn numbers_of_diverged_runs_are_read() {
        assert_eq!(parse_number(b"-1.#INF"), Some(f64::NEG_INFINITY));
        assert!(parse_number(b"-1.#IND").unwrap().is_nan());
        assert!(parse_number(b"nan").unwrap().is_nan());
        assert_eq!(parse_number(b"1.E+05"), Some(1e5));
        assert_eq!(parse_number(b"3.5E-014"), Some(3.5e-14));
        assert_eq!(parse_number(b"1.#X"), None);
        assert_eq!(parse_number(b"abc"), None);
    }
}
