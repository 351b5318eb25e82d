use std::cell::RefCell;
use std::collections::BTreeSet;
use std::ops::RangeInclusive;

use toml::de::{DeTable, DeValue};

use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Source, Span};

/// A text value from `study.toml` with its position in the file. Names in it are resolved in the deck later.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct SpannedText {
    /// Text as written in the file.
    pub text: String,
    /// Position of the text in `study.toml`.
    pub span: Span,
}

/// Type of the value of a key in `study.toml`.
#[derive(Clone, PartialEq, Debug)]
pub(crate) enum ValueType {
    /// A table with further keys.
    Table,
    /// A text.
    Text,
    /// A number between these bounds, both included. A tiny positive lower bound means "more than zero".
    Number(f64, f64),
    /// A whole number between these bounds, both included.
    Count(usize, usize),
    /// One of these words.
    Choice(Vec<&'static str>),
    /// A list of texts.
    Texts,
    /// A table with user-defined names as keys, each with a text.
    OwnTexts,
    /// True or false.
    Flag,
    /// A number, or a text with a number and its unit.
    Quantity,
    /// A lower and an upper bound, each as [`Self::Quantity`].
    Bounds,
    /// A list of numbers.
    Numbers,
    /// Any number of tables with the same keys.
    Tables,
}

/// A key of `study.toml` that the program reads.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Key {
    /// Full name of the key, with dots between its components. The component `NAME` stands for a user-defined name.
    pub path: String,
    /// Type of the value.
    pub holds: ValueType,
}

/// Recorder of all keys that are queried while `study.toml` is read. The JSON Schema is generated from the recorded keys.
#[derive(Default)]
pub(super) struct SchemaRecorder {
    /// Result that [`Section::is_text`] returns while keys are recorded.
    pub texts: bool,
    /// Recorded keys, in the order in which they were queried.
    pub keys: RefCell<Vec<Key>>,
}

/// One table of `study.toml`. It remembers which keys were queried, so unknown keys can be reported.
pub(super) struct Section<'a> {
    source: &'a Source,
    path: String,
    table: Option<&'a DeTable<'a>>,
    span: Span,
    asked: BTreeSet<&'static str>,
    inquiry: Option<&'a SchemaRecorder>,
}

impl<'a> Section<'a> {
    /// Creates a section without contents that records every queried key in `inquiry`.
    pub(crate) fn inquiring(source: &'a Source, inquiry: &'a SchemaRecorder) -> Self {
        Self {
            source,
            path: String::new(),
            table: None,
            span: Span::at(0),
            asked: BTreeSet::new(),
            inquiry: Some(inquiry),
        }
    }

    /// Records a queried key with the type of its value, unless it has been recorded already.
    pub(super) fn note(&self, key: &str, holds: ValueType) {
        let Some(inquiry) = self.inquiry else { return };
        let key = Key {
            path: self.name(key),
            holds,
        };
        let mut keys = inquiry.keys.borrow_mut();
        if !keys.contains(&key) {
            keys.push(key);
        }
    }

    /// Creates the section for the whole file.
    pub(crate) fn root(source: &'a Source, table: &'a DeTable<'a>) -> Self {
        Self {
            source,
            path: String::new(),
            table: Some(table),
            span: Span::new(0, source.bytes().len().min(1)),
            asked: BTreeSet::new(),
            inquiry: None,
        }
    }

    /// Returns true if the file contains this table. While keys are recorded, always returns true.
    pub(crate) fn is_present(&self) -> bool {
        self.table.is_some() || self.inquiry.is_some()
    }

    /// Returns true if this table has a key.
    pub(super) fn has(&self, key: &str) -> bool {
        self.table.is_some_and(|table| table.contains_key(key))
    }

    /// Returns true while keys are recorded.
    pub(super) fn is_inquiry(&self) -> bool {
        self.inquiry.is_some()
    }

