//! Linearly dependent columns of a sparse matrix.

use super::entries::Entries;
use super::ordering::by_shared_rows;
use super::pivoting::{RANK_TOLERANCE, eliminated};

/// Returns the indices of columns whose removal leaves linearly independent columns with the same span; all empty columns are among them. If
/// several choices are possible, the low-fill elimination order determines which columns are returned.
pub(crate) fn dependent_columns(matrix: &Entries<'_, f64>) -> Vec<u32> {
    eliminated(matrix, by_shared_rows(matrix), false, RANK_TOLERANCE).free
}

#[cfg(test)]
mod tests {
    use crate::linear::{Matrix, Sink, dependent_columns};

    /// The rank of three columns is two, and one of them is returned as dependent. The empty fourth column is returned, too.
    #[test]
    fn one_of_dependent_columns_is_named() {
        let columns = [
            [1.0, 2.0, 0.0, 1.0],
            [0.0, 1.0, 1.0, -1.0],
            [2.0, 5.0, 1.0, 1.0],
        ];
        let mut matrix = Matrix::new(4);
        for (k, column) in columns.iter().enumerate() {
            for (row, value) in column.iter().enumerate() {
                matrix.add(row, k, *value);
            }
        }
        matrix.finish();
        let found = dependent_columns(&matrix.view());
        assert_eq!((found.len(), found.last()), (2, Some(&3)));
    }
}
