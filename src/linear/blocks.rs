//! Steps of an elimination that have their rows and columns in common, run through together.
//!
//! Steps a, a + 1, ... are a block if each has the columns of the next in its row of U and that one's own, and the same of L. Outside of
//! the block all add to the same entries: these are fetched once for all of them. Each entry gets its products in the order of the steps.

use super::scalar::Scalar;
use super::step::Step;

/// A run of steps, and the operations between them: value indices that products are taken off.
///
/// Per step, row by row of L: all of U for rows of the block, U within the block for those outside. Then, row by row outside, U outside.
#[derive(Clone, Debug, Default)]
pub(super) struct Blocks {
    /// How many steps each has.
    sizes: Vec<u32>,
    targets: Vec<u32>,
}

/// An elimination written down step by step: values and their columns or rows, as of [`Step::at`], and where the products go.
pub(super) struct Written<'a> {
    /// With [`Step::below`] counted from the first of all L.
    pub steps: &'a [Step],
    /// (value, column) of pivot and U of all steps, (value, row) of L.
    pub across: &'a mut [(u32, u32)],
    pub down: &'a mut [(u32, u32)],
    /// For every step, row by row of L.
    pub targets: &'a [u32],
}

impl Written<'_> {
    fn upper(&self, step: &Step) -> &[(u32, u32)] {
        &self.across[step.across()]
    }

    fn lower(&self, step: &Step) -> &[(u32, u32)] {
        &self.down[step.down()]
    }

    /// True if a step has what the next one has, and that one's pivot.
    fn leads_to(&self, step: &Step, next: &Step, seen: &mut [u32], mark: &mut u32) -> bool {
        if step.upper != next.upper + 1 || step.lower != next.lower + 1 {
            return false;
        }
        let mut covers = |all: &[(u32, u32)], pivot: u32, others: &[(u32, u32)]| {
            *mark += 1;
            for (_, index) in all {
                seen[*index as usize] = *mark;
            }
            let has = |index: u32| seen[index as usize] == *mark;
            has(pivot) && others.iter().all(|(_, index)| has(*index))
        };
        covers(self.upper(step), next.column, self.upper(next))
            && covers(self.lower(step), next.row, self.lower(next))
    }

    /// Finds the blocks and brings the entries of their steps into one order.
    pub(super) fn blocks(&mut self, n: usize) -> Blocks {
        let mut blocks = Blocks::default();
        let (mut seen, mut mark) = (vec![0; n], 0);
        // Where the targets of the step begin.
        let mut from = 0;
        let mut first = 0;
        while first < self.steps.len() {
            let mut count = 1;
            while first + count < self.steps.len() {
                let (step, next) = (&self.steps[first + count - 1], &self.steps[first + count]);
                if !self.leads_to(step, next, &mut seen, &mut mark) {
                    break;
                }
                count += 1;
            }
            from = self.put_in_order(first, count, from, &mut seen, &mut blocks.targets);
            blocks.sizes.push(count as u32);
            first += count;
        }
        blocks
    }

    /// Of one block; gives where the targets of the next one begin.
    fn put_in_order(
        &mut self,
        first: usize,
        count: usize,
        mut from: usize,
        place: &mut [u32],
        targets: &mut Vec<u32>,
    ) -> usize {
        let steps = &self.steps[first..first + count];
        let last = &steps[count - 1];
        let outside = |entries: &[(u32, u32)]| entries.iter().map(|e| e.1).collect::<Vec<u32>>();
        let (columns, rows) = (outside(self.upper(last)), outside(self.lower(last)));
        for (at, step) in steps.iter().enumerate() {
            let inside = count - 1 - at;
            let mut arranged =
                |entries: &[(u32, u32)], own: &dyn Fn(&Step) -> u32, rest: &[u32]| {
                    for (k, (_, index)) in entries.iter().enumerate() {
                        place[*index as usize] = k as u32;
                    }
                    let wanted = steps[at + 1..].iter().map(own).chain(rest.iter().copied());
                    let from: Vec<u32> = wanted.map(|index| place[index as usize]).collect();
                    from
                };
            let across = arranged(self.upper(step), &|step| step.column, &columns);
            let down = arranged(self.lower(step), &|step| step.row, &rows);
            let width = step.upper as usize;
            for (k, row) in down.iter().enumerate() {
                let now = if k < inside || inside == 0 {
                    width
                } else {
                    inside
                };
                let begin = from + *row as usize * width;
                let moved = across[..now].iter();
                targets.extend(moved.map(|column| self.targets[begin + *column as usize]));
            }
            from += width * step.lower as usize;
            for (order, moved) in [
                (&mut self.across[step.across()], across),
                (&mut self.down[step.down()], down),
            ] {
                let before = order.to_vec();
                for (to, old) in order.iter_mut().zip(moved) {
                    *to = before[old as usize];
                }
            }
        }
        from
    }
}

impl Blocks {
    pub(super) fn is_empty(&self) -> bool {
        self.sizes.is_empty()
    }

    /// The most steps of a block.
    #[cfg(test)]
    pub(super) fn largest(&self) -> u32 {
        self.sizes.iter().copied().max().unwrap_or(0)
    }

    /// Gives the values other numbers.
    pub(super) fn renumber(&mut self, to: impl Fn(u32) -> u32) {
        for target in &mut self.targets {
            *target = to(*target);
        }
    }

    /// Runs through the operations with new values of the matrix; false if a pivot has shrunk too far. `row` is memory.
    pub(super) fn repeat<T: Scalar>(
        &self,
        steps: &[Step],
        index: &[u32],
        scales: (&[f64], &[f64]),
        values: &mut [T],
        row: &mut Vec<T>,
    ) -> bool {
        let mut targets = self.targets.as_slice();
        let mut left = steps;
        for size in &self.sizes {
            let (steps, later) = left.split_at(*size as usize);
            left = later;
            for (at, step) in steps.iter().enumerate() {
                let (upper, lower) = (step.upper as usize, step.below as usize);
                // Blocks are of factors that only steps of an iteration come from.
                if !step.holds(values, index, scales, true) {
                    return false;
                }
                let inverse = values[step.at as usize].inverse();
                row.clear();
                row.extend_from_slice(&values[step.across()]);
                let inside = steps.len() - 1 - at;
                for k in 0..step.lower as usize {
                    let multiplier = values[lower + k] * inverse;
                    values[lower + k] = multiplier;
                    let (now, after) = targets.split_at(match (k < inside, inside) {
                        (true, _) => upper,
                        (false, 0) => 0,
                        (false, inside) => inside,
                    });
                    targets = after;
                    if multiplier == T::default() {
                        continue;
                    }
                    for (&target, &factor) in now.iter().zip(row.iter()) {
                        values[target as usize] -= multiplier * factor;
                    }
                }
            }
            let last = &steps[steps.len() - 1];
            let width = last.upper as usize;
            for k in 0..last.lower as usize {
                let (now, after) = targets.split_at(width);
                targets = after;
                row.clear();
                row.extend(now.iter().map(|target| values[*target as usize]));
                for (at, step) in steps.iter().enumerate() {
                    let inside = steps.len() - 1 - at;
                    let multiplier = values[step.below as usize + inside + k];
                    if multiplier == T::default() {
                        continue;
                    }
                    let factors = &values[step.across()][inside..];
                    for (sum, &factor) in row.iter_mut().zip(factors) {
                        *sum -= multiplier * factor;
                    }
                }
                for (&target, &value) in now.iter().zip(row.iter()) {
                    values[target as usize] = value;
                }
            }
        }
        true
    }
}
