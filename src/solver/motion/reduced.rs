//! Reduction of linear descriptor equations to state equations. Algebraic rows, such as the balances of massless parts, are eliminated.

use nalgebra::DMatrix;

use crate::mechanics::eigen::singular_values;

/// Singular values of the rate matrix E below this share of the largest count as zero.
const NO_RATE: f64 = 1e-12;
/// Pivots below this share of the largest coefficient of the algebraic rows count as zero.
const NO_PIVOT: f64 = 1e-10;
/// A dependence on input rates below this share of the largest coefficient is neglected.
const NO_INPUT_RATE: f64 = 1e-9;
/// Number of input orders: the inputs, and their first and second time derivatives.
const ORDERS: usize = 3;

/// Reason why no state equations exist.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Irreducible {
    /// The equations leave some motion undetermined.
    Undetermined,
    /// The state with this index depends on the rate of an input.
    StateByInputRate(usize),
}

/// State equations `v' = A v + B w` of the descriptor system `E u' = F u + B w`. The states v are some of the components of u, and
/// `u = N v + M (w, w', w'')`.
///
/// Combinations of rows in which E vanishes are algebraic: `0 = a v + b w`. Each of them eliminates one component of v, components without
/// inertia first. This is repeated until every row contains a rate. (Elimination of the algebraic rows of a descriptor system, as in
/// Luenberger's shuffle algorithm, Automatica 14, 1978.)
pub(super) struct Reduced {
    pub A: DMatrix<f64>,
    /// Input matrix. Its first columns belong to the inputs. The remaining columns, which belong to the time derivatives of the inputs, are
    /// negligible.
    pub B: DMatrix<f64>,
    /// Indices of the components of u that are states.
    pub kept: Vec<usize>,
    N: DMatrix<f64>,
    M: DMatrix<f64>,
    inputs: usize,
}

impl Reduced {
    /// Reduces the system `E u' = F u + B w`. Components of u with a larger `lightness` are eliminated before components with a smaller one.
    pub(super) fn new(
        E: &DMatrix<f64>,
        F: &DMatrix<f64>,
        B: &DMatrix<f64>,
        lightness: &[u8],
    ) -> Result<Self, Irreducible> {
        let (size, inputs) = (E.nrows(), B.ncols());
        let mut new = Self {
            A: DMatrix::zeros(0, 0),
            B: DMatrix::zeros(0, ORDERS * inputs),
            kept: (0..size).collect(),
            N: DMatrix::identity(size, size),
            M: DMatrix::zeros(size, ORDERS * inputs),
            inputs,
        };
        let (mut E, mut F) = (E.clone(), F.clone());
        let mut B = B.clone().resize_horizontally(ORDERS * inputs, 0.0);
        loop {
            let by_rate = &E * &new.N;
            let by_state = &F * &new.N;
            let by_input = &F * &new.M + &B - &E * new.shifted(&new.M);
            let Some(found) = singular_values(by_rate.clone(), true, false) else {
                if new.kept.is_empty() {
                    return Ok(new);
                }
                return Err(Irreducible::Undetermined);
            };
            let most = found.singular_values.amax();
            let (with_rate, without): (Vec<usize>, Vec<usize>) =
                (0..by_rate.nrows()).partition(|k| found.singular_values[*k] > NO_RATE * most);
            if without.is_empty() {
                let lu = by_rate.full_piv_lu();
                let solved = lu.solve(&by_state).zip(lu.solve(&by_input));
                let (A, B) = solved.ok_or(Irreducible::Undetermined)?;
                if let Some(row) = beyond_inputs(&B, inputs) {
                    return Err(Irreducible::StateByInputRate(new.kept[row]));
                }
                new.A = A;
                new.B = B;
                return Ok(new);
            }
            let U = found.u.ok_or(Irreducible::Undetermined)?;
            let left = U.select_columns(&without);
            new.eliminate(left.tr_mul(&by_state), left.tr_mul(&by_input), lightness)?;
            let rows = U.select_columns(&with_rate);
            (E, F, B) = (rows.tr_mul(&E), rows.tr_mul(&F), rows.tr_mul(&B));
        }
    }