    /// Returns all tables of a key, written `[[section.key]]`. A value of another type is reported.
    pub(super) fn tables(
        &mut self,
        key: &'static str,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Vec<Section<'a>> {
        self.note(key, ValueType::Tables);
        let path = self.name(key);
        let section = |table, span, inquiry| Section {
            source: self.source,
            path: path.clone(),
            table,
            span,
            asked: BTreeSet::new(),
            inquiry,
        };
        if self.inquiry.is_some() {
            return vec![section(None, self.span, self.inquiry)];
        }
        let Some(value) = self.table.and_then(|table| table.get(key)) else {
            self.asked.insert(key);
            return Vec::new();
        };
        let mut found = Vec::new();
        let mut all_tables = true;
        for item in value.get_ref().as_array().into_iter().flatten() {
            let table = item.get_ref().as_table();
            all_tables &= table.is_some();
            found.push(section(table, Span::from(item.span()), None));
        }
        if !all_tables || value.get_ref().as_array().is_none() {
            let expected = format!("tables, each beginning with [[{path}]]");
            self.wrong(key, Span::from(value.span()), &expected, diagnostics);
        }
        self.asked.insert(key);
        found
    }

    /// Returns the position of the table in the file.
    pub(crate) fn span(&self) -> Span {
        self.span
    }

    /// Returns the name of the file that contains this table.
    pub(crate) fn file(&self) -> &'a str {
        self.source.name()
    }

    /// Returns the full name of a key of this table.
    pub(crate) fn name(&self, key: &str) -> String {
        if self.path.is_empty() {
            key.to_string()
        } else {
            format!("{}.{key}", self.path)
        }
    }

    pub(super) fn get(&mut self, key: &'static str) -> Option<(&'a DeValue<'a>, Span)> {
        self.asked.insert(key);
        let value = self.table?.get(key)?;
        Some((value.get_ref(), Span::from(value.span())))
    }

    /// Reports that the value of a key in this table is not what is expected.
    pub(crate) fn wrong(
        &self,
        key: &str,
        span: Span,
        expected: &str,
        diagnostics: &mut Vec<Diagnostic>,
    ) {
        diagnostics.push(
            Diagnostic::error(
                Code::BadSetting,
                format!("`{}` must be {expected}", self.name(key)),
            )
            .label(self.source.name(), span, ""),
        );
    }

    /// Reports that this table has no key `marker` with the marker of the wheel.
    pub(crate) fn missing_marker(&self, diagnostics: &mut Vec<Diagnostic>) {
        let message = format!("`{}` is missing", self.name("marker"));
        diagnostics.push(
            Diagnostic::error(Code::MissingSetting, message)
                .label(self.source.name(), self.span(), "")
                .help("give the marker at the wheel centre, for example marker = \"MARKER/20\""),
        );
    }

