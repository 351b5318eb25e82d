use super::scalar::Scalar;

/// View of the entries of a sparse matrix with n rows and columns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entries<'a, T> {
    pub n: usize,
    /// (column, row) of every entry, sorted.
    pub places: &'a [(u32, u32)],
    pub values: &'a [T],
    /// Hash that identifies which entries of a common pattern are present; zero if all entries are present.
    pub fingerprint: u64,
}

impl<'a, T: Scalar> Entries<'a, T> {
    /// Creates a view in which all entries of the pattern are present.
    pub(crate) fn whole(n: usize, places: &'a [(u32, u32)], values: &'a [T]) -> Self {
        Self {
            n,
            places,
            values,
            fingerprint: 0,
        }
    }

    /// Iterates over (row, column, value) of every entry, column by column.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, usize, T)> + '_ {
        self.places
            .iter()
            .zip(self.values)
            .map(|(&(column, row), &value)| (row as usize, column as usize, value))
    }
}
