//! Sheets of Excel workbooks.

use std::io::Cursor;

use calamine::{DataRef, Reader, Xlsx};

use super::file_options::FileOptions;
use super::sheet::Sheet;
use admire_study::did_you_mean;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Source;

/// Largest number of cells that are read from one sheet, and the largest row and column.
const MAX_CELLS: usize = 20_000_000;
const LAST_ROW: u32 = 1_048_575;
const LAST_COLUMN: u32 = 4_095;

/// Returns true if the bytes begin like a workbook: a ZIP archive, or a compound file of old Excel versions.
pub(crate) fn is_workbook(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(&[0xd0, 0xcf, 0x11, 0xe0])
}

/// Reads all sheets of a workbook that contain cells. Cells are read one by one, so that a single distant cell does not create a huge table.
pub(crate) fn sheets_of(
    source: &Source,
    options: &FileOptions,
    out: &mut Vec<Diagnostic>,
) -> Result<Vec<Sheet>, Diagnostic> {
    let refused = |why: String| {
        let message = format!(
            "`{}` is not a workbook in the format .xlsx: {why}",
            source.name()
        );
        Diagnostic::error(Code::CannotRead, message)
            .help("save the sheet as .xlsx or as CSV, and import that file")
    };
    let mut book: Xlsx<_> = calamine::open_workbook_from_rs(Cursor::new(source.bytes()))
        .map_err(|error: calamine::XlsxError| refused(error.to_string()))?;
    let mut names = book.sheet_names();
    if let Some(wanted) = &options.sheet {
        if !names.contains(wanted) {
            let message = format!("`{}` has no sheet `{wanted}`", source.name());
            let help = did_you_mean(wanted, "the workbook", &names);
            return Err(Diagnostic::error(Code::BadSetting, message).help(help));
        }
        names.retain(|name| name == wanted);
    }
    let mut found = Vec::new();
    for name in names {
        let mut text = SheetText::default();
        // Sheets that contain only charts have no cells.
        let Ok(mut cells) = book.worksheet_cells_reader(&name) else {
            continue;
        };
        loop {
            let cell = match cells.next_cell() {
                Ok(Some(cell)) => cell,
                Ok(None) => break,
                Err(error) => return Err(refused(format!("sheet `{name}`: {error}"))),
            };
            let (row, column) = cell.get_position();
            if text.count >= MAX_CELLS || row > LAST_ROW || column > LAST_COLUMN {
                let why = format!(
                    "sheet `{name}` has more than {MAX_CELLS} cells or {LAST_COLUMN} columns"
                );
                return Err(refused(why));
            }
            let value = spelled(cell.get_value());
            if !value.is_empty() && !text.push(row, column, &value) {
                return Err(refused(format!(
                    "sheet `{name}`: its cells are out of order"
                )));
            }
        }
        if text.text.is_empty() {
            continue;
        }
        let named = format!("{}[{name}]", source.name());
        let own = Source::new(named, text.text + "\n");
        found.push(Sheet::new(Some(name), own, b'\t', options, out));
    }
    Ok(found)
}

/// Text of a sheet with tabs between its cells and a line for each row.
#[derive(Default)]
struct SheetText {
    text: String,
    row: u32,
    column: u32,
    count: usize,
}

impl SheetText {
    /// Adds a cell. Returns false if the cell precedes the last added cell.
    fn push(&mut self, row: u32, column: u32, value: &str) -> bool {
        let is_later = (row, column) > (self.row, self.column) || self.count == 0;
        if !is_later {
            return false;
        }
        while self.row < row {
            self.text.push('\n');
            self.row += 1;
            self.column = 0;
        }
        while self.column < column {
            self.text.push('\t');
            self.column += 1;
        }
        // Each row is one line of text, so line breaks and tabs in a cell become blanks. Quotes are doubled.
        let inner = value.replace(['\n', '\r', '\t'], " ");
        if inner.starts_with('"') {
            self.text += &format!("\"{}\"", inner.replace('"', "\"\""));
        } else {
            self.text += &inner;
        }
        self.count += 1;
        true
    }
}

fn spelled(value: &DataRef<'_>) -> String {
    match value {
        DataRef::Int(number) => number.to_string(),
        DataRef::Float(number) => number.to_string(),
        DataRef::String(text) | DataRef::DateTimeIso(text) | DataRef::DurationIso(text) => {
            text.trim().to_string()
        }
        DataRef::SharedString(text) => text.trim().to_string(),
        DataRef::Bool(value) => value.to_string(),
        DataRef::DateTime(time) => time.as_f64().to_string(),
        DataRef::Error(error) => error.to_string(),
        DataRef::Empty => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sheets;

    #[test]
    fn rows_keep_their_numbers() {
        let mut text = SheetText::default();
        assert!(text.push(2, 1, "a\nb") && text.push(2, 3, "1.5") && text.push(4, 0, "\"x"));
        assert_eq!(text.text, "\n\n\ta b\t\t1.5\n\n\"\"\"x\"");
        assert!(!text.push(3, 0, "back"));
    }

    #[test]
    fn damaged_workbooks_are_refused() {
        for bytes in [&b"PK\x03\x04nothing"[..], &[0xd0, 0xcf, 0x11, 0xe0, 1, 2]] {
            let source = Source::new("lab.xls", bytes);
            let found = sheets(&source, &FileOptions::default(), &mut Vec::new());
            assert!(found.unwrap_err().help.unwrap().contains("CSV"));
        }
    }
}
