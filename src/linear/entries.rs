use super::scalar::Scalar;

/// The entries of a sparse matrix of n rows and columns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Entries<'a, T> {
    pub n: usize,
    /// (column, row) of every entry, sorted.
    pub places: &'a [(u32, u32)],
    pub values: &'a [T],
}

impl<T: Scalar> Entries<'_, T> {
    /// (row, column, value) of every entry, by columns.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (usize, usize, T)> + '_ {
        self.places
            .iter()
            .zip(self.values)
            .map(|(&(column, row), &value)| (row as usize, column as usize, value))
    }
}
