/// Receiver of the entries of a matrix. Entries at the same position are added up.
pub trait Sink {
    /// False if the receiver ignores all entries, so that they need not be computed.
    const NEEDS_ENTRIES: bool = true;

    /// False if the receiver also ignores the rows of the constraints.
    const ROWS: bool = Self::NEEDS_ENTRIES;

    /// Adds `value` to one entry.
    fn add(&mut self, row: usize, column: usize, value: f64);

    /// Adds to consecutive entries of a column, starting at `row`.
    fn add_column(&mut self, row: usize, column: usize, values: &[f64]) {
        for (k, value) in values.iter().enumerate() {
            self.add(row + k, column, *value);
        }
    }

    /// Adds the effect of a multiplier on the balances from `first` on, and the row of its equation, which is the negative of that column.
    fn add_reaction(&mut self, multiplier: usize, first: usize, column: &[f64]) {
        for (k, value) in column.iter().enumerate() {
            self.add(multiplier, first + k, -value);
            self.add(first + k, multiplier, *value);
        }
    }
}

/// Receiver that ignores all entries.
pub(crate) struct NoMatrix;

impl Sink for NoMatrix {
    const NEEDS_ENTRIES: bool = false;
    fn add(&mut self, _: usize, _: usize, _: f64) {}
}
