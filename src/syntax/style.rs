use super::new_statement::NewStatement;
use super::{Dataset, Statement};
use crate::grammar::{STATEMENTS, ValueKind};
use crate::text::Span;

/// Style that prevails among the statements of a file. New statements and arguments are written in this style.
#[derive(Clone, PartialEq, Eq, Debug)]
pub(super) struct Style {
    /// Line end of the file, `\n` or `\r\n`.
    pub line_end: &'static str,
    layout: Layout,
    /// True if equals signs are surrounded by blanks (` = `), false if they are not (`=`).
    spaced: bool,
    /// True if the first argument of a statement without id directly follows the slash: `UNITS/FORCE = NEWTON`. ADAMS/View writes it on the
    /// next line.
    pub behind_slash: bool,
}

/// Layout of the arguments of a statement.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Layout {
    /// Each argument has its own line, which begins with a comma.
    Comma,
    /// Each argument has its own line, and the preceding line ends with `&`.
    Ampersand,
    /// All arguments are on the line of the keyword.
    OneLine,
}

impl Style {
    /// Returns the style that prevails among the first 200 statements with arguments in a dataset.
    pub(crate) fn of(dataset: &Dataset) -> Self {
        let sample = dataset
            .statements()
            .iter()
            .filter(|statement| !statement.arguments.is_empty())
            .take(200);
        let mut counts = [0usize; 3];
        let mut spaced = 0isize;
        for statement in sample {
            let style = Self::of_statement(dataset, statement);
            counts[style.layout as usize] += 1;
            spaced += if style.spaced { 1 } else { -1 };
        }
        let layouts = [Layout::Comma, Layout::Ampersand, Layout::OneLine];
        let most = (0..3).max_by_key(|k| (counts[*k], 3 - k)).unwrap_or(0);
        Self {
            line_end: line_end(dataset.bytes()),
            layout: layouts[most],
            spaced: spaced >= 0,
            behind_slash: layouts[most] == Layout::OneLine || most_stand_behind_slash(dataset),
        }
    }

    /// Returns the style of one statement.
    pub(crate) fn of_statement(dataset: &Dataset, statement: &Statement) -> Self {
        let text = dataset.source().slice(statement.span);
        let layout = match memchr::memchr2(b'\n', b'\r', text) {
            None => Layout::OneLine,
            Some(at) if text[..at].trim_ascii_end().ends_with(b"&") => Layout::Ampersand,
            Some(_) => Layout::Comma,
        };
        // A statement without arguments shows no layout. The layout of ADAMS/View is then assumed: one argument per line.
        let layout = if statement.arguments.is_empty() {
            Layout::Comma
        } else {
            layout
        };
        let spaced = memchr::memchr(b'=', text)
            .is_none_or(|at| at > 0 && text[at - 1] == b' ' && text.get(at + 1) == Some(&b' '));
        Self {
            line_end: line_end(dataset.bytes()),
            layout,
            spaced,
            behind_slash: is_behind_slash(dataset, statement).unwrap_or(layout == Layout::OneLine),
        }
    }

    /// Formats an argument and the separator before it: `, NAME = value`.
    pub(crate) fn argument(&self, name: &str, value: Option<&str>) -> String {
        let lead = match self.layout {
            Layout::Comma => format!("{}, ", self.line_end),
            Layout::Ampersand => format!(" &{}, ", self.line_end),
            Layout::OneLine => ", ".to_string(),
        };
        match (value, self.spaced) {
            (Some(value), true) => format!("{lead}{name} = {value}"),
            (Some(value), false) => format!("{lead}{name}={value}"),
            (None, _) => format!("{lead}{name}"),
        }
    }

    /// Formats the comment line that gives an ADAMS/View name to the statement below it.
    pub(crate) fn name_comment(&self, name: &str) -> String {
        // ADAMS/View centres the text of the comment on column 41.
        let comment = format!("adams_view_name='{name}'");
        let pad = " ".repeat(40usize.saturating_sub(comment.len().div_ceil(2)).max(1));
        format!("!{pad}{comment}{}", self.line_end)
    }

    /// Formats a whole statement, with the comment of its name and with line ends.
    pub(crate) fn statement(&self, new: &NewStatement) -> String {
        let mut text = String::new();
        let end = self.line_end;
        if let Some(name) = &new.view_name {
            text = format!("!{end}{}", self.name_comment(name));
        }
        text.push_str(&new.kind);
        text.push('/');
        if let Some(id) = new.id {
            text.push_str(&id.to_string());
        }
        let last = new.arguments.len().saturating_sub(1);
        for (at, (name, value)) in new.arguments.iter().enumerate() {
            text.push_str(&self.argument(name, value.as_deref()));
            // Without a backslash at its end, the function would continue with the next argument.
            if at < last && is_function(&new.kind, name) && !text.ends_with('\\') {
                text.push('\\');
            }
        }
        text.push_str(end);
        text
    }
}

/// Returns true if most statements without id have their first argument on the line of the keyword.
fn most_stand_behind_slash(dataset: &Dataset) -> bool {
    let all = dataset.statements().iter();
    let told = all.filter_map(|statement| is_behind_slash(dataset, statement));
    told.fold(0isize, |sum, behind| sum + if behind { 1 } else { -1 }) > 0
}

/// Returns whether the first argument of a statement without id is on the line of the keyword; `None` for other statements.
fn is_behind_slash(dataset: &Dataset, statement: &Statement) -> Option<bool> {
    let first = statement.arguments.first()?;
    statement.def.filter(|_| statement.id.is_none())?;
    let between = Span::new(statement.keyword.end(), first.name.start());
    let text = dataset.source().slice(between);
    Some(memchr::memchr2(b'\n', b'\r', text).is_none())
}

fn is_function(kind: &str, argument: &str) -> bool {
    let def = STATEMENTS.iter().find(|def| def.name == kind);
    let mut arguments = def.map_or(&[][..], |def| def.arguments).iter();
    arguments.any(|def| def.name == argument && def.kind == ValueKind::Function)
}

/// Returns the line end of the first line.
fn line_end(bytes: &[u8]) -> &'static str {
    match memchr::memchr(b'\n', bytes) {
        Some(at) if at > 0 && bytes[at - 1] == b'\r' => "\r\n",
        _ => "\n",
    }
}
