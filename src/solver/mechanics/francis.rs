//! Eigenvalues of a dense matrix by the double-shift QR iteration of Francis, with the exceptional shifts of EISPACK's `HQR` (Martin, Peters and
//! Wilkinson, Handbook for Automatic Computation, volume II, contribution II/14).

use nalgebra::{Complex, DMatrix};

/// Largest number of QR steps per eigenvalue; two or three are usual.
const STEPS: usize = 100;
/// Number of QR steps after which an exceptional shift is taken.
const STALLED: usize = 10;

/// Shifts of a QR step: sum and product of two numbers, as two diagonal entries and the product of the entries beside them.
struct Shifts {
    last: f64,
    before: f64,
    product: f64,
}

/// Returns the eigenvalues of a Hessenberg matrix, whose entries below the first subdiagonal are zero. Returns `None` if the iteration does not
/// converge.
pub(super) fn eigenvalues(mut H: DMatrix<f64>) -> Option<Vec<Complex<f64>>> {
    let norm: f64 = H.iter().map(|value| value.abs()).sum();
    let mut found = Vec::with_capacity(H.nrows());
    // Sum of the exceptional shifts, which were subtracted from the diagonal.
    let mut subtracted = 0.0;
    let mut steps = 0;
    // Number of eigenvalues that are not found yet.
    let mut left = H.nrows();
    while left > 0 {
        let last = left - 1;
        let first = start_of_block(&H, last, norm);
        if first == last {
            found.push(Complex::new(H[(last, last)] + subtracted, 0.0));
            (left, steps) = (left - 1, 0);
            continue;
        }
        let mut shifts = Shifts {
            last: H[(last, last)],
            before: H[(last - 1, last - 1)],
            product: H[(last, last - 1)] * H[(last - 1, last)],
        };
        if first + 1 == last {
            found.extend(shifts.roots().map(|value| value + subtracted));
            (left, steps) = (left - 2, 0);
            continue;
        }
        if steps == STEPS {
            return None;
        }
        if steps % STALLED == STALLED - 1 {
            subtracted += shifts.last;
            for k in 0..left {
                H[(k, k)] -= shifts.last;
            }
            let size = H[(last, last - 1)].abs() + H[(last - 1, last - 2)].abs();
            shifts = Shifts {
                last: 0.75 * size,
                before: 0.75 * size,
                product: -0.4375 * size * size,
            };
        }
        steps += 1;
        step(&mut H, first, last, &shifts);
    }
    Some(found)
}

impl Shifts {
    /// Returns the eigenvalues of the matrix of two rows.
    fn roots(&self) -> [Complex<f64>; 2] {
        let half = 0.5 * (self.before - self.last);
        let square = half * half + self.product;
        let root = square.abs().sqrt();
        if square < 0.0 {
            let real = self.last + half;
            return [Complex::new(real, root), Complex::new(real, -root)];
        }
        let far = half + if half < 0.0 { -root } else { root };
        let near = if far == 0.0 { 0.0 } else { self.product / far };
        [
            Complex::new(self.last + far, 0.0),
            Complex::new(self.last - near, 0.0),
        ]
    }
}

/// Returns the first row of the block that ends at `last` and has no negligible entry on its subdiagonal. The negligible entry before the block
/// is set to zero.
fn start_of_block(H: &DMatrix<f64>, last: usize, norm: f64) -> usize {
    let negligible = |k: &usize| {
        let beside = H[(*k, *k)].abs() + H[(k - 1, k - 1)].abs();
        let size = if beside == 0.0 { norm } else { beside };
        H[(*k, k - 1)].abs() <= f64::EPSILON * size
    };
    (1..=last).rev().find(negligible).unwrap_or(0)
}

