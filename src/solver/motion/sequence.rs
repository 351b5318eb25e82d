//! Newton iteration over the stages of a step one after the other, each with its own derivatives.
//!
//! The matrix A of the method is factored as A = L U, where U has a unit diagonal. S, the inverse of L, replaces B, the inverse of A. Each
//! stage then depends only on the stages before it. The matrix of a stage has the pattern of the static equations, with z = S_ii / h.
//!
//! Errors in constraints vanish after three iterations. Errors of oscillating motions fall by the factor [`RATE`] or faster in each iteration.
//! Near a singular position, a few error components grow; [`AndersonAcceleration`] removes them. (W. Hoffmann, J. J. B. de Swart, Approximating
//! Runge-Kutta matrices by triangular matrices, BIT 37, 1997; P. J. van der Houwen, J. J. B. de Swart, Triangularly implicit iteration methods,
//! SIAM J. Sci. Comput. 18, 1997.)
//!
//! Near a singular position, this iteration still converges, whereas the derivatives of one stage are too inaccurate for all three stages. It
//! costs a fraction of [`super::coupled`].

use super::anderson::AndersonAcceleration;
use super::linearisation::{Correction, Linearisation};
use super::newton::{Step, StepMatrices, Unknowns, turns};
use super::tableau::A;
use crate::linear::Lu;
use crate::mechanics::{Mat3, Vec3};
use crate::system::{NoValue, Parameters, System};

/// Largest error ratio from one iteration to the next for an oscillating motion, reached at the angular frequency 4.8 / h. Errors in
/// constraints are excluded.
pub(super) const RATE: f64 = 0.373;

/// Derivatives of the three stages, and factors of their matrices.
#[derive(Debug)]
pub(super) struct StageSequence {
    /// S, the inverse of L.
    lower: [[f64; 3]; 3],
    linear: [Linearisation; 3],
    factors: [Lu; 3],
    values: Vec<f64>,
    turns: [Vec<Mat3>; 3],
    mixing: AndersonAcceleration,
}

impl StageSequence {
    /// Creates the iteration with the patterns of `equations`. Its factors later adopt the elimination order of `equations`.
    pub(crate) fn new(system: &System, equations: &StepMatrices) -> Self {
        Self {
            lower: inverse_of_lower(&A),
            linear: std::array::from_fn(|_| equations.linear.clone()),
            // `Lu::for_steps` is not used, for the reason given in [`super::coupled`].
            factors: std::array::from_fn(|_| Lu::for_many(system.moving_unknowns)),
            values: Vec::new(),
            turns: Default::default(),
            mixing: AndersonAcceleration::default(),
        }
    }

    /// Evaluates the derivatives of the stages and factors their matrices. `sizes` contains the weights of the unknowns for
    /// [`AndersonAcceleration`].
    pub(crate) fn factor(
        &mut self,
        equations: &mut StepMatrices,
        system: &System,
        parameters: &Parameters,
        step: Step<'_>,
        unknowns: &Unknowns,
        sizes: Unknowns,
    ) -> Result<(), NoValue> {
        let Step { start, h } = step;
        self.mixing.begin(sizes);
        for i in 0..3 {
            equations.place_stage(system, start, h, i, unknowns);
            equations.linearise_stage(system, parameters, &mut self.linear[i])?;
            let z = self.lower[i][i] / h;
            let matrix = self.linear[i].matrix(system, &mut self.values, z);
            let (before, now) = self.factors.split_at_mut(i);
            match before.last() {
                Some(last) => now[0].follow(last),
                None => now[0].follow(&equations.factors),
            }
            now[0].factor_entries(&matrix);
            self.turns[i] = turns(system, &unknowns.z[i]);
        }
        equations.factorisations += 1;
        Ok(())
    }

