use super::Sink;
use super::additions::by_columns;
use super::entries::Entries;
use super::occupied::Occupied;

/// Sparse matrix to which values are added in the same order in every assembly, so that the position of each value is looked up only once.
#[derive(Clone, Debug, Default)]
pub(crate) struct Matrix {
    n: usize,
    /// (column, row) of every entry, sorted.
    places: Vec<(u32, u32)>,
    values: Vec<f64>,
    /// Index of the entry to which the k-th added value goes.
    slots: Vec<u32>,
    next: usize,
    /// Values added in the first assembly: column, row, value.
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
    /// Creates a matrix with n rows and columns.
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

    /// Prepares for an assembly: sets all values to zero.
    pub(crate) fn clear(&mut self) {
        self.values.fill(0.0);
        self.next = 0;
    }

    /// Finishes an assembly. The first assembly determines the pattern.
    pub(crate) fn finish(&mut self) {
        if self.known {
            debug_assert_eq!(self.next, self.slots.len(), "same order every time");
            return;
        }
        let order = by_columns(self.n, &self.first, |addition| (addition.0, addition.1));
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

    /// Adds a value to an entry after the assembly. A value outside the pattern is ignored.
    pub(crate) fn add_later(&mut self, row: usize, column: usize, value: f64) {
        if let Ok(at) = self.places.binary_search(&(column as u32, row as u32)) {
            self.values[at] += value;
        }
    }

    /// Iterates over (row, column, value) of every entry, column by column.
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

    /// Returns a view of the entries that have ever been nonzero. `occupied` keeps the record of these entries, and `values` receives their
    /// values.
    pub(crate) fn occupied<'a>(
        &self,
        occupied: &'a mut Occupied,
        values: &'a mut Vec<f64>,
    ) -> Entries<'a, f64> {
        occupied.begin(self.places.len());
        for (entry, value) in self.values.iter().enumerate() {
            if *value != 0.0 {
                occupied.mark(entry);
            }
        }
        occupied.end(&self.places);
        values.clear();
        values.extend(occupied.kept().iter().map(|k| self.values[*k as usize]));
        occupied.entries(self.n, values)
    }

    /// Returns a view of all entries of the pattern.
    pub(crate) fn view(&self) -> Entries<'_, f64> {
        Entries::whole(self.n, &self.places, &self.values)
    }
}
