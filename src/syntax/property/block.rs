use std::borrow::Cow;

use super::super::Number;
use crate::text::{Source, Span};

/// A block `[NAME]`, or a part `(PART)` of it, with what stands in it.
#[derive(Clone, PartialEq, Debug)]
pub struct Block {
    /// Its name in capitals.
    pub name: String,
    /// The name of the part in capitals; absent for what stands in the block itself.
    pub part: Option<String>,
    /// Where its heading stands.
    pub heading: Span,
    /// `NAME = value` lines.
    pub parameters: Vec<Parameter>,
    /// Tables in their order.
    pub tables: Vec<Table>,
}

/// `NAME = value`.
#[derive(Clone, PartialEq, Debug)]
pub struct Parameter {
    /// Its name in capitals.
    pub name: String,
    /// What it is.
    pub value: Cell,
}

/// Rows under a heading in braces.
#[derive(Clone, PartialEq, Debug)]
pub struct Table {
    /// The words of the heading, in lower case; empty for rows without one.
    pub columns: Vec<String>,
    /// Row by row.
    pub rows: Vec<Vec<Cell>>,
    /// From the heading to the last row.
    pub span: Span,
}

/// One value.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Cell {
    /// A number as written; no degree suffix here.
    Number(Number),
    /// A text, quotes not included.
    Text(Span),
}

impl Block {
    /// The last parameter of this name in capitals.
    pub(crate) fn parameter(&self, name: &str) -> Option<&Parameter> {
        self.parameters
            .iter()
            .rev()
            .find(|parameter| parameter.name == name)
    }
}

impl Parameter {
    /// Its number, if it is one.
    pub(crate) fn number(&self) -> Option<f64> {
        self.value.number()
    }

    /// Its text without quotes and blanks around it.
    pub(crate) fn text<'s>(&self, source: &'s Source) -> Cow<'s, str> {
        match source.text(self.value.span()) {
            Cow::Borrowed(text) => Cow::Borrowed(text.trim()),
            Cow::Owned(text) => Cow::Owned(text.trim().to_string()),
        }
    }
}

impl Cell {
    /// Its number, if it is one.
    pub(crate) fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(number.value),
            Self::Text(_) => None,
        }
    }

    /// Where it stands.
    pub fn span(&self) -> Span {
        match self {
            Self::Number(number) => number.span,
            Self::Text(span) => *span,
        }
    }
}
