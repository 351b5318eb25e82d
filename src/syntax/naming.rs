//! Changes of the title and of ADAMS/View names, as edits of a dataset.

use super::statements::BOM;
use super::style::Style;
use super::{Dataset, Statement};
use crate::diagnostic::{Code, Diagnostic};
use crate::text::{Edit, Span};

impl Dataset {
    /// Returns the edits that replace the title. The title is the first line without its surrounding blanks.
    pub(super) fn set_title(&self, text: &str) -> Result<Vec<Edit>, Diagnostic> {
        let line = self.title_span();
        if text.contains(['\n', '\r']) {
            let message = "the title must be a single line".to_string();
            return Err(self.refuse(Code::SyntaxError, message, line));
        }
        if text == self.title() {
            return Ok(Vec::new());
        }
        let mut bytes = self.source().slice(line);
        let mut start = line.start();
        if let Some(rest) = bytes.strip_prefix(BOM) {
            start += BOM.len();
            bytes = rest;
        }
        start += bytes.len() - bytes.trim_ascii_start().len();
        let end = (start + bytes.trim_ascii().len()).min(line.end());
        Ok(vec![Edit::new(Span::new(start, end), self.encoded(text))])
    }

    /// Returns the edit that changes, removes or adds the ADAMS/View name of a statement; `None` if the statement already has that name.
    ///
    /// # Errors
    /// Returns `syntax-error` for a name that cannot be written in the comment.
    pub(super) fn rename(
        &self,
        statement: &Statement,
        name: Option<&str>,
    ) -> Result<Option<Edit>, Diagnostic> {
        let refused = |message: String| self.refuse(Code::SyntaxError, message, statement.keyword);
        if name.is_some_and(str::is_empty) {
            return Err(refused("the view name is empty".to_string()));
        }
        if name.is_some_and(|name| name.contains(['\n', '\r', '\''])) {
            let message = "the view name contains a single quote or a line break";
            return Err(refused(message.to_string()));
        }
        Ok(match (statement.view_name, name) {
            (None, None) => None,
            (Some(old), Some(new)) if self.source().text(old) == new => None,
            (Some(old), Some(new)) => Some(Edit::new(old, self.encoded(new))),
            (Some(old), None) => {
                let line = Span::new(self.line_start(old.start()), self.line_end(old.end()));
                let comment = self.source().slice(line).trim_ascii();
                // Other text on the line is kept.
                Some(if comment.starts_with(b"!") && comment.ends_with(b"'") {
                    Edit::new(line, "")
                } else {
                    Edit::new(old, "")
                })
            }
            (None, Some(new)) => {
                let start = self.line_start(statement.span.start());
                let lead = &self.bytes()[start..statement.span.start()];
                if !lead.trim_ascii().is_empty() {
                    let message = "the statement cannot have a view name: the name is a comment on a line of its own, but other text precedes the statement on its line";
                    return Err(refused(message.to_string()));
                }
                let comment = Style::of(self).name_comment(new);
                Some(Edit::new(Span::at(start), self.encoded(&comment)))
            }
        })
    }
}
