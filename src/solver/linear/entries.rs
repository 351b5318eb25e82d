use super::scalar::Scalar;

/// The entries of a sparse matrix of n rows and columns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entries<'a, T> {
    pub n: usize,
    /// (column, row) of every entry, sorted.
    pub places: &'a [(u32, u32)],
    pub values: &'a [T],
    /// Of places of the same pattern: which of them there are.
    pub fingerprint: u64,
}

impl<'a, T: Scalar> Entries<'a, T> {
    /// All of a pattern.
    pub(crate) fn whole(n: usize, places: &'a [(u32, u32)], values: &'a [T]) -> Self {
        Self {
            n,
            places,
            values,
            fingerprint: 0,
        }
    }

    /// (row, column, value) of every entry, by columns.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, usize, T)> + '_ {
        self.places
            .iter()
            .zip(self.values)
            .map(|(&(column, row), &value)| (row as usize, column as usize, value))
    }
}
