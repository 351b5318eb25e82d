use std::ops::Range;

use super::lexer::{Lexer, is_blank};
use super::lines::{PhysicalLine, logical_lines, physical_line};
use super::statements::{BOM, one, parse_lines};
use super::{Statement, Token, TokenKind};
use crate::diagnostic::Checked;
use crate::grammar::{Lookup, Role, find_statement};
use crate::text::{Source, Span};

/// An ADAMS/Solver command file (.acf), losslessly.
#[derive(Clone, Debug)]
pub struct CommandFile {
    source: Source,
    head: Option<Head>,
    commands: Vec<Statement>,
    lines: Vec<CommandLine>,
}

/// The two prompt-style first lines: which dataset, and the prefix of the output files (guide/formats.md 5.1).
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct Head {
    /// The name of the dataset as typed.
    pub model: Span,
    /// The prefix as typed; if absent it is the model's name.
    pub prefix: Option<Span>,
}

/// One physical line after the head: what `.msg` echoes, and what it makes happen.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct CommandLine {
    /// The line as typed, without its line end; blank and comment lines are echoed too.
    pub echo: Span,
    /// Indices of the commands that are complete with this line.
    pub commands: Range<usize>,
}

impl CommandFile {
    /// Reads any bytes. Complaints are those of [`Dataset::parse`](super::Dataset::parse), with commands for statements.
    pub fn parse(source: Source) -> Checked<Self> {
        let bytes = source.bytes();
        let bom = if bytes.starts_with(BOM) { BOM.len() } else { 0 };
        let (head, body) = head(bytes, bom);
        Self::read(source, head, body)
    }

    /// Reads commands alone: a first line that is no command is not taken for the name of a dataset.
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

    /// The file.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// All bytes, exactly as they were read.
    pub fn bytes(&self) -> &[u8] {
        self.source.bytes()
    }

    /// The prompt-style first lines, if the file begins with them.
    pub fn head(&self) -> Option<Head> {
        self.head
    }

    /// Every command in order.
    pub fn commands(&self) -> &[Statement] {
        &self.commands
    }

    /// Every physical line after the head.
    pub fn lines(&self) -> &[CommandLine] {
        &self.lines
    }

    /// Every token, from the first byte to the last.
    pub fn tokens(&self) -> impl Iterator<Item = Token> + '_ {
        let bytes = self.bytes();
        let bom = if bytes.starts_with(BOM) { BOM.len() } else { 0 };
        // The head's two lines are texts; line ends and blanks between them are lexed as such.
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

/// The head, if there is one, and where the commands begin.
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

/// `SIMULATE/...`: a word that is a command, and a slash.
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
