//! A small dataset copied from a large one: some statements, and the statements that they refer to. Neighbourhood rules and the model give
//! the same results for the copied statements as in the whole dataset.

use std::collections::{BTreeMap, BTreeSet};

use super::document::Document;
use admire_syntax::catalogue::references;
use admire_syntax::text::{Source, Span};
use admire_syntax::{Dataset, ObjectId, Statement};

/// Statements of a document as a dataset of their own.
pub(super) struct Excerpt {
    /// The excerpt as a dataset.
    pub dataset: Dataset,
    pieces: Vec<Copied>,
}

/// A run of bytes copied from the document to the excerpt.
struct Copied {
    /// Offset in the excerpt.
    start: usize,
    /// Position in the document.
    from: Span,
    /// True for a requested statement, false for a statement that was added because another statement refers to it.
    asked: bool,
}

/// Largest number of statements with the same id that are copied. In a valid dataset, each id belongs to a single statement.
const MOST_OF_AN_ID: usize = 64;

/// Depth to which an excerpt follows references.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Depth {
    /// Only the statements that a requested statement names.
    One,
    /// All statements reached through references, up to this total number of statements.
    All(usize),
}

impl Excerpt {
    /// Creates the excerpt of the given statements. `asked` contains their (piece, statement) indices.
    pub(crate) fn of(
        document: &Document,
        asked: impl IntoIterator<Item = (usize, usize)>,
        depth: Depth,
    ) -> Self {
        let mut chosen: BTreeMap<(usize, usize), bool> = BTreeMap::new();
        let mut open: Vec<(usize, usize)> = Vec::new();
        for place in asked {
            chosen.insert(place, true);
            open.push(place);
        }
        let mut known: BTreeSet<ObjectId> = BTreeSet::new();
        let most = match depth {
            Depth::One => usize::MAX,
            Depth::All(most) => most,
        };
        let mut wave = 0;
        while !open.is_empty() && chosen.len() < most {
            let mut next = Vec::new();
            let mut take = |place: (usize, usize), next: &mut Vec<_>| {
                if let std::collections::btree_map::Entry::Vacant(entry) = chosen.entry(place) {
                    entry.insert(false);
                    next.push(place);
                }
            };
            for place in open {
                let statement = document.statement(place);
                let named = references(statement).map(|r| (r.space, r.id));
                // Statements with the same id are treated as referred to. A marker may belong to the body before it.
                for object in named.chain(statement.object()) {
                    if known.insert(object) {
                        let places = document.definitions(object);
                        for other in places.into_iter().take(MOST_OF_AN_ID) {
                            take(other, &mut next);
                        }
                    }
                }
                if statement.follows_body()
                    && let Some(body) = document.body_before(place)
                {
                    take(body, &mut next);
                }
            }
            wave += 1;
            // The bodies to which markers without a PART belong are always included.
            if depth == Depth::One && wave == 2 {
                break;
            }
            open = match depth {
                Depth::One => next
                    .into_iter()
                    .filter(|place| document.statement(*place).follows_body())
                    .collect(),
                Depth::All(_) => next,
            };
        }
        Self::written(document, &chosen)
    }

    fn written(document: &Document, chosen: &BTreeMap<(usize, usize), bool>) -> Self {
        let mut bytes = b"excerpt\n".to_vec();
        let mut pieces = Vec::new();
        for (&(piece, at), &asked) in chosen {
            let (piece, base) = (
                &document.pieces().pieces()[piece],
                document.pieces().start(piece),
            );
            let statement = &piece.statements()[at];
            if statement.def.is_none() {
                continue;
            }
            let mut copy = |span: Span, bytes: &mut Vec<u8>| {
                pieces.push(Copied {
                    start: bytes.len(),
                    from: Span::new(base + span.start(), base + span.end()),
                    asked,
                });
                bytes.extend_from_slice(piece.source().slice(span));
            };
            if !names_itself(statement, piece.source()) {
                // An empty statement is inserted before the copied statement. The first words of the copy would otherwise be read as arguments of
                // the preceding statement.
                bytes.extend_from_slice(b"_;\n");
            }
            if let Some(name) = statement.view_name {
                bytes.extend_from_slice(b"! adams_view_name='");
                copy(name, &mut bytes);
                bytes.extend_from_slice(b"'\n");
            }
            copy(statement.span, &mut bytes);
            if bytes.last() != Some(&b';') {
                bytes.push(b';');
            }
            bytes.push(b'\n');
        }
        bytes.extend_from_slice(b"END\n");
        let source = Source::new(document.name(), bytes);
        Self {
            dataset: Dataset::parse(source).value,
            pieces,
        }
    }

    /// Returns the position in the document of a span in the excerpt, and whether the statement there was requested.
    pub(crate) fn place(&self, span: Span) -> Option<(Span, bool)> {
        let after = self
            .pieces
            .partition_point(|piece| piece.start <= span.start());
        let piece = &self.pieces[after.checked_sub(1)?];
        let shift = |offset: usize| piece.from.start() + (offset - piece.start);
        Some((
            Span::new(shift(span.start()), shift(span.end())),
            piece.asked,
        ))
    }
}

/// Returns true if a slash follows the statement's keyword.
fn names_itself(statement: &Statement, source: &Source) -> bool {
    let rest = &source.bytes()[statement.keyword.end()..statement.span.end()];
    rest.trim_ascii_start().starts_with(b"/")
}
