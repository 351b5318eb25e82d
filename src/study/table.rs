use std::collections::BTreeMap;

use super::section::nearest;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Source, Span};

/// End of the message about a number with a point in a file whose other numbers have decimal commas.
const BESIDE_COMMAS: &str = "is ambiguous: its point may separate thousands or decimals, because other numbers of this file have decimal commas";

/// One cell of a CSV file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Cell {
    /// Text of the cell, without quotes and surrounding blanks.
    pub text: String,
    /// Position of the cell in the file.
    pub span: Span,
}

/// A CSV file as described in guide/study.md, with one header line and `#` comment lines. Columns are found by their header names. Lines end
/// with LF or CR LF. Cells are separated by commas, or by semicolons or tabs as spreadsheets write them. With semicolons or tabs, numbers may
/// have decimal commas. UTF-8 and UTF-16 are accepted.
#[derive(Clone, Debug)]
pub struct Table {
    /// Source of the file.
    pub source: Source,
    header: Vec<Cell>,
    rows: Vec<Vec<Cell>>,
    columns: BTreeMap<String, usize>,
    delimiter: u8,
    decimal_commas: bool,
}

impl Table {
    /// Splits a file into cells. Malformed lines are reported. A note states which separators and decimal commas were assumed, unless cells are
    /// separated by commas.
    pub fn read(source: Source, diagnostics: &mut Vec<Diagnostic>) -> Self {
        let source = source.in_utf8();
        let bytes = source.bytes();
        let delimiter = delimiter(bytes);
        let lines = split(&source, delimiter, Some(b'#'), diagnostics);
        let mut lines = lines.into_iter();
        let header = lines.next().unwrap_or_default();
        let mut columns = BTreeMap::new();
        for (at, cell) in header.iter().enumerate() {
            columns.entry(cell.text.to_lowercase()).or_insert(at);
        }
        let blank = |row: &Vec<Cell>| row.iter().all(|cell| cell.text.is_empty());
        let rows: Vec<Vec<Cell>> = lines.filter(|row| !blank(row)).collect();
        let has_comma = |cell: &Cell| cell.text.contains(',') && decimal(&cell.text).is_some();
        let decimal_commas = delimiter != b',' && rows.iter().flatten().any(has_comma);
        let table = Self {
            source,
            header,
            rows,
            columns,
            delimiter,
            decimal_commas,
        };
        if delimiter != b',' {
            diagnostics.push(table.dialect(delimiter));
        }
        if let Some(long) = table.rows.iter().find(|row| table.is_too_long(row)) {
            let count = long.iter().filter(|cell| !cell.text.is_empty()).count();
            let message = format!(
                "the row has {count} cells, but the header line names only {}",
                table.header.len()
            );
            diagnostics.push(
                Diagnostic::error(Code::BadReading, message)
                    .label(table.source.name(), table.row_span(long), "")
                    .help("numbers with decimal commas need semicolons between the cells"),
            );
        }
        table
    }

    /// Returns a note that states the assumed separators and decimal commas, for a file whose cells are separated by semicolons or tabs.
    fn dialect(&self, delimiter: u8) -> Diagnostic {
        let between = if delimiter == b';' {
            "semicolons"
        } else {
            "tabs"
        };
        let numbers = if self.decimal_commas {
            ", numbers with decimal commas"
        } else {
            ""
        };
        Diagnostic::note(
            Code::CsvDialect,
            format!("read with {between} between the cells{numbers}"),
        )
        .label(self.source.name(), self.header_span(), "")
    }

    fn is_too_long(&self, row: &[Cell]) -> bool {
        row.iter()
            .skip(self.header.len())
            .any(|cell| !cell.text.is_empty())
    }

