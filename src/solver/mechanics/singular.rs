//! Singular values and vectors of a dense matrix by the method of Golub and Reinsch: reduction to two diagonals by reflections, then QR steps
//! with an implicit shift. The steps and their order are those of LINPACK's `DSVDC` (Dongarra and others, LINPACK Users' Guide, chapter 11).
//!
//! All vectors are products of reflections and rotations. They therefore are orthonormal for any rank of the matrix.

use nalgebra::DMatrix;

use super::columns::{add, columns_mut, dot, rotate};

/// Largest number of QR steps per singular value; two or three are usual.
const STEPS: usize = 100;
/// Magnitude that counts as zero beside no other number, 2^-966.
const TINY: f64 = 1.6033346880071782e-291;

/// Singular values, largest first, with the left and right vectors as columns.
pub(super) struct Singular {
    pub(super) U: DMatrix<f64>,
    pub(super) values: Vec<f64>,
    pub(super) V: DMatrix<f64>,
}

/// Computes the factors of `A = U diag(values) V'` for an m by n matrix with m >= n > 0 and finite entries of magnitude at most one. U is m by
/// n, V is n by n. Returns `None` if the iteration does not converge.
pub(super) fn singular(A: DMatrix<f64>) -> Option<Singular> {
    let mut two = bidiagonal(A);
    two.iterate()?;
    let n = two.s.len();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|a, b| two.s[*b].total_cmp(&two.s[*a]));
    Some(Singular {
        U: two.U.select_columns(&order),
        values: order.iter().map(|k| two.s[*k]).collect(),
        V: two.V.select_columns(&order),
    })
}

/// A matrix `U B V'`, where B has the diagonal `s` and the superdiagonal `e`, whose last entry is zero.
struct Bidiagonal {
    U: DMatrix<f64>,
    s: Vec<f64>,
    e: Vec<f64>,
    V: DMatrix<f64>,
}

/// Turns a vector into that of the reflection which maps it onto the first axis, scaled such that its first entry is one plus a cosine. Returns
/// the first entry of the reflected vector; zero for the vector zero, which stays.
fn reflection(vector: &mut [f64]) -> f64 {
    let norm = dot(vector, vector).sqrt();
    if norm == 0.0 {
        return 0.0;
    }
    let signed = if vector[0] < 0.0 { -norm } else { norm };
    for value in &mut *vector {
        *value /= signed;
    }
    vector[0] += 1.0;
    -signed
}

/// Reflects a vector by a vector of [`reflection`].
fn reflect(by: &[f64], vector: &mut [f64]) {
    add(-dot(by, vector) / by[0], by, vector);
}

/// Reduces an m by n matrix with m >= n to two diagonals.
fn bidiagonal(mut A: DMatrix<f64>) -> Bidiagonal {
    let (m, n) = A.shape();
    let (mut s, mut e) = (vec![0.0; n], vec![0.0; n]);
    let mut V = DMatrix::<f64>::identity(n, n);
    let mut sums = vec![0.0; m];
    // A square matrix needs no reflection of its last column, which has one entry left.
    let by_columns = n.min(m - 1);
    for k in 0..n {
        if k < by_columns {
            s[k] = reflection(&mut A.as_mut_slice()[k * m + k..(k + 1) * m]);
            if s[k] != 0.0 {
                for j in k + 1..n {
                    let (by, column) = columns_mut(&mut A, k, j);
                    reflect(&by[k..], &mut column[k..]);
                }
            }
        } else {
            s[k] = A[(k, k)];
        }
        if k + 2 >= n {
            if k + 1 < n {
                e[k] = A[(k, k + 1)];
            }
            continue;
        }
        let row = &mut V.as_mut_slice()[k * n + k + 1..(k + 1) * n];
        for (j, value) in row.iter_mut().enumerate() {
            *value = A[(k, k + 1 + j)];
        }
        e[k] = reflection(row);
        if e[k] == 0.0 {
            continue;
        }
        let sums = &mut sums[k + 1..];
        sums.fill(0.0);
        for (j, factor) in row.iter().enumerate() {
            let first = (k + 1 + j) * m;
            add(*factor, &A.as_slice()[first + k + 1..first + m], sums);
        }
        for (j, factor) in row.iter().enumerate() {
            let first = (k + 1 + j) * m;
            let column = &mut A.as_mut_slice()[first + k + 1..first + m];
            add(-factor / row[0], sums, column);
        }
    }
    let U = product_of_reflections(&A, 0, &s[..by_columns]);
    let V = product_of_reflections(&V, 1, &e[..n.saturating_sub(2)]);
    Bidiagonal { U, s, e, V }
}

