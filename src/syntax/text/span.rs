use std::ops::Range;

/// A half-open range of byte offsets in one [`Source`](super::Source).
///
/// Offsets have 32 bits to save memory, because a deck has a span for each of its words and numbers. A file that is read as a whole is
/// therefore smaller than 4 GiB ([`Source::LARGEST`](super::Source::LARGEST)). Larger offsets, as in a streamed results file, are clamped
/// to the largest 32-bit value.
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug, Default)]
pub struct Span {
    start: u32,
    end: u32,
}

const fn cut(offset: usize) -> u32 {
    if offset > u32::MAX as usize {
        u32::MAX
    } else {
        offset as u32
    }
}

impl Span {
    /// Creates the span that begins at `start` and ends before `end`.
    pub const fn new(start: usize, end: usize) -> Self {
        Self {
            start: cut(start),
            end: cut(end),
        }
    }

    /// Creates an empty span: a position between two bytes.
    pub const fn at(offset: usize) -> Self {
        Self::new(offset, offset)
    }

    /// Returns the offset of the first byte.
    pub const fn start(self) -> usize {
        self.start as usize
    }

    /// Returns the offset after the last byte.
    pub const fn end(self) -> usize {
        self.end as usize
    }

    /// Returns the number of bytes.
    pub const fn len(self) -> usize {
        self.end() - self.start()
    }

    /// Returns true for an empty span, which is a position between two bytes.
    pub const fn is_empty(self) -> bool {
        self.start == self.end
    }

    #[must_use]
    /// Returns the smallest span that contains both spans.
    pub fn join(self, other: Self) -> Self {
        Self {
            start: self.start.min(other.start),
            end: self.end.max(other.end),
        }
    }

    #[must_use]
    /// Returns a span with the same start that ends before `end`.
    pub const fn to(self, end: usize) -> Self {
        Self {
            start: self.start,
            end: cut(end),
        }
    }

    /// Returns true if `other` lies completely inside this span.
    pub const fn contains(self, other: Self) -> bool {
        self.start <= other.start && other.end <= self.end
    }

    /// Returns the span as a range, for slicing.
    pub const fn range(self) -> Range<usize> {
        self.start()..self.end()
    }
}

impl From<Range<usize>> for Span {
    fn from(range: Range<usize>) -> Self {
        Self::new(range.start, range.end)
    }
}
