use std::borrow::Cow;

use super::super::Number;
use crate::text::{Source, Span};

/// A block `[NAME]` of a property file, or a part `(PART)` of a block, with its content.
#[derive(Clone, PartialEq, Debug)]
pub struct Block {
    /// Name of the block, in capitals.
    pub name: String,
    /// Name of the part in capitals; `None` for the block itself.
    pub part: Option<String>,
    /// Location of the heading `[NAME]` or `(PART)`.
    pub heading: Span,
    /// The `NAME = value` lines.
    pub parameters: Vec<Parameter>,
    /// Tables in the order of the file.
    pub tables: Vec<Table>,
}

/// A line `NAME = value`.
#[derive(Clone, PartialEq, Debug)]
pub struct Parameter {
    /// Name in capitals.
    pub name: String,
    /// Value after the equals sign.
    pub value: Cell,
    /// Location of the line, without surrounding blanks and without its comment.
    pub span: Span,
}

/// A table: rows of cells under a heading in braces.
#[derive(Clone, PartialEq, Debug)]
pub struct Table {
    /// Words of the heading in lower case, one for each column; empty if the rows have no heading.
    pub columns: Vec<String>,
    /// Cells, row by row.
    pub rows: Vec<Vec<Cell>>,
    /// Span from the heading to the last row.
    pub span: Span,
}

/// A single value of a parameter, or a single cell of a table.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Cell {
    /// A number; property files have no degree suffix.
    Number(Number),
    /// A text; the span excludes its quotes.
    Text(Span),
}

impl Block {
    /// Returns the last parameter with this name, which is given in capitals.
    pub fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters
            .iter()
            .rev()
            .find(|parameter| parameter.name == name)
    }
}

impl Parameter {
    /// Returns the value if it is a number.
    pub fn number(&self) -> Option<f64> {
        self.value.number()
    }

    /// Returns the text of the value, without quotes and surrounding blanks.
    pub fn text<'s>(&self, source: &'s Source) -> Cow<'s, str> {
        self.value.text(source)
    }
}

impl Table {
    /// Returns true for a row of a single text in a table of several columns. Such a row is a remark on the row above it, for example on a row
    /// of parameters in an assembly file.
    pub fn is_remark(&self, row: &[Cell]) -> bool {
        self.columns.len() > 1 && matches!(row, [Cell::Text(_)])
    }
}

impl Cell {
    /// Returns the number in the cell, or `None` if the cell is a text.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(number.value),
            Self::Text(_) => None,
        }
    }

    /// Returns the text of the cell, without quotes and surrounding blanks.
    pub fn text<'s>(&self, source: &'s Source) -> Cow<'s, str> {
        match source.text(self.span()) {
            Cow::Borrowed(text) => Cow::Borrowed(text.trim()),
            Cow::Owned(text) => Cow::Owned(text.trim().to_string()),
        }
    }

    /// Returns the location of the cell.
    pub fn span(&self) -> Span {
        match self {
            Self::Number(number) => number.span,
            Self::Text(span) => *span,
        }
    }
}