    /// Returns the index of the column with this name, ignoring case.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.get(&name.to_lowercase()).copied()
    }

    /// Returns the indices of the required columns. If any is missing, the missing columns are reported and the result is `None`.
    pub fn columns<const N: usize>(
        &self,
        names: [&str; N],
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<[usize; N]> {
        let missing: Vec<&str> = names
            .iter()
            .copied()
            .filter(|name| self.column(name).is_none())
            .collect();
        if missing.is_empty() {
            let found = names.map(|name| self.column(name).expect("checked just above"));
            for column in found {
                self.only(column, diagnostics);
            }
            return Some(found);
        }
        let words: Vec<String> = missing.iter().map(|name| format!("`{name}`")).collect();
        diagnostics.push(
            Diagnostic::error(
                Code::MissingColumn,
                format!("the file has no column {}", words.join(", ")),
            )
            .label(self.source.name(), self.header_span(), "the header line")
            .help(match self.slip(missing[0]) {
                Some(near) => format!(
                    "is `{near}` meant to be `{}`? the header line must name: {}",
                    missing[0],
                    names.join(",")
                ),
                None => format!("the header line must name: {}", names.join(",")),
            }),
        );
        None
    }

    /// Reports an error if another column has the same name as this column, because the choice between them would be arbitrary.
    pub(crate) fn only(&self, column: usize, diagnostics: &mut Vec<Diagnostic>) {
        let Some(own) = self.header.get(column) else {
            return;
        };
        let same = |(at, cell): &(usize, &Cell)| {
            *at != column && cell.text.to_lowercase() == own.text.to_lowercase()
        };
        let Some((_, other)) = self.header.iter().enumerate().find(same) else {
            return;
        };
        let message = format!("two columns are called `{}`", own.text);
        diagnostics.push(
            Diagnostic::error(Code::BadReading, message)
                .label(self.source.name(), own.span, "this one")
                .label(self.source.name(), other.span, "and this one")
                .help("rename or remove one of them"),
        );
    }

    /// Returns the column names as written in the header line.
    pub fn header(&self) -> Vec<String> {
        self.header.iter().map(|cell| cell.text.clone()).collect()
    }

    /// Returns the cells of the header line.
    pub fn header_cells(&self) -> &[Cell] {
        &self.header
    }

    /// Returns the column name in the header line that is most similar to `name`, if they differ by only a few letters.
    fn slip(&self, name: &str) -> Option<&str> {
        let long = |cell: &&Cell| cell.text.len() > 2;
        let names = self.header.iter().filter(long);
        nearest(name, names.map(|cell| cell.text.as_str())).filter(|_| name.len() > 2)
    }

    /// Returns the position of the header line.
    pub fn header_span(&self) -> Span {
        match (self.header.first(), self.header.last()) {
            (Some(first), Some(last)) => first.span.join(last.span),
            _ => Span::at(0),
        }
    }

    /// Returns the rows below the header line.
    pub fn rows(&self) -> &[Vec<Cell>] {
        &self.rows
    }

    /// Returns the cell of a row in a column; `None` if the row is too short or the cell is empty.
    pub fn cell<'a>(&self, row: &'a [Cell], column: usize) -> Option<&'a Cell> {
        row.get(column).filter(|cell| !cell.text.is_empty())
    }

    /// Returns the text of the header line, in the style of the file.
    pub(crate) fn header_row(&self) -> String {
        let cells: Vec<String> = self.header();
        cells.join(std::str::from_utf8(&[self.delimiter]).unwrap_or(",")) + "\n"
    }

    /// Returns the text of a new row in the style of the file. `cells` holds pairs of column and text; all other cells are empty.
    pub fn further_row(&self, cells: &[(usize, String)]) -> String {
        let of = |column: usize| {
            let own = cells.iter().find(|(at, _)| *at == column);
            let text = own.map_or("", |(_, text)| text.as_str());
            if self.decimal_commas && text.parse::<f64>().is_ok() {
                text.replace('.', ",")
            } else {
                text.to_string()
            }
        };
        let cells: Vec<String> = (0..self.header.len()).map(of).collect();
        cells.join(std::str::from_utf8(&[self.delimiter]).unwrap_or(",")) + "\n"
    }

    /// Returns the position of a row in the file.
    pub fn row_span(&self, row: &[Cell]) -> Span {
        match (row.first(), row.last()) {
            (Some(first), Some(last)) => first.span.join(last.span),
            _ => Span::at(0),
        }
    }

    /// Returns true if the header line contains a name that differs from `name` by only a few letters.
    pub(crate) fn has_slip(&self, name: &str) -> bool {
        self.slip(name).is_some()
    }

    /// Returns the finite number in a cell. Returns `None` if the cell holds no number, or an ambiguous number (see [`Self::is_ambiguous`]).
    pub(crate) fn value(&self, cell: &Cell) -> Option<f64> {
        let number = match cell.text.parse().ok() {
            None if self.decimal_commas => decimal(&cell.text),
            _ if self.is_ambiguous(cell) => None,
            number => number,
        };
        number.filter(|x: &f64| x.is_finite())
    }

    /// Returns true if the cell holds a number with a point although the file has decimal commas. For example, `1.500` may then mean 1500 or
    /// 1.5.
    fn is_ambiguous(&self, cell: &Cell) -> bool {
        self.decimal_commas && cell.text.contains('.') && cell.text.parse::<f64>().is_ok()
    }

    /// Reports a number with a point in a file with decimal commas, at most once per file. Returns true if the cell holds such a number.
    pub(crate) fn complain_of_point(&self, cell: &Cell, out: &mut Vec<Diagnostic>) -> bool {
        if !self.is_ambiguous(cell) {
            return false;
        }
        let said = |d: &Diagnostic| {
            let file = d.labels.first().map(|label| &*label.file);
            file == Some(self.source.name()) && d.message.ends_with(BESIDE_COMMAS)
        };
        if !out.iter().any(said) {
            let message = format!("`{}` {BESIDE_COMMAS}", cell.text);
            out.push(
                Diagnostic::error(Code::BadReading, message)
                    .label(self.source.name(), cell.span, "")
                    .help("write decimal commas everywhere, and nothing between thousands"),
            );
        }
        true
    }

    /// Returns the number in a cell of a row. Returns `None` for an empty cell. Also returns `None` for text that is no finite number, with a
    /// warning, and for a number with a point in a file with decimal commas, with an error.
    pub fn number(
        &self,
        row: &[Cell],
        column: usize,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<f64> {
        let cell = self.cell(row, column)?;
        let number = self.value(cell);
        if number.is_none() && !self.complain_of_point(cell, diagnostics) {
            diagnostics.push(
                Diagnostic::warning(
                    Code::BadReading,
                    format!("`{}` is not a number; the reading is left out", cell.text),
                )
                .label(self.source.name(), cell.span, ""),
            );
        }
        number
    }
}

