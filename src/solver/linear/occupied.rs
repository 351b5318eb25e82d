//! Record of the entries of a matrix that have ever been nonzero.
//!
//! A pattern contains every entry that may be nonzero. In a mechanism, three quarters of these entries stay zero. Without them, the factors
//! have only a fraction of the entries. An entry that becomes nonzero joins the record at the next factorisation, which then chooses a new
//! order.

use std::hash::{DefaultHasher, Hash, Hasher};

use super::entries::Entries;
use super::scalar::Scalar;

/// Number of times that only the newly nonzero entries join the record. The next time, the whole pattern joins.
const GROWTHS: usize = 5;

/// Record of the entries of a pattern that have ever been nonzero. No entry is ever removed from it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Occupied {
    marks: Vec<bool>,
    /// Indices of the recorded entries in the pattern.
    kept: Vec<u32>,
    /// (column, row) of the recorded entries.
    places: Vec<(u32, u32)>,
    fingerprint: u64,
    growths: usize,
    grown: bool,
}

impl Occupied {
    /// Prepares for marking the entries of a pattern of the given size.
    pub(super) fn begin(&mut self, entries: usize) {
        self.marks.resize(entries, false);
    }

    /// Marks an entry as nonzero.
    #[inline]
    pub(super) fn mark(&mut self, entry: usize) {
        if !self.marks[entry] {
            self.marks[entry] = true;
            self.grown = true;
        }
    }

    /// Finishes the marking and updates the record. `places` contains (column, row) of every entry of the pattern.
    pub(super) fn end(&mut self, places: &[(u32, u32)]) {
        if !std::mem::take(&mut self.grown) {
            return;
        }
        self.growths += 1;
        if self.growths > GROWTHS {
            self.marks.fill(true);
        }
        let all = 0..places.len();
        self.kept = all.filter(|k| self.marks[*k]).map(|k| k as u32).collect();
        self.places = self.kept.iter().map(|k| places[*k as usize]).collect();
        let mut hasher = DefaultHasher::new();
        self.kept.hash(&mut hasher);
        self.fingerprint = hasher.finish();
    }

    /// Returns the indices of the recorded entries in the pattern, in ascending order.
    pub(super) fn kept(&self) -> &[u32] {
        &self.kept
    }

    /// Returns a view of the recorded entries, with the given values, as a matrix with n rows and columns.
    pub(super) fn entries<'a, T: Scalar>(&'a self, n: usize, values: &'a [T]) -> Entries<'a, T> {
        Entries {
            n,
            places: &self.places,
            values,
            fingerprint: self.fingerprint,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Occupied;
    use crate::linear::{Lu, Matrix, Sink};

    /// Returns the stiffness matrix of a row of springs on slides. The three directions of a slide are uncoupled unless the slide leans. `lean`
    /// is the index of the leaning slide.
    fn springs(count: usize, lean: Option<usize>) -> Matrix {
        let mut matrix = Matrix::new(3 * count);
        for k in 0..count {
            for a in 0..3 {
                for b in 0..3 {
                    let across = if lean == Some(k) { 0.5 } else { 0.0 };
                    let own = if a == b { 4.0 } else { across };
                    matrix.add(3 * k + a, 3 * k + b, own);
                    if k > 0 {
                        let next = if a == b { -1.0 } else { across };
                        matrix.add(3 * k + a, 3 * k - 3 + b, next);
                        matrix.add(3 * k - 3 + a, 3 * k + b, next);
                    }
                }
            }
        }
        matrix.finish();
        matrix
    }

    #[track_caller]
    fn solves(lu: &mut Lu, matrix: &Matrix) {
        let right = |k: usize| libm::sin(1.0 + k as f64);
        let mut x: Vec<f64> = (0..matrix.size()).map(right).collect();
        lu.solve(&mut x);
        let mut left: Vec<f64> = (0..matrix.size()).map(right).collect();
        for (row, column, value) in matrix.entries() {
            left[row] -= value * x[column];
        }
        assert!(left.iter().all(|left| left.abs() < 1e-13), "{left:?}");
    }

    /// Entries that are zero are omitted from the factors. The entries of a leaning slide join the record, and they remain in it when the slide
    /// stands straight again.
    #[test]
    fn zeros_join_when_they_are_none_any_more() {
        let count = 40;
        let (mut occupied, mut values) = (Occupied::default(), Vec::new());
        let (mut lu, mut whole) = (Lu::for_many(3 * count), Lu::for_many(3 * count));
        whole.factor(&springs(count, None));
        let mut places = Vec::new();
        for lean in [None, Some(7), None, Some(7), Some(30)] {
            let matrix = springs(count, lean);
            lu.factor_entries(&matrix.occupied(&mut occupied, &mut values));
            solves(&mut lu, &matrix);
            places.push(lu.places());
        }
        assert!(3 * places[0] <= whole.places() + count, "{places:?}");
        assert!(places[0] < places[1] && places[1] < places[4], "{places:?}");
        assert_eq!((places[1], places[1]), (places[2], places[3]));
        assert_eq!(lu.orders, 3);
    }

    /// If new entries become nonzero again and again, the whole pattern joins the record in the end, and the order no longer changes.
    #[test]
    fn places_that_join_one_by_one_do_not_choose_for_ever() {
        let count = 40;
        let (mut occupied, mut values) = (Occupied::default(), Vec::new());
        let mut lu = Lu::for_many(3 * count);
        for k in 0..count {
            let matrix = springs(count, Some(k));
            lu.factor_entries(&matrix.occupied(&mut occupied, &mut values));
            solves(&mut lu, &matrix);
        }
        assert_eq!(lu.orders, super::GROWTHS + 1);
    }

    /// Factors with a copied elimination order choose a new order if their matrix has different entries, even if the number of entries is the
    /// same.
    #[test]
    fn other_places_are_told_apart() {
        let count = 40;
        let mut values = Vec::new();
        let mut one = Lu::for_many(3 * count);
        let first = springs(count, Some(7));
        one.factor_entries(&first.occupied(&mut Occupied::default(), &mut values));
        let mut other = Lu::for_many(3 * count);
        other.follow(&one);
        let second = springs(count, Some(8));
        other.factor_entries(&second.occupied(&mut Occupied::default(), &mut values));
        solves(&mut other, &second);
    }
}
