use std::ops::Range;

use crate::Statement;
use crate::diagnostic::{Code, Diagnostic};
use crate::lines::{comment_start, physical_line};
use crate::text::{Source, Span};

/// Diagnostics that comments in a file suppress.
///
/// `! admire: ignore[tab, unreferenced]` suppresses the listed codes for one statement, if it follows the statement or is on a line above
/// it. Without a list, all codes are suppressed. `! admire: ignore-file[tab]` suppresses the listed codes in the whole file.
#[derive(Clone, Debug, Default)]
pub struct Suppressed {
    silences: Vec<Silence>,
    /// Warnings about unknown codes in the suppressing comments.
    pub diagnostics: Vec<Diagnostic>,
}

#[derive(Clone, Debug)]
struct Silence {
    place: Range<usize>,
    whole_file: bool,
    /// Suppressed codes; `None` means that all codes are suppressed.
    codes: Option<Vec<Code>>,
}

impl Silence {
    fn covers(&self, code: Code) -> bool {
        let codes = self.codes.as_ref();
        codes.is_none_or(|codes| codes.contains(&code))
    }
}

/// First word of a suppressing comment.
const MARK: &[u8] = b"admire:";

impl Suppressed {
    /// Reads the suppressing comments of a file; `statements` are its statements or commands, in the order of the file.
    pub fn of(source: &Source, statements: &[Statement]) -> Self {
        let bytes = source.bytes();
        let mut found = Self::default();
        for at in memchr::memmem::find_iter(bytes, MARK) {
            let start = memchr::memrchr2(b'\n', b'\r', &bytes[..at]).map_or(0, |end| end + 1);
            let line = physical_line(bytes, start).span;
            let comment = start + comment_start(&bytes[line.range()]);
            let said = Span::new(at + MARK.len(), line.end());
            if comment >= at || !bytes[comment + 1..at].trim_ascii().is_empty() {
                continue;
            }
            let Some((whole_file, codes)) = found.words(source, said) else {
                continue;
            };
            let place = if whole_file {
                Some(0..bytes.len() + 1)
            } else {
                statement_of(statements, line, comment)
            };
            if let Some(place) = place {
                found.silences.push(Silence {
                    place,
                    whole_file,
                    codes,
                });
            }
        }
        found
    }

    /// Returns true if a comment in the file suppresses the diagnostic.
    pub fn covers(&self, diagnostic: &Diagnostic) -> bool {
        let label = diagnostic.labels.first();
        label.is_some_and(|label| self.covers_at(diagnostic.code, label.span.start()))
    }

    /// Returns true if a comment suppresses a code at an offset of the file.
    pub fn covers_at(&self, code: Code, offset: usize) -> bool {
        let here = |silence: &Silence| silence.place.contains(&offset);
        self.silences.iter().any(|s| here(s) && s.covers(code))
    }

    /// Returns true if a comment suppresses a code in the whole file.
    pub fn covers_file(&self, code: Code) -> bool {
        let mut silences = self.silences.iter();
        silences.any(|silence| silence.whole_file && silence.covers(code))
    }

    /// Parses the text after [`MARK`]; returns whether the comment applies to the whole file, and its codes (`None` means all).
    fn words(&mut self, source: &Source, said: Span) -> Option<(bool, Option<Vec<Code>>)> {
        let text = source.text(said);
        let text = text.trim();
        let rest = text.strip_prefix("ignore")?;
        let (whole_file, rest) = match rest.strip_prefix("-file") {
            Some(rest) => (true, rest),
            None => (false, rest),
        };
        let Some((list, _)) = rest
            .trim_start()
            .strip_prefix('[')
            .and_then(|list| list.split_once(']'))
        else {
            return Some((whole_file, None));
        };
        let mut codes = Vec::new();
        for word in list.split([',', ' ']).filter(|word| !word.is_empty()) {
            match Code::parse(word) {
                Some(code) => codes.push(code),
                None => self.diagnostics.push(
                    Diagnostic::warning(
                        Code::UnknownKey,
                        format!("`{word}` is not a message code, so nothing is ignored"),
                    )
                    .label(source.name(), said, "")
                    .help("each message shows its code, as in error[undefined-id]"),
                ),
            }
        }
        Some((whole_file, Some(codes)))
    }
}

/// Returns the byte range to which a comment applies: the statement that contains or precedes the comment, or else the next statement.
fn statement_of(statements: &[Statement], line: Span, comment: usize) -> Option<Range<usize>> {
    let behind = statements
        .iter()
        .rev()
        .skip_while(|statement| statement.span.start() > comment)
        .find(|statement| statement.span.end() > line.start())
        .filter(|statement| statement.span.start() < comment);
    let next = || {
        statements
            .iter()
            .find(|statement| statement.span.start() > comment)
    };
    let statement = behind.or_else(next)?;
    Some(statement.span.start()..statement.span.end() + 1)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dataset;
    use crate::lint::{Options, check};

    #[test]
    fn comments_silence_the_statement_they_stand_at() {
        let text = "t\nPART/1, GROUND\nMARKER/1, PART=8 ! admire: ignore[undefined-id]\n! admire: ignore\nMARKER/2, PART=8\nMARKER/3,\
                    \n! admire: ignore[tab]\n, PART=8\nMARKER/4, PART=8 ! \"admire: ignore\"\nEND ! admire: ignore[undefind-id]\n";
        let dataset = Dataset::parse(Source::new("a", text.as_bytes())).value;
        let suppressed = Suppressed::of(dataset.source(), dataset.statements());
        let left: Vec<String> = check(&dataset, &Options::default())
            .into_iter()
            .filter(|found| !suppressed.covers(found))
            .map(|found| found.message)
            .collect();
        assert_eq!(left.len(), 2, "{left:?}");
        assert!(left[0].starts_with("MARKER/3") && left[1].starts_with("MARKER/4"));
        assert_eq!(suppressed.diagnostics.len(), 1);
        let text = format!("{text}! admire: ignore-file[undefined-id]\n");
        let dataset = Dataset::parse(Source::new("a", text.as_bytes())).value;
        let suppressed = Suppressed::of(dataset.source(), dataset.statements());
        let found = check(&dataset, &Options::default());
        assert!(
            found.iter().all(|found| suppressed.covers(found)),
            "{found:?}"
        );
    }
}
