//! Removal of statements and arguments from a dataset, together with the comments and separators that belong to them.

use super::{Address, Argument, Dataset, Statement, Value};
use crate::diagnostic::{Code, Diagnostic};
use crate::text::{Edit, Span};

impl Dataset {
    /// Returns the edits that remove a statement and the comments with its name, or only one of its arguments if the address gives one.
    ///
    /// # Errors
    /// Returns `undefined-id` if the statement does not exist, and `unknown-argument` if the argument is not written. Returns
    /// `missing-argument` if the statement is a body to which later markers belong without naming it; after its removal they would belong
    /// to the preceding body.
    pub fn remove(&self, address: &Address) -> Result<Vec<Edit>, Diagnostic> {
        let at = self
            .position(&address.kind, address.id)
            .ok_or_else(|| self.absent(address))?;
        if let Some(name) = &address.argument {
            let statement = &self.statements()[at];
            let mut written = statement.every(name).peekable();
            if written.peek().is_none() {
                let message = format!("{address} is not written in this dataset");
                return Err(self.refuse(Code::UnknownArgument, message, statement.keyword));
            }
            return Ok(written
                .map(|argument| self.without(statement, argument))
                .collect());
        }
        match self.carried(at).next() {
            Some(marker) => Err(self.stranded(at, marker)),
            None => Ok(vec![self.without_statement(&self.statements()[at])]),
        }
    }

    /// Returns the indices of the markers that belong to a body without naming it: markers that name no body, between this body and the
    /// next.
    pub(super) fn carried(&self, body: usize) -> impl Iterator<Item = usize> + '_ {
        let statements = self.statements();
        let behind = if statements[body].carries_markers() {
            &statements[body + 1..]
        } else {
            &[]
        };
        behind
            .iter()
            .enumerate()
            .take_while(|(_, other)| !other.carries_markers())
            .filter(|(_, other)| other.follows_body())
            .map(move |(k, _)| body + 1 + k)
    }

    /// Returns the error that a body cannot be removed because the given marker belongs to it without naming it.
    pub(super) fn stranded(&self, body: usize, marker: usize) -> Diagnostic {
        let (body, marker) = (&self.statements()[body], &self.statements()[marker]);
        let address = Address::of(body).map_or_else(String::new, |address| address.to_string());
        let id = marker.number().unwrap_or_default();
        self.refuse(
            Code::MissingArgument,
            format!(
                "MARKER/{id} names no body and belongs to {address} by its position: remove the marker first, or add its body, such as PART=id"
            ),
            marker.keyword,
        )
    }

    /// Returns the edit that removes a statement and the comments with its name.
    pub(super) fn without_statement(&self, statement: &Statement) -> Edit {
        let start = self.line_start(statement.span.start());
        let line_end = self.line_end(statement.span.end());
        let shared = self.statements().iter().any(|other| {
            other.span != statement.span
                && other.span.start() < line_end
                && other.span.end() > start
        });
        if shared {
            // Other statements share the line, separated by semicolons.
            return Edit::new(statement.span, "");
        }
        let mut from = start;
        if let Some(name) = statement.view_name {
            let comment = self.line_start(name.start());
            from = comment;
            // ADAMS/View writes an empty comment line before each name; it is removed as well.
            if comment > 0 {
                let end = self.bytes()[..comment]
                    .strip_suffix(b"\n")
                    .unwrap_or(&self.bytes()[..comment]);
                let end = end.strip_suffix(b"\r").unwrap_or(end);
                let before = self.line_start(end.len());
                if self.bytes()[before..comment].trim_ascii() == b"!" {
                    from = before;
                }
            }
        }
        Edit::new(Span::new(from, line_end), "")
    }

    /// Returns the edit that removes an argument and the separator before it.
    pub(super) fn without(&self, statement: &Statement, argument: &Argument) -> Edit {
        let before = statement
            .arguments
            .iter()
            .rfind(|other| other.span.end() <= argument.span.start());
        let after_function = before
            .is_some_and(|before| matches!(before.value, Value::Function(_) | Value::User(_)));
        let rest = &self.bytes()[argument.span.end()..statement.span.end()];
        let backslash = rest
            .iter()
            .position(|byte| !byte.is_ascii_whitespace())
            .filter(|at| rest[*at] == b'\\');
        match backslash {
            // A backslash ends a function. It is removed with the argument, unless the argument before it is a function that now needs the
            // backslash.
            Some(at) if !after_function => {
                let start = argument.span.start();
                Edit::new(Span::new(start, argument.span.end() + at + 1), "")
            }
            _ => {
                let start =
                    before.map_or_else(|| self.after_header(statement), |before| before.span.end());
                Edit::new(Span::new(start, argument.span.end()), "")
            }
        }
    }
}
