use super::Sink;
use super::additions::by_columns;
use super::entries::Entries;
use super::occupied::Occupied;
use super::scalar::Scalar;

/// Sparse matrix of three levels with a common pattern: derivatives with respect to the unknowns, to their first rates and to their second
/// rates. A separate column contains the derivatives with respect to time.
///
/// Column c of an added value stands for unknown c % n at level c / n; level 3 is time. Values must be added in the same order in every
/// assembly.
#[derive(Clone, Debug, Default)]
pub(crate) struct Levels {
    n: usize,
    /// (column, row) of every entry, sorted.
    places: Vec<(u32, u32)>,
    /// Indices into `places` of the entries that have a derivative with respect to a first or second rate, in ascending order.
    rates: Vec<u32>,
    /// (column, row) of the entries in `rates`.
    rated: Vec<(u32, u32)>,
    /// For every entry of the pattern, the derivative with respect to the unknown of its column. After all of these, two values follow for
    /// each entry in `rates`: the derivatives with respect to the first and the second rate of that unknown.
    values: Vec<f64>,
    /// Derivative of every row with respect to time.
    pub time: Vec<f64>,
    /// Index in `values` of the derivative to which the k-th added value goes.
    slots: Vec<u32>,
    next: usize,
    /// Values added in the first assembly: column, row, level, value.
    first: Vec<(u32, u32, u8, f64)>,
    known: bool,
    occupied: Occupied,
}

impl Sink for Levels {
    #[inline]
    fn add(&mut self, row: usize, column: usize, value: f64) {
        if column >= 3 * self.n {
            self.time[row] += value;
        } else if self.known {
            self.values[self.slots[self.next] as usize] += value;
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
            for (at, value) in self.slots[self.next..end].iter().zip(values) {
                self.values[*at as usize] += value;
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
    /// Creates a matrix with n rows and columns.
    pub(crate) fn new(n: usize) -> Self {
        Self {
            n,
            time: vec![0.0; n],
            ..Self::default()
        }
    }

    /// Prepares for an assembly: sets all values to zero.
    pub(crate) fn clear(&mut self) {
        self.values.fill(0.0);
        self.time.fill(0.0);
        self.next = 0;
        if !self.known {
            self.first.clear();
        }
    }

    /// Finishes an assembly. The first assembly determines the pattern.
    pub(crate) fn finish(&mut self) {
        if self.known {
            debug_assert_eq!(self.next, self.slots.len(), "same order every time");
            self.occupy();
            return;
        }
        let order = by_columns(self.n, &self.first, |addition| (addition.0, addition.1));
        for &k in &order {
            let (column, row, level, _) = self.first[k as usize];
            if self.places.last() != Some(&(column, row)) {
                self.places.push((column, row));
            }
            let at = self.places.len() as u32 - 1;
            if level > 0 && self.rates.last() != Some(&at) {
                self.rates.push(at);
                self.rated.push((column, row));
            }
        }
        self.values = vec![0.0; self.places.len() + 2 * self.rates.len()];
        self.slots = vec![0; self.first.len()];
        let (mut at, mut rate) = (0, 0);
        for k in order {
            let (column, row, level, value) = self.first[k as usize];
            while self.places[at] != (column, row) {
                at += 1;
            }
            let slot = if level == 0 {
                at
            } else {
                while (self.rates[rate] as usize) < at {
                    rate += 1;
                }
                self.places.len() + 2 * rate + usize::from(level) - 1
            };
            self.values[slot] += value;
            self.slots[k as usize] = slot as u32;
        }
        self.first = Vec::new();
        self.known = true;
        self.next = self.slots.len();
        self.occupy();
    }

    /// Returns, for every entry and level, whether the assembly adds a value there, even if that value is zero. The order is that of
    /// [`Self::entries`].
    pub(crate) fn standing(&self) -> Vec<[bool; 3]> {
        let mut out = vec![[false; 3]; self.places.len()];
        for &slot in &self.slots {
            match (slot as usize).checked_sub(self.places.len()) {
                None => out[slot as usize][0] = true,
                Some(k) => out[self.rates[k / 2] as usize][1 + k % 2] = true,
            }
        }
        out
    }

    /// Writes the weighted sum of the three levels of every entry to `values`; `weights(row, column)` returns the three weights. Returns a view
    /// of the entries that have ever been nonzero.
    pub(crate) fn combined<'a, T: Scalar>(
        &'a self,
        values: &'a mut Vec<T>,
        weights: impl Fn(usize, usize) -> [T; 3],
    ) -> Entries<'a, T> {
        values.clear();
        let mut rates = self.by_rates().peekable();
        values.extend(self.occupied.kept().iter().map(|&at| {
            let at = at as usize;
            let (column, row) = self.places[at];
            let [by_place, by_rate, by_second] = weights(row as usize, column as usize);
            let value = by_place * T::of(self.values[at]);
            while rates.next_if(|rate| rate.0 < at).is_some() {}
            match rates.next_if(|rate| rate.0 == at) {
                Some((_, [c, m])) => value + by_rate * T::of(c) + by_second * T::of(m),
                None => value,
            }
        }));
        self.occupied.entries(self.n, values)
    }

    /// Records the entries that are nonzero for the first time.
    fn occupy(&mut self) {
        let (values, rates) = self.values.split_at(self.places.len());
        self.occupied.begin(values.len());
        for (entry, value) in values.iter().enumerate() {
            if *value != 0.0 {
                self.occupied.mark(entry);
            }
        }
        for (entry, values) in self.rates.iter().zip(rates.chunks_exact(2)) {
            if values != [0.0, 0.0] {
                self.occupied.mark(*entry as usize);
            }
        }
        self.occupied.end(&self.places);
    }

    /// Iterates over all entries, column by column: (row, column, derivatives with respect to [the unknown, its first rate, its second rate]).
    pub(crate) fn entries(&self) -> impl Iterator<Item = (usize, usize, [f64; 3])> + '_ {
        let mut rates = self.by_rates().peekable();
        let places = self.places.iter().zip(&self.values).enumerate();
        places.map(move |(at, (&(column, row), value))| {
            let [c, m] = rates.next_if(|rate| rate.0 == at).unwrap_or_default().1;
            (row as usize, column as usize, [*value, c, m])
        })
    }

    /// Iterates, column by column, over the entries with derivatives with respect to rates: (row, column, derivatives with respect to [the
    /// first rate, the second rate]).
    pub(crate) fn rates(&self) -> impl Iterator<Item = (usize, usize, [f64; 2])> + '_ {
        let rates = self.rated.iter().zip(self.by_rates());
        rates.map(|(&(column, row), (_, values))| (row as usize, column as usize, values))
    }

    /// Iterates over the entries of [`Self::rates`]: index into `places`, and derivatives with respect to [the first rate, the second rate].
    fn by_rates(&self) -> impl Iterator<Item = (usize, [f64; 2])> + '_ {
        let values = self.values[self.places.len()..].chunks_exact(2);
        let rates = self.rates.iter().zip(values);
        rates.map(|(at, values)| (*at as usize, [values[0], values[1]]))
    }
}
