//! Rearrangement of an elimination order that brings related columns close together and leaves the fill unchanged.
//!
//! The elimination of a column changes columns that are eliminated later. The first of these is its parent. All orders in which children
//! precede their parents have the same fill. Minimum degree orders place the child with the largest subtree last, which suits multifrontal
//! methods. In a long chain with a short branch at every link, such an order eliminates all branches first, then all links. Here the child with
//! the largest subtree comes first, so that every branch is eliminated next to its link. The values that an elimination step reads are then
//! still in the cache.

const NONE: u32 = u32::MAX;

/// Returns the rearranged elimination order. `starts` and `rows` give the pattern in compressed columns. The pattern is treated as symmetric.
pub(super) fn rearranged(order: &[usize], starts: &[usize], rows: &[usize]) -> Vec<u32> {
    let parents = parents(order, starts, rows);
    let n = order.len();
    let mut sizes = vec![1_u32; n];
    for k in 0..n {
        if parents[k] != NONE {
            sizes[parents[k] as usize] += sizes[k];
        }
    }
    // Linked lists of the children of every elimination step, and one more list of the roots. New items are inserted at the front.
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

/// Returns the parent of every elimination step by Liu's algorithm; [`NONE`] for a root.
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
            // Ascend to the root of the tree that contains the earlier step. Each step passed on the way is linked to `k` directly, which
            // shortens later ascents.
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

    /// In a chain with a branch at every link, branches and links alternate in the order, and no column is eliminated before its children.
    #[test]
    fn branches_stand_next_to_their_links() {
        let links = 200;
        let n = 2 * links;
        // The columns of the links come first; the column of branch k is links + k.
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
