use super::Span;

/// An edit that replaces the bytes of a span. If the span is empty, the edit inserts bytes; if the replacement is empty, it deletes bytes.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Edit {
    /// Span to be replaced, in the unedited bytes.
    pub span: Span,
    /// New bytes.
    pub replacement: Vec<u8>,
}

impl Edit {
    /// Creates an edit from a span and its new bytes.
    pub fn new(span: Span, replacement: impl Into<Vec<u8>>) -> Self {
        Self {
            span,
            replacement: replacement.into(),
        }
    }
}

/// Reason why a list of edits cannot be applied.
#[derive(Clone, PartialEq, Eq, Debug, thiserror::Error)]
pub enum EditConflict {
    /// Two edits replace the same bytes.
    #[error("two edits overlap at bytes {}..{} and {}..{}", .0.start(), .0.end(), .1.start(), .1.end())]
    Overlap(Span, Span),
    /// An edit (span) extends past the end of the bytes (length).
    #[error("an edit ends at byte {} of a text of {} bytes", .0.end(), .1)]
    OutOfBounds(Span, usize),
}

/// Applies edits to `bytes`, in any order; all spans are offsets in the unedited bytes. Insertions at the same offset keep their order in
/// the list.
///
/// # Errors
/// Returns an error if two edits overlap or an edit lies outside of `bytes`; nothing is applied then.
pub fn apply_edits(bytes: &[u8], edits: &[Edit]) -> Result<Vec<u8>, EditConflict> {
    let mut order: Vec<&Edit> = edits.iter().collect();
    order.sort_by_key(|edit| (edit.span.start(), edit.span.end()));
    let mut out =
        Vec::with_capacity(bytes.len() + edits.iter().map(|e| e.replacement.len()).sum::<usize>());
    let mut at = Span::at(0);
    for edit in order {
        if edit.span.end() > bytes.len() || edit.span.start() > edit.span.end() {
            return Err(EditConflict::OutOfBounds(edit.span, bytes.len()));
        }
        if edit.span.start() < at.end() {
            return Err(EditConflict::Overlap(at, edit.span));
        }
        out.extend_from_slice(&bytes[at.end()..edit.span.start()]);
        out.extend_from_slice(&edit.replacement);
        at = edit.span;
    }
    out.extend_from_slice(&bytes[at.end()..]);
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_apply_in_offsets_of_the_original() {
        let edits = [
            Edit::new(Span::new(4, 5), "XY"),
            Edit::new(Span::new(0, 1), ""),
            Edit::new(Span::at(6), "!"),
        ];
        assert_eq!(apply_edits(b"abcdef", &edits).unwrap(), b"bcdXYf!");
    }

    #[test]
    fn overlap_and_overreach_are_refused() {
        let overlap = [
            Edit::new(Span::new(0, 3), ""),
            Edit::new(Span::new(2, 4), ""),
        ];
        assert!(matches!(
            apply_edits(b"abcdef", &overlap),
            Err(EditConflict::Overlap(..))
        ));
        assert!(matches!(
            apply_edits(b"ab", &[Edit::new(Span::new(1, 3), "")]),
            Err(EditConflict::OutOfBounds(..))
        ));
    }
}
