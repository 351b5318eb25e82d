//! Rearrangement of an elimination order with the same fill, so that related columns are eliminated close together.
//!
//! The elimination of a column changes later columns; the first of these is its parent. All orders in which children precede their parents
//! have the same fill. Minimum degree orders place the largest child last, which suits a stack of matrices. In a long chain with a short
//! branch at every link they eliminate all branches, then all links. Here the largest child comes first, and every branch next to its link.
//! The values that a step reads are then still in the cache.

const NONE: u32 = u32::MAX;

/// Returns the rearranged order. The pattern is treated as symmetric; `starts` and `rows` describe its columns.
pub(super) fn rearranged(order: &[usize], starts: &[usize], rows: &[usize]) -> Vec<u32> {
    let parents = parents(order, starts, rows);
    let n = order.len();
    let mut sizes = vec![1_u32; n];
    for k in 0..n {
        if parents[k] != NONE {
            sizes[parents[k] as usize] += sizes[k];
        }
    }
    // Linked lists of the children of every step, and one more list of the roots. New items are inserted at the front.
    let mut first = vec![NONE; n + 1];
    let mut next = vec![NONE; n];
    let list = |k: usize| match parents[k] {
        NONE => n,
        parent => parent as usize,
    };
    let mut by_size: Vec<u32> = (0..n as u32).collect();
    by_size.sort_by_key(|k| sizes[*k as usize]);
    for k in by_size {
        let list = list(k as usize);
        next[k as usize] = first[list];
        first[list] = k;
    }
    let mut out = Vec::with_capacity(n);
    let mut path = Vec::new();
    let mut at = first[n];
    loop {
        // Descend to the first leaf, then ascend until there is a sibling.
        while at != NONE {
            path.push(at);
            at = first[at as usize];
        }
        let Some(done) = path.pop() else {
            return out;
        };
        out.push(order[done as usize] as u32);
        at = next[done as usize];
    }
}

/// Returns the parent of every elimination step, by Liu's algorithm.
fn parents(order: &[usize], starts: &[usize], rows: &[usize]) -> Vec<u32> {
    let n = order.len();
    let mut step = vec![0_u32; n];
    for (k, column) in order.iter().enumerate() {
        step[*column] = k as u32;
    }
    let mut before = vec![Vec::new(); n];
    for column in 0..n {
        for row in &rows[starts[column]..starts[column + 1]] {
            let (a, b) = (step[column], step[*row]);
            if a != b {
                before[a.max(b) as usize].push(a.min(b));
            }
        }
    }
    let (mut parents, mut roots) = (vec![NONE; n], vec![NONE; n]);
    for k in 0..n as u32 {
        for &earlier in &before[k as usize] {
            // Ascend to the root of what has been eliminated so far. The path is shortened for the next time.
            let mut at = earlier;
            while at != k {
                let up = roots[at as usize];
                roots[at as usize] = k;
                if up == NONE {
                    parents[at as usize] = k;
                    break;
                }
                at = up;
            }
        }
    }
    parents
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A chain with a branch at every link: branches and links alternate, and no column is eliminated before its children.
    #[test]
    fn branches_stand_next_to_their_links() {
        let links = 200;
        let n = 2 * links;
        // Links come first, branch k is column links + k.
        let mut columns = vec![Vec::new(); n];
        let mut joined = |a: usize, b: usize| {
            columns[a].push(b);
            columns[b].push(a);
        };
        for k in 0..links {
            joined(k, links + k);
            if k > 0 {
                joined(k - 1, k);
            }
        }
        let mut starts = vec![0];
        for rows in &columns {
            starts.push(starts.last().unwrap() + rows.len());
        }
        let rows: Vec<usize> = columns.concat();
        // A minimum degree order: all branches, then all links.
        let order: Vec<usize> = (links..n).chain(0..links).collect();
        let found = rearranged(&order, &starts, &rows);
        let mut step = vec![usize::MAX; n];
        for (k, column) in found.iter().enumerate() {
            step[*column as usize] = k;
        }
        for k in 0..links {
            assert!(step[links + k] < step[k]);
            assert!(step[k] - step[links + k] <= 2);
            assert!(k == 0 || step[k - 1] < step[k]);
        }
    }
}
