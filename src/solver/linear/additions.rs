//! Sorting of additions: the values that the first assembly adds to a matrix are brought into the order of the matrix entries.

/// Returns the indices of the additions (values added to matrix entries), sorted by column, then by row, then by order of arrival. `place`
/// returns (column, row) of an addition. A counting sort by column is followed by a comparison sort within each column, because columns are
/// short.
pub(super) fn by_columns<T>(n: usize, all: &[T], place: impl Fn(&T) -> (u32, u32)) -> Vec<u32> {
    let mut ends = vec![0_u32; n + 1];
    for addition in all {
        ends[place(addition).0 as usize + 1] += 1;
    }
    for k in 0..n {
        ends[k + 1] += ends[k];
    }
    let mut next = ends.clone();
    let mut order = vec![0; all.len()];
    for (k, addition) in all.iter().enumerate() {
        let at = &mut next[place(addition).0 as usize];
        order[*at as usize] = k as u32;
        *at += 1;
    }
    for pair in ends.windows(2) {
        let column = &mut order[pair[0] as usize..pair[1] as usize];
        column.sort_unstable_by_key(|&k| (place(&all[k as usize]).1, k));
    }
    order
}