    /// Returns the table that is the value of a key. If it is absent, an empty section is returned.
    pub(crate) fn section(
        &mut self,
        key: &'static str,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Section<'a> {
        self.note(key, ValueType::Table);
        let path = self.name(key);
        let found = self.get(key);
        let mut table = None;
        let mut span = self.span;
        if let Some((value, at)) = found {
            span = at;
            table = value.as_table();
            if table.is_none() {
                self.wrong(key, at, "a table", diagnostics);
            }
        }
        Section {
            source: self.source,
            path,
            table,
            span,
            asked: BTreeSet::new(),
            inquiry: self.inquiry,
        }
    }

    /// Returns the value of a key as a text; `None` if the key is absent. A value of another type is reported.
    pub(crate) fn text(
        &mut self,
        key: &'static str,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<SpannedText> {
        self.note(key, ValueType::Text);
        let (value, span) = self.get(key)?;
        let Some(text) = value.as_str() else {
            self.wrong(key, span, "a string in quotes", diagnostics);
            return None;
        };
        Some(SpannedText {
            text: text.to_string(),
            span,
        })
    }

    /// Returns the value of a key as a finite number in a range, or the default.
    pub(crate) fn number(
        &mut self,
        key: &'static str,
        default: f64,
        range: RangeInclusive<f64>,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> f64 {
        self.optional_number(key, range, diagnostics)
            .unwrap_or(default)
    }

    /// Returns the value of a key as a finite number in a range, if given.
    pub(crate) fn optional_number(
        &mut self,
        key: &'static str,
        range: RangeInclusive<f64>,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<f64> {
        let (least, most) = range.into_inner();
        self.note(key, ValueType::Number(least, most));
        let (value, span) = self.get(key)?;
        let number = number_of(value);
        match number {
            Some(number) if number >= least && number <= most => Some(number),
            _ => {
                self.wrong(key, span, &range_in_words(least, most), diagnostics);
                None
            }
        }
    }

    /// Returns the value of a key as a positive standard deviation; `None` if the key is absent. Zero is reported as an error, because readings
    /// without noise would have infinite weight.
    pub(crate) fn deviation(
        &mut self,
        key: &'static str,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<f64> {
        self.note(key, ValueType::Number(f64::MIN_POSITIVE, f64::INFINITY));
        let (value, span) = self.get(key)?;
        if number_of(value) != Some(0.0) {
            return self.optional_number(key, f64::MIN_POSITIVE..=f64::INFINITY, diagnostics);
        }
        let name = self.name(key);
        diagnostics.push(
            Diagnostic::error(Code::BadSetting, format!("`{name}` must be more than 0"))
                .label(self.source.name(), span, "")
                .help(
                    "for readings without noise, write 1e-4; without the key, the noise is estimated from the marks",
                ),
        );
        None
    }

    /// Returns the value of a key as a whole number in a range, or the default.
    pub(crate) fn count(
        &mut self,
        key: &'static str,
        default: usize,
        range: RangeInclusive<usize>,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> usize {
        let (least, most) = range.into_inner();
        self.note(key, ValueType::Count(least, most));
        let Some((value, span)) = self.get(key) else {
            return default;
        };
        match value.as_integer().and_then(|i| i.as_str().parse().ok()) {
            Some(count) if (least..=most).contains(&count) => count,
            _ => {
                let expected = format!("a whole number from {least} to {most}");
                self.wrong(key, span, &expected, diagnostics);
                default
            }
        }
    }

    /// Returns the choice that belongs to the keyword given as the value of a key. If the key is absent or its value is reported as wrong,
    /// returns the default.
    pub(crate) fn choice<T: Copy>(
        &mut self,
        key: &'static str,
        default: T,
        words: &[(&'static str, T)],
        diagnostics: &mut Vec<Diagnostic>,
    ) -> T {
        self.note(
            key,
            ValueType::Choice(words.iter().map(|(word, _)| *word).collect()),
        );
        let Some((value, span)) = self.get(key) else {
            return default;
        };
        let found = value
            .as_str()
            .and_then(|text| words.iter().find(|(word, _)| *word == text));
        if let Some((_, choice)) = found {
            return *choice;
        }
        let names: Vec<String> = words
            .iter()
            .map(|(word, _)| format!("\"{word}\""))
            .collect();
        self.wrong(key, span, &names.join(" or "), diagnostics);
        default
    }

    /// Returns the value of a key as a list of texts; `None` if the key is absent. Items of other types are reported.
    pub(crate) fn texts(
        &mut self,
        key: &'static str,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<Vec<SpannedText>> {
        self.note(key, ValueType::Texts);
        let (value, span) = self.get(key)?;
        let Some(array) = value.as_array() else {
            self.wrong(key, span, "a list of strings", diagnostics);
            return None;
        };
        let mut texts = Vec::new();
        for item in array {
            let at = Span::from(item.span());
            match item.get_ref().as_str() {
                Some(text) => texts.push(SpannedText {
                    text: text.to_string(),
                    span: at,
                }),
                None => self.wrong(key, at, "a list of strings", diagnostics),
            }
        }
        Some(texts)
    }

    /// Returns all keys of this table with their text values, in the order of the file. Values of other types are reported.
    pub(crate) fn all_texts(
        &mut self,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Vec<(SpannedText, SpannedText)> {
        self.note("NAME", ValueType::OwnTexts);
        let mut found = Vec::new();
        for (key, value) in self.entries() {
            match value.0.as_str() {
                Some(text) => found.push((
                    key,
                    SpannedText {
                        text: text.to_string(),
                        span: value.1,
                    },
                )),
                None => self.wrong(&key.text, value.1, "a string in quotes", diagnostics),
            }
        }
        found
    }

    /// Returns all keys of this table with their values as sections, in the order of the file. Values that are not tables are reported.
    pub(crate) fn all_sections(
        &mut self,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Vec<(SpannedText, Section<'a>)> {
        let mut found = Vec::new();
        if self.inquiry.is_some() {
            let key = SpannedText {
                text: "NAME".to_string(),
                span: self.span,
            };
            found.push((key, self.section("NAME", diagnostics)));
        }
        for (key, (value, span)) in self.entries() {
            if value.as_table().is_none() {
                self.wrong(&key.text, span, "a table", diagnostics);
            }
            let section = Section {
                source: self.source,
                path: self.name(&key.text),
                table: value.as_table(),
                span,
                asked: BTreeSet::new(),
                inquiry: self.inquiry,
            };
            found.push((key, section));
        }
        found
    }

    /// Returns true if the value of a key is a text.
    pub(crate) fn is_text(&mut self, key: &'static str) -> bool {
        if let Some(inquiry) = self.inquiry {
            return inquiry.texts;
        }
        self.get(key).is_some_and(|(value, _)| value.is_str())
    }

    fn entries(&self) -> Vec<(SpannedText, (&'a DeValue<'a>, Span))> {
        let mut entries: Vec<_> = self
            .table
            .into_iter()
            .flat_map(|table| table.iter())
            .map(|(key, value)| {
                let spelled = SpannedText {
                    text: key.get_ref().to_string(),
                    span: Span::from(key.span()),
                };
                (spelled, (value.get_ref(), Span::from(value.span())))
            })
            .collect();
        entries.sort_by_key(|(key, _)| key.span.start());
        entries
    }

    /// Reports all keys of this table that no query has used.
    pub(crate) fn finish(self, diagnostics: &mut Vec<Diagnostic>) {
        for (key, _) in self.entries() {
            if self.asked.contains(key.text.as_str()) {
                continue;
            }
            let help = if let Some(near) = nearest(&key.text, self.asked.iter().copied()) {
                format!("did you mean `{}`?", self.name(near))
            } else {
                let known: Vec<&str> = self.asked.iter().copied().collect();
                format!("the keys here are {}", known.join(", "))
            };
            diagnostics.push(
                Diagnostic::error(
                    Code::UnknownKey,
                    format!("`{}` is not a key of study.toml", self.name(&key.text)),
                )
                .label(self.source.name(), key.span, "")
                .help(help),
            );
        }
    }
}

/// Returns the position of the value of `key` in a section of a TOML text; `None` if the value is no number.
pub(super) fn number_span(text: &str, section: &str, key: &str) -> Option<Span> {
    let (document, _) = DeTable::parse_recoverable(text);
    let value = document
        .get_ref()
        .get(section)?
        .get_ref()
        .as_table()?
        .get(key)?;
    number_of(value.get_ref()).map(|_| Span::from(value.span()))
}

pub(super) fn number_of(value: &DeValue<'_>) -> Option<f64> {
    let text = match value {
        DeValue::Float(float) => float.as_str(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str(),
        _ => return None,
    };
    text.parse().ok().filter(|number: &f64| number.is_finite())
}

/// Returns a TOML text in which `key` of a section has the given numerical value. The key is added if it is absent. The section must exist.
pub fn with_number(text: &str, section: &str, key: &str, value: f64) -> String {
    let mut changed = text.to_string();
    if let Some(span) = number_span(text, section, key) {
        changed.replace_range(span.range(), &format!("{value:?}"));
        return changed;
    }
    let header = format!("[{section}]");
    changed.replacen(&header, &format!("{header}\n{key} = {value:?}"), 1)
}

/// Describes the range of a number in words. A tiny positive lower bound reads "more than 0".
fn range_in_words(least: f64, most: f64) -> String {
    match (least > 0.0 && least < 1e-6, most.is_finite()) {
        (true, true) => format!("a number above 0 and at most {most}"),
        (true, false) => "a number more than 0".to_string(),
        (false, true) => format!("a number from {least} to {most}"),
        (false, false) => format!("a number, {least} or more"),
    }
}

/// Returns the help text for an unknown name `word`: the most similar known name, or a list of the known names in `there`. `place` describes
/// where these names exist.
///
/// A similar name must contain the same digits: `BUSHING/3` is not a misspelling of `BUSHING/2`.
pub fn did_you_mean(word: &str, place: &str, there: &[String]) -> String {
    const SHOWN: usize = 8;
    let digits = |text: &str| -> String { text.chars().filter(char::is_ascii_digit).collect() };
    let alike = there
        .iter()
        .map(String::as_str)
        .filter(|name| digits(name) == digits(word));
    if let Some(near) = nearest(word, alike) {
        return format!("did you mean `{near}`?");
    }
    // If addresses are among the known names, plain names are compared but not listed.
    let listed =
        |name: &&String| name.contains('/') || !there.iter().any(|name| name.contains('/'));
    let there: Vec<&str> = there.iter().filter(listed).map(String::as_str).collect();
    let names = there[..there.len().min(SHOWN)].join(", ");
    match there.len() {
        0 => format!("{place} has none"),
        n if n > SHOWN => format!("{place} has {names} and {} more", n - SHOWN),
        _ => format!("{place} has {names}"),
    }
}

/// Returns the candidate that is most similar to `word`, if they differ by only a few letters.
pub(super) fn nearest<'a>(
    word: &str,
    candidates: impl Iterator<Item = &'a str>,
) -> Option<&'a str> {
    candidates
        .map(|candidate| (letters_apart(word, candidate), candidate))
        .filter(|(apart, candidate)| *apart <= 1 + candidate.len() / 4)
        .min()
        .map(|(_, candidate)| candidate)
}

/// Returns the edit distance (Levenshtein distance) between two words, ignoring case.
fn letters_apart(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.to_lowercase().chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.to_lowercase().chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}
