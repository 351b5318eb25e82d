//! Linearly dependent columns of a sparse matrix.

use super::entries::Entries;
use super::ordering::by_shared_rows;
use super::pivoting::{RANK_TOLERANCE, eliminated};

/// Returns columns whose removal leaves a linearly independent set with the same span; all empty columns are among them. Of several possible
/// choices, the elimination order with little fill selects one.
pub(crate) fn dependent_columns(matrix: &Entries<'_, f64>) -> Vec<u32> {
    eliminated(matrix, by_shared_rows(matrix), false, RANK_TOLERANCE).free
}

#[cfg(test)]
mod tests {
    use crate::linear::{Matrix, Sink, dependent_columns};

    /// One of three columns in a plane is dependent, and so is an empty column.
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
