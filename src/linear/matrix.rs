use super::Sink;
use super::entries::Entries;

/// A sparse matrix whose entries arrive in the same order in every assembly: the place of each is looked up once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Matrix {
    n: usize,
    /// (column, row) of every entry, sorted.
    places: Vec<(u32, u32)>,
    values: Vec<f64>,
    /// Entry of the k-th addition.
    slots: Vec<u32>,
    next: usize,
    /// Additions of the first assembly.
    first: Vec<(u32, u32, f64)>,
    known: bool,
}

impl Sink for Matrix {
    #[inline]
    fn add(&mut self, row: usize, column: usize, value: f64) {
        if self.known {
            self.values[self.slots[self.next] as usize] += value;
            self.next += 1;
        } else {
            self.first.push((column as u32, row as u32, value));
        }
    }

    #[inline]
    fn add_column(&mut self, row: usize, column: usize, values: &[f64]) {
        if self.known {
            let end = self.next + values.len();
            for (slot, value) in self.slots[self.next..end].iter().zip(values) {
                self.values[*slot as usize] += value;
            }
            self.next = end;
        } else {
            for (k, value) in values.iter().enumerate() {
                self.add(row + k, column, *value);
            }
        }
    }
}

impl Matrix {
    /// Of n rows and columns.
    pub(crate) fn new(n: usize) -> Self {
        Self {
            n,
            ..Self::default()
        }
    }

    #[cfg(test)]
    pub(crate) fn size(&self) -> usize {
        self.n
    }

    /// Makes ready for an assembly.
    pub(crate) fn clear(&mut self) {
        self.values.fill(0.0);
        self.next = 0;
    }

    /// Ends an assembly.
    pub(crate) fn finish(&mut self) {
        if self.known {
            debug_assert_eq!(self.next, self.slots.len(), "same order every time");
            return;
        }
        let order = self.by_columns();
        self.slots = vec![0; self.first.len()];
        for k in order {
            let (column, row, value) = self.first[k as usize];
            if self.places.last() == Some(&(column, row)) {
                *self.values.last_mut().expect("a value for every place") += value;
            } else {
                self.places.push((column, row));
                self.values.push(value);
            }
            self.slots[k as usize] = self.places.len() as u32 - 1;
        }
        self.first = Vec::new();
        self.known = true;
        self.next = self.slots.len();
    }

    /// The additions in order of columns, then rows: counted into columns, which are short.
    fn by_columns(&self) -> Vec<u32> {
        let mut ends = vec![0_u32; self.n + 1];
        for (column, _, _) in &self.first {
            ends[*column as usize + 1] += 1;
        }
        for k in 0..self.n {
            ends[k + 1] += ends[k];
        }
        let mut next = ends.clone();
        let mut order = vec![0; self.first.len()];
        for (k, (column, _, _)) in self.first.iter().enumerate() {
            let at = &mut next[*column as usize];
            order[*at as usize] = k as u32;
            *at += 1;
        }
        for pair in ends.windows(2) {
            let column = &mut order[pair[0] as usize..pair[1] as usize];
            column.sort_unstable_by_key(|&k| (self.first[k as usize].1, k));
        }
        order
    }

    /// Adds to an entry that is in the pattern, after the assembly.
    pub(crate) fn add_later(&mut self, row: usize, column: usize, value: f64) {
        if let Ok(at) = self.places.binary_search(&(column as u32, row as u32)) {
            self.values[at] += value;
        }
    }

    /// (row, column, value) of every entry, by columns.
    pub(crate) fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        self.places
            .iter()
            .zip(&self.values)
            .map(|(&(column, row), &value)| (row as usize, column as usize, value))
    }

    #[cfg(test)]
    pub(crate) fn values(&self) -> &[f64] {
        &self.values
    }

    /// Its pattern and values.
    pub(crate) fn view(&self) -> Entries<'_, f64> {
        Entries {
            n: self.n,
            places: &self.places,
            values: &self.values,
        }
    }
}
