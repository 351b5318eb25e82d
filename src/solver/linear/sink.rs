/// Receives the entries of a matrix. Entries of one place add up.
pub trait Sink {
    /// False if nobody wants the entries: they need not be worked out.
    const WANTED: bool = true;

    /// False if nobody wants the rows of the constraints either.
    const ROWS: bool = Self::WANTED;

    /// Adds to one entry.
    fn add(&mut self, row: usize, column: usize, value: f64);

    /// Adds to entries below each other, from a row on.
    fn add_column(&mut self, row: usize, column: usize, values: &[f64]) {
        for (k, value) in values.iter().enumerate() {
            self.add(row + k, column, *value);
        }
    }

    /// Adds what a multiplier does to the balances from `first` on, and the row of its equation, which is the opposite.
    fn add_reaction(&mut self, multiplier: usize, first: usize, column: &[f64]) {
        for (k, value) in column.iter().enumerate() {
            self.add(multiplier, first + k, -value);
            self.add(first + k, multiplier, *value);
        }
    }
}

/// No matrix is wanted.
pub(crate) struct NoMatrix;

impl Sink for NoMatrix {
    const WANTED: bool = false;
    fn add(&mut self, _: usize, _: usize, _: f64) {}
}
