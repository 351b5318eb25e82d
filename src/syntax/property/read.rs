use super::block::{Block, Cell, Parameter, Table};
use crate::Number;
use crate::diagnostic::{Checked, Code, Diagnostic};
use crate::lines::physical_line;
use crate::number::parse_number;
use crate::text::{Source, Span};

/// Maximum number of diagnostics for one file.
const MOST_COMPLAINTS: usize = 50;

/// Reads all blocks of a TeimOrbit file line by line, whatever their names are.
pub(super) fn blocks(source: &Source) -> Checked<Vec<Block>> {
    let mut reader = Reader {
        source,
        blocks: Vec::new(),
        open_table: false,
        diagnostics: Vec::new(),
    };
    let bytes = source.bytes();
    let mut at = 0;
    while at < bytes.len() {
        let line = physical_line(bytes, at);
        at = line.next;
        let span = without_comment(bytes, line.span);
        if !span.is_empty() {
            reader.line(span);
        }
    }
    reader.diagnostics.truncate(MOST_COMPLAINTS);
    Checked {
        value: reader.blocks,
        diagnostics: reader.diagnostics,
    }
}

struct Reader<'a> {
    source: &'a Source,
    blocks: Vec<Block>,
    /// True while the next row belongs to the last table.
    open_table: bool,
    diagnostics: Vec<Diagnostic>,
}

impl Reader<'_> {
    fn line(&mut self, span: Span) {
        let line = self.source.slice(span);
        match (line[0], line[line.len() - 1]) {
            (b'[', b']') => {
                let name = self.upper(inside(span));
                self.open(name, None, span);
            }
            (b'(', b')') => {
                let name = self.blocks.last().map(|block| block.name.clone());
                let part = self.upper(inside(span));
                self.open(name.unwrap_or_default(), Some(part), span);
            }
            (b'{', b'}') => {
                let columns = cells(self.source, inside(span))
                    .iter()
                    .map(|cell| self.source.text(cell.span()).to_lowercase())
                    .collect();
                let table = Table {
                    columns,
                    rows: Vec::new(),
                    span,
                };
                if let Some(block) = self.block(span) {
                    block.tables.push(table);
                    self.open_table = true;
                }
            }
            _ => match equals(line) {
                Some(mark) => self.parameter(span, span.start() + mark),
                None => self.row(span),
            },
        }
    }

    fn open(&mut self, name: String, part: Option<String>, heading: Span) {
        self.open_table = false;
        self.blocks.push(Block {
            name,
            part,
            heading,
            parameters: Vec::new(),
            tables: Vec::new(),
        });
    }

    /// Returns the block that contains the current line. If no block was opened, reports an error.
    fn block(&mut self, span: Span) -> Option<&mut Block> {
        if self.blocks.is_empty() {
            self.complain(
                Diagnostic::error(
                    Code::SyntaxError,
                    "this line is outside of any block: write a heading such as [UNITS] above it",
                ),
                span,
            );
        }
        self.blocks.last_mut()
    }

    fn parameter(&mut self, span: Span, equals: usize) {
        self.open_table = false;
        let name = self.upper(trimmed(self.source, Span::new(span.start(), equals)));
        let value = trimmed(self.source, Span::new(equals + 1, span.end()));
        let value = cells(self.source, value)
            .first()
            .copied()
            .unwrap_or(Cell::Text(value));
        if let Some(block) = self.block(span) {
            block.parameters.push(Parameter { name, value, span });
        }
    }

    fn row(&mut self, span: Span) {
        let row = cells(self.source, span);
        let begins_table = !self.open_table;
        let Some(block) = self.block(span) else {
            return;
        };
        if begins_table {
            block.tables.push(Table {
                columns: Vec::new(),
                rows: Vec::new(),
                span,
            });
        }
        let Some(table) = block.tables.last_mut() else {
            return;
        };
        table.span = table.span.join(span);
        // A heading of one word may stand above rows of several texts; the first row then gives the width.
        let width = match (table.columns.len(), table.rows.first()) {
            (_, Some(first)) => first.len(),
            (0 | 1, None) => row.len(),
            (columns, None) => columns,
        };
        let found = row.len();
        let is_remark = table.is_remark(&row) && !table.rows.is_empty();
        table.rows.push(row);
        self.open_table = true;
        if found != width && !is_remark {
            self.complain(
                Diagnostic::error(
                    Code::WrongCount,
                    format!("the row has {found} values, but its table has {width} columns"),
                ),
                span,
            );
        }
    }

    fn upper(&self, span: Span) -> String {
        self.source.text(span).trim().to_ascii_uppercase()
    }

    fn complain(&mut self, diagnostic: Diagnostic, span: Span) {
        if self.diagnostics.len() < MOST_COMPLAINTS {
            self.diagnostics
                .push(diagnostic.label(self.source.name(), span, ""));
        }
    }
}

/// Returns the span of a line without surrounding blanks and without its comment. A comment starts at `$` or `!` outside of quotes.
fn without_comment(bytes: &[u8], line: Span) -> Span {
    let text = &bytes[line.range()];
    let mut quoted = false;
    let end = text
        .iter()
        .position(|byte| {
            quoted ^= *byte == b'\'';
            !quoted && matches!(byte, b'$' | b'!')
        })
        .unwrap_or(text.len());
    let text = &text[..end];
    let front = text.len() - text.trim_ascii_start().len();
    let length = text.trim_ascii().len();
    Span::new(line.start() + front, line.start() + front + length)
}

const fn inside(span: Span) -> Span {
    Span::new(span.start() + 1, span.end() - 1)
}

fn trimmed(source: &Source, span: Span) -> Span {
    let text = source.slice(span);
    let front = text.len() - text.trim_ascii_start().len();
    let start = span.start() + front;
    Span::new(start, start + text.trim_ascii().len())
}

/// Returns the position of the first equals sign outside of quotes.
fn equals(line: &[u8]) -> Option<usize> {
    let mut quoted = false;
    line.iter().position(|byte| {
        quoted ^= *byte == b'\'';
        !quoted && *byte == b'='
    })
}

/// Splits a line into cells, which are separated by blanks, commas or tabs. A text in single quotes may contain blanks.
fn cells(source: &Source, span: Span) -> Vec<Cell> {
    let bytes = &source.bytes()[..span.end()];
    let mut found = Vec::new();
    let mut at = span.start();
    while at < bytes.len() {
        if bytes[at].is_ascii_whitespace() || bytes[at] == b',' {
            at += 1;
            continue;
        }
        if bytes[at] == b'\'' {
            let length = memchr::memchr(b'\'', &bytes[at + 1..]);
            let end = length.map_or(bytes.len(), |length| at + 1 + length);
            found.push(Cell::Text(Span::new(at + 1, end)));
            at = end + 1;
            continue;
        }
        let end = bytes[at..]
            .iter()
            .position(|byte| byte.is_ascii_whitespace() || *byte == b',')
            .map_or(bytes.len(), |length| at + length);
        let word = Span::new(at, end);
        found.push(match parse_number(source.slice(word)) {
            Some((value, false)) => Cell::Number(Number {
                value,
                degrees: false,
                span: word,
            }),
            _ => Cell::Text(word),
        });
        at = end;
    }
    found
}
