//! First elimination of a pattern, which chooses the pivots and records the operations.

use super::entries::Entries;
use super::scalar::Scalar;
use super::step::EliminationStep;

/// Size below which a pivot counts as zero, after the rows and columns are scaled so that their largest entries are about one.
pub(super) const RANK_TOLERANCE: f64 = 1e-11;
/// Smallest allowed ratio of a pivot to the largest entry of its column, both scaled.
const THRESHOLD: f64 = 0.1;
/// Entries below this share of the largest entry in their column or row are round-off of direction cosines, such as cos 90 degrees.
const NOISE: f64 = 1e-14;
/// Number of columns examined in the search for one pivot.
const CANDIDATES: usize = 4;
const NOWHERE: u32 = u32::MAX;

/// Record of an elimination. `values` is in order of creation: first the entries of the matrix, then the fill. The "place" of a value is its
/// index in `values`.
pub(super) struct Eliminated<T> {
    pub values: Vec<T>,
    pub steps: Vec<EliminationStep>,
    /// Place of the pivot of each elimination step.
    pub pivots: Vec<u32>,
    /// (column, place) of the entries of U, for all elimination steps in turn.
    across: Vec<(u32, u32)>,
    /// (row, place) of the entries of L, for all elimination steps in turn.
    down: Vec<(u32, u32)>,
    /// End of each elimination step in `across` and in `down`.
    ends: Vec<(usize, usize)>,
    /// Place from which each product was subtracted, ordered by elimination step and, within a step, by rows of L. Empty unless requested.
    pub targets: Vec<u32>,
    /// Columns without a pivot.
    pub free: Vec<u32>,
    /// Rows without a pivot.
    pub idle: Vec<u32>,
    pub row_scale: Vec<f64>,
    pub column_scale: Vec<f64>,
}

impl<T> Eliminated<T> {
    /// Returns the entries of the k-th elimination step: (column, place) for U, and (row, place) for L.
    pub(super) fn of_step(&self, k: usize) -> (&[(u32, u32)], &[(u32, u32)]) {
        let (upper, lower) = k.checked_sub(1).map_or((0, 0), |k| self.ends[k]);
        let ends = self.ends[k];
        (&self.across[upper..ends.0], &self.down[lower..ends.1])
    }
}

/// An elimination in progress.
struct Elimination<T> {
    done: Eliminated<T>,
    with_targets: bool,
    rank_tolerance: f64,
    /// (column, place) of the entries of each row that is not yet eliminated.
    rows: Vec<Vec<(u32, u32)>>,
    /// (row, place) of the entries of each column, in rows that are not yet eliminated.
    columns: Vec<Vec<(u32, u32)>>,
    /// Columns grouped by their number of entries; some items may be out of date.
    buckets: Vec<Vec<u32>>,
    /// Columns in the given elimination order, with the next column last. Empty if columns are searched for.
    given: Vec<u32>,
    /// Whether each column has been eliminated or set aside.
    closed: Vec<bool>,
    place: Vec<u32>,
}

/// Eliminates the columns of a matrix in the order `given`. If `given` is empty, the columns are searched for.
pub(super) fn eliminated<T: Scalar>(
    matrix: &Entries<'_, T>,
    mut given: Vec<u32>,
    with_targets: bool,
    rank_tolerance: f64,
) -> Eliminated<T> {
    let n = matrix.n;
    given.reverse();
    let (mut row_scale, mut column_scale) = (vec![0.0; n], vec![0.0; n]);
    scale(matrix, &mut row_scale, &mut column_scale);
    let mut rows = vec![Vec::new(); n];
    let mut columns = vec![Vec::new(); n];
    for (k, (row, column, _)) in matrix.iter().enumerate() {
        rows[row].push((column as u32, k as u32));
        columns[column].push((row as u32, k as u32));
    }
    let mut work = Elimination {
        done: Eliminated {
            values: matrix.values.to_vec(),
            steps: Vec::with_capacity(n),
            pivots: Vec::with_capacity(n),
            across: Vec::new(),
            down: Vec::new(),
            ends: Vec::with_capacity(n),
            targets: Vec::new(),
            free: Vec::new(),
            idle: Vec::new(),
            row_scale,
            column_scale,
        },
        with_targets,
        rank_tolerance,
        rows,
        columns,
        buckets: vec![Vec::new(); n + 1],
        given,
        closed: vec![false; n],
        place: vec![NOWHERE; n],
    };
    for column in 0..n {
        work.file(column as u32);
    }
    while let Some((row, column)) = work.choose() {
        work.eliminate(row, column);
    }
    let mut done = work.done;
    done.free.sort_unstable();
    let mut active = vec![true; n];
    for step in &done.steps {
        active[step.row as usize] = false;
    }
    done.idle = (0..n as u32).filter(|r| active[*r as usize]).collect();
    done
}

impl<T: Scalar> Elimination<T> {
    fn file(&mut self, column: u32) {
        let count = self.columns[column as usize].len();
        self.buckets[count].push(column);
    }

    fn size(&self, row: u32, column: u32, value: u32) -> f64 {
        self.done.values[value as usize].size()
            * self.done.row_scale[row as usize]
            * self.done.column_scale[column as usize]
    }

