//! Column order for the elimination of large systems: approximate minimum degree (Amestoy, Davis and Duff 1996), by the crate
//! `amd`. It depends only on the pattern of the matrix.

use amd::Control;

use super::entries::Entries;
use super::postorder::rearranged;
use super::scalar::Scalar;

/// Number of unknowns from which a precomputed order is better than a search for each pivot. The search considers only the entries at the
/// current elimination step.
const LARGE: usize = 500;

/// Rows with more entries than this are ignored by [`by_shared_rows`], because they would connect too many columns with each other.
const CROWD: usize = 300;

/// Returns the column order of a matrix. The order is empty for a small system, whose pivots are searched for during the elimination.
pub(super) fn columns_of<T: Scalar>(matrix: &Entries<'_, T>) -> Vec<u32> {
    if matrix.n < LARGE {
        return Vec::new();
    }
    minimum_degree(matrix)
}

/// Returns the minimum degree order of the columns for the pattern of A + A'.
pub(crate) fn minimum_degree<T: Scalar>(matrix: &Entries<'_, T>) -> Vec<u32> {
    of_pattern(
        matrix.n,
        matrix.iter().map(|(row, column, _)| (column, row)),
    )
}

/// Returns a column order for systems in which a row may have its large entries in any column of its own group. The groups are in minimum
/// degree order, and the columns of a group follow one another. `group[k]` is the group of row k and of column k, counted from zero. The order
/// is empty for a small system, whose pivots are searched for.
pub(crate) fn by_groups<T: Scalar>(matrix: &Entries<'_, T>, group: &[u32]) -> Vec<u32> {
    if matrix.n < LARGE {
        return Vec::new();
    }
    let count = group.iter().max().map_or(0, |last| *last as usize + 1);
    let mut members = vec![Vec::new(); count];
    for (k, of) in group.iter().enumerate() {
        members[*of as usize].push(k as u32);
    }
    let mut places: Vec<(usize, usize)> = matrix
        .iter()
        .map(|(row, column, _)| (group[column] as usize, group[row] as usize))
        .collect();
    places.sort_unstable();
    places.dedup();
    let order = of_pattern(count, places.into_iter());
    let columns = order.iter().flat_map(|of| &members[*of as usize]);
    columns.copied().collect()
}

/// Returns the minimum degree order of the columns for the pattern of A' A, which connects columns that share a row. Rows with more than
/// [`CROWD`] entries are ignored.
pub(super) fn by_shared_rows<T: Scalar>(matrix: &Entries<'_, T>) -> Vec<u32> {
    let mut rows = vec![Vec::new(); matrix.n];
    for (row, column, _) in matrix.iter() {
        rows[row].push(column);
    }
    let few = rows.iter().filter(|columns| columns.len() <= CROWD);
    let mut places: Vec<(usize, usize)> = few
        .flat_map(|columns| {
            columns
                .iter()
                .flat_map(|a| columns.iter().map(|b| (*a, *b)))
        })
        .collect();
    places.sort_unstable();
    places.dedup();
    let order = of_pattern(matrix.n, places.into_iter());
    if order.is_empty() {
        return (0..matrix.n as u32).collect();
    }
    order
}

/// Returns the minimum degree order of a pattern. `places` contains (column, row) of each entry, sorted. The order is empty if the pattern is
/// invalid.
fn of_pattern(n: usize, places: impl Iterator<Item = (usize, usize)>) -> Vec<u32> {
    let (mut starts, mut rows) = (vec![0_usize; n + 1], Vec::new());
    for (column, row) in places {
        starts[column + 1] += 1;
        rows.push(row);
    }
    for k in 0..n {
        starts[k + 1] += starts[k];
    }
    match amd::order(n, &starts, &rows, &Control::default()) {
        Ok((order, ..)) => rearranged(&order, &starts, &rows),
        // The pivots are searched for.
        Err(_) => Vec::new(),
    }
}