/// Multiplies reflections. The vector of reflection k is column k of `by`, from row k + `shift` on. A reflection with a zero in `images` is left
/// out. Returns the first columns of the product.
fn product_of_reflections(by: &DMatrix<f64>, shift: usize, images: &[f64]) -> DMatrix<f64> {
    let (m, n) = by.shape();
    let mut out = DMatrix::<f64>::identity(m, n);
    for (k, image) in images.iter().enumerate().rev() {
        if *image == 0.0 {
            continue;
        }
        let by = &by.as_slice()[k * m + k + shift..(k + 1) * m];
        for j in k + shift..n {
            reflect(by, &mut out.as_mut_slice()[j * m + k + shift..(j + 1) * m]);
        }
    }
    out
}

impl Bidiagonal {
    /// Reduces the superdiagonal to zero and makes the diagonal positive. Returns `None` if that takes too many steps.
    fn iterate(&mut self) -> Option<()> {
        let mut steps = 0;
        // Number of values that are not found yet.
        let mut p = self.s.len();
        while p > 0 {
            // Index of the first value of the last block whose superdiagonal has no zero.
            let mut first = p - 1;
            while first > 0 && !self.splits(first - 1) {
                first -= 1;
            }
            if first + 1 == p {
                self.make_positive(p - 1);
                (p, steps) = (p - 1, 0);
                continue;
            }
            let zero = (first..p).rev().find(|k| self.vanishes(*k, first, p));
            match zero {
                Some(k) if k + 1 == p => self.remove_last(first, p),
                Some(k) => self.remove(k, p),
                None if steps == STEPS => return None,
                None => {
                    steps += 1;
                    self.step(first, p);
                }
            }
        }
        Some(())
    }

    /// Returns whether entry k of the superdiagonal is negligible, and then sets it to zero.
    fn splits(&mut self, k: usize) -> bool {
        let beside = self.s[k].abs() + self.s[k + 1].abs();
        let negligible = self.e[k].abs() <= TINY + f64::EPSILON * beside;
        if negligible {
            self.e[k] = 0.0;
        }
        negligible
    }

    /// Returns whether entry k of the diagonal is negligible in the block from `first` to `p`, and then sets it to zero.
    fn vanishes(&mut self, k: usize, first: usize, p: usize) -> bool {
        let after = if k + 1 < p { self.e[k].abs() } else { 0.0 };
        let before = if k > first { self.e[k - 1].abs() } else { 0.0 };
        let negligible = self.s[k].abs() <= TINY + f64::EPSILON * (before + after);
        if negligible {
            self.s[k] = 0.0;
        }
        negligible
    }

    fn make_positive(&mut self, k: usize) {
        if self.s[k] < 0.0 {
            self.s[k] = -self.s[k];
            self.V.column_mut(k).neg_mut();
        }
    }

    /// Removes the superdiagonal entry above the last value of a block, which is zero.
    fn remove_last(&mut self, first: usize, p: usize) {
        let mut f = std::mem::take(&mut self.e[p - 2]);
        for j in (first..p - 1).rev() {
            let (length, c, s) = rotation(self.s[j], f);
            self.s[j] = length;
            if j > first {
                f = -s * self.e[j - 1];
                self.e[j - 1] *= c;
            }
            rotate(&mut self.V, j, p - 1, c, s);
        }
    }

    /// Removes the superdiagonal entry beside value k, which is zero.
    fn remove(&mut self, k: usize, p: usize) {
        let mut f = std::mem::take(&mut self.e[k]);
        for j in k + 1..p {
            let (length, c, s) = rotation(self.s[j], f);
            self.s[j] = length;
            f = -s * self.e[j];
            self.e[j] *= c;
            rotate(&mut self.U, j, k, c, s);
        }
    }

