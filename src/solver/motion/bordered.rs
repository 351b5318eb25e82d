//! Projections: the system `[ S, G'; G, 0 ]` of one weight matrix per part and the constraint gradients.

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
    /// True if all weights are diagonal.
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

    /// Creates a projection for diagonal weights only.
    pub(crate) fn plain(system: &System) -> Self {
        Self {
            plain: true,
            ..Self::new(system)
        }
    }

    /// Factors the system. Equations that do not take part get a multiplier of zero.
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

    /// Solves in place. The vector contains motions of the parts, then multipliers.
    pub(crate) fn solve(&mut self, b: &mut [f64]) {
        self.factors.solve(b);
    }

    /// Solves for numbers of another kind. The solution is written to `x`, and `b` is overwritten.
    pub(crate) fn solve_into<T>(&self, b: &mut [T], x: &mut [T])
    where
        T: Scalar + Mul<f64, Output = T> + Div<f64, Output = T>,
    {
        self.factors.solve_into(b, x);
    }
}

/// Returns a weight for parts that is independent of their masses: m for translations, m L^2 for rotations, with the model's reference mass
/// and length.
pub(super) fn plain_weight(system: &System) -> Mat6 {
    let (m, l) = (system.reference_mass, system.length);
    Mat6::from_fn(|i, j| match (i == j, i < 3) {
        (false, _) => 0.0,
        (true, true) => m,
        (true, false) => m * l * l,
    })
}
