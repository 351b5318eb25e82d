//! Projections onto the constraints, with the matrix `[ S, G'; G, 0 ]`. S contains one weight matrix per part, and G the constraint gradients.

use std::ops::{Div, Mul};

use crate::linear::{Lu, Matrix, Occupied, Scalar, Sink};
use crate::mechanics::Mat6;
use crate::system::{Rows, System};

/// Matrix of a projection and its factors.
#[derive(Clone, Debug)]
pub(super) struct Bordered {
    matrix: Matrix,
    occupied: Occupied,
    values: Vec<f64>,
    factors: Lu,
    bodies: usize,
    /// True if all weight matrices are diagonal.
    plain: bool,
}

impl Bordered {
    pub(crate) fn new(system: &System) -> Self {
        let n = system.first_equation + system.equations;
        Self {
            matrix: Matrix::new(n),
            occupied: Occupied::default(),
            values: Vec::new(),
            factors: Lu::for_many(n),
            bodies: system.first_equation,
            plain: false,
        }
    }

    /// Creates a projection whose weight matrices are all diagonal.
    pub(crate) fn plain(system: &System) -> Self {
        Self {
            plain: true,
            ..Self::new(system)
        }
    }

    /// Assembles and factors the matrix. Equations for which `takes_part` is false get a multiplier of zero.
    pub(crate) fn factor(
        &mut self,
        system: &System,
        rows: &Rows,
        takes_part: impl Fn(usize) -> bool,
        weight: impl Fn(usize) -> Mat6,
    ) {
        self.matrix.clear();
        for (part, body) in system.bodies.iter().enumerate() {
            let S = weight(part);
            for j in 0..body.freedoms {
                for i in (0..body.freedoms).filter(|i| !self.plain || *i == j) {
                    self.matrix.add(body.first + i, body.first + j, S[(i, j)]);
                }
            }
        }
        for k in 0..system.equations {
            let row = self.bodies + k;
            let out = f64::from(u8::from(!takes_part(k)));
            self.matrix.add(row, row, out);
        }
        for &(row, column, value) in &rows.entries {
            let value = if takes_part(row as usize) { value } else { 0.0 };
            let row = self.bodies + row as usize;
            self.matrix.add(row, column as usize, value);
            self.matrix.add(column as usize, row, value);
        }
        self.matrix.finish();
        let matrix = self.matrix.occupied(&mut self.occupied, &mut self.values);
        self.factors.factor_entries(&matrix);
    }

    /// Replaces the right side `b` by the solution. The vector contains the motions of the parts, then the multipliers.
    pub(crate) fn solve(&mut self, b: &mut [f64]) {
        self.factors.solve(b);
    }

    /// Solves for a right side of another number type, for example complex numbers. Writes the solution to `x` and overwrites `b`.
    pub(crate) fn solve_into<T>(&self, b: &mut [T], x: &mut [T])
    where
        T: Scalar + Mul<f64, Output = T> + Div<f64, Output = T>,
    {
        self.factors.solve_into(b, x);
    }
}

/// Returns a diagonal weight matrix that is independent of the masses of the parts: m for translations, m L^2 for rotations. m is the reference
/// mass of the model, and L is its length.
pub(super) fn plain_weight(system: &System) -> Mat6 {
    let (m, l) = (system.reference_mass, system.length);
    Mat6::from_fn(|i, j| match (i == j, i < 3) {
        (false, _) => 0.0,
        (true, true) => m,
        (true, false) => m * l * l,
    })
}
