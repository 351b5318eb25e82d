//! Context of the text being typed, from the part of the statement before the cursor.

use super::document::Document;
use admire_syntax::expression::argument_space;
use admire_syntax::grammar::{
    ArgumentDef, Role, STATEMENTS, StatementDef, ValueKind, find_argument, find_function,
    find_statement,
};
use admire_syntax::text::Span;

/// Kind of text that may follow at a position.
pub(super) enum Typing {
    /// The keyword of a statement.
    Keyword,
    /// The id of a statement.
    Id(&'static StatementDef),
    /// An argument of a statement, with the names of the arguments that the statement already has.
    Argument(&'static StatementDef, Vec<&'static str>),
    /// A value of this argument.
    Value(&'static ArgumentDef),
    /// An id from this id space, expected in an argument, in a function, or in the list of a command.
    Reference(&'static str),
    /// Part of an expression.
    Expression,
}

/// A position in the text with the word typed so far.
pub(super) struct Place {
    /// Kind of text that may follow.
    pub typing: Typing,
    /// Span of the word typed so far.
    pub word: Span,
}

/// A function call whose parentheses are still open.
pub(super) struct OpenCall {
    /// Name of the function, in upper case.
    pub name: String,
    /// Index of the argument being typed, from 0.
    pub argument: usize,
}

/// Largest distance that is searched backwards for the start of a statement, in bytes.
const MOST_BYTES: usize = 1 << 16;

/// Returns the kind of text that may follow at an offset.
pub(super) fn place(document: &Document, offset: usize) -> Option<Place> {
    let text = statement_before(document, offset)?;
    let word = text.len() - text.bytes().rev().take_while(|byte| is_word(*byte)).count();
    let (before, typed) = text.split_at(word);
    let word = Span::new(offset - typed.len(), offset);
    Some(Place {
        typing: typing(document, before)?,
        word,
    })
}

/// Returns the innermost open call at an offset.
pub(super) fn open_call(document: &Document, offset: usize) -> Option<OpenCall> {
    let text = statement_before(document, offset)?;
    call_in(&text)
}

fn call_in(text: &str) -> Option<OpenCall> {
    let (mut depth, mut argument) = (0usize, 0);
    for (at, c) in text.char_indices().rev() {
        match c {
            ')' => depth += 1,
            '(' if depth > 0 => depth -= 1,
            '(' => {
                let front = text[..at].trim_end();
                let letters = front
                    .bytes()
                    .rev()
                    .take_while(|byte| is_word(*byte))
                    .count();
                let name = front[front.len() - letters..].to_uppercase();
                return Some(OpenCall { name, argument });
            }
            ',' if depth == 0 => argument += 1,
            '=' => return None,
            _ => {}
        }
    }
    None
}

/// Returns the part of a statement before an offset, joined to one line and without comments. `None` within a comment or a title.
fn statement_before(document: &Document, offset: usize) -> Option<String> {
    let pieces = document.pieces();
    let last = pieces.at(offset)?;
    let first = last.saturating_sub(1);
    let mut bytes = Vec::new();
    for piece in &pieces.pieces()[first..=last] {
        bytes.extend_from_slice(piece.source().bytes());
    }
    bytes.truncate(offset - pieces.start(first));
    let bytes = &bytes[bytes.len().saturating_sub(MOST_BYTES)..];
    let text = String::from_utf8_lossy(bytes);
    let mut lines: Vec<&str> = text.split(['\n', '\r']).collect();
    let is_title = !document.is_command_file() && first == 0 && lines.len() == 1;
    if is_title || code(lines.last()?).len() < lines.last()?.len() {
        return None;
    }
    let mut parts = Vec::new();
    while let Some(line) = lines.pop() {
        let own = code(line).trim_start();
        let current = parts.is_empty();
        if own.trim().is_empty() && !current {
            continue;
        }
        parts.push(own.trim_start_matches(','));
        let before = lines
            .iter()
            .rev()
            .map(|line| code(line))
            .find(|line| !line.trim().is_empty());
        let open = before.is_some_and(|line| line.trim_end().ends_with(['&', ',']));
        if !own.starts_with(',') && !open {
            break;
        }
    }
    parts.reverse();
    let mut out = String::new();
    for part in parts {
        if !out.is_empty() {
            out.truncate(out.trim_end().trim_end_matches(['&', ',']).len());
            out.push_str(", ");
        }
        out.push_str(part);
    }
    let start = out.rfind(';').map_or(0, |end| end + 1);
    Some(out[start..].trim_start().to_string())
}

/// Returns a line without the comment at its end.
fn code(line: &str) -> &str {
    let mut quoted = false;
    let comment = line.bytes().position(|byte| {
        quoted ^= byte == b'"';
        byte == b'!' && !quoted
    });
    &line[..comment.unwrap_or(line.len())]
}

fn typing(document: &Document, before: &str) -> Option<Typing> {
    let role = if document.is_command_file() {
        Role::Command
    } else {
        Role::Dataset
    };
    let Some((keyword, rest)) = before.split_once('/') else {
        return before.trim().is_empty().then_some(Typing::Keyword);
    };
    let def = find_statement(keyword.trim().as_bytes(), role).found()?;
    let (head, arguments) = match def.id {
        Some(_) => match rest.split_once(',') {
            Some((_, arguments)) => (false, arguments),
            None => (true, rest),
        },
        None => (false, rest),
    };
    if head {
        return Some(Typing::Id(def));
    }
    let parts = split(arguments);
    let mut there = Vec::new();
    // The last argument with a value is still being typed, unless a comma has ended it and it takes no further list values.
    let mut open: Option<(&'static ArgumentDef, usize)> = None;
    for part in &parts {
        let (name, has_value) = match part.split_once('=') {
            Some((name, _)) => (name, true),
            None => (*part, false),
        };
        let argument = find_argument(def, name.trim().as_bytes()).found();
        if has_value {
            open = argument.map(|argument| (argument, 0));
            there.extend(argument.map(|argument| argument.name));
            // A backslash ends the value, and the next argument follows.
            open = open.filter(|_| !part.contains('\\'));
        } else if let Some(flag) = argument {
            there.push(flag.name);
            open = None;
        } else if let Some((_, count)) = &mut open {
            *count += 1;
        }
    }
    let last = parts.last().copied().unwrap_or_default();
    match open {
        Some((argument, _)) if argument.kind == ValueKind::Function && last.contains('=') => {
            let value = last.split_once('=').map_or("", |(_, value)| value);
            let space = call_in(value).and_then(|call| {
                let function = find_function(call.name.as_bytes())?;
                argument_space(function.name, call.argument)
            });
            Some(space.map_or(Typing::Expression, Typing::Reference))
        }
        Some((argument, count)) => {
            let fits = argument.count.max.is_none_or(|most| count < most);
            let listed = matches!(argument.name, "ID" | "RANGE");
            let space = match argument.kind {
                ValueKind::Reference(space) => Some(space),
                ValueKind::Integer if listed => listed_space(def, &there),
                _ => None,
            };
            match space {
                Some(space) if fits => Some(Typing::Reference(space)),
                None if fits => Some(Typing::Value(argument)),
                _ => Some(Typing::Argument(def, there)),
            }
        }
        None => Some(Typing::Argument(def, there)),
    }
}

/// Returns the id space of the ids that an ACTIVATE or DEACTIVATE command lists; `None` for any other command. `there` contains the
/// arguments that the command already has.
fn listed_space(def: &StatementDef, there: &[&str]) -> Option<&'static str> {
    if !matches!(def.name, "ACTIVATE" | "DEACTIVATE") {
        return None;
    }
    there
        .iter()
        .find_map(|kind| STATEMENTS.iter().find(|def| def.name == *kind)?.id)
}

/// Splits a text at the commas outside parentheses and quotes.
fn split(text: &str) -> Vec<&str> {
    let (mut depth, mut quoted, mut start) = (0usize, false, 0);
    let mut parts = Vec::new();
    for (at, c) in text.char_indices() {
        match c {
            '"' => quoted = !quoted,
            '(' if !quoted => depth += 1,
            ')' if !quoted => depth = depth.saturating_sub(1),
            ',' if depth == 0 && !quoted => {
                parts.push(&text[start..at]);
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(&text[start..]);
    parts
}

const fn is_word(byte: u8) -> bool {
    byte.is_ascii_alphanumeric() || byte == b'_'
}
