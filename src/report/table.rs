use std::fmt::Write as _;

use super::escape;

/// How a column is aligned.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
    /// Long words that may wrap.
    Wrap,
}

#[derive(Clone, Debug)]
struct Cell {
    text: String,
    class: Option<&'static str>,
    /// A drawing of this crate in place of the text, which then says what is drawn.
    picture: Option<String>,
}

/// From so many columns on a table does not fit a telephone.
const CARDS: usize = 5;

/// A table of texts.
#[derive(Clone, Debug, Default)]
pub struct Table {
    columns: Vec<(String, Align)>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// A table with these column heads.
    pub fn new(columns: &[(&str, Align)]) -> Self {
        let columns = columns
            .iter()
            .map(|(name, align)| ((*name).to_string(), *align))
            .collect();
        Self {
            columns,
            rows: Vec::new(),
        }
    }

    /// Adds a row of plain cells; missing cells stay empty.
    pub fn row<S: Into<String>>(&mut self, cells: impl IntoIterator<Item = S>) -> &mut Self {
        self.rows.push(
            cells
                .into_iter()
                .map(|cell| Cell {
                    text: cell.into(),
                    class: None,
                    picture: None,
                })
                .collect(),
        );
        self
    }

    /// Marks a cell of the last row with a class of the page's style: `good`, `bad` or `soft`.
    pub(crate) fn mark(&mut self, column: usize, class: &'static str) -> &mut Self {
        if let Some(cell) = self.rows.last_mut().and_then(|row| row.get_mut(column)) {
            cell.class = Some(class);
        }
        self
    }

    /// Replaces a cell of the last row by a drawing of this module; the cell's text becomes its description.
    pub(super) fn picture(&mut self, column: usize, svg: String) -> &mut Self {
        if let Some(cell) = self.rows.last_mut().and_then(|row| row.get_mut(column)) {
            cell.picture = Some(svg);
        }
        self
    }

    pub(super) fn html(&self) -> String {
        let class = |align: Align, mark: Option<&str>| {
            let align = match align {
                Align::Left => "",
                Align::Right => "right",
                Align::Wrap => "wrap",
            };
            let both = [align, mark.unwrap_or("")].join(" ");
            if both.trim().is_empty() {
                String::new()
            } else {
                format!(" class=\"{}\"", both.trim())
            }
        };
        // On a telephone a row of many cells becomes a card.
        let cards = if self.columns.len() >= CARDS {
            " class=\"cards\""
        } else {
            ""
        };
        let mut out = format!("<table{cards}>\n<thead><tr>");
        for (name, align) in &self.columns {
            write!(
                out,
                "<th scope=\"col\"{}>{}</th>",
                class(*align, None),
                escape(name)
            )
            .expect("a String takes all");
        }
        out.push_str("</tr></thead>\n<tbody>\n");
        for row in &self.rows {
            out.push_str("<tr>");
            for (k, (_, align)) in self.columns.iter().enumerate() {
                let cell = row.get(k);
                let class = class(*align, cell.and_then(|cell| cell.class));
                let inside = cell.map_or_else(String::new, |cell| {
                    cell.picture.clone().unwrap_or_else(|| escape(&cell.text))
                });
                // The first cell names its row.
                let (open, close) = if k == 0 {
                    ("th scope=\"row\"", "th")
                } else {
                    ("td", "td")
                };
                let head = if k == 0 || cards.is_empty() {
                    String::new()
                } else {
                    format!(" data-head=\"{}\"", escape(&self.columns[k].0))
                };
                write!(out, "<{open}{class}{head}>{inside}</{close}>").expect("a String takes all");
            }
            out.push_str("</tr>\n");
        }
        out.push_str("</tbody>\n</table>");
        out
    }
}