/// One double step on the rows and columns from `first` to `last`, at least three. Entries outside of the block are not needed any more.
fn step(H: &mut DMatrix<f64>, first: usize, last: usize, shifts: &Shifts) {
    // Starts below two successive small entries of the subdiagonal, if there are any.
    let mut start = last - 2;
    let mut along = loop {
        let m = start;
        let z = H[(m, m)];
        let (r, s) = (shifts.last - z, shifts.before - z);
        let p = (r * s - shifts.product) / H[(m + 1, m)] + H[(m, m + 1)];
        let q = H[(m + 1, m + 1)] - z - r - s;
        let r = H[(m + 2, m + 1)];
        let size = p.abs() + q.abs() + r.abs();
        let along = [p / size, q / size, r / size];
        if m == first {
            break along;
        }
        let above = H[(m, m - 1)].abs() * (along[1].abs() + along[2].abs());
        let beside = H[(m - 1, m - 1)].abs() + z.abs() + H[(m + 1, m + 1)].abs();
        if above <= f64::EPSILON * along[0].abs() * beside {
            break along;
        }
        start -= 1;
    };
    for k in start..last {
        let three = k + 1 < last;
        if k > start {
            let below = |row: usize| H[(row, k - 1)];
            along = [
                below(k),
                below(k + 1),
                if three { below(k + 2) } else { 0.0 },
            ];
        }
        let size: f64 = along.iter().map(|value| value.abs()).sum();
        if size == 0.0 {
            continue;
        }
        let [p, q, r] = along.map(|value| value / size);
        let length = (p * p + q * q + r * r).sqrt();
        let s = if p < 0.0 { -length } else { length };
        if k > start {
            H[(k, k - 1)] = -s * size;
            H[(k + 1, k - 1)] = 0.0;
            if three {
                H[(k + 2, k - 1)] = 0.0;
            }
        } else if k > first {
            H[(k, k - 1)] = -H[(k, k - 1)];
        }
        // The reflection is I - [x y z]' [1 q r].
        let [x, y, z] = [p + s, q, r].map(|value| value / s);
        let (q, r) = (q / (p + s), r / (p + s));
        let rows = H.nrows();
        let values = H.as_mut_slice();
        if three {
            for column in k..=last {
                let of = &mut values[column * rows + k..][..3];
                let sum = of[0] + q * of[1] + r * of[2];
                of[0] -= sum * x;
                of[1] -= sum * y;
                of[2] -= sum * z;
            }
            let (a, after) = values[k * rows..].split_at_mut(rows);
            let (b, c) = after.split_at_mut(rows);
            for row in first..=last.min(k + 3) {
                let sum = x * a[row] + y * b[row] + z * c[row];
                a[row] -= sum;
                b[row] -= sum * q;
                c[row] -= sum * r;
            }
        } else {
            for column in k..=last {
                let of = &mut values[column * rows + k..][..2];
                let sum = of[0] + q * of[1];
                of[0] -= sum * x;
                of[1] -= sum * y;
            }
            let (a, b) = values[k * rows..].split_at_mut(rows);
            for row in first..=last {
                let sum = x * a[row] + y * b[row];
                a[row] -= sum;
                b[row] -= sum * q;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Hessenberg;
    use proptest::prelude::*;

    fn sorted(A: DMatrix<f64>) -> Vec<Complex<f64>> {
        let mut found = eigenvalues(Hessenberg::new(A).unpack_h()).unwrap();
        found.sort_by(|a, b| a.re.total_cmp(&b.re).then(a.im.total_cmp(&b.im)));
        found
    }

    /// A permutation of n numbers in a circle has the n roots of one; its iteration ends only by exceptional shifts.
    #[test]
    fn a_circle_of_permutations_has_the_roots_of_one() {
        for n in [3, 4, 5, 12, 33] {
            let A = DMatrix::from_fn(n, n, |i, j| f64::from(u8::from(i == (j + 1) % n)));
            for value in sorted(A) {
                let turns = value.arg() * n as f64 / std::f64::consts::TAU;
                assert!((value.norm() - 1.0).abs() < 1e-13, "{value}");
                assert!((turns - turns.round()).abs() < 1e-12, "{value}");
            }
        }
    }

    /// A block (a b; -b a) has the eigenvalues a ± b i. A similarity with a reflection fills the matrix.
    #[test]
    fn a_similar_matrix_has_the_eigenvalues_of_its_blocks() {
        let n = 20;
        let mut blocks = DMatrix::zeros(n, n);
        for k in (0..n).step_by(2) {
            let (a, b) = (k as f64 - 7.0, 0.25 * k as f64);
            blocks[(k, k)] = a;
            blocks[(k + 1, k + 1)] = a;
            blocks[(k, k + 1)] = b;
            blocks[(k + 1, k)] = -b;
            if k + 2 < n {
                blocks[(k, k + 3)] = 0.5;
            }
        }
        let v = nalgebra::DVector::from_fn(n, |k, _| libm::sin(k as f64 + 1.0));
        let reflect = DMatrix::identity(n, n) - 2.0 / v.norm_squared() * &v * v.transpose();
        let found = sorted(&reflect * blocks * &reflect);
        for (k, pair) in found.chunks(2).enumerate() {
            let (a, b) = (2.0 * k as f64 - 7.0, 0.5 * k as f64);
            for (value, sign) in pair.iter().zip([-1.0, 1.0]) {
                let off = value - Complex::new(a, sign * b);
                assert!(off.norm() < 1e-11, "{value} {a} {b}");
            }
        }
    }

    proptest! {
        /// The sum of the eigenvalues is the trace, and the sum of their squares is that of the squared matrix.
        #[test]
        fn powers_have_the_trace_of_the_matrix(
            n in 1_usize..9,
            entries in prop::collection::vec(
                prop_oneof![Just(0.0), Just(1.0), -1.0..1.0, -1e-12..1e-12],
                64,
            ),
        ) {
            let A = DMatrix::from_fn(n, n, |i, j| entries[i * n + j]);
            let found = sorted(A.clone());
            prop_assert_eq!(found.len(), n);
            let sum: Complex<f64> = found.iter().sum();
            let squares: Complex<f64> = found.iter().map(|value| value * value).sum();
            prop_assert!((sum - A.trace()).norm() < 1e-12);
            prop_assert!((squares - (&A * &A).trace()).norm() < 1e-11);
        }
    }
}
