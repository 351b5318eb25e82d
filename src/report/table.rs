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

/// A table of texts.
#[derive(Clone, Debug, Default)]
pub struct Table {
    columns: Vec<(String, Align)>,
    rows: Vec<Vec<(String, Option<&'static str>)>>,
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
        self.rows
            .push(cells.into_iter().map(|cell| (cell.into(), None)).collect());
        self
    }

    /// Marks a cell of the last row with a class of the page's style: `good`, `bad` or `soft`.
    pub fn mark(&mut self, column: usize, class: &'static str) -> &mut Self {
        if let Some(cell) = self.rows.last_mut().and_then(|row| row.get_mut(column)) {
            cell.1 = Some(class);
        }
        self
    }

    /// True if it has no rows.
    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
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
        let mut out = String::from("<table>\n<thead><tr>");
        for (name, align) in &self.columns {
            write!(out, "<th{}>{}</th>", class(*align, None), escape(name))
                .expect("a String takes all");
        }
        out.push_str("</tr></thead>\n<tbody>\n");
        for row in &self.rows {
            out.push_str("<tr>");
            for (k, (_, align)) in self.columns.iter().enumerate() {
                let (text, mark) = row
                    .get(k)
                    .map_or(("", None), |(text, mark)| (text.as_str(), *mark));
                write!(out, "<td{}>{}</td>", class(*align, mark), escape(text))
                    .expect("a String takes all");
            }
            out.push_str("</tr>\n");
        }
        out.push_str("</tbody>\n</table>");
        out
    }
}
