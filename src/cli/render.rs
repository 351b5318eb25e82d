use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt;
use std::fmt::Write as _;

use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteSpanContents, SourceCode};
use serde_json::{Value, json};

use admire_session::Sources;
use admire_syntax::diagnostic::{Applicability, Diagnostic, Severity};
use admire_syntax::text::{Source, Span, masked, printable};

use super::annotations;
use super::format::Format;

/// Largest number of diagnostics shown; further diagnostics are only counted.
const SHOWN: usize = 200;

/// Formats diagnostics in the given format, with or without colours, within a width.
pub(super) fn diagnostics(
    diagnostics: &[Diagnostic],
    sources: &Sources,
    format: Format,
    colours: bool,
    width: usize,
) -> String {
    match format {
        Format::Text => graphical(diagnostics, sources, colours, width),
        Format::Plain => diagnostics
            .iter()
            .map(|d| printable(&plain(d, sources)).into_owned())
            .collect(),
        Format::Json => {
            let all: Vec<Value> = diagnostics.iter().map(|d| as_json(d, sources)).collect();
            let text = serde_json::to_string_pretty(&all).expect("JSON values print");
            printable(&(text + "\n")).into_owned()
        }
        Format::Sarif => printable(&annotations::sarif(diagnostics, sources)).into_owned(),
        Format::Github => printable(&annotations::github(diagnostics, sources)).into_owned(),
    }
}

fn severity_word(severity: Severity) -> &'static str {
    match severity {
        Severity::Note => "note",
        Severity::Warning => "warning",
        Severity::Error => "error",
    }
}

fn plain(diagnostic: &Diagnostic, sources: &Sources) -> String {
    let place = diagnostic
        .labels
        .first()
        .map(|label| sources.place(label) + ": ")
        .unwrap_or_default();
    format!(
        "{place}{}[{}]: {}\n",
        severity_word(diagnostic.severity),
        diagnostic.code,
        diagnostic.message
    )
}

fn as_json(diagnostic: &Diagnostic, sources: &Sources) -> Value {
    let labels: Vec<Value> = diagnostic
        .labels
        .iter()
        .map(|label| {
            let mut shown = json!({
                "file": &*label.file,
                "start": label.span.start(),
                "end": label.span.end(),
                "message": label.message,
            });
            if let Some(source) = sources.get(&label.file).filter(|_| !label.is_about_all()) {
                let (from, to) = (
                    source.line_column(label.span.start()),
                    source.line_column(label.span.end()),
                );
                shown["line"] = json!(from.line);
                shown["column"] = json!(from.column);
                shown["end_line"] = json!(to.line);
                shown["end_column"] = json!(to.column);
            }
            shown
        })
        .collect();
    let fix = diagnostic.fix.as_ref().map(|fix| {
        let edits: Vec<Value> = fix
            .edits
            .iter()
            .map(|edit| {
                json!({
                    "start": edit.span.start(),
                    "end": edit.span.end(),
                    "replacement": latin1(&edit.replacement),
                })
            })
            .collect();
        json!({
            "title": fix.title,
            "safe": fix.applicability == Applicability::Safe,
            "edits": edits,
        })
    });
    json!({
        "code": diagnostic.code.as_str(),
        "severity": severity_word(diagnostic.severity),
        "message": diagnostic.message,
        "labels": labels,
        "help": diagnostic.help,
        "fix": fix,
    })
}

fn graphical(diagnostics: &[Diagnostic], sources: &Sources, colours: bool, width: usize) -> String {
    let theme = if colours {
        GraphicalTheme::unicode()
    } else {
        GraphicalTheme::unicode_nocolor()
    };
    let handler = GraphicalReportHandler::new_themed(theme)
        .with_width(width)
        .with_links(false);
    let mut decoded: BTreeMap<String, Decoded> = BTreeMap::new();
    let mut out = String::new();
    for diagnostic in diagnostics.iter().take(SHOWN) {
        if let Some(label) = diagnostic.labels.first()
            && !decoded.contains_key(&*label.file)
            && let Some(source) = sources.get(&label.file)
            && source.bytes().len() < LARGEST_SHOWN
        {
            decoded.insert(label.file.to_string(), Decoded::new(source));
        }
        let shown = Shown::new(diagnostic, &decoded, sources);
        handler
            .render_report(&mut out, &shown)
            .expect("writing to a String does not fail");
        out.push('\n');
    }
    if diagnostics.len() > SHOWN {
        _ = writeln!(
            out,
            "messages that are not shown: {}",
            diagnostics.len() - SHOWN
        );
    }
    out
}

