/// Receiver of the entries of a matrix. Values added at the same position are summed.
pub trait Sink {
    /// False if the receiver ignores the entries outside the constraint rows, so that they need not be computed.
    const NEEDS_ENTRIES: bool = true;

    /// False if the receiver also ignores the entries in the constraint rows.
    const ROWS: bool = Self::NEEDS_ENTRIES;

    /// Adds `value` to one entry.
    fn add(&mut self, row: usize, column: usize, value: f64);

    /// Adds `values` to consecutive entries of a column, starting at `row`.
    fn add_column(&mut self, row: usize, column: usize, values: &[f64]) {
        for (k, value) in values.iter().enumerate() {
            self.add(row + k, column, *value);
        }
    }

    /// Adds the two blocks of a Lagrange multiplier: `column` in the force balances from row `first` on, and the negative of `column` in the
    /// row of the constraint equation.
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
