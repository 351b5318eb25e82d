use std::ops::Range;

use admire_syntax::diagnostic::Code;

use super::{ResultsError, StepKind};

/// One whole step of a results file: as many values as the file has columns.
#[derive(Clone, Copy, Debug)]
pub struct Step<'a> {
    pub(super) file: &'a str,
    /// Position among all steps of the file, from 0.
    pub index: usize,
    /// Kind of analysis.
    pub kind: StepKind,
    /// Name of the Data block it stands in, for example `quasiStatic_001`.
    pub block: &'a str,
    pub(super) values: Values<'a>,
}

/// The values of a step.
#[derive(Clone, Copy, Debug)]
pub(super) enum Values<'a> {
    /// As an XRF file spells them.
    Text {
        /// Offset in the file.
        offset: u64,
        /// What stands between the tags.
        text: &'a [u8],
    },
    /// In memory: element i belongs to id i + 1.
    Numbers(&'a [f64]),
}

impl<'a> Step<'a> {
    /// All values, replacing those in `values`: element i belongs to id i + 1.
    ///
    /// # Errors
    /// When something is not a number; the error tells where.
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

    /// The values of `ids`, which increase, appended to `values`. Reads no further than the last of them.
    ///
    /// # Errors
    /// When something is not a number or an id is none of the file; the error tells where.
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

    /// The text between the tags; empty where the values are in memory.
    pub(super) fn text(&self) -> &'a [u8] {
        match self.values {
            Values::Text { text, .. } => text,
            Values::Numbers(_) => &[],
        }
    }

    /// Offset of the text in the file.
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

/// The places of the numbers in the text of a step.
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

/// How many numbers a text holds: places where a blank, or the beginning, is followed by something else.
pub(super) fn count_tokens(text: &[u8]) -> usize {
    let Some((&first, rest)) = text.split_first() else {
        return 0;
    };
    // Sums of bytes in short runs let the compiler use wide registers.
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

/// A number as C libraries print it, infinities and NaN of a diverged run included.
pub(super) fn parse_number(token: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(token).ok()?;
    match text.parse() {
        Ok(value) => Some(value),
        Err(_) if text.contains('#') => {
            // Windows before 2015: 1.#INF, -1.#IND, 1.#QNAN.
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
