//! The order of the additions of a first assembly in the matrix they make up.

/// Numbers of the additions in order of columns, then rows, then as they came; `place` is (column, row). They are counted into columns, which
/// are short.
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