    /// Computes the corrections from the residuals of the stages, with the factors computed last. Writes the corrections to `change` and
    /// returns the accelerated step.
    pub(crate) fn correct(
        &mut self,
        equations: &StepMatrices,
        system: &System,
        step: Step<'_>,
        change: &mut Unknowns,
    ) -> Unknowns {
        let Step { start, h } = step;
        let (n, all) = (system.first_equation, system.moving_unknowns);
        let first_state = system.first_state();
        for i in 0..3 {
            // Contribution of the corrections of earlier stages to the rates at this stage.
            let (mut moved, mut quickened) = (vec![0.0; all], vec![0.0; n]);
            for j in 0..i {
                let by = self.lower[i][j] / h;
                for (to, dz) in moved.iter_mut().zip(&change.z[j]) {
                    *to += by * dz;
                }
                for (to, dw) in quickened.iter_mut().zip(&change.w[j]) {
                    *to += by * dw;
                }
            }
            let (r1, g, r4) = equations.residuals.at(i);
            let r1 = r1.iter().zip(&moved).map(|(r, d)| r + d).collect();
            let mut of = Correction::of(g.to_vec(), r1, r4.to_vec());
            for (row, column, [by_rate, by_second]) in self.linear[i].levels.rates() {
                if (n..system.first_variable).contains(&row) {
                    continue;
                }
                if column < n {
                    of.z[row] += by_second * quickened[column];
                } else if column >= first_state {
                    of.z[row] += by_rate * moved[column];
                }
            }
            // The equations of the stage are solved for y, where dd = P y. Rotation residuals are therefore multiplied by the inverse of P.
            let turns = &self.turns[i];
            each_turn(system, &mut of.w, |part, turn| {
                turns[part].try_inverse().unwrap_or(Mat3::identity()) * turn
            });
            let z = self.lower[i][i] / h;
            self.linear[i].solve(system, start, z, &mut of, &self.factors[i]);
            change.z[i] = of.z;
            change.w[i] = of.w;
            change.mu[i] = of.mu;
            each_turn(system, &mut change.z[i], |part, turn| turns[part] * turn);
        }
        self.mixing.mixed(change)
    }
}

/// Applies `change` to the rotation vectors of all bodies that rotate.
fn each_turn(system: &System, values: &mut [f64], change: impl Fn(usize, Vec3) -> Vec3) {
    for (part, body) in system.bodies.iter().enumerate() {
        if body.freedoms == 6 {
            let turn = &mut values[body.first + 3..body.first + 6];
            let changed = change(part, Vec3::new(turn[0], turn[1], turn[2]));
            turn.copy_from_slice(changed.as_slice());
        }
    }
}

/// Returns the inverse of L, where `matrix` = L U and U has a unit diagonal (Crout).
fn inverse_of_lower(matrix: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    // The row operations that turn A into U turn the identity on the right into the inverse of L.
    let mut left = *matrix;
    let mut right = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for k in 0..3 {
        let pivot = left[k][k];
        for row in [&mut left[k], &mut right[k]] {
            for value in row {
                *value /= pivot;
            }
        }
        for i in k + 1..3 {
            let factor = left[i][k];
            for j in 0..3 {
                left[i][j] -= factor * left[k][j];
                right[i][j] -= factor * right[k][j];
            }
        }
    }
    right
}

#[cfg(test)]
mod tests {
    use nalgebra::{Complex, Matrix3};

    use super::*;

    /// One iteration multiplies the error of `y' = q y` over a step of length one by the matrix `q (1 - q L)^-1 (A - L)`.
    #[test]
    fn what_swings_falls_by_the_rate() {
        let matrix = |rows: &[[f64; 3]; 3]| Matrix3::from_fn(|i, j| rows[i][j]);
        let (S, whole) = (matrix(&inverse_of_lower(&A)), matrix(&A));
        assert_eq!((S[(0, 1)], S[(0, 2)], S[(1, 2)]), (0.0, 0.0, 0.0));
        let L = S.try_inverse().expect("a lower triangle");
        let complex = |M: &Matrix3<f64>| M.map(|x| Complex::new(x, 0.0));
        let mut most = 0.0_f64;
        for k in 0..600 {
            let q = Complex::new(0.0, 10.0_f64.powf(f64::from(k) * 0.01 - 2.0));
            let step = Matrix3::identity() - complex(&L) * q;
            let step = step.try_inverse().expect("stable") * complex(&(whole - L)) * q;
            // The spectral radius, from the growth of a high power.
            let mut power = step;
            let mut exponent = 1.0;
            for _ in 0..8 {
                power *= power;
                exponent *= 2.0;
            }
            most = most.max(power.norm().powf(1.0 / exponent));
        }
        assert!((0.98 * RATE..1.02 * RATE).contains(&most), "{most}");
        // Errors in constraints vanish after three iterations.
        let rest = (Matrix3::identity() - S * whole).pow(3);
        assert!(rest.norm() < 1e-12, "{rest}");
    }
}
