use std::fmt::Write as _;

use super::escape;
use super::escape::prose;

/// Alignment of a table column.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Align {
    /// Left-aligned, for words.
    Left,
    /// Right-aligned, for numbers.
    Right,
    /// Left-aligned with line breaks, for long texts. Text in backticks is set as code.
    Wrap,
}

#[derive(Clone, Debug)]
struct Cell {
    text: String,
    class: Option<&'static str>,
    /// SVG drawing shown in place of the text. The text then describes the drawing.
    picture: Option<String>,
}

/// Number of columns at and above which a table is too wide for a phone.
const CARDS: usize = 4;

/// Class of a row that is the heading of the rows below it.
const GROUP: &str = "group";

/// Table of texts, with a heading for each column.
#[derive(Clone, Debug, Default)]
pub struct Table {
    columns: Vec<(String, Align)>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    /// Creates a table with these column headings.
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

    /// Adds a row of plain cells. Missing cells remain empty.
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

    /// Adds a row with the heading of the rows that follow, over all columns.
    pub(super) fn group(&mut self, text: &str) -> &mut Self {
        self.row([text]);
        if let Some(cell) = self.rows.last_mut().and_then(|row| row.first_mut()) {
            cell.class = Some(GROUP);
        }
        self
    }

    /// Sets the class of a cell in the last row, from the page's style sheet: `good`, `bad` or `soft`. An empty text sets none.
    pub fn mark(&mut self, column: usize, class: &'static str) -> &mut Self {
        if let Some(cell) = self.rows.last_mut().and_then(|row| row.get_mut(column)) {
            cell.class = Some(class);
        }
        self
    }

    /// Shows an SVG drawing in place of a cell's text in the last row. The text then describes the drawing.
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
        // On a phone, each row of a wide table becomes a card.
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
            if let Some(cell) = row.first().filter(|cell| cell.class == Some(GROUP)) {
                writeln!(
                    out,
                    "<tr class=\"{GROUP}\"><th scope=\"colgroup\" colspan=\"{}\">{}</th></tr>",
                    self.columns.len(),
                    escape(&cell.text)
                )
                .expect("a String takes all");
                continue;
            }
            out.push_str("<tr>");
            for (k, (_, align)) in self.columns.iter().enumerate() {
                let cell = row.get(k);
                let class = class(*align, cell.and_then(|cell| cell.class));
                let inside = cell.map_or_else(String::new, |cell| {
                    let text = || match align {
                        Align::Wrap => prose(&cell.text),
                        Align::Left | Align::Right => escape(&cell.text),
                    };
                    cell.picture.clone().unwrap_or_else(text)
                });
                // The first cell is the heading of its row.
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
