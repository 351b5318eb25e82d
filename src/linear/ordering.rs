//! The order in which the columns of large systems are eliminated: approximate minimum degree, as faer has it. Knows no values.

use faer::dyn_stack::{MemBuffer, MemStack};
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::amd;

use super::entries::Entries;
use super::scalar::Scalar;

/// From so many unknowns on the order is worth more than the search for the next pivot, which sees only what is there now.
const LARGE: usize = 500;

/// The columns in order; none for small systems, whose pivots are searched for.
pub(super) fn columns_of<T: Scalar>(matrix: &Entries<'_, T>) -> Vec<u32> {
    if matrix.n < LARGE {
        return Vec::new();
    }
    minimum_degree(matrix)
}

/// By the pattern of A + A'.
pub(crate) fn minimum_degree<T: Scalar>(matrix: &Entries<'_, T>) -> Vec<u32> {
    let n = matrix.n;
    let (mut starts, mut rows) = (vec![0_usize; n + 1], Vec::new());
    for (row, column, _) in matrix.iter() {
        starts[column + 1] += 1;
        rows.push(row);
    }
    for k in 0..n {
        starts[k + 1] += starts[k];
    }
    let pattern = SymbolicSparseColMatRef::new_checked(n, n, &starts, None, &rows);
    let (mut order, mut inverse) = (vec![0_usize; n], vec![0_usize; n]);
    let mut memory = MemBuffer::new(amd::order_scratch::<usize>(n, rows.len()));
    let found = amd::order(
        &mut order,
        &mut inverse,
        pattern,
        amd::Control::default(),
        MemStack::new(&mut memory),
    );
    match found {
        Ok(_) => order.iter().map(|&column| column as u32).collect(),
        // Too large for it: the pivots are searched for.
        Err(_) => Vec::new(),
    }
}
