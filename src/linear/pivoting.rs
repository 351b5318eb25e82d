//! The first elimination of a pattern: choosing pivots, and writing down what is done.

use super::blocks::{Blocks, Written};
use super::entries::Entries;
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
    pub steps: Vec<Step>,
    /// Where each entry of the matrix goes.
    pub entries: Vec<u32>,
    /// Column (of U entries) or row (of L entries) of every value.
    pub index: Vec<u32>,
    pub values: Vec<T>,
    /// For every step, row by row of L: where the products go.
    pub targets: Vec<u32>,
    /// The operations of many steps at once, in place of the targets; empty where they were not asked for.
    pub blocks: Blocks,
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
    steps: Vec<Step>,
    /// Value indices of pivot and U of all steps, columns beside them; of L, rows beside them.
    across: Vec<(u32, u32)>,
    down: Vec<(u32, u32)>,
    targets: Vec<u32>,
    free: Vec<u32>,
}

/// Eliminates a matrix, its columns in the order given; where none is, they are searched for. `in_blocks` writes the steps down in blocks.
pub(super) fn eliminated<T: Scalar>(
    matrix: &Entries<'_, T>,
    mut given: Vec<u32>,
    in_blocks: bool,
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
        values: matrix.values.to_vec(),
        rows,
        columns,
        buckets: vec![Vec::new(); n + 1],
        given,
        closed: vec![false; n],
        place: vec![NOWHERE; n],
        row_scale: &row_scale,
        column_scale: &column_scale,
        steps: Vec::with_capacity(n),
        across: Vec::new(),
        down: Vec::new(),
        targets: Vec::new(),
        free: Vec::new(),
    };
    for column in 0..n {
        work.file(column as u32);
    }
    while let Some((row, column)) = work.choose() {
        work.eliminate(row, column);
    }
    let mut active = vec![true; n];
    for step in &work.steps {
        active[step.row as usize] = false;
    }
    let Elimination {
        values,
        mut steps,
        across: mut order,
        mut down,
        mut targets,
        mut free,
        ..
    } = work;
    free.sort_unstable();
    let mut blocks = Blocks::default();
    if in_blocks {
        let mut written = Written {
            steps: &steps,
            across: &mut order,
            down: &mut down,
            targets: &targets,
        };
        blocks = written.blocks(n);
        targets = Vec::new();
    }
    for step in &mut steps {
        step.below += order.len() as u32;
    }
    order.extend(down);
    // Values move to where a step finds its own side by side; what no step owns is dropped at the end.
    let mut moved = vec![NOWHERE; values.len()];
    for (new, (old, _)) in order.iter().enumerate() {
        moved[*old as usize] = new as u32;
    }
    let dump = order.len() as u32;
    let to = |old: u32| match moved[old as usize] {
        NOWHERE => dump,
        new => new,
    };
    blocks.renumber(to);
    let own = order.iter().map(|(old, _)| values[*old as usize]);
    Eliminated {
        values: own.chain([T::default()]).collect(),
        index: order.iter().map(|(_, index)| *index).collect(),
        entries: (0..matrix.values.len() as u32).map(to).collect(),
        targets: targets.into_iter().map(to).collect(),
        blocks,
        steps,
        free,
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
        self.steps.push(Step {
            row,
            column,
            at: self.across.len() as u32,
            upper: upper.len() as u32,
            below: self.down.len() as u32,
            lower: lower.len() as u32,
            size: size.size(),
        });
        self.across.push((pivot, column));
        for &(other, value) in &upper {
            self.across.push((value, other));
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
            self.down.push((value, other));
            let multiplier = self.values[value as usize] / size;
            self.values[value as usize] = multiplier;
            for &(c, v) in &self.rows[other as usize] {
                self.place[c as usize] = v;
            }
            for &(c, v) in &upper {
                let product = multiplier * self.values[v as usize];
                let mut target = self.place[c as usize];
                if target == NOWHERE {
                    target = self.values.len() as u32;
                    self.values.push(-product);
                    self.rows[other as usize].push((c, target));
                    self.columns[c as usize].push((other, target));
                    self.place[c as usize] = target;
                } else {
                    self.values[target as usize] -= product;
                }
                self.targets.push(target);
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
    }
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
