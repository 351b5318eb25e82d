//! Sheets: the cells of a file with their places.

use super::file_options::FileOptions;
use admire_study::{Cell, split};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Source, Span};

/// Words that stand for a missing value.
const MISSING: [&str; 9] = ["", "-", "--", "nan", "n/a", "na", "#n/a", "#nv", "null"];

/// One table sheet: a CSV file, or a sheet of a workbook. A sheet of a workbook is stored as text with one line per row, so that diagnostics can
/// state the number of the row.
#[derive(Clone, Debug)]
pub struct Sheet {
    /// Name of the sheet in its workbook; `None` for a CSV file.
    pub name: Option<String>,
    /// Text of the sheet, in UTF-8.
    pub source: Source,
    lines: Vec<Vec<Cell>>,
    decimal_commas: bool,
}

impl Sheet {
    /// Splits the text of a sheet into cells. Malformed lines are reported.
    pub(crate) fn new(
        name: Option<String>,
        source: Source,
        delimiter: u8,
        options: &FileOptions,
        out: &mut Vec<Diagnostic>,
    ) -> Self {
        let lines = split(&source, delimiter, None, out);
        let has_comma = |cell: &Cell| cell.text.contains(',') && parsed(&cell.text, true).is_some();
        let decimal_commas = options.decimal.map_or_else(
            || delimiter != b',' && lines.iter().flatten().any(has_comma),
            |mark| mark == b',',
        );
        Self {
            name,
            source,
            lines,
            decimal_commas,
        }
    }

    /// Returns the lines with their cells, without blank lines.
    pub fn lines(&self) -> &[Vec<Cell>] {
        &self.lines
    }

    /// Returns true if numbers have decimal commas.
    pub fn has_decimal_commas(&self) -> bool {
        self.decimal_commas
    }

    /// Returns the number of a line in the file, counted from 1.
    pub fn line_number(&self, line: &[Cell]) -> usize {
        let start = line.first().map_or(0, |cell| cell.span.start());
        self.source.line_column(start).line
    }

    /// Returns the finite number in a cell; `None` if the cell holds no number, or a number with an ambiguous decimal mark.
    pub(crate) fn number(&self, cell: &Cell) -> Option<f64> {
        if self.is_unclear(cell) {
            return None;
        }
        parsed(&cell.text, self.decimal_commas)
    }

    /// Returns true if the cell holds a number with a point although other numbers have decimal commas. For example, `1.500` may then be 1500 or 1.5.
    pub(crate) fn is_unclear(&self, cell: &Cell) -> bool {
        self.decimal_commas && cell.text.contains('.') && parsed(&cell.text, false).is_some()
    }

    /// Returns an error at a position in this sheet.
    pub(crate) fn error(&self, code: Code, message: String, span: Span) -> Diagnostic {
        Diagnostic::error(code, message).label(self.source.name(), span, "")
    }
}

/// Returns true if the text of a cell stands for a missing value.
pub(crate) fn is_missing(text: &str) -> bool {
    MISSING.contains(&text.to_lowercase().as_str())
}

/// Parses a finite number, with a decimal comma if `comma` is true.
fn parsed(text: &str, comma: bool) -> Option<f64> {
    let begins = |c: char| c.is_ascii_digit() || matches!(c, '+' | '-' | '.' | ',');
    if !text.starts_with(begins) {
        return None;
    }
    let number: f64 = match text.split_once(',') {
        Some((whole, fraction)) if comma && !text.contains('.') => {
            format!("{whole}.{fraction}").parse().ok()?
        }
        Some(_) => return None,
        None => text.parse().ok()?,
    };
    number.is_finite().then_some(number)
}
