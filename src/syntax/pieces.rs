//! A dataset or a command file that is split into pieces of whole lines. After an edit, only the pieces it touches are parsed again.
//!
//! Together, the pieces contain exactly the statements that [`Dataset::parse`] or [`CommandFile::parse`] reads from all bytes at once.
//!
//! [`Dataset::parse`]: super::Dataset::parse

use std::ops::Range;
use std::sync::Arc;

#[cfg(feature = "parallel")]
use rayon::prelude::*;

use super::lines::{LogicalLine, continues, logical_lines, physical_line};
use super::statements::{parse_lines_after, statement_before};
use super::{CommandFile, Head, Statement};
use crate::diagnostic::Diagnostic;
use crate::grammar::{Role, StatementDef};
use crate::text::{Source, Span};

/// Number of logical lines in a piece. An edit usually touches two pieces.
const LINES: usize = 48;

/// Consecutive whole lines of a file, parsed on their own. Spans in a piece are offsets from its first byte.
#[derive(Debug)]
pub struct Piece {
    key: u32,
    source: Source,
    statements: Vec<Statement>,
    diagnostics: Vec<Diagnostic>,
    line_ends: usize,
    /// Definition of the statement before the piece. A line that lacks its leading comma may contain an argument of this statement.
    before: Option<&'static StatementDef>,
    after: Option<&'static StatementDef>,
    ends: bool,
    head: Option<Head>,
}

impl Piece {
    /// Returns the key of the piece. Keys are unique: a piece that replaces another piece gets a new key.
    pub fn key(&self) -> u32 {
        self.key
    }

    /// Returns the bytes of the piece as a source with the name of the file.
    pub fn source(&self) -> &Source {
        &self.source
    }

    /// Returns the statements or commands of the piece.
    pub fn statements(&self) -> &[Statement] {
        &self.statements
    }

    /// Returns the diagnostics that the parser reported for the piece.
    pub fn diagnostics(&self) -> &[Diagnostic] {
        &self.diagnostics
    }

    /// Returns the size of the piece in bytes.
    pub fn size(&self) -> usize {
        self.source.bytes().len()
    }

    fn of(name: &Arc<str>, bytes: Vec<u8>) -> Self {
        Self {
            key: 0,
            line_ends: line_ends(&bytes),
            source: Source::new(Arc::clone(name), bytes),
            statements: Vec::new(),
            diagnostics: Vec::new(),
            before: None,
            after: None,
            ends: false,
            head: None,
        }
    }

    /// Parses a piece of a dataset from its offset `start` on. No line after the piece may be a continuation of its last line.
    fn body(
        name: &Arc<str>,
        bytes: Vec<u8>,
        start: usize,
        before: Option<&'static StatementDef>,
    ) -> Self {
        let mut piece = Self::of(name, bytes);
        let (lines, _) = logical_lines(piece.source.bytes(), start, true);
        let (statements, diagnostics, after) =
            parse_lines_after(&piece.source, &lines, Role::Dataset, before);
        piece.statements = statements;
        piece.diagnostics = diagnostics;
        (piece.before, piece.after) = (before, after);
        let end = piece
            .statements
            .iter()
            .position(|s| s.is_end(&piece.source));
        if let Some(last) = end {
            piece.ends = true;
            piece.statements.truncate(last + 1);
            let start = piece.statements[last].span.end();
            piece.diagnostics.retain(|diagnostic| {
                let label = diagnostic.labels.first();
                label.is_none_or(|label| label.span.start() < start)
            });
        }
        piece
    }
}

/// Counts the line ends in `bytes`; a line ends at LF, CR LF or a single CR.
fn line_ends(bytes: &[u8]) -> usize {
    memchr::memchr2_iter(b'\n', b'\r', bytes)
        .filter(|at| bytes[*at] == b'\n' || bytes.get(at + 1) != Some(&b'\n'))
        .count()
}

/// A dataset or command file that is split into pieces.
#[derive(Clone, Debug)]
pub struct Pieces {
    name: Arc<str>,
    role: Role,
    all: Vec<Arc<Piece>>,
    /// Number of pieces up to the piece with END. The pieces after END are parsed as well, because they become part of the dataset if END
    /// is deleted.
    live: usize,
    /// Byte offset and line number (from 0) at which each piece begins; the last entry is the end of the file.
    starts: Vec<(usize, usize)>,
    next_key: u32,
}

/// Pieces that an edit removed and added.
#[derive(Clone, Debug)]
pub struct Change {
    /// Removed pieces; they were next to each other in the file.
    pub removed: Vec<Arc<Piece>>,
    /// Indices of the pieces that replace the removed ones.
    pub added: Range<usize>,
}

