//! Mappings, which describe the columns of a laboratory's tables. They are read from TOML.

use std::collections::BTreeMap;

use serde::Deserialize;
use toml::Spanned;

use super::block::Block;
use super::characteristic::{Characteristic, Target};
use super::column::Column;
use super::file_options::FileOptions;
use super::heading::folded;
use super::named_test::NamedTest;
use super::quantity::Quantity;
use super::sheet::Sheet;
use super::words;
use admire_kc::{Side, TestKind};
use admire_session::read_toml;
use admire_study::did_you_mean;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::text::{Source, Span};

/// Mapping of a laboratory's tables: file options, content of the columns, and the laboratory's words for tests and sides.
#[derive(Clone, Default, PartialEq, Debug)]
pub struct Mapping {
    /// Options for reading the files.
    pub file: FileOptions,
    /// Columns to import. All others are left out.
    pub columns: Vec<Column>,
    /// The laboratory's words for tests. They occur in a column, in a title or as the name of a sheet.
    pub tests: Vec<(String, NamedTest)>,
    /// The laboratory's words for the sides of the vehicle, in a column.
    pub sides: Vec<(String, Side)>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct MappingFile {
    #[serde(default)]
    file: FileTable,
    #[serde(default)]
    columns: BTreeMap<Spanned<String>, Spanned<ColumnTable>>,
    #[serde(default)]
    tests: BTreeMap<Spanned<String>, Spanned<String>>,
    #[serde(default)]
    sides: BTreeMap<Spanned<String>, Spanned<String>>,
}

#[derive(Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct FileTable {
    sheet: Option<String>,
    header: Option<Spanned<HeaderLines>>,
    units: Option<usize>,
    delimiter: Option<Spanned<String>>,
    decimal: Option<Spanned<String>>,
    test: Option<Spanned<String>>,
    side: Option<Spanned<String>>,
    every: Option<usize>,
}

/// Number of the heading line, or numbers of two lines that are joined.
#[derive(Deserialize)]
#[serde(untagged)]
enum HeaderLines {
    One(usize),
    Several(Vec<usize>),
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ColumnTable {
    is: Option<Spanned<String>>,
    load: Option<Spanned<String>>,
    load_sign: Option<Spanned<String>>,
    side: Option<Spanned<String>>,
    unit: Option<Spanned<String>>,
    positive: Option<Spanned<String>>,
    over_mm: Option<Spanned<f64>>,
}

/// Collector of diagnostics about one file.
struct Complaints<'a> {
    source: &'a Source,
    all: Vec<Diagnostic>,
}

impl Complaints<'_> {
    fn wrong(&mut self, at: std::ops::Range<usize>, message: String, help: String) {
        let wrong = Diagnostic::error(Code::BadSetting, message);
        let wrong = wrong.label(self.source.name(), Span::from(at), "");
        self.all.push(wrong.help(help));
    }

    /// Returns the value that a word names, or reports the word.
    fn choice<T>(
        &mut self,
        word: Option<&Spanned<String>>,
        key: &str,
        known: &[&str],
        find: impl Fn(&str) -> Option<T>,
    ) -> Option<T> {
        let word = word?;
        let found = find(word.get_ref());
        if found.is_none() {
            let names: Vec<String> = known.iter().map(|name| (*name).to_string()).collect();
            self.wrong(
                word.span(),
                format!("`{}` is not a value of `{key}`", word.get_ref()),
                did_you_mean(word.get_ref(), &format!("`{key}`"), &names),
            );
        }
        found
    }
}

/// Returns the side with this name.
pub(crate) fn side_named(word: &str) -> Option<Side> {
    Side::BOTH.into_iter().find(|side| side.word() == word)
}

/// Returns the test with this name.
fn test_named(word: &str) -> Option<TestKind> {
    TestKind::ALL.into_iter().find(|kind| kind.name() == word)
}

