//! Folding ranges: statements and comment blocks of several lines.

use lsp_types::{FoldingRange, FoldingRangeKind, FoldingRangeParams};

use super::position::PieceLines;
use super::workspace::{Workspace, path_of};

pub(super) fn folding(
    workspace: &Workspace,
    params: &FoldingRangeParams,
) -> Option<Vec<FoldingRange>> {
    let file = workspace.file(&path_of(&params.text_document.uri))?;
    let pieces = file.document.pieces();
    let mut found = Vec::new();
    let mut add = |first: u32, last: u32, kind| {
        if last > first {
            found.push(FoldingRange {
                start_line: first,
                end_line: last,
                kind: Some(kind),
                ..FoldingRange::default()
            });
        }
    };
    for (at, piece) in pieces.pieces().iter().enumerate() {
        let lines = PieceLines::of(pieces, at);
        let live = at < pieces.live().len();
        for statement in piece.statements().iter().filter(|_| live) {
            let range = lines.range(statement.span);
            add(range.start.line, range.end.line, FoldingRangeKind::Region);
        }
        // A comment block ends at the end of its piece.
        let mut block: Option<(u32, u32)> = None;
        for (line, text) in lines.texts() {
            let is_comment = text.trim_ascii_start().starts_with(b"!");
            match (&mut block, is_comment) {
                (Some((_, last)), true) => *last = line,
                (None, true) => block = Some((line, line)),
                (Some((first, last)), false) => {
                    // Comments of up to three lines, such as a view name and a remark above a statement, do not fold.
                    if *last > *first + 2 {
                        add(*first, *last, FoldingRangeKind::Comment);
                    }
                    block = None;
                }
                (None, false) => {}
            }
        }
        if let Some((first, last)) = block.filter(|(first, last)| *last > first + 2) {
            add(first, last, FoldingRangeKind::Comment);
        }
    }
    Some(found)
}
