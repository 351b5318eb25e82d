use super::scalar::Scalar;

/// Entries of a sparse matrix with n rows and columns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entries<'a, T> {
    pub n: usize,
    /// (column, row) of every entry, sorted.
    pub places: &'a [(u32, u32)],
    pub values: &'a [T],
    /// Identifies which entries of a common pattern are present.
    pub fingerprint: u64,
}

impl<'a, T: Scalar> Entries<'a, T> {
    /// Creates a matrix that contains all entries of its pattern.
    pub(crate) fn whole(n: usize, places: &'a [(u32, u32)], values: &'a [T]) -> Self {
        Self {
            n,
            places,
            values,
            fingerprint: 0,
        }
    }

    /// Iterates by columns over (row, column, value) of every entry.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, usize, T)> + '_ {
        self.places
            .iter()
            .zip(self.values)
            .map(|(&(column, row), &value)| (row as usize, column as usize, value))
    }
}
