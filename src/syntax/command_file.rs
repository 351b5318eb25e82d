use std::ops::Range;

use super::lexer::{Lexer, is_blank};
use super::lines::{PhysicalLine, logical_lines, physical_line};
use super::statements::{BOM, one, parse_lines};
use super::{Statement, Token, TokenKind};
use crate::diagnostic::Checked;
use crate::grammar::{Lookup, Role, find_statement};
use crate::text::{Source, Span};

/// An ADAMS/Solver command file (.acf). All of its bytes are kept, including comments and blanks.
#[derive(Clone, Debug)]
pub struct CommandFile {
    source: Source,
    head: Option<Head>,
    commands: Vec<Statement>,
    lines: Vec<CommandLine>,
}

/// The two prompt-style first lines: the name of the dataset and the prefix of the output files (guide/formats.md 5.1).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Head {
    /// Name of the dataset, as typed.
    pub model: Span,
    /// Prefix of the output files, as typed; `None` means that the name of the model is the prefix.
    pub prefix: Option<Span>,
}

/// One physical line after the head, with the commands that it completes.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct CommandLine {
    /// The line as typed, without its line end; blank and comment lines are included because `.msg` echoes them.
    pub echo: Span,
    /// Indices of the commands completed by this line.
    pub commands: Range<usize>,
}

impl CommandFile {
    /// Reads a command file from any bytes. Its diagnostics are of the same kinds as the diagnostics of
    /// [`Dataset::parse`](super::Dataset::parse), apart from the missing END.
    pub fn parse(source: Source) -> Checked<Self> {
        let bytes = source.bytes();
        let bom = if bytes.starts_with(BOM) { BOM.len() } else { 0 };
        let (head, body) = head(bytes, bom);
        Self::read(source, head, body)
    }

    /// Reads a file that has no head: the first line is a command even if it looks like the name of a dataset.
    pub fn parse_commands(source: Source) -> Checked<Self> {
        Self::read(source, None, 0)
    }

    fn read(source: Source, head: Option<Head>, body: usize) -> Checked<Self> {
        let bytes = source.bytes();
        let (logical, _) = logical_lines(bytes, body, false);
        let (commands, diagnostics) = parse_lines(&source, &logical, Role::Command);
        let mut lines = Vec::new();
        let mut at = body;
        let mut done = 0;
        let mut ends = logical.iter().map(|line| line.span.end()).peekable();
        while at < bytes.len() {
            let PhysicalLine { span, next } = physical_line(bytes, at);
            at = next;
            let mut complete = done;
            if ends.next_if(|end| *end <= span.end()).is_some() {
                complete += commands[done..]
                    .iter()
                    .take_while(|command| command.span.start() < span.end())
                    .count();
            }
            lines.push(CommandLine {
                echo: span,
                commands: done..complete,
            });
            done = complete;
        }
        Checked {
            value: Self {
                source,
                head,
                commands,
                lines,
            },
            diagnostics,
        }
    }

    /// Returns the source file.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// Returns all bytes of the file, exactly as they were read.
    pub fn bytes(&self) -> &[u8] {
        self.source.bytes()
    }

    /// Returns the two prompt-style first lines, if the file begins with them.
    pub fn head(&self) -> Option<Head> {
        self.head
    }

    /// Returns all commands in order.
    pub fn commands(&self) -> &[Statement] {
        &self.commands
    }

    /// Returns all physical lines after the head.
    pub fn lines(&self) -> &[CommandLine] {
        &self.lines
    }

    /// Iterates over all tokens of the file; together they cover every byte.
    pub fn tokens(&self) -> impl Iterator<Item = Token> + '_ {
        let bytes = self.bytes();
        let bom = if bytes.starts_with(BOM) { BOM.len() } else { 0 };
        // The two lines of the head are text tokens; line ends and blanks between them are lexed as usual.
        let mut head = Vec::new();
        let mut at = bom;
        for text in self
            .head
            .iter()
            .flat_map(|head| [Some(head.model), head.prefix])
            .flatten()
        {
            head.extend(Lexer::new(bytes, Span::new(at, text.start()), true));
            head.extend(one(TokenKind::Text, text));
            at = text.end();
        }
        one(TokenKind::Blank, Span::new(0, bom))
            .chain(head)
            .chain(Lexer::new(bytes, Span::new(at, bytes.len()), at == bom))
    }
}

/// Returns the head, if the file has one, and the offset at which the commands begin.
fn head(bytes: &[u8], bom: usize) -> (Option<Head>, usize) {
    let first = physical_line(bytes, bom);
    let model = trimmed(bytes, first.span);
    let text = &bytes[model.range()];
    let commanding = text.is_empty()
        || text[0] == b'!'
        || (text.contains(&b'/') && text.contains(&b'='))
        || begins_with_command(text);
    if commanding {
        return (None, bom);
    }
    let second = physical_line(bytes, first.next);
    let prefix = trimmed(bytes, second.span);
    let head = Head {
        model,
        prefix: (!prefix.is_empty()).then_some(prefix),
    };
    (Some(head), second.next)
}

/// Returns true if the text begins with a command keyword and a slash: `SIMULATE/...`.
fn begins_with_command(text: &[u8]) -> bool {
    let word = text
        .iter()
        .take_while(|byte| byte.is_ascii_alphanumeric() || **byte == b'_')
        .count();
    word > 0
        && text[word..].iter().find(|byte| !is_blank(**byte)) == Some(&b'/')
        && matches!(
            find_statement(&text[..word], Role::Command),
            Lookup::Found(_)
        )
}

fn trimmed(bytes: &[u8], span: Span) -> Span {
    let line = &bytes[span.range()];
    let Some(first) = line.iter().position(|byte| !is_blank(*byte)) else {
        return Span::at(span.start());
    };
    let last = line
        .iter()
        .rposition(|byte| !is_blank(*byte))
        .map_or(first, |at| at + 1);
    Span::new(span.start() + first, span.start() + last)
}
