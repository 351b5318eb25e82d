//! Parsing of statements that a user typed. The statements are then added to a dataset in the style of this dataset.

use super::lines::logical_lines;
use super::statement::{NO_OWNER, without_continuation};
use super::statements::parse_lines;
use super::{Argument, NewStatement, Statement};
use crate::diagnostic::{Checked, Code, Diagnostic, Severity};
use crate::grammar::Role;
use crate::text::{Source, Span};

impl NewStatement {
    /// Parses statements from a text without a title line, such as `MARKER/99, PART=2, QP=1,2,3`, in any spelling that is legal in a
    /// dataset.
    ///
    /// Values are kept as typed, and continuation lines are joined. Unknown statements or arguments, unreadable values, and a MARKER that
    /// names no body are errors. If there is an error, the returned list is empty.
    pub fn read(source: &Source) -> Checked<Vec<Self>> {
        let (lines, _) = logical_lines(source.bytes(), 0, false);
        let (statements, mut diagnostics) = parse_lines(source, &lines, Role::Dataset);
        let unknown = |place: Span, what: &str| {
            let text = source.text(place).into_owned();
            Diagnostic::error(Code::SyntaxError, format!("{text} {what}")).label(
                source.name(),
                place,
                "",
            )
        };
        for statement in &statements {
            let Some(def) = statement.def else {
                diagnostics.push(unknown(statement.keyword, "cannot be added"));
                continue;
            };
            if matches!(def.name, "TITLE" | "END") {
                diagnostics.push(unknown(
                    statement.keyword,
                    "cannot be added: a dataset has exactly one",
                ));
            }
            if statement.follows_body() {
                diagnostics.push(unknown(statement.span, NO_OWNER));
            }
            for argument in &statement.arguments {
                if argument.def.is_none() {
                    diagnostics.push(unknown(
                        argument.name,
                        "is not an argument that can be added",
                    ));
                }
            }
        }
        let failed = diagnostics
            .iter()
            .any(|found| found.severity == Severity::Error);
        let value = if failed {
            Vec::new()
        } else {
            let read = |statement| Self::of(statement, source);
            statements.iter().filter_map(read).collect()
        };
        Checked { value, diagnostics }
    }

    fn of(statement: &Statement, source: &Source) -> Option<Self> {
        let ends = statement.arguments.iter().skip(1);
        let ends = ends
            .map(|next| next.name.start())
            .chain([statement.span.end()]);
        let arguments = statement.arguments.iter().zip(ends);
        Some(Self {
            kind: statement.kind()?.to_string(),
            id: statement.number(),
            view_name: statement
                .view_name
                .map(|name| source.text(name).into_owned()),
            arguments: arguments
                .map(|(argument, end)| {
                    let name = argument.kind().unwrap_or_default().to_string();
                    (name, value(argument, end, source))
                })
                .collect(),
        })
    }
}

/// Returns the text between the equals sign of an argument and the next argument; `None` if there is no equals sign.
fn value(argument: &Argument, end: usize, source: &Source) -> Option<String> {
    let typed = source.text(Span::new(argument.name.end(), end));
    let typed = without_continuation(&typed);
    let value = typed.trim().strip_prefix('=')?;
    Some(
        value
            .trim_matches(|c: char| c.is_whitespace() || c == ',' || c == ';')
            .to_string(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Checked<Vec<NewStatement>> {
        NewStatement::read(&Source::new("typed", text.as_bytes()))
    }

    #[test]
    fn values_are_kept_as_they_are_typed() {
        let read = read(
            "! adams_view_name='tip'\nmark/99, part=2, qp=1.0, 2, -3E0\n, REULER = 90D,0, 0\n\
             SFORCE/3, FUNCTION=STEP(TIME, 0, 0,\n, 1, 5)\\, I=99, TRANS; STRING/1, STRING=\"a, b\"",
        );
        assert_eq!(read.diagnostics, []);
        let shown: Vec<String> = read
            .value
            .iter()
            .map(|new| {
                let arguments = new.arguments.iter();
                let all: Vec<String> = arguments
                    .map(|(name, value)| format!("{name}:{}", value.as_deref().unwrap_or("-")))
                    .collect();
                format!("{}/{:?} {}", new.kind, new.id.unwrap(), all.join(" | "))
            })
            .collect();
        assert_eq!(
            shown,
            [
                "MARKER/99 PART:2 | QP:1.0, 2, -3E0 | REULER:90D,0, 0",
                "SFORCE/3 FUNCTION:STEP(TIME, 0, 0, 1, 5)\\ | I:99 | TRANSLATIONAL:-",
                "STRING/1 STRING:\"a, b\"",
            ]
        );
        assert_eq!(read.value[0].view_name.as_deref(), Some("tip"));
    }

    #[test]
    fn what_no_deck_could_hold_is_refused() {
        for text in [
            "END",
            "MARKER/1, QP=1, 2, 3",
            "MARKR/1",
            "MARKER/1, QQQ=3",
            "MARKER/1, QP=a",
            "TITLE/x",
            "5",
        ] {
            let read = read(text);
            assert!(
                read.value.is_empty() && !read.diagnostics.is_empty(),
                "{text}"
            );
        }
    }
}
