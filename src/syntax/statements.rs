//! Parsing of the logical lines of a dataset or command file into statements.

#[cfg(feature = "parallel")]
use rayon::prelude::*;

use super::lexer::is_blank;
use super::lines::LogicalLine;
use super::parser::StatementParser;
use super::{Statement, Token, TokenKind};
use crate::diagnostic::{Code, Diagnostic, Severity};
use crate::grammar::{Role, StatementDef};
use crate::text::{Source, Span};

/// The byte order mark that some editors write at the start of a file.
pub(super) const BOM: &[u8] = b"\xef\xbb\xbf";

/// Yields one token with this kind and span, or no token if the span is empty.
pub(super) fn one(kind: TokenKind, span: Span) -> impl Iterator<Item = Token> {
    (!span.is_empty())
        .then_some(Token { kind, span })
        .into_iter()
}

/// Returns true if only blanks precede `offset` on its line.
pub(super) fn starts_line(bytes: &[u8], offset: usize) -> bool {
    bytes[..offset]
        .iter()
        .rfind(|byte| !is_blank(**byte))
        .is_none_or(|byte| matches!(byte, b'\n' | b'\r'))
}

/// Maximum number of diagnostics kept for one file; the rest is only counted.
const MOST_COMPLAINTS: usize = 10_000;

/// Parses logical lines into statements. Long files are parsed in parallel on all processors.
pub(super) fn parse_lines(
    source: &Source,
    lines: &[LogicalLine],
    role: Role,
) -> (Vec<Statement>, Vec<Diagnostic>) {
    let (statements, diagnostics, _) = parse_lines_after(source, lines, role, None);
    (statements, diagnostics)
}

/// Parses logical lines that follow a statement with the definition `before`. Also returns the definition of the last statement.
pub(super) fn parse_lines_after(
    source: &Source,
    lines: &[LogicalLine],
    role: Role,
    before: Option<&'static StatementDef>,
) -> (
    Vec<Statement>,
    Vec<Diagnostic>,
    Option<&'static StatementDef>,
) {
    const CHUNK: usize = 4096;
    // The numbers and arguments of this many lines fit into the processor cache.
    const GROUP: usize = 256;
    let read = |(at, chunk): (usize, &[LogicalLine])| {
        let mut parser = StatementParser::new(source, role);
        parser.before = statement_before(source, &lines[..at * CHUNK], role, before);
        let mut statements = Vec::with_capacity(chunk.len());
        for group in chunk.chunks(GROUP) {
            for line in group {
                parser.line(*line, &mut statements);
            }
            parser.close();
        }
        (
            statements,
            parser.diagnostics,
            parser.dropped,
            parser.before,
        )
    };
    let chunks: Vec<_> = if lines.len() <= CHUNK {
        vec![read((0, lines))]
    } else {
        #[cfg(feature = "parallel")]
        let chunks = lines.par_chunks(CHUNK);
        #[cfg(not(feature = "parallel"))]
        let chunks = lines.chunks(CHUNK);
        chunks.enumerate().map(read).collect()
    };
    let mut statements = Vec::with_capacity(lines.len());
    let mut diagnostics = Vec::new();
    let (mut dropped, mut worst) = (0, Severity::Note);
    let mut after = before;
    for (some, complaints, (count, severity), last) in chunks {
        after = last;
        statements.extend(some);
        let room = MOST_COMPLAINTS.saturating_sub(diagnostics.len());
        for late in complaints.iter().skip(room) {
            dropped += 1;
            worst = worst.max(late.severity);
        }
        diagnostics.extend(complaints.into_iter().take(room));
        dropped += count;
        worst = worst.max(severity);
    }
    if dropped > 0 {
        let mut more = Diagnostic::note(
            Code::LimitExceeded,
            format!("{dropped} more messages are not listed"),
        )
        .label(source.name(), Span::at(source.bytes().len()), "");
        more.severity = worst;
        diagnostics.push(more);
    }
    (statements, diagnostics, after)
}

/// Returns the definition of the last statement in some lines, or `otherwise` if the lines contain no keyword.
///
/// The next line may be a continuation of that statement whose leading comma is missing.
pub(super) fn statement_before(
    source: &Source,
    lines: &[LogicalLine],
    role: Role,
    otherwise: Option<&'static StatementDef>,
) -> Option<&'static StatementDef> {
    // Only this many lines are searched, because no sensible deck has a longer run of lines without a keyword.
    const MOST: usize = 16;
    for line in lines.iter().rev().take(MOST) {
        let mut parser = StatementParser::new(source, role);
        parser.line(*line, &mut Vec::new());
        if parser.knows_before {
            return parser.before;
        }
    }
    otherwise
}
