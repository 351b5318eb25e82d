use super::Sink;
use super::entries::Entries;
use super::scalar::Scalar;

/// A sparse matrix in three levels over one pattern: derivatives by the unknowns, by their first and by their second rates; and a column
/// of derivatives by the time.
///
/// Column c of an addition stands for unknown c % n at level c / n; level 3 is the time. Entries arrive in the same order in every
/// assembly.
#[derive(Clone, Debug, Default)]
pub(crate) struct Levels {
    n: usize,
    /// (column, row) of every entry, sorted.
    places: Vec<(u32, u32)>,
    values: [Vec<f64>; 3],
    /// The entries that stand at the first or the second rate.
    rates: Vec<u32>,
    /// Derivative of every row by the time.
    pub time: Vec<f64>,
    /// Entry of the k-th addition, and its level.
    slots: Vec<(u32, u8)>,
    next: usize,
    /// Additions of the first assembly: column, row, level, value.
    first: Vec<(u32, u32, u8, f64)>,
    known: bool,
}

impl Sink for Levels {
    #[inline]
    fn add(&mut self, row: usize, column: usize, value: f64) {
        if column >= 3 * self.n {
            self.time[row] += value;
        } else if self.known {
            let (at, level) = self.slots[self.next];
            self.values[level as usize][at as usize] += value;
            self.next += 1;
        } else {
            let (level, column) = (column / self.n, column % self.n);
            self.first
                .push((column as u32, row as u32, level as u8, value));
        }
    }

    #[inline]
    fn add_column(&mut self, row: usize, column: usize, values: &[f64]) {
        if self.known && column < 3 * self.n {
            let end = self.next + values.len();
            for ((at, level), value) in self.slots[self.next..end].iter().zip(values) {
                self.values[*level as usize][*at as usize] += value;
            }
            self.next = end;
        } else {
            for (k, value) in values.iter().enumerate() {
                self.add(row + k, column, *value);
            }
        }
    }
}

impl Levels {
    /// Of n rows and columns.
    pub(crate) fn new(n: usize) -> Self {
        Self {
            n,
            time: vec![0.0; n],
            ..Self::default()
        }
    }

    /// Makes ready for an assembly.
    pub(crate) fn clear(&mut self) {
        for values in &mut self.values {
            values.fill(0.0);
        }
        self.time.fill(0.0);
        self.next = 0;
        if !self.known {
            self.first.clear();
        }
    }

    /// Ends an assembly.
    pub(crate) fn finish(&mut self) {
        if self.known {
            debug_assert_eq!(self.next, self.slots.len(), "same order every time");
            return;
        }
        let mut order: Vec<u32> = (0..self.first.len() as u32).collect();
        order.sort_by_key(|&k| (self.first[k as usize].0, self.first[k as usize].1));
        self.slots = vec![(0, 0); self.first.len()];
        for k in order {
            let (column, row, level, value) = self.first[k as usize];
            if self.places.last() != Some(&(column, row)) {
                self.places.push((column, row));
                for values in &mut self.values {
                    values.push(0.0);
                }
            }
            let at = self.places.len() - 1;
            self.values[level as usize][at] += value;
            self.slots[k as usize] = (at as u32, level);
        }
        let by_rate = self.slots.iter().filter(|slot| slot.1 > 0);
        self.rates = by_rate.map(|slot| slot.0).collect();
        self.rates.sort_unstable();
        self.rates.dedup();
        self.first = Vec::new();
        self.known = true;
        self.next = self.slots.len();
    }

    /// At which levels each entry stands, whatever its value, in the order of [`Self::entries`].
    pub(crate) fn standing(&self) -> Vec<[bool; 3]> {
        let mut out = vec![[false; 3]; self.places.len()];
        for &(at, level) in &self.slots {
            out[at as usize][level as usize] = true;
        }
        out
    }

    /// Fills `values` with the sum of the levels, weighted by row and column, and gives it as a matrix.
    pub(crate) fn combined<'a, T: Scalar>(
        &'a self,
        values: &'a mut Vec<T>,
        weights: impl Fn(usize, usize) -> [T; 3],
    ) -> Entries<'a, T> {
        values.clear();
        for (at, &(column, row)) in self.places.iter().enumerate() {
            let [k, c, m] = weights(row as usize, column as usize);
            values.push(
                k * T::of(self.values[0][at])
                    + c * T::of(self.values[1][at])
                    + m * T::of(self.values[2][at]),
            );
        }
        Entries {
            n: self.n,
            places: &self.places,
            values,
        }
    }

    /// (row, column, [by the unknown, by its rate, by its second rate]) of every entry, by columns.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (usize, usize, [f64; 3])> + '_ {
        let [k, c, m] = &self.values;
        self.places
            .iter()
            .enumerate()
            .map(move |(at, &(column, row))| (row as usize, column as usize, [k[at], c[at], m[at]]))
    }

    /// (row, column, [by the rate, by the second rate]) of the entries that stand at one of them, by columns.
    pub(crate) fn rates(&self) -> impl Iterator<Item = (usize, usize, [f64; 2])> + '_ {
        let [_, c, m] = &self.values;
        self.rates.iter().map(move |&at| {
            let at = at as usize;
            let (column, row) = self.places[at];
            (row as usize, column as usize, [c[at], m[at]])
        })
    }
}