fn latin1(bytes: &[u8]) -> String {
    match std::str::from_utf8(bytes) {
        Ok(text) => text.to_string(),
        Err(_) => bytes.iter().map(|&byte| char::from(byte)).collect(),
    }
}

/// Diagnostic in the form that `miette` renders.
struct Shown<'a> {
    diagnostic: &'a Diagnostic,
    source: Option<&'a Decoded>,
    labels: Vec<LabeledSpan>,
    help: Option<String>,
}

impl<'a> Shown<'a> {
    fn new(
        diagnostic: &'a Diagnostic,
        decoded: &'a BTreeMap<String, Decoded>,
        sources: &Sources,
    ) -> Self {
        let first = diagnostic.labels.first();
        let source = first
            .filter(|label| !label.is_about_all())
            .and_then(|label| decoded.get(&*label.file));
        let mut labels = Vec::new();
        let mut help: Vec<String> = Vec::new();
        for (k, label) in diagnostic.labels.iter().enumerate() {
            let said = (!label.message.is_empty()).then(|| printable(&label.message).into_owned());
            match source {
                Some(source) if first.is_some_and(|f| f.file == label.file) => {
                    let span = source.span(label.span);
                    labels.push(if k == 0 {
                        LabeledSpan::new_primary_with_span(said, span)
                    } else {
                        LabeledSpan::new_with_span(said, span)
                    });
                }
                _ => {
                    let place = sources.place(label);
                    help.push(match said {
                        Some(said) => format!("{place}: {said}"),
                        None if label.is_about_all() => format!("file: {place}"),
                        None => format!("see {place}"),
                    });
                }
            }
        }
        help.extend(diagnostic.help.clone());
        if let Some(fix) = &diagnostic.fix {
            help.push(format!("fix: {}", fix.title));
        }
        Self {
            diagnostic,
            source,
            labels,
            help: (!help.is_empty()).then(|| printable(&help.join("\n")).into_owned()),
        }
    }
}

impl fmt::Debug for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Debug::fmt(self.diagnostic, f)
    }
}

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&printable(&self.diagnostic.message))
    }
}

impl std::error::Error for Shown<'_> {}

impl miette::Diagnostic for Shown<'_> {
    fn code<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        Some(Box::new(self.diagnostic.code))
    }

    fn severity(&self) -> Option<miette::Severity> {
        Some(match self.diagnostic.severity {
            Severity::Note => miette::Severity::Advice,
            Severity::Warning => miette::Severity::Warning,
            Severity::Error => miette::Severity::Error,
        })
    }

    fn help<'a>(&'a self) -> Option<Box<dyn fmt::Display + 'a>> {
        self.help.as_ref().map(|h| Box::new(h) as Box<_>)
    }

    fn source_code(&self) -> Option<&dyn SourceCode> {
        self.source.map(|source| source as &dyn SourceCode)
    }

    fn labels(&self) -> Option<Box<dyn Iterator<Item = LabeledSpan> + '_>> {
        (!self.labels.is_empty()).then(|| Box::new(self.labels.iter().cloned()) as Box<_>)
    }
}

/// File as UTF-8 text. If the file is not UTF-8, every byte is shown as its Latin-1 character.
struct Decoded {
    name: String,
    text: String,
    /// Original of a file that is not UTF-8. It serves to convert offsets in the file to offsets in `text`.
    original: Option<Source>,
}

/// Largest size in bytes of a file in which places are shown. In larger files, places are given by their line number only, because showing
/// them needs a copy of the text.
pub(super) const LARGEST_SHOWN: usize = 64 << 20;

/// Length from which only a part of a line around the place is shown.
const LONG_LINE: usize = 240;

impl Decoded {
    fn new(source: &Source) -> Self {
        let whole = Span::new(0, source.bytes().len());
        let (text, original) = match source.text(whole) {
            Cow::Borrowed(text) => (masked(text).into_owned(), None),
            Cow::Owned(text) => (masked(&text).into_owned(), Some(source.clone())),
        };
        Self {
            name: printable(source.name()).into_owned(),
            text,
            original,
        }
    }

    /// Converts a byte offset in the file to an offset in `text`, where a Latin-1 character above 127 takes two bytes.
    fn offset(&self, offset: usize) -> usize {
        let moved = match &self.original {
            None => offset,
            Some(source) => {
                let before = &source.bytes()[..offset.min(source.bytes().len())];
                before.len() + before.iter().filter(|byte| !byte.is_ascii()).count()
            }
        };
        self.boundary(moved)
    }

    /// Returns the last character boundary in `text` at or before an offset.
    fn boundary(&self, offset: usize) -> usize {
        let mut at = offset.min(self.text.len());
        while !self.text.is_char_boundary(at) {
            at -= 1;
        }
        at
    }

