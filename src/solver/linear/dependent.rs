//! Columns that say nothing new.

use super::entries::Entries;
use super::ordering::by_shared_rows;
use super::pivoting::{RANK_TOLERANCE, eliminated};

/// Columns of a sparse matrix without which the others have the same span and depend on none of each other; all that are empty are among
/// them. Which of several it is goes by the order that keeps the elimination short.
pub(crate) fn dependent_columns(matrix: &Entries<'_, f64>) -> Vec<u32> {
    eliminated(matrix, by_shared_rows(matrix), false, RANK_TOLERANCE).free
}

#[cfg(test)]
mod tests {
    use crate::linear::{Matrix, Sink, dependent_columns};

    /// Of three columns in a plane one is left over, of an empty one nothing is kept.
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
