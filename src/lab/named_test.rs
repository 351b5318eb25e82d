//! Tests named by words of a laboratory.

use admire_kc::TestKind;

/// Meaning of a word for a test.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum NamedTest {
    /// A test of the guide page `kc`.
    Test(TestKind),
    /// Rows that are left out, such as the rows of a warm-up run.
    Skipped,
}

impl NamedTest {
    /// Word of a mapping for rows that are left out.
    pub(crate) const SKIP: &str = "skip";

    /// Returns the meaning of a word of a mapping; `None` for an unknown word.
    pub(crate) fn named(word: &str) -> Option<Self> {
        if word == Self::SKIP {
            return Some(Self::Skipped);
        }
        let found = TestKind::ALL.into_iter().find(|kind| kind.name() == word);
        found.map(Self::Test)
    }

    /// Returns the word of a mapping.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Test(kind) => kind.name(),
            Self::Skipped => Self::SKIP,
        }
    }

    /// Returns the test; `None` if the rows are left out.
    pub(crate) const fn test(self) -> Option<TestKind> {
        match self {
            Self::Test(kind) => Some(kind),
            Self::Skipped => None,
        }
    }
}
