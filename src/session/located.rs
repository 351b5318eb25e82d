use std::fmt::Write as _;

use admire_syntax::Dataset;
use admire_syntax::diagnostic::{Diagnostic, Label};
use admire_syntax::text::{Source, Span};

use super::object_names::{ObjectNames, qualified};

/// Texts of all files to which diagnostics refer.
#[derive(Clone, Debug, Default)]
pub struct Sources {
    files: Vec<Source>,
    names: Option<ObjectNames>,
}

impl Sources {
    /// Adds a file; it replaces an earlier file with the same name.
    pub fn add(&mut self, source: Source) {
        self.files.retain(|known| known.name() != source.name());
        self.files.push(source);
    }

    /// Returns the file with this name.
    pub fn get(&self, name: &str) -> Option<&Source> {
        self.files.iter().find(|source| source.name() == name)
    }

    /// Sets the dataset that gives the names of the objects shown with diagnostics. It replaces an earlier dataset.
    pub(crate) fn name_objects(&mut self, dataset: &Dataset) {
        self.names = Some(ObjectNames::of(dataset));
    }

    /// Returns the name, as ADAMS prints it, of the object to which a diagnostic refers.
    fn object(&self, diagnostic: &Diagnostic) -> Option<String> {
        let named = |label| self.names.as_ref()?.at(label).map(str::to_string);
        if let Some(name) = diagnostic.labels.first().and_then(named) {
            return Some(name);
        }
        let view = diagnostic.object.as_ref()?.view.as_deref()?;
        Some(qualified(None, view))
    }

    /// Returns `file:line:column` for a label. Returns only the file if its text is not available or if the label refers to the whole file.
    pub fn place(&self, label: &Label) -> String {
        match self.get(&label.file) {
            Some(source) if !label.is_about_all() => {
                let at = source.line_column(label.span.start());
                format!("{}:{}:{}", label.file, at.line, at.column)
            }
            _ => label.file.to_string(),
        }
    }
}

/// Formats a diagnostic as plain text of several lines, which ends with a line end.
///
/// The first lines contain the location, the message, and the source line with a marker below it. Further labels, the name of the object in
/// the form of ADAMS, the help and the code follow.
pub fn located(diagnostic: &Diagnostic, sources: &Sources) -> String {
    let mut out = String::new();
    let mut put = |text: std::fmt::Arguments<'_>| {
        out.write_fmt(text)
            .expect("writing to a String does not fail");
    };
    match diagnostic.labels.first() {
        Some(label) => put(format_args!(
            "{}: {}\n",
            sources.place(label),
            diagnostic.message
        )),
        None => put(format_args!("{}\n", diagnostic.message)),
    }
    for (k, label) in diagnostic.labels.iter().enumerate() {
        if k > 0 {
            put(format_args!(
                "{}: {}\n",
                sources.place(label),
                label.message
            ));
        }
        let shown = sources.get(&label.file).filter(|_| !label.is_about_all());
        if let Some(source) = shown {
            let line = source.line_column(label.span.start()).line;
            let (text, before, width) = excerpt(source, label.span);
            let margin = line.to_string().len();
            let said = if k == 0 { label.message.as_str() } else { "" };
            let marks = format!("{}{} {said}", " ".repeat(before), "^".repeat(width));
            put(format_args!("  {line} | {text}\n"));
            put(format_args!("  {:margin$} | {}\n", "", marks.trim_end()));
        }
    }
    if let Some(object) = sources.object(diagnostic) {
        put(format_args!("  object: {object}\n"));
    }
    if let Some(help) = &diagnostic.help {
        put(format_args!("  help: {help}\n"));
    }
    put(format_args!("  [{}]\n", diagnostic.code));
    out
}

/// Returns the first line of a span, the number of characters before the span, and the number of characters in the span.
///
/// If the line is long, only a window around the start of the span is returned. Bytes that are not UTF-8 are decoded as Latin-1, and
/// control characters become blanks.
fn excerpt(source: &Source, span: Span) -> (String, usize, usize) {
    const WINDOW: usize = 100;
    let bytes = source.bytes();
    let start = span.start().min(bytes.len());
    let line_start = memchr::memrchr(b'\n', &bytes[..start]).map_or(0, |at| at + 1);
    let line_end =
        memchr::memchr2(b'\n', b'\r', &bytes[start..]).map_or(bytes.len(), |at| start + at);
    let from = line_start.max(start.saturating_sub(WINDOW));
    let to = line_end.min(start + WINDOW);
    let end = span.end().clamp(start, to);
    let (before, inside, after) = (
        shown(&bytes[from..start]),
        shown(&bytes[start..end]),
        shown(&bytes[end..to]),
    );
    let width = inside.chars().count().max(1);
    let count = before.chars().count();
    (format!("{before}{inside}{after}"), count, width)
}

/// Decodes bytes as one line of text. Bytes that are not UTF-8 are decoded as Latin-1, and control characters become blanks.
fn shown(bytes: &[u8]) -> String {
    let blank = |c: char| if c.is_control() { ' ' } else { c };
    match std::str::from_utf8(bytes) {
        Ok(text) => text.chars().map(blank).collect(),
        Err(_) => bytes.iter().map(|&byte| blank(char::from(byte))).collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_syntax::diagnostic::Code;

    #[test]
    fn the_place_is_marked_in_latin1_text_too() {
        let mut sources = Sources::default();
        sources.add(Source::new(
            "a.adm",
            &b"title\nMARKER/1, PART = 7 \xb7\n"[..],
        ));
        let diagnostic = Diagnostic::error(Code::UndefinedId, "no PART has the id 7")
            .label("a.adm", Span::new(23, 24), "referenced here")
            .help("define it");
        assert_eq!(
            located(&diagnostic, &sources),
            "a.adm:2:18: no PART has the id 7\n  2 | MARKER/1, PART = 7 ·\n    |                  ^ referenced here\n  help: \
             define it\n  [undefined-id]\n"
        );
    }

    #[test]
    fn spans_past_the_end_and_endless_lines_are_shown_in_part() {
        let mut sources = Sources::default();
        sources.add(Source::new("a.adm", vec![b'('; 1_000_000]));
        for span in [
            Span::new(500_000, 500_003),
            Span::at(1_000_000),
            Span::at(2_000_000),
        ] {
            let diagnostic = Diagnostic::error(Code::SyntaxError, "bad").label("a.adm", span, "");
            assert!(located(&diagnostic, &sources).len() < 600);
        }
    }
}