/// Splits a file in UTF-8 into lines of cells. Blank lines are left out, and so are lines that begin with `comment`. A malformed line is
/// reported and ends the table.
pub fn split(
    source: &Source,
    delimiter: u8,
    comment: Option<u8>,
    diagnostics: &mut Vec<Diagnostic>,
) -> Vec<Vec<Cell>> {
    let bytes = source.bytes();
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .flexible(true)
        .delimiter(delimiter)
        .comment(comment)
        .from_reader(bytes);
    let mut record = csv::ByteRecord::new();
    let mut lines = Vec::new();
    loop {
        let start = reader.position().byte() as usize;
        match reader.read_byte_record(&mut record) {
            Ok(true) => {}
            Ok(false) => break,
            Err(error) => {
                diagnostics.push(
                    Diagnostic::error(Code::BadReading, format!("this is not valid CSV: {error}"))
                        .label(source.name(), Span::at(start.min(bytes.len())), ""),
                );
                break;
            }
        }
        let end = reader.position().byte() as usize;
        let start = row_start(bytes, start, comment);
        lines.push(cells(bytes, start..end, delimiter, &record));
    }
    lines
}

/// Returns the separator of the cells, judged by the header line: semicolon or tab if it occurs there more often than the comma, otherwise the
/// comma.
fn delimiter(bytes: &[u8]) -> u8 {
    let line = &bytes[row_start(bytes, 0, Some(b'#')).min(bytes.len())..];
    let end = memchr::memchr2(b'\n', b'\r', line).unwrap_or(line.len());
    let mut quoted = false;
    let mut counts = [(b',', 0), (b';', 0), (b'\t', 0)];
    for byte in &line[..end] {
        quoted ^= *byte == b'"';
        if let Some((_, count)) = counts.iter_mut().find(|(mark, _)| mark == byte && !quoted) {
            *count += 1;
        }
    }
    let [comma, semicolon, tab] = counts.map(|(_, count)| count);
    match semicolon.max(tab) {
        most if most <= comma => b',',
        most if most == semicolon => b';',
        _ => b'\t',
    }
}

/// Parses a number with a decimal comma; returns `None` for any other text.
fn decimal(text: &str) -> Option<f64> {
    let (whole, fraction) = text.split_once(',')?;
    if whole.contains('.') || fraction.contains(',') {
        return None;
    }
    format!("{whole}.{fraction}").parse().ok()
}

