//! Which places of a matrix have ever held something but zero.
//!
//! A pattern holds what may stand somewhere; of a mechanism three quarters of that are zeros that stay. Factors of the rest have a fraction
//! of the places. What changes from zero joins at the next factorisation, which then chooses its order anew.

use std::hash::{DefaultHasher, Hash, Hasher};

use super::entries::Entries;
use super::scalar::Scalar;

/// So often places may join one by one; then all do.
const GROWTHS: usize = 5;

/// Places of a pattern, of which none is ever left out again.
#[derive(Clone, Debug, Default)]
pub(crate) struct Occupied {
    marks: Vec<bool>,
    /// Entries of the pattern, and (column, row) of these.
    kept: Vec<u32>,
    places: Vec<(u32, u32)>,
    fingerprint: u64,
    growths: usize,
    grown: bool,
}

impl Occupied {
    /// Begins a look at a pattern of so many entries.
    pub(super) fn begin(&mut self, entries: usize) {
        self.marks.resize(entries, false);
    }

    /// Something stands at this entry.
    #[inline]
    pub(super) fn mark(&mut self, entry: usize) {
        if !self.marks[entry] {
            self.marks[entry] = true;
            self.grown = true;
        }
    }

    /// Ends a look; `places` are those of the pattern.
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

    /// The entries of the pattern that are kept, in their order.
    pub(super) fn kept(&self) -> &[u32] {
        &self.kept
    }

    /// A matrix of n rows and columns with these values of what is kept.
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

    /// A row of springs on slides, each with directions across that nothing couples until it leans: `lean` does for one of them.
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

    /// Zeros are left out of the factors; what leans later joins, and none is lost when it stands straight again.
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

    /// Where ever more places join the whole pattern does, and the order stays.
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

    /// Factors that follow others of other places choose an order of their own, be there as many.
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
