//! The first elimination of a pattern: choosing pivots, and writing down what is done.

use super::entries::Entries;
use super::factors::Factors;
use super::pattern::Pattern;
use super::scalar::Scalar;
use super::step::Step;

/// A pivot smaller than this, after rows and columns are scaled to one, is none.
const RANK_TOLERANCE: f64 = 1e-11;
/// A pivot must reach this share of the largest entry of its column.
const THRESHOLD: f64 = 0.1;
/// Entries smaller than this beside others are round-off of directions: cos 90 degrees.
const NOISE: f64 = 1e-14;
/// How many columns are looked at for one pivot.
const CANDIDATES: usize = 4;
const NOWHERE: u32 = u32::MAX;

/// An elimination as it was done.
pub(super) struct Eliminated<T> {
    pub pattern: Pattern,
    pub factors: Factors<T>,
    /// Columns without a pivot.
    pub free: Vec<u32>,
    /// Rows without a pivot.
    pub idle: Vec<u32>,
    pub row_scale: Vec<f64>,
    pub column_scale: Vec<f64>,
}

/// An elimination in progress. Values stand in order of creation: entries of the matrix, then fill.
struct Elimination<'a, T> {
    values: Vec<T>,
    /// (column, value index) of the entries of each active row.
    rows: Vec<Vec<(u32, u32)>>,
    /// (row, value index) of the entries of each column in active rows.
    columns: Vec<Vec<(u32, u32)>>,
    /// Columns by number of entries; an entry may be out of date.
    buckets: Vec<Vec<u32>>,
    /// The columns in the order they are taken in, the next one last; empty if they are searched for.
    given: Vec<u32>,
    /// Columns that are done with or put aside.
    closed: Vec<bool>,
    place: Vec<u32>,
    row_scale: &'a [f64],
    column_scale: &'a [f64],
    /// Row, column and value index of the pivots.
    pivots: Vec<(u32, u32, u32)>,
    /// Columns and value indices of U of all steps, rows and value indices of L; where those of a step end.
    across: Vec<(u32, u32)>,
    down: Vec<(u32, u32)>,
    ends: Vec<(u32, u32)>,
    free: Vec<u32>,
}

/// Eliminates a matrix, its columns in the order given; where none is, they are searched for.
pub(super) fn eliminated<T: Scalar>(matrix: &Entries<'_, T>, mut given: Vec<u32>) -> Eliminated<T> {
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
        values: matrix.values.to_vec(),
        rows,
        columns,
        buckets: vec![Vec::new(); n + 1],
        given,
        closed: vec![false; n],
        place: vec![NOWHERE; n],
        row_scale: &row_scale,
        column_scale: &column_scale,
        pivots: Vec::with_capacity(n),
        across: Vec::new(),
        down: Vec::new(),
        ends: Vec::with_capacity(n),
        free: Vec::new(),
    };
    for column in 0..n {
        work.file(column as u32);
    }
    while let Some((row, column)) = work.choose() {
        work.eliminate(row, column);
    }
    work.free.sort_unstable();
    let (pattern, factors) = work.written(matrix);
    let mut active = vec![true; n];
    for step in &pattern.steps {
        active[step.row as usize] = false;
    }
    Eliminated {
        pattern,
        factors,
        free: work.free,
        idle: (0..n as u32).filter(|r| active[*r as usize]).collect(),
        row_scale,
        column_scale,
    }
}