    fn span(&self, span: Span) -> miette::SourceSpan {
        let (start, end) = (self.offset(span.start()), self.offset(span.end()));
        (start, end.max(start) - start).into()
    }
}

impl SourceCode for Decoded {
    fn read_span<'a>(
        &'a self,
        span: &miette::SourceSpan,
        lines_before: usize,
        lines_after: usize,
    ) -> Result<Box<dyn miette::SpanContents<'a> + 'a>, miette::MietteError> {
        let bytes = self.text.as_bytes();
        let at = self.boundary(span.offset());
        let end = self.boundary(span.offset() + span.len());
        let line_start = |at: usize| memchr::memrchr(b'\n', &bytes[..at]).map_or(0, |k| k + 1);
        let line_end =
            |at: usize| memchr::memchr(b'\n', &bytes[at..]).map_or(bytes.len(), |k| at + k + 1);
        let (mut from, mut to) = (at, end);
        if lines_before + lines_after > 0 {
            from = line_start(at);
            to = line_end(end.max(at + 1).min(bytes.len()).max(1) - 1).max(end);
            if to - from > LONG_LINE {
                from = from.max(self.boundary(at.saturating_sub(LONG_LINE / 2)));
                to = to.min(self.boundary(at + LONG_LINE / 2)).max(from);
            } else {
                for _ in 0..lines_before {
                    let before = line_start(from.saturating_sub(1));
                    if from - before <= LONG_LINE {
                        from = before;
                    }
                }
                for _ in 0..lines_after {
                    let after = line_end(to);
                    if after - to <= LONG_LINE {
                        to = after;
                    }
                }
            }
        }
        let line = memchr::memchr_iter(b'\n', &bytes[..from]).count();
        let before = &self.text[line_start(from)..from];
        let column = match self.original {
            // Columns count bytes of the file, and each Latin-1 character was one byte there.
            Some(_) => before.chars().count(),
            None => before.len(),
        };
        let data = &bytes[from..to];
        let contents = MietteSpanContents::new_named(
            self.name.clone(),
            data,
            (from, to - from).into(),
            line,
            column,
            memchr::memchr_iter(b'\n', data).count(),
        );
        Ok(Box::new(contents))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_syntax::diagnostic::Code;
    use admire_syntax::text::Edit;

    fn sample() -> (Vec<Diagnostic>, Sources) {
        let text =
            &b"title \xb7\nPART/1, GROUND\nMARKER/1, PART = 7 ! \xb7 \xe9\nMARKER/1, PART = 1\n"[..];
        let mut sources = Sources::default();
        sources.add(Source::new("a.adm", text));
        let undefined = Diagnostic::error(Code::UndefinedId, "no PART has the id 7")
            .label("a.adm", Span::new(40, 41), "referenced here")
            .help("define PART/7")
            .fix(
                "use PART/1",
                vec![Edit::new(Span::new(40, 41), "1")],
                Applicability::MaybeIncorrect,
            );
        let twice = Diagnostic::warning(Code::DuplicateId, "MARKER/1 is defined twice")
            .label("a.adm", Span::new(55, 56), "again here")
            .label("a.adm", Span::new(30, 31), "first here")
            .label("b.acf", Span::new(3, 4), "used here");
        (vec![undefined, twice], sources)
    }

    #[test]
    fn the_three_formats() {
        let (found, sources) = sample();
        insta::assert_snapshot!(
            "text",
            diagnostics(&found, &sources, Format::Text, false, 100)
        );
        insta::assert_snapshot!(
            "plain",
            diagnostics(&found, &sources, Format::Plain, false, 100)
        );
        insta::assert_snapshot!(
            "json",
            diagnostics(&found, &sources, Format::Json, false, 100)
        );
    }

    #[test]
    fn any_span_of_any_text_is_shown() {
        let texts: [&[u8]; 5] = [
            b"",
            b"\n",
            b"a",
            b"\xff\xfe\n\xff",
            "\u{b7}\r\n\u{b7}".as_bytes(),
        ];
        let long = vec![b'x'; 100_000];
        for text in texts.into_iter().chain([&long[..]]) {
            let mut sources = Sources::default();
            sources.add(Source::new("a", text));
            for start in [0, 1, 2, 3, 50_000, 100_000, 200_000] {
                for len in [0, 1, 5] {
                    let d = Diagnostic::error(Code::SyntaxError, "bad").label(
                        "a",
                        Span::new(start, start + len),
                        "here",
                    );
                    let shown = diagnostics(&[d], &sources, Format::Text, false, 100);
                    assert!(shown.contains("bad") && shown.len() < 2000, "{shown}");
                }
            }
        }
    }
}
