//! Files from laboratories: workbooks, and texts in any encoding with any separator.

use super::file_options::FileOptions;
use super::sheet::Sheet;
use super::workbook::{is_workbook, sheets_of};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Source, Span};

/// Reads the sheets of a file: the sheets of an Excel workbook, or a CSV file with any separator.
///
/// CSV may be UTF-8, UTF-16 or, if it is neither, Windows-1252, which contains Latin-1.
///
/// # Errors
/// Returns a diagnostic if the file is a damaged workbook, a workbook in another format than `.xlsx`, or a text without a separator.
pub fn sheets(
    source: &Source,
    options: &FileOptions,
    out: &mut Vec<Diagnostic>,
) -> Result<Vec<Sheet>, Diagnostic> {
    if is_workbook(source.bytes()) {
        return sheets_of(source, options, out);
    }
    let text = in_utf8(source.clone());
    let delimiter = options.delimiter.or_else(|| delimiter(text.bytes()));
    let Some(delimiter) = delimiter else {
        let message = "the file has neither semicolons, tabs nor commas between its cells";
        let help = "state the separator in the mapping, below `[file]`: delimiter = \"|\"; save a workbook other than .xlsx as CSV";
        return Err(Diagnostic::error(Code::BadReading, message)
            .label(text.name(), Span::new(0, text.bytes().len().min(1)), "")
            .help(help));
    };
    Ok(vec![Sheet::new(None, text, delimiter, options, out)])
}

/// Converts a text to UTF-8 without a byte order mark.
fn in_utf8(source: Source) -> Source {
    let source = source.in_utf8();
    if source.utf8().is_ok() {
        return source;
    }
    let (text, _, _) = encoding_rs::WINDOWS_1252.decode(source.bytes());
    Source::new(source.name(), text.into_owned())
}

/// Returns the separator of the cells: a tab or semicolon if at least half of all lines with text contain it, else a comma by the same rule.
fn delimiter(bytes: &[u8]) -> Option<u8> {
    let lines: Vec<&[u8]> = bytes
        .split(|byte| *byte == b'\n')
        .filter(|line| line.iter().any(|byte| !byte.is_ascii_whitespace()))
        .collect();
    let usual = |mark: u8| {
        let count = lines.iter().filter(|line| line.contains(&mark)).count();
        count > 0 && 2 * count >= lines.len()
    };
    [b'\t', b';', b','].into_iter().find(|mark| usual(*mark))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> Sheet {
        let mut out = Vec::new();
        let source = Source::new("lab.csv", bytes);
        let mut all = sheets(&source, &FileOptions::default(), &mut out).unwrap();
        assert!(out.is_empty(), "{out:?}");
        all.remove(0)
    }

    #[test]
    fn decimal_commas_do_not_hide_semicolons() {
        let sheet = read(b"Lab; 2026, March\nTravel;Toe\n1,5;2,25\n-3,0;4,5e-1\n");
        let last = &sheet.lines()[3];
        assert_eq!(sheet.number(&last[0]), Some(-3.0));
        assert_eq!(sheet.number(&last[1]), Some(0.45));
        assert_eq!(sheet.line_number(last), 4);
    }

    #[test]
    fn windows_1252_and_utf_16_are_read_alike() {
        let sheet = read(b"Einfederung\tSpur (\xb0)\n1\t2\n");
        assert_eq!(sheet.lines()[0][1].text, "Spur (\u{b0})");
        let text = "Einfederung\tSpur (\u{b0})\r\n1\t2\r\n";
        let wide: Vec<u8> = [0xff, 0xfe]
            .into_iter()
            .chain(text.encode_utf16().flat_map(u16::to_le_bytes))
            .collect();
        assert_eq!(read(&wide).lines()[0][1].text, "Spur (\u{b0})");
    }

    /// If `1.500` and `0,5` are in one file, `1.500` may be 1500 or 1.5. It is not a number until the mapping states the decimal mark.
    #[test]
    fn a_point_beside_decimal_commas_is_unclear() {
        let sheet = read(b"a;b\n0,5;1.500\n");
        assert!(sheet.is_unclear(&sheet.lines()[1][1]));
        assert_eq!(sheet.number(&sheet.lines()[1][1]), None);
    }

    #[test]
    fn a_text_without_cells_is_refused() {
        let source = Source::new("lab.csv", "one\ntwo\n");
        let found = sheets(&source, &FileOptions::default(), &mut Vec::new());
        assert!(found.unwrap_err().help.unwrap().contains("delimiter"));
    }
}
