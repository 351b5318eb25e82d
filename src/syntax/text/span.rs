use std::ops::Range;

/// A half-open range of byte offsets in one [`Source`](super::Source).
///
/// Offsets are kept in 32 bits, since a deck has a span for each of its words and numbers: a file that is read as a whole is smaller
/// than 4 GiB ([`Source::LARGEST`](super::Source::LARGEST)). Offsets beyond that (places in a results file, which is streamed) are
/// cut to the largest one.
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
    /// The span from `start` up to, not including, `end`.
    pub const fn new(start: usize, end: usize) -> Self {
        Self {
            start: cut(start),
            end: cut(end),
        }
    }

    /// An empty span: a place between two bytes.
    pub const fn at(offset: usize) -> Self {
        Self::new(offset, offset)
    }

    /// Offset of the first byte.
    pub const fn start(self) -> usize {
        self.start as usize
    }

    /// Offset one past the last byte.
    pub const fn end(self) -> usize {
        self.end as usize
    }

    /// Number of bytes.
    pub const fn len(self) -> usize {
        self.end() - self.start()
    }

    /// True for a place between two bytes.
    pub const fn is_empty(self) -> bool {
        self.start == self.end
    }

    #[must_use]
    /// The smallest span that holds both.
    pub fn join(self, other: Self) -> Self {
        Self {
            start: self.start.min(other.start),
            end: self.end.max(other.end),
        }
    }

    #[must_use]
    /// The same start with another end.
    pub const fn to(self, end: usize) -> Self {
        Self {
            start: self.start,
            end: cut(end),
        }
    }

    /// True if `other` lies wholly inside.
    pub const fn contains(self, other: Self) -> bool {
        self.start <= other.start && other.end <= self.end
    }

    /// As a range, for slicing.
    pub const fn range(self) -> Range<usize> {
        self.start()..self.end()
    }
}

impl From<Range<usize>> for Span {
    fn from(range: Range<usize>) -> Self {
        Self::new(range.start, range.end)
    }
}