/// Returns the position of the next record at or after `at`, skipping comment lines and blank lines.
fn row_start(bytes: &[u8], mut at: usize, comment: Option<u8>) -> usize {
    loop {
        let rest = &bytes[at.min(bytes.len())..];
        match rest.first() {
            Some(b'\n' | b'\r') => at += 1,
            Some(first) if comment == Some(*first) => match memchr::memchr(b'\n', rest) {
                Some(end) => at += end + 1,
                None => return bytes.len(),
            },
            Some(_) if at == 0 && rest.starts_with(b"\xef\xbb\xbf") => at += 3,
            _ => return at,
        }
    }
}

/// Returns the cells of a record with their positions in the bytes of the file. As in the CSV reader, a quote opens a quoted field only as the
/// first byte of the field, and is an ordinary character elsewhere.
fn cells(
    bytes: &[u8],
    place: std::ops::Range<usize>,
    delimiter: u8,
    record: &csv::ByteRecord,
) -> Vec<Cell> {
    let mut cells = Vec::with_capacity(record.len());
    let mut at = place.start;
    let last = place.end.min(bytes.len());
    for field in record {
        let from = at.min(last);
        at = from + field_length(&bytes[from..last], delimiter);
        let (mut start, mut end) = (from, at);
        while start < end && bytes[start].is_ascii_whitespace() {
            start += 1;
        }
        while start < end && bytes[end - 1].is_ascii_whitespace() {
            end -= 1;
        }
        at += 1;
        // Bytes that are not UTF-8 are read as Latin-1, which some spreadsheets still write. Names in decks are read in the same way.
        let text = std::str::from_utf8(field).map_or_else(
            |_| field.iter().map(|&byte| char::from(byte)).collect(),
            str::to_string,
        );
        cells.push(Cell {
            text: text.trim().to_string(),
            span: Span::new(start, end),
        });
    }
    cells
}