impl Pieces {
    /// Splits a text into pieces and parses them: a command file if the role is `Role::Command`, a dataset otherwise.
    pub fn parse(source: &Source, role: Role) -> Self {
        let mut pieces = Self {
            name: source.name().into(),
            role,
            all: Vec::new(),
            live: 0,
            starts: vec![(0, 0)],
            next_key: 0,
        };
        pieces.edit(Span::at(0), source.bytes());
        pieces
    }

    /// Returns the name of the file.
    pub fn name(&self) -> Arc<str> {
        Arc::clone(&self.name)
    }

    /// Returns true for a command file.
    pub fn is_command_file(&self) -> bool {
        self.role == Role::Command
    }

    /// Returns all pieces in order, including those after END.
    pub fn pieces(&self) -> &[Arc<Piece>] {
        &self.all
    }

    /// Returns the pieces up to and including the piece with END; only these belong to the dataset.
    pub fn live(&self) -> &[Arc<Piece>] {
        &self.all[..self.live]
    }

    /// Returns the byte offset at which the piece with index `at` begins.
    pub fn start(&self, at: usize) -> usize {
        self.starts[at].0
    }

    /// Returns the number (from 0) of the first line of the piece with index `at`.
    pub fn first_line(&self, at: usize) -> usize {
        self.starts[at].1
    }

    /// Returns the size of the file in bytes.
    pub fn size(&self) -> usize {
        self.start(self.all.len())
    }

    /// Returns the prompt-style first lines of a command file, which name its dataset and output files.
    pub fn head(&self) -> Option<Head> {
        self.all.first()?.head
    }