impl Mapping {
    /// Reads a mapping. Unknown keys and words are reported with their places; the value is then `None`.
    pub fn read(source: &Source) -> Checked<Option<Self>> {
        let file: MappingFile = match read_toml(source, Code::BadSetting) {
            Ok(file) => file,
            Err(wrong) => {
                return Checked {
                    value: None,
                    diagnostics: vec![wrong.help("`admire guide kc` shows every key of a mapping")],
                };
            }
        };
        let mut out = Complaints {
            source,
            all: Vec::new(),
        };
        let tests = TestKind::ALL.map(TestKind::name);
        let known: Vec<&str> = tests.into_iter().chain([NamedTest::SKIP]).collect();
        let sides = Side::BOTH.map(Side::word);
        let mark = |text: &str| match *text.as_bytes() {
            [byte] if byte.is_ascii() => Some(byte),
            _ => None,
        };
        let own = &file.file;
        let options = FileOptions {
            sheet: own.sheet.clone(),
            header: match own.header.as_ref().map(Spanned::get_ref) {
                None => Vec::new(),
                Some(HeaderLines::One(line)) => vec![*line],
                Some(HeaderLines::Several(lines)) => lines.clone(),
            },
            units: own.units,
            delimiter: out.choice(own.delimiter.as_ref(), "delimiter", &[";", ","], mark),
            decimal: out.choice(own.decimal.as_ref(), "decimal", &[".", ","], |text| {
                mark(text).filter(|mark| [b'.', b','].contains(mark))
            }),
            test: out.choice(own.test.as_ref(), "test", &tests, test_named),
            side: out.choice(own.side.as_ref(), "side", &sides, side_named),
            every: own.every.unwrap_or(1),
        };
        if let Some(header) = &own.header
            && options.header.is_empty()
        {
            let message = "`file.header` must be the number of a line, or a list of numbers";
            out.wrong(header.span(), message.to_string(), "header = 3".to_string());
        }
        let mut columns: Vec<Column> = file
            .columns
            .iter()
            .map(|(name, table)| column(name, table, &mut out))
            .collect();
        columns.sort_by_key(|column| column.span.map(Span::start));
        let named = |(word, value): (&Spanned<String>, &Spanned<String>),
                     out: &mut Complaints<'_>| {
            let kind = out.choice(Some(value), "tests", &known, NamedTest::named)?;
            Some((word.get_ref().clone(), kind))
        };
        let all_tests = file.tests.iter().filter_map(|pair| named(pair, &mut out));
        let all_tests = all_tests.collect();
        let named = |(word, value): (&Spanned<String>, &Spanned<String>),
                     out: &mut Complaints<'_>| {
            let side = out.choice(Some(value), "sides", &sides, side_named)?;
            Some((word.get_ref().clone(), side))
        };
        let all_sides = file.sides.iter().filter_map(|pair| named(pair, &mut out));
        let all_sides = all_sides.collect();
        let mapping = Self {
            file: options,
            columns,
            tests: all_tests,
            sides: all_sides,
        };
        Checked {
            value: out.all.is_empty().then_some(mapping),
            diagnostics: out.all,
        }
    }

    /// Returns the test for a word of the laboratory, or for an unambiguous name.
    pub(crate) fn test(&self, word: &str) -> Option<NamedTest> {
        let asked = folded(word);
        let own = self.tests.iter().find(|(own, _)| folded(own) == asked);
        own.map(|(_, kind)| *kind)
            .or_else(|| words::test(word).map(NamedTest::Test))
    }

    /// Returns the side for a word of the laboratory, or for an unambiguous name.
    pub(crate) fn side(&self, word: &str) -> Option<Side> {
        let asked = folded(word);
        let own = self.sides.iter().find(|(own, _)| folded(own) == asked);
        own.map(|(_, side)| *side).or_else(|| words::side(word))
    }

    /// Returns the test of a block. In this order, it is the test stated for the block, the test in the last title that names one, the test in the
    /// name of the sheet, or the test stated for the whole file.
    pub(crate) fn test_of_block(&self, block: &Block, sheets: &[Sheet]) -> Option<NamedTest> {
        let sheet = sheets[block.sheet].name.as_deref();
        let of_title = |text: &str| {
            let behind = text.rsplit_once(':').map(|(_, name)| name.trim());
            self.test(text).or_else(|| self.test(behind?))
        };
        let mut titles = block.titles.iter().rev();
        let stated = block.test.map(NamedTest::Test);
        stated
            .or_else(|| titles.find_map(|cell| of_title(&cell.text)))
            .or_else(|| self.test(sheet?))
            .or_else(|| self.file.test.map(NamedTest::Test))
    }
}