    /// Returns the time derivative of an expression that is given by its coefficients of the inputs and of their derivatives. Coefficients of
    /// the highest derivative are dropped.
    fn shifted(&self, by_input: &DMatrix<f64>) -> DMatrix<f64> {
        let count = self.inputs;
        let mut shifted = DMatrix::zeros(by_input.nrows(), ORDERS * count);
        let known = by_input.columns(0, (ORDERS - 1) * count);
        shifted
            .columns_mut(count, (ORDERS - 1) * count)
            .copy_from(&known);
        shifted
    }

    /// Eliminates one state for each algebraic row `0 = a v + b w`, by Gaussian elimination with full pivoting.
    fn eliminate(
        &mut self,
        mut a: DMatrix<f64>,
        mut b: DMatrix<f64>,
        lightness: &[u8],
    ) -> Result<(), Irreducible> {
        let most = a.amax();
        let mut pivots: Vec<(usize, usize)> = Vec::new();
        while pivots.len() < a.nrows() {
            let mut best: Option<(u8, f64, usize, usize)> = None;
            for row in 0..a.nrows() {
                for column in 0..a.ncols() {
                    let taken = |p: &(usize, usize)| p.0 == row || p.1 == column;
                    let value = a[(row, column)].abs();
                    if pivots.iter().any(taken) || !(value > NO_PIVOT * most) {
                        continue;
                    }
                    let light = lightness[self.kept[column]];
                    if best.is_none_or(|b| (light, value) > (b.0, b.1)) {
                        best = Some((light, value, row, column));
                    }
                }
            }
            let Some((_, _, row, column)) = best else {
                return Err(Irreducible::Undetermined);
            };
            let pivot = a[(row, column)];
            let (of_a, of_b) = (a.row(row) / pivot, b.row(row) / pivot);
            for other in 0..a.nrows() {
                if other == row {
                    a.set_row(row, &of_a);
                    b.set_row(row, &of_b);
                } else {
                    let share = a[(other, column)];
                    let (next_a, next_b) =
                        (a.row(other) - &of_a * share, b.row(other) - &of_b * share);
                    a.set_row(other, &next_a);
                    b.set_row(other, &next_b);
                }
            }
            pivots.push((row, column));
        }
        // The eliminated component equals minus the rest of its row.
        for &(row, column) in &pivots {
            let along = self.N.column(column).into_owned();
            let (mut of_a, of_b) = (a.row(row).into_owned(), b.row(row).into_owned());
            of_a[column] = 0.0;
            for (_, other) in &pivots {
                of_a[*other] = 0.0;
            }
            self.N -= &along * of_a;
            self.M -= &along * of_b;
        }
        let stay: Vec<usize> = (0..self.kept.len())
            .filter(|column| pivots.iter().all(|pivot| pivot.1 != *column))
            .collect();
        self.N = self.N.select_columns(&stay);
        self.kept = stay.iter().map(|k| self.kept[*k]).collect();
        Ok(())
    }

    /// Returns the matrices C and D of the output `by_u u + by_rate u' + direct w = C v + D w`. The error is the index of the first row that
    /// depends on the rate of an input.
    pub(super) fn output(
        &self,
        by_u: &DMatrix<f64>,
        by_rate: &DMatrix<f64>,
        direct: &DMatrix<f64>,
    ) -> Result<(DMatrix<f64>, DMatrix<f64>), usize> {
        let direct = direct
            .clone()
            .resize_horizontally(ORDERS * self.inputs, 0.0);
        let C = by_u * &self.N + by_rate * &self.N * &self.A;
        let D = by_u * &self.M + by_rate * (&self.N * &self.B + self.shifted(&self.M)) + direct;
        match beyond_inputs(&D, self.inputs) {
            Some(row) => Err(row),
            None => Ok((C, D.columns(0, self.inputs).into_owned())),
        }
    }
}

/// Returns the index of the first row that depends on rates of the inputs.
fn beyond_inputs(by_input: &DMatrix<f64>, inputs: usize) -> Option<usize> {
    let most = by_input.amax();
    let rates = by_input.columns(inputs, by_input.ncols() - inputs);
    (0..rates.nrows()).find(|row| rates.row(*row).amax() > NO_INPUT_RATE * most)
}