impl<T: Scalar> Elimination<'_, T> {
    fn file(&mut self, column: u32) {
        let count = self.columns[column as usize].len();
        self.buckets[count].push(column);
    }

    fn size(&self, row: u32, column: u32, value: u32) -> f64 {
        self.values[value as usize].size()
            * self.row_scale[row as usize]
            * self.column_scale[column as usize]
    }

    /// The pivot of the next step: few entries in its row and column, and large enough.
    fn choose(&mut self) -> Option<(u32, u32)> {
        while let Some(column) = self.given.pop() {
            self.closed[column as usize] = true;
            match self.best_row(column) {
                Some(row) => return Some((row, column)),
                None => self.free.push(column),
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
                        // Nothing resists this unknown.
                        self.closed[column as usize] = true;
                        self.free.push(column);
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
            // Longer columns cannot do much better than what is found.
            if let Some((cost, _, _)) = best
                && cost <= count * count
            {
                break;
            }
            count += 1;
        }
        best.map(|b| (b.1, b.2))
    }

    /// The shortest row whose entry in the column is large enough.
    fn best_row(&self, column: u32) -> Option<u32> {
        let mut largest = 0.0_f64;
        for &(row, value) in &self.columns[column as usize] {
            largest = largest.max(self.size(row, column, value));
        }
        let enough = largest >= RANK_TOLERANCE;
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
        let size = self.values[pivot as usize];
        self.pivots.push((row, column, pivot));
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
            let multiplier = self.values[value as usize] / size;
            self.values[value as usize] = multiplier;
            for &(c, v) in &self.rows[other as usize] {
                self.place[c as usize] = v;
            }
            for &(c, v) in &upper {
                let product = multiplier * self.values[v as usize];
                let target = self.place[c as usize];
                if target == NOWHERE {
                    let target = self.values.len() as u32;
                    self.values.push(-product);
                    self.rows[other as usize].push((c, target));
                    self.columns[c as usize].push((other, target));
                    self.place[c as usize] = target;
                } else {
                    self.values[target as usize] -= product;
                }
            }
            for &(c, _) in &self.rows[other as usize] {
                self.place[c as usize] = NOWHERE;
            }
        }
        for &(other, _) in &upper {
            if !self.closed[other as usize] {
                self.file(other);
            }
        }
        self.across.extend(upper);
        self.down.extend(lower);
        self.ends
            .push((self.across.len() as u32, self.down.len() as u32));
    }

    /// What was done, row by row.
    fn written(&self, matrix: &Entries<'_, T>) -> (Pattern, Factors<T>) {
        let count = self.pivots.len();
        // Rows without a pivot have no step.
        let mut step_of = vec![NOWHERE; matrix.n];
        for (k, (row, ..)) in self.pivots.iter().enumerate() {
            step_of[*row as usize] = k as u32;
        }
        let places = matrix.places.iter().enumerate();
        let entries = by_rows(count, || {
            let rows = places.clone();
            rows.map(|(k, &(column, row))| (step_of[row as usize], (k as u32, column)))
        });
        let left = by_rows(count, || {
            let steps = self.ends.iter().enumerate();
            steps
                .flat_map(|(k, &(_, end))| {
                    let from = k.checked_sub(1).map_or(0, |k| self.ends[k].1);
                    let down = &self.down[from as usize..end as usize];
                    down.iter().map(move |&(row, at)| (row, (k as u32, at)))
                })
                .map(|(row, entry)| (step_of[row as usize], entry))
        });
        let mut pattern = Pattern {
            steps: Vec::with_capacity(count),
            entries: entries.1,
            lower: (left.1.iter())
                .map(|(k, _)| (*k, self.pivots[*k as usize].1))
                .collect(),
            upper: self.across.iter().map(|(column, _)| *column).collect(),
        };
        let mut factors = Factors::default();
        let mut to = factors.begin(pattern.lower.len(), pattern.upper.len());
        let zero = T::default();
        let (mut from_lower, mut from_upper) = (0, 0);
        for (k, &(row, column, pivot)) in self.pivots.iter().enumerate() {
            let (lower, upper) = (left.0[k], self.ends[k].0);
            for &(k, at) in &left.1[from_lower..lower as usize] {
                let multiplier = self.values[at as usize];
                if multiplier != zero {
                    to.push_lower(self.pivots[k as usize].0, multiplier);
                }
            }
            for &(column, at) in &self.across[from_upper..upper as usize] {
                to.push_upper(column, self.values[at as usize]);
            }
            (from_lower, from_upper) = (lower as usize, upper as usize);
            let pivot = self.values[pivot as usize];
            to.end_row(row, column, pivot);
            pattern.steps.push(Step {
                row,
                column,
                entries: entries.0[k],
                lower,
                upper,
                size: pivot.size(),
            });
        }
        (pattern, factors)
    }
}

/// Items sorted into so many rows, each in the order in which they come, and where the rows end. What has no row is left out.
fn by_rows<I>(count: usize, items: impl Fn() -> I) -> (Vec<u32>, Vec<(u32, u32)>)
where
    I: Iterator<Item = (u32, (u32, u32))>,
{
    let of_rows = || items().filter(|(row, _)| *row != NOWHERE);
    let mut next = vec![0_u32; count + 1];
    for (row, _) in of_rows() {
        next[row as usize + 1] += 1;
    }
    for k in 0..count {
        next[k + 1] += next[k];
    }
    let mut sorted = vec![(0, 0); next[count] as usize];
    for (row, item) in of_rows() {
        let at = &mut next[row as usize];
        sorted[*at as usize] = item;
        *at += 1;
    }
    // Every row went up to where the next one begins.
    next.pop();
    (next, sorted)
}

/// Powers of two that bring the largest entry of every row, then of every column, close to one. An entry that is round-off beside the
/// others of its column says nothing about its row, and the other way round: a row of nothing else stays small, and has no pivot.
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

/// Close to the inverse and free of round-off; one for zero.
fn inverse_power_of_two(x: f64) -> f64 {
    if x > 0.0 && x.is_finite() {
        libm::exp2(-libm::log2(x).round())
    } else {
        1.0
    }
}