/// Returns the length in bytes of the field at the start of `bytes`.
fn field_length(bytes: &[u8], delimiter: u8) -> usize {
    let mut quoted = bytes.first() == Some(&b'"');
    let mut at = usize::from(quoted);
    while at < bytes.len() {
        match bytes[at] {
            // Two quotes inside a quoted field stand for one quote.
            b'"' if quoted && bytes.get(at + 1) == Some(&b'"') => at += 1,
            b'"' if quoted => quoted = false,
            byte if !quoted && (byte == delimiter || matches!(byte, b'\n' | b'\r')) => break,
            _ => {}
        }
        at += 1;
    }
    at
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn comments_line_ends_quotes_and_empty_cells() {
        let text =
            "# a comment\r\ncase, x ,y\r\n\r\n1, 2.5,\r\n# in between\r\n\"two, three\",nan,4\r\n";
        let mut diagnostics = Vec::new();
        let table = Table::read(Source::new("t.csv", text.as_bytes()), &mut diagnostics);
        assert!(diagnostics.is_empty());
        let [case, x, y] = table.columns(["case", "X", "y"], &mut diagnostics).unwrap();
        assert_eq!(table.rows().len(), 2);
        assert_eq!(
            table.number(&table.rows()[0], x, &mut diagnostics),
            Some(2.5)
        );
        assert_eq!(table.number(&table.rows()[0], y, &mut diagnostics), None);
        assert!(diagnostics.is_empty());
        assert_eq!(table.rows()[1][case].text, "two, three");
        assert_eq!(table.number(&table.rows()[1], x, &mut diagnostics), None);
        assert_eq!(diagnostics.len(), 1);
        let place = diagnostics[0].labels[0].span;
        assert_eq!(&text[place.range()], "nan");
        assert_eq!(table.source.line_column(place.start()).line, 6);
        assert!(table.columns(["part"], &mut diagnostics).is_none());
    }

    fn read(text: &str) -> (Table, Vec<Diagnostic>) {
        let mut diagnostics = Vec::new();
        let table = Table::read(Source::new("t.csv", text.as_bytes()), &mut diagnostics);
        (table, diagnostics)
    }

    /// In a file with decimal commas, `1.500` may mean 1500 or 1.5. The file does not tell which.
    #[test]
    fn a_point_beside_decimal_commas_is_refused_once() {
        let (table, mut out) = read("case;x;y\n1.1;0,5;1.500\n1.2;2;3.000\n1.3;7;-12\n");
        let [x, y] = table.columns(["x", "y"], &mut out).unwrap();
        let before = out.len();
        for row in table.rows() {
            assert!(table.number(row, x, &mut out).is_some());
        }
        let numbers = table
            .rows()
            .iter()
            .map(|row| table.number(row, y, &mut out));
        assert_eq!(numbers.collect::<Vec<_>>(), [None, None, Some(-12.0)]);
        assert_eq!(out.len(), before + 1);
        assert_eq!(
            out[before].severity,
            admire_syntax::diagnostic::Severity::Error
        );
        assert!(
            out[before].message.contains("`1.500`"),
            "{}",
            out[before].message
        );
        // In a file without decimal commas, points are decimal points.
        let (table, mut out) = read("case;x\n1;1.500\n");
        let [x] = table.columns(["x"], &mut out).unwrap();
        assert_eq!(table.number(&table.rows()[0], x, &mut out), Some(1.5));
    }

    #[test]
    fn two_columns_of_one_name_are_refused_where_they_are_read() {
        let (table, mut out) = read("case,x,time,X,time\n1,1,2,3,4\n");
        assert!(table.columns(["case"], &mut out).is_some() && out.is_empty());
        let _ = table.columns(["x"], &mut out);
        assert_eq!(out.len(), 1);
        assert_eq!(out[0].severity, admire_syntax::diagnostic::Severity::Error);
        let places: Vec<_> = out[0].labels.iter().map(|l| l.span.start()).collect();
        assert_eq!(places, [5, 12]);
    }

    #[test]
    fn utf_16_is_read_as_spreadsheets_write_it() {
        let text = "case\tx\tLängs\n1\t1,5\t2\n";
        let units = |bytes: fn(u16) -> [u8; 2]| -> Vec<u8> {
            text.encode_utf16().flat_map(bytes).collect()
        };
        let (little, big) = (units(u16::to_le_bytes), units(u16::to_be_bytes));
        let marked = |mark: [u8; 2], text: &[u8]| [&mark[..], text].concat();
        for bytes in [
            marked([0xff, 0xfe], &little),
            marked([0xfe, 0xff], &big),
            little,
            big,
        ] {
            let mut out = Vec::new();
            let table = Table::read(Source::new("t.txt", bytes), &mut out);
            let columns = table.columns(["case", "x", "längs"], &mut out).unwrap();
            let row = &table.rows()[0];
            let read = columns.map(|column| table.number(row, column, &mut out));
            assert_eq!(read, [Some(1.0), Some(1.5), Some(2.0)]);
        }
    }

    #[test]
    fn semicolons_and_decimal_commas_are_read_and_said() {
        let (table, mut diagnostics) = read("case;x;y\n1;1,5;-2,25E-3\n2;\"3,0\";4\n3;1.234,5;6\n");
        assert_eq!(diagnostics.len(), 1);
        assert_eq!(
            diagnostics[0].severity,
            admire_syntax::diagnostic::Severity::Note
        );
        assert!(
            diagnostics[0].message.contains("semicolons")
                && diagnostics[0].message.contains("decimal commas")
        );
        let [x, y] = table.columns(["x", "y"], &mut diagnostics).unwrap();
        let mut numbers = |row: usize| {
            let row = &table.rows()[row];
            (
                table.number(row, x, &mut diagnostics),
                table.number(row, y, &mut diagnostics),
            )
        };
        assert_eq!(numbers(0), (Some(1.5), Some(-2.25e-3)));
        assert_eq!(numbers(1), (Some(3.0), Some(4.0)));
        // A number with both a point and a comma is rejected.
        assert_eq!(numbers(2), (None, Some(6.0)));
        assert_eq!(&table.source.text(table.rows()[0][1].span), "1,5");
        let (table, mut diagnostics) = read("case\tx\na\t1.5\n");
        assert!(diagnostics[0].message.contains("tabs"));
        assert_eq!(
            table.number(&table.rows()[0], 1, &mut diagnostics),
            Some(1.5)
        );
    }

    #[test]
    fn decimal_commas_between_commas_are_refused() {
        let (_, diagnostics) = read("case,x,y\n1,1,5,2,5\n");
        assert_eq!(diagnostics[0].code, Code::BadReading);
        assert!(
            diagnostics[0]
                .help
                .as_deref()
                .unwrap()
                .contains("semicolons")
        );
        // Trailing empty cells of spreadsheets are ignored.
        assert!(read("case,x,y\n1,1.5,2.5,,\n").1.is_empty());
    }
}
