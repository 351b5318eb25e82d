use std::collections::BTreeMap;

use crate::diagnostic::{Code, Diagnostic};
use crate::text::{Source, Span};

/// One cell of a CSV file.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Cell {
    /// Its text, trimmed, quotes removed.
    pub text: String,
    /// Where it stands in the file.
    pub span: Span,
}

/// A CSV file as STUDY-FORMAT describes it: one header line, `#` comment lines, columns found by header name, LF or CR LF.
#[derive(Clone, Debug)]
pub struct Table {
    /// The file.
    pub source: Source,
    header: Vec<Cell>,
    rows: Vec<Vec<Cell>>,
    columns: BTreeMap<String, usize>,
}

impl Table {
    /// Splits a file into cells. Lines that are no CSV are complained about and left out.
    pub fn read(source: Source, diagnostics: &mut Vec<Diagnostic>) -> Self {
        let bytes = source.bytes();
        let mut reader = csv::ReaderBuilder::new()
            .has_headers(false)
            .flexible(true)
            .comment(Some(b'#'))
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
                        Diagnostic::error(Code::BadReading, format!("no CSV: {error}")).label(
                            source.name(),
                            Span::at(start.min(bytes.len())),
                            "",
                        ),
                    );
                    break;
                }
            }
            let end = reader.position().byte() as usize;
            lines.push(cells(bytes, row_start(bytes, start), end, &record));
        }
        let mut lines = lines.into_iter();
        let header = lines.next().unwrap_or_default();
        let mut columns = BTreeMap::new();
        for (at, cell) in header.iter().enumerate() {
            columns.entry(cell.text.to_lowercase()).or_insert(at);
        }
        let blank = |row: &Vec<Cell>| row.iter().all(|cell| cell.text.is_empty());
        let rows = lines.filter(|row| !blank(row)).collect();
        Self {
            source,
            header,
            rows,
            columns,
        }
    }

    /// The position of a column.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.get(&name.to_lowercase()).copied()
    }

    /// The positions of columns that must be there; the missing ones are complained about.
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
            return Some(names.map(|name| self.column(name).expect("checked just above")));
        }
        let words: Vec<String> = missing.iter().map(|name| format!("`{name}`")).collect();
        diagnostics.push(
            Diagnostic::error(
                Code::MissingColumn,
                format!("the file has no column {}", words.join(", ")),
            )
            .label(self.source.name(), self.header_span(), "the header line")
            .help(format!("the header line must name: {}", names.join(","))),
        );
        None
    }

    /// The whole header line.
    pub fn header_span(&self) -> Span {
        match (self.header.first(), self.header.last()) {
            (Some(first), Some(last)) => first.span.join(last.span),
            _ => Span::at(0),
        }
    }

    /// The rows below the header.
    pub fn rows(&self) -> &[Vec<Cell>] {
        &self.rows
    }

    /// The cell of a row, unless the row is too short or the cell empty.
    pub fn cell<'a>(&self, row: &'a [Cell], column: usize) -> Option<&'a Cell> {
        row.get(column).filter(|cell| !cell.text.is_empty())
    }

    /// The whole row.
    pub fn row_span(&self, row: &[Cell]) -> Span {
        match (row.first(), row.last()) {
            (Some(first), Some(last)) => first.span.join(last.span),
            _ => Span::at(0),
        }
    }

    /// A number of a row. `None` for an empty cell (silently) and for what is no finite number (with a warning).
    pub fn number(
        &self,
        row: &[Cell],
        column: usize,
        diagnostics: &mut Vec<Diagnostic>,
    ) -> Option<f64> {
        let cell = self.cell(row, column)?;
        let number = cell.text.parse().ok().filter(|x: &f64| x.is_finite());
        if number.is_none() {
            diagnostics.push(
                Diagnostic::warning(
                    Code::BadReading,
                    format!("`{}` is no number; the reading is left out", cell.text),
                )
                .label(self.source.name(), cell.span, ""),
            );
        }
        number
    }
}

/// Skips the comment and blank lines before a record.
fn row_start(bytes: &[u8], mut at: usize) -> usize {
    loop {
        let rest = &bytes[at.min(bytes.len())..];
        match rest.first() {
            Some(b'\n' | b'\r') => at += 1,
            Some(b'#') => match memchr::memchr(b'\n', rest) {
                Some(end) => at += end + 1,
                None => return bytes.len(),
            },
            Some(_) if rest.starts_with(b"\xef\xbb\xbf") => at += 3,
            _ => return at,
        }
    }
}

/// Finds each field of a record in the bytes it was read from.
fn cells(bytes: &[u8], start: usize, end: usize, record: &csv::ByteRecord) -> Vec<Cell> {
    let mut cells = Vec::with_capacity(record.len());
    let mut at = start;
    for field in record {
        let from = at;
        let mut quoted = false;
        while at < end.min(bytes.len()) {
            match bytes[at] {
                b'"' => quoted = !quoted,
                b',' | b'\n' | b'\r' if !quoted => break,
                _ => {}
            }
            at += 1;
        }
        let (mut start, mut end) = (from.min(bytes.len()), at.min(bytes.len()));
        while start < end && bytes[start].is_ascii_whitespace() {
            start += 1;
        }
        while start < end && bytes[end - 1].is_ascii_whitespace() {
            end -= 1;
        }
        let span = Span::new(start, end);
        at += 1;
        cells.push(Cell {
            text: String::from_utf8_lossy(field).trim().to_string(),
            span,
        });
    }
    cells
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
}