fn column(
    name: &Spanned<String>,
    table: &Spanned<ColumnTable>,
    out: &mut Complaints<'_>,
) -> Column {
    let own = table.get_ref();
    let is = out.choice(own.is.as_ref(), "is", &Target::words(), Target::named);
    if own.is.is_none() && own.load.is_none() {
        let message = format!("the column `{}` needs `is` or `load`", name.get_ref());
        let help = format!("the values of `is` are {}", Target::words().join(", "));
        out.wrong(table.span(), message, help);
    }
    let load_sign = out.choice(
        own.load_sign.as_ref(),
        "load_sign",
        &["+", "-"],
        |word| match word {
            "+" => Some(1.0),
            "-" => Some(-1.0),
            _ => None,
        },
    );
    let side = out.choice(
        own.side.as_ref(),
        "side",
        &Side::BOTH.map(Side::word),
        side_named,
    );
    let characteristic = match is {
        Some(Target::Characteristic(of)) => Some(of),
        _ => None,
    };
    let senses: Vec<&str> = characteristic.map_or_else(Vec::new, |of| {
        of.senses().iter().map(|(word, _)| *word).collect()
    });
    let positive = match characteristic {
        Some(of) => out.choice(own.positive.as_ref(), "positive", &senses, |word| {
            of.sign(word, None).map(|_| word.to_string())
        }),
        None => None,
    };
    let quantity = characteristic.and_then(Characteristic::quantity);
    let over_mm = own.over_mm.as_ref().and_then(|over| {
        let good = *over.get_ref() > 0.0 && over.get_ref().is_finite();
        if good && quantity == Some(Quantity::Angle) {
            return Some(*over.get_ref());
        }
        let message = if quantity == Some(Quantity::Angle) {
            "`over_mm` must be a length above 0, in mm".to_string()
        } else {
            "`over_mm` applies only to angles".to_string()
        };
        let help = "the length over which the laboratory measured, such as the diameter of the rim";
        out.wrong(over.span(), message, help.to_string());
        None
    });
    let measured = if over_mm.is_some() {
        Some(Quantity::Length)
    } else {
        quantity
    };
    if let (Some(unit), Some(quantity)) = (&own.unit, measured)
        && quantity.factor(unit.get_ref()).is_none()
    {
        let message = format!(
            "`{}` is not a unit of the column `{}`",
            unit.get_ref(),
            name.get_ref()
        );
        out.wrong(unit.span(), message, quantity.described().to_string());
    }
    Column {
        name: name.get_ref().clone(),
        is,
        load: own.load.as_ref().map(|load| load.get_ref().clone()),
        load_sign,
        side,
        unit: own.unit.as_ref().map(|unit| unit.get_ref().clone()),
        positive,
        over_mm,
        span: Some(Span::from(name.span())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Checked<Option<Mapping>> {
        Mapping::read(&Source::new("lab.toml", text))
    }

    #[test]
    fn wrong_words_are_told_with_their_place() {
        let text = "[columns]\n\"Toe\" = { is = \"toe_angle\", positive = \"inn\", unit = \"mm\" }\n\"z\" = { is = \"travel\" }\n[tests]\n\"A\" = \"bounse\"\n";
        let found = read(text);
        assert!(found.value.is_none());
        let mut sorted = found.diagnostics.clone();
        sorted.sort_by_key(|d| d.labels[0].span.start());
        let places: Vec<&str> = sorted
            .iter()
            .map(|d| &text[d.labels[0].span.range()])
            .collect();
        assert_eq!(places, ["\"inn\"", "\"mm\"", "\"travel\"", "\"bounse\""]);
        let help = |k: usize| sorted[k].help.clone().unwrap();
        assert!(help(0).contains("did you mean `in`"), "{}", help(0));
        assert!(help(3).contains("did you mean `bounce`"), "{}", help(3));
    }

    #[test]
    fn an_unknown_key_is_refused() {
        let found = read("[columns]\n\"Toe\" = { is = \"toe_angle\", sign = \"+\" }\n");
        assert!(found.diagnostics[0].message.contains("sign"));
        assert_eq!(
            read("").value,
            Some(Mapping {
                file: FileOptions {
                    every: 1,
                    ..FileOptions::default()
                },
                ..Mapping::default()
            })
        );
    }

    #[test]
    fn columns_keep_their_order() {
        let found = read("[columns]\nb = { is = \"time\" }\na = { is = \"test\" }\n");
        let names = found.value.unwrap().columns;
        assert_eq!([&names[0].name, &names[1].name], ["b", "a"]);
    }
}