    /// Chooses the (row, column) of the next pivot, which is large enough and has few entries in its row and column. Returns `None` if no pivot
    /// is left.
    fn choose(&mut self) -> Option<(u32, u32)> {
        while let Some(column) = self.given.pop() {
            self.closed[column as usize] = true;
            match self.best_row(column) {
                Some(row) => return Some((row, column)),
                None => self.done.free.push(column),
            }
        }
        let mut best: Option<(usize, u32, u32)> = None;
        let mut looked = 0;
        let mut count = 0;
        while count < self.buckets.len() {
            let mut at = 0;
            while at < self.buckets[count].len() {
                let column = self.buckets[count][at];
                let current =
                    !self.closed[column as usize] && self.columns[column as usize].len() == count;
                if !current {
                    self.buckets[count].swap_remove(at);
                    continue;
                }
                at += 1;
                match self.best_row(column) {
                    None => {
                        // The column has no pivot.
                        self.closed[column as usize] = true;
                        self.done.free.push(column);
                        self.buckets[count].swap_remove(at - 1);
                        at -= 1;
                    }
                    Some(row) => {
                        let others = self.rows[row as usize].len() - 1;
                        let cost = others * (count - 1);
                        if best.is_none_or(|b| cost < b.0) {
                            best = Some((cost, row, column));
                        }
                        looked += 1;
                        if looked >= CANDIDATES || cost == 0 {
                            return best.map(|b| (b.1, b.2));
                        }
                    }
                }
            }
            // Longer columns cannot have a much lower cost.
            if let Some((cost, _, _)) = best
                && cost <= count * count
            {
                break;
            }
            count += 1;
        }
        best.map(|b| (b.1, b.2))
    }

    /// Returns the shortest row whose entry in the column is large enough; `None` if the column has no pivot.
    fn best_row(&self, column: u32) -> Option<u32> {
        let mut largest = 0.0_f64;
        for &(row, value) in &self.columns[column as usize] {
            largest = largest.max(self.size(row, column, value));
        }
        let enough = largest >= self.rank_tolerance;
        if !enough {
            return None;
        }
        let mut best: Option<(usize, f64, u32)> = None;
        for &(row, value) in &self.columns[column as usize] {
            let size = self.size(row, column, value);
            if size < THRESHOLD * largest {
                continue;
            }
            let count = self.rows[row as usize].len();
            if best.is_none_or(|b| count < b.0 || (count == b.0 && size > b.1)) {
                best = Some((count, size, row));
            }
        }
        best.map(|b| b.2)
    }

    fn eliminate(&mut self, row: u32, column: u32) {
        let mut upper = std::mem::take(&mut self.rows[row as usize]);
        let at = upper
            .iter()
            .position(|entry| entry.0 == column)
            .expect("the pivot is in its row");
        let pivot = upper.swap_remove(at).1;
        let mut lower = std::mem::take(&mut self.columns[column as usize]);
        lower.retain(|other| other.0 != row);
        self.closed[column as usize] = true;
        let done = &mut self.done;
        let size = done.values[pivot as usize];
        done.pivots.push(pivot);
        done.steps.push(EliminationStep {
            row,
            column,
            size: size.size(),
        });
        for &(other, _) in &upper {
            let rows = &mut self.columns[other as usize];
            let at = rows
                .iter()
                .position(|entry| entry.0 == row)
                .expect("columns list the rows of their entries");
            rows.swap_remove(at);
        }
        for &(other, value) in &lower {
            let at = self.rows[other as usize]
                .iter()
                .position(|entry| entry.0 == column)
                .expect("columns list the rows of their entries");
            self.rows[other as usize].swap_remove(at);
            let multiplier = done.values[value as usize] / size;
            done.values[value as usize] = multiplier;
            for &(c, v) in &self.rows[other as usize] {
                self.place[c as usize] = v;
            }
            for &(c, v) in &upper {
                let product = multiplier * done.values[v as usize];
                let mut target = self.place[c as usize];
                if target == NOWHERE {
                    target = done.values.len() as u32;
                    done.values.push(-product);
                    self.rows[other as usize].push((c, target));
                    self.columns[c as usize].push((other, target));
                    self.place[c as usize] = target;
                } else {
                    done.values[target as usize] -= product;
                }
                if self.with_targets {
                    done.targets.push(target);
                }
            }
            for &(c, _) in &self.rows[other as usize] {
                self.place[c as usize] = NOWHERE;
            }
        }
        done.across.extend(&upper);
        done.down.extend(lower);
        done.ends.push((done.across.len(), done.down.len()));
        for (other, _) in upper {
            if !self.closed[other as usize] {
                self.file(other);
            }
        }
    }
}

/// Computes powers of two that scale the largest entry of every row, then of every column, to about one. An entry that is round-off relative to
/// the largest entry of its column is ignored in the scale of its row, and vice versa. A row that contains only such entries thus stays small
/// and gets no pivot.
fn scale<T: Scalar>(matrix: &Entries<'_, T>, rows: &mut [f64], columns: &mut [f64]) {
    rows.fill(0.0);
    columns.fill(0.0);
    for (_, column, value) in matrix.iter() {
        columns[column] = columns[column].max(value.size());
    }
    for (row, column, value) in matrix.iter() {
        if value.size() > NOISE * columns[column] {
            rows[row] = rows[row].max(value.size());
        }
    }
    for scale in rows.iter_mut() {
        *scale = inverse_power_of_two(*scale);
    }
    columns.fill(0.0);
    for (row, column, value) in matrix.iter() {
        let size = value.size() * rows[row];
        if size > NOISE {
            columns[column] = columns[column].max(size);
        }
    }
    for scale in columns.iter_mut() {
        *scale = inverse_power_of_two(*scale);
    }
}

/// Returns a power of two close to 1 / x, which scales without round-off; one if x is zero or not finite.
fn inverse_power_of_two(x: f64) -> f64 {
    if x > 0.0 && x.is_finite() {
        libm::exp2(-libm::log2(x).round())
    } else {
        1.0
    }
}