    /// Returns all bytes of the file.
    pub fn bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(self.size());
        for piece in &self.all {
            bytes.extend_from_slice(piece.source.bytes());
        }
        bytes
    }

    /// Returns all bytes as a source with the name of the file.
    pub fn source(&self) -> Source {
        Source::new(Arc::clone(&self.name), self.bytes())
    }

    /// Returns the index of the piece that contains a byte offset. For the end of the file, this is the last piece. Returns `None` for an
    /// empty file.
    pub fn at(&self, offset: usize) -> Option<usize> {
        let after = self.starts.partition_point(|(start, _)| *start <= offset);
        Some(after.checked_sub(1)?.min(self.all.len().checked_sub(1)?))
    }

    /// Returns the index of the piece that contains a line (from 0). For lines beyond the end, this is the last piece. Returns `None` for
    /// an empty file.
    pub fn at_line(&self, line: usize) -> Option<usize> {
        let after = self.starts.partition_point(|(_, first)| *first <= line);
        Some(after.checked_sub(1)?.min(self.all.len().checked_sub(1)?))
    }

    /// Returns true if the dataset has an END statement.
    pub fn has_end(&self) -> bool {
        self.live().last().is_some_and(|piece| piece.ends)
    }

    /// Replaces the bytes of a span, which must lie in the file, and parses again all pieces that the edit affects.
    pub fn edit(&mut self, span: Span, replacement: &[u8]) -> Change {
        let count = self.all.len();
        // The preceding piece is parsed again too, because the edited text may continue its last line.
        let touched = self.starts[..count]
            .partition_point(|(start, _)| *start < span.start())
            .saturating_sub(1);
        let (first, mut last) = match self.role {
            Role::Command => (0, count),
            Role::Dataset | Role::Both => (
                touched.saturating_sub(1),
                self.starts[..count].partition_point(|(start, _)| *start <= span.end()),
            ),
        };
        let mut bytes = Vec::new();
        for piece in &self.all[first..last] {
            bytes.extend_from_slice(piece.source.bytes());
        }
        let from = self.starts[first].0;
        bytes.splice(
            span.start() - from..span.end() - from,
            replacement.iter().copied(),
        );
        let mut new = loop {
            let next = self.all.get(last);
            if let Some(new) = self.read(first, &bytes, next.map(Arc::as_ref)) {
                break new;
            }
            // The range doubles in each round, so each line is parsed only a few times even if the edit changes all pieces.
            let more = (last - first).max(1).min(count - last);
            for piece in &self.all[last..last + more] {
                bytes.extend_from_slice(piece.source.bytes());
            }
            last += more;
        };
        for piece in &mut new {
            piece.key = self.next_key;
            self.next_key = self.next_key.wrapping_add(1);
        }
        let added = first..first + new.len();
        let removed = self
            .all
            .splice(first..last, new.into_iter().map(Arc::new))
            .collect();
        self.starts.truncate(first + 1);
        for piece in &self.all[first..] {
            let (bytes, lines) = *self.starts.last().unwrap_or(&(0, 0));
            self.starts
                .push((bytes + piece.size(), lines + piece.line_ends));
        }
        self.renew_live(first);
        Change { removed, added }
    }

    /// Determines again which piece contains END, after the pieces from index `first` on have changed.
    fn renew_live(&mut self, first: usize) {
        // An END before the changed pieces stays the first END.
        if self.live <= first && self.all[..self.live].last().is_some_and(|piece| piece.ends) {
            return;
        }
        let end = self.all[first..].iter().position(|piece| piece.ends);
        self.live = end.map_or(self.all.len(), |end| first + end + 1);
    }

    /// Splits bytes into pieces, of which the first gets the index `first`.
    ///
    /// Returns `None` if the following piece `next` must be parsed again as well, because it continues the last line of the bytes or the
    /// statement before it has changed.
    fn read(&self, first: usize, bytes: &[u8], next: Option<&Piece>) -> Option<Vec<Piece>> {
        let name = &self.name;
        if self.role == Role::Command {
            let mut piece = Piece::of(name, bytes.to_vec());
            let read = CommandFile::parse(piece.source.clone());
            piece.head = read.value.head();
            piece.statements = read.value.commands().to_vec();
            piece.diagnostics = read.diagnostics;
            return Some(vec![piece]);
        }
        let source = Source::new(Arc::clone(name), bytes);
        let mut new: Vec<Piece> = Vec::new();
        let mut lines: Vec<LogicalLine> = Vec::new();
        let mut from = 0;
        // Logical lines end at END; the text after it is split in the same way.
        while from < bytes.len() {
            // The title precedes the first statement only at the start of the file.
            let title = match (first, from) {
                (0, 0) => physical_line(bytes, 0).next,
                _ => from,
            };
            let end;
            (lines, end) = logical_lines(bytes, title, true);
            let stop = end.map_or(bytes.len(), |end| physical_line(bytes, end).next);
            let before = match new.last() {
                Some(last) => last.after,
                None => first.checked_sub(1).and_then(|at| self.all[at].after),
            };
            let count = lines.len().div_ceil(LINES).max(1);
            let cut = |k: usize| match (k * LINES).checked_sub(1) {
                None => from,
                Some(_) if k == count => stop,
                Some(last) => physical_line(bytes, lines[last].span.end()).next,
            };
            let piece = |k: usize| {
                let lines = &lines[..k * LINES];
                let before = statement_before(&source, lines, Role::Dataset, before);
                let title = if k == 0 { title - from } else { 0 };
                Piece::body(name, bytes[cut(k)..cut(k + 1)].to_vec(), title, before)
            };
            #[cfg(feature = "parallel")]
            if count < 8 {
                new.extend((0..count).map(piece));
            } else {
                new.par_extend((0..count).into_par_iter().map(piece));
            }
            #[cfg(not(feature = "parallel"))]
            new.extend((0..count).map(piece));
            from = stop;
        }
        let Some(next) = next else {
            return Some(new);
        };
        let last: Option<&LogicalLine> = lines.last();
        let apart = last.is_some_and(|last| {
            let end = last.span.end();
            physical_line(bytes, end).next == bytes.len()
                && end < bytes.len()
                && !continues(&bytes[..end], next.source.bytes())
        });
        let as_before = new.last().is_some_and(|last| last.after == next.before);
        (apart && as_before).then_some(new)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn end_in_the_middle_is_read_with_its_neighbours_only() {
        let markers: Vec<String> = (1..5000)
            .map(|id| format!("MARKER/{id}\n, PART = 1\n"))
            .collect();
        let markers = markers.concat();
        let text = format!("t\nPART/1, GROUND\n{markers}END\n");
        let mut pieces = Pieces::parse(&Source::new("a.adm", text.as_bytes()), Role::Dataset);
        let counted = |pieces: &Pieces| -> usize {
            let live = pieces.live().iter();
            live.map(|piece| piece.statements().len()).sum()
        };
        let (all, count) = (pieces.pieces().len(), counted(&pieces));
        assert_eq!((count, pieces.live().len()), (5001, all));
        let middle = text.find("MARKER/2500").expect("a marker");
        let typed = pieces.edit(Span::at(middle), b"END\n");
        assert!(
            typed.removed.len() < 5 && typed.added.len() < 8,
            "{typed:?}"
        );
        assert_eq!((counted(&pieces), pieces.has_end()), (2501, true));
        // An edit after END changes nothing in the dataset.
        let behind = pieces.size() - 200;
        pieces.edit(Span::at(behind), b"PART/2\n");
        assert_eq!(counted(&pieces), 2501);
        pieces.edit(Span::new(behind, behind + 7), b"");
        let deleted = pieces.edit(Span::new(middle, middle + 4), b"");
        assert!(deleted.removed.len() < 8, "{deleted:?}");
        assert_eq!(counted(&pieces), count);
        assert_eq!(pieces.bytes(), text.as_bytes());
    }
}