    /// One QR step with a shift, on the values from `first` to `p`.
    fn step(&mut self, first: usize, p: usize) {
        let (mut f, mut g) = self.shifted(first, p);
        for j in first..p - 1 {
            let (length, c, s) = rotation(f, g);
            if j > first {
                self.e[j - 1] = length;
            }
            f = c * self.s[j] + s * self.e[j];
            self.e[j] = c * self.e[j] - s * self.s[j];
            g = s * self.s[j + 1];
            self.s[j + 1] *= c;
            rotate(&mut self.V, j, j + 1, c, s);
            let (length, c, s) = rotation(f, g);
            self.s[j] = length;
            f = c * self.e[j] + s * self.s[j + 1];
            self.s[j + 1] = c * self.s[j + 1] - s * self.e[j];
            g = s * self.e[j + 1];
            self.e[j + 1] *= c;
            rotate(&mut self.U, j, j + 1, c, s);
        }
        self.e[p - 2] = f;
    }

    /// Returns the first two entries of the first row of `B'B`, less the shift, divided by a common factor.
    fn shifted(&self, first: usize, p: usize) -> (f64, f64) {
        let (s, e) = (&self.s, &self.e);
        let all = [s[p - 1], s[p - 2], e[p - 2], s[first], e[first]];
        let scale = all.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let [last, before, above, s0, e0] = all.map(|value| value / scale);
        let b = f64::midpoint((before + last) * (before - last), above * above);
        let c = (last * above) * (last * above);
        let shift = if b == 0.0 && c == 0.0 {
            0.0
        } else {
            let root = (b * b + c).sqrt();
            c / (b + if b < 0.0 { -root } else { root })
        };
        ((s0 + last) * (s0 - last) + shift, s0 * e0)
    }
}

/// Returns length, cosine and sine of the rotation that turns (f, g) onto the first axis.
fn rotation(f: f64, g: f64) -> (f64, f64, f64) {
    let length = libm::hypot(f, g);
    if length == 0.0 {
        (0.0, 1.0, 0.0)
    } else {
        (length, f / length, g / length)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn check(A: &DMatrix<f64>) {
        let n = A.ncols();
        let found = singular(A.clone()).unwrap();
        let values = DMatrix::from_diagonal(&found.values.clone().into());
        let bar = 1e-14 * (n as f64 + 1.0);
        let back = &found.U * values * found.V.transpose();
        assert!((back - A).amax() < bar, "{A}");
        for vectors in [&found.U, &found.V] {
            let off = vectors.tr_mul(vectors) - DMatrix::identity(n, n);
            assert!(off.amax() < bar, "{off}");
        }
        assert!(found.values.windows(2).all(|pair| pair[0] >= pair[1]));
        assert!(found.values.iter().all(|value| *value >= 0.0));
    }

    proptest! {
        /// Matrices of any rank, with entries of equal magnitude, with zeros and with entries that differ by many decades.
        #[test]
        fn factors_give_the_matrix_back(
            n in 1_usize..9,
            extra in 0_usize..4,
            entries in prop::collection::vec(
                prop_oneof![Just(0.0), Just(1.0), -1.0..1.0, -1e-12..1e-12, -1e-200..1e-200],
                96,
            ),
        ) {
            check(&DMatrix::from_fn(n + extra, n, |i, j| entries[i * n + j]));
        }
    }

    /// The second difference matrix of n points has the singular values `4 sin²(k π / (2 n + 2))`.
    #[test]
    fn second_differences_have_the_known_values() {
        let n = 40;
        let A = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
            0 => 0.5,
            1 => -0.25,
            _ => 0.0,
        });
        let found = singular(A).unwrap();
        for (k, value) in found.values.iter().enumerate() {
            let half = (n - k) as f64 * std::f64::consts::FRAC_PI_2 / (n as f64 + 1.0);
            let expected = libm::pow(libm::sin(half), 2.0);
            assert!((value - expected).abs() < 1e-14, "{value} {expected}");
        }
    }

    #[test]
    fn repeated_and_vanishing_values_are_no_obstacle() {
        check(&DMatrix::zeros(4, 3));
        check(&DMatrix::identity(5, 5));
        check(&DMatrix::from_element(6, 6, 1.0));
        let wave = |i: usize, j: usize| libm::sin((i * 7 + j * j * 3) as f64);
        let A = DMatrix::from_fn(60, 20, wave);
        check(&(&A * A.transpose() / 60.0));
        check(&A);
    }
}
