//! Eigenvalues of the reduced tangent stiffness close to a shift, by Arnoldi's method with factors of the shifted equations.

use nalgebra::DMatrix;

use crate::linear::{Lu, Matrix, Sink};
use crate::mechanics::eigen::eigenvalues;
use crate::system::{NoValue, Parameters, Scratch, State, System};

/// Dimension of the Krylov space. Successive shifts have the ratio [`CLOSER`]. An eigenvalue between two shifts therefore dominates the
/// inverted operator by about this ratio, and a space of this dimension finds it.
const DIMENSION: usize = 30;
/// Ratio of each shift to the previous shift.
const CLOSER: f64 = 1e-2;
/// Number of shifts. The last shift reaches the round-off of the largest stiffness.
const SHIFTS: i32 = 7;
/// Eigenvalues of the inverted operator below this share of the largest have not converged and are ignored.
const SETTLED: f64 = 1e-3;

/// The factored matrix `[S - shift W, G'; G, 0]`. S is the stiffness, G the constraint gradients, and W contains the squares of the length
/// factors of the unknowns.
pub(super) struct ShiftInvert<'a> {
    system: &'a System,
    parameters: &'a Parameters,
    state: &'a State,
    lengths: Vec<f64>,
    matrix: Matrix,
    factors: Lu,
    scratch: Scratch,
    g: Vec<f64>,
}

impl<'a> ShiftInvert<'a> {
    pub(crate) fn new(
        system: &'a System,
        parameters: &'a Parameters,
        state: &'a State,
        lengths: Vec<f64>,
    ) -> Self {
        let n = system.unknowns();
        Self {
            system,
            parameters,
            state,
            lengths,
            matrix: Matrix::new(n),
            factors: Lu::new(n),
            scratch: Scratch::new(system),
            g: vec![0.0; n],
        }
    }

    /// Returns the smallest eigenvalue and its eigenvector, a motion whose rotations are multiplied by the model's length. Returns `None` if no
    /// part can move. `bound` is an upper bound of all eigenvalues.
    ///
    /// The shifts are negative, and their magnitude decreases from about `bound` towards zero. Every shift is thus below all eigenvalues that
    /// are not negative. An eigenvalue below the shift gives a negative eigenvalue of the inverted operator.
    pub(crate) fn smallest(mut self, bound: f64) -> Result<Option<(f64, Vec<f64>)>, NoValue> {
        let bound = if bound > 0.0 { bound } else { 1.0 };
        let mut estimate = f64::INFINITY;
        for k in 0..SHIFTS {
            let shift = -1.1 * bound * CLOSER.powi(k);
            let Some(least) = self.least_beside(shift, bound)? else {
                return Ok(None);
            };
            let steady = (least - estimate).abs() < 1e-2 * least;
            estimate = least;
            if least < 0.0 || (steady && -shift < least) {
                break;
            }
        }
        for _ in 0..8 {
            let shift = estimate - 0.1 * estimate.abs();
            if shift.abs() < f64::EPSILON * bound {
                break;
            }
            let Some(least) = self.least_beside(shift, bound)? else {
                break;
            };
            let change = (least - estimate).abs();
            estimate = least;
            if change < 1e-9 * estimate.abs() {
                break;
            }
        }
        let motion = self.near(estimate, bound)?;
        Ok(Some((estimate, motion)))
    }

    /// Returns the eigenvector of an eigenvalue by inverse iteration.
    fn near(&mut self, value: f64, bound: f64) -> Result<Vec<f64>, NoValue> {
        self.factor(value - 1e-9 * bound)?;
        let mut vector: Vec<f64> = start(self.lengths.len());
        for _ in 0..10 {
            self.apply(&mut vector);
            let length = norm(&vector);
            if length == 0.0 || !length.is_finite() {
                break;
            }
            for x in &mut vector {
                *x /= length;
            }
        }
        Ok(vector)
    }

    /// Returns the smallest of the eigenvalues that have converged for this shift. Returns `None` if no part can move.
    fn least_beside(&mut self, shift: f64, bound: f64) -> Result<Option<f64>, NoValue> {
        self.factor(shift)?;
        let mut vector: Vec<f64> = start(self.lengths.len());
        let before = norm(&vector);
        self.apply(&mut vector);
        // Every motion that the constraints allow contributes at least 1 / (2 bound) times its component in the start vector.
        let after = norm(&vector);
        let moves = after * bound > 1e-9 * before;
        if !moves {
            return Ok(None);
        }
        let Some(inverse) = eigenvalues(self.arnoldi(vector, after)) else {
            return Ok(None);
        };
        let largest = inverse.iter().fold(0.0_f64, |a, b| a.max(b.norm()));
        let values = inverse
            .iter()
            .filter(|value| value.norm() > SETTLED * largest)
            .map(|value| shift + value.re / value.norm_sqr());
        Ok(Some(values.fold(f64::INFINITY, f64::min)))
    }

    fn factor(&mut self, shift: f64) -> Result<(), NoValue> {
        self.matrix.clear();
        let (scratch, g, matrix) = (&mut self.scratch, &mut self.g, &mut self.matrix);
        self.system
            .assemble(self.parameters, self.state, scratch, g, matrix)?;
        // The Jacobian of the forces is the negative stiffness.
        for (k, length) in self.lengths.iter().enumerate() {
            matrix.add(k, k, shift * length * length);
        }
        matrix.finish();
        self.factors.factor(matrix);
        Ok(())
    }

    /// Replaces a motion x by the response of the shifted system to the forces W x. Rotations in `vector` are multiplied by the model's length.
    fn apply(&mut self, vector: &mut [f64]) {
        self.g.fill(0.0);
        for ((g, x), length) in self.g.iter_mut().zip(vector.iter()).zip(&self.lengths) {
            *g = -x * length;
        }
        self.factors.solve(&mut self.g);
        for ((x, g), length) in vector.iter_mut().zip(&self.g).zip(&self.lengths) {
            *x = g * length;
        }
    }

    /// Returns the projection of [`Self::apply`] onto the Krylov space of `vector`, as an upper Hessenberg matrix. `length` is the norm of
    /// `vector`.
    fn arnoldi(&mut self, mut vector: Vec<f64>, mut length: f64) -> DMatrix<f64> {
        let size = DIMENSION.min(self.lengths.len());
        let mut H = DMatrix::zeros(size, size);
        let mut basis: Vec<Vec<f64>> = Vec::with_capacity(size);
        for j in 0..size {
            for x in &mut vector {
                *x /= length;
            }
            basis.push(vector.clone());
            self.apply(&mut vector);
            let whole = norm(&vector);
            // Two passes of orthogonalisation are enough (Kahan).
            for _ in 0..2 {
                for (i, b) in basis.iter().enumerate() {
                    let share: f64 = vector.iter().zip(b).map(|(x, y)| x * y).sum();
                    H[(i, j)] += share;
                    for (x, y) in vector.iter_mut().zip(b) {
                        *x -= share * y;
                    }
                }
            }
            length = norm(&vector);
            if length <= 1e-12 * whole {
                // The Krylov space contains no further directions.
                return H.view((0, 0), (j + 1, j + 1)).clone_owned();
            }
            if j + 1 < size {
                H[(j + 1, j)] = length;
            }
        }
        H
    }
}

/// Returns a reproducible pseudo-random start vector, so that every eigenvector has a component in it.
fn start(n: usize) -> Vec<f64> {
    let mut seed = 0x9E37_79B9_7F4A_7C15_u64;
    let mut next = || {
        seed = seed
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    (0..n).map(|_| next()).collect()
}

fn norm(v: &[f64]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}
