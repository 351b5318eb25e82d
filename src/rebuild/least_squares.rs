use nalgebra::{DMatrix, DVector};

/// Solution of a linear least-squares problem.
#[derive(Clone, Debug)]
pub(crate) struct Solution {
    /// Values of the unknowns.
    pub(crate) x: DVector<f64>,
    /// Indeterminacy of each unknown: 0 if the equations determine it, 1 if they do not determine it at all.
    pub(crate) open: Vec<f64>,
    /// Largest absolute residual of the equations.
    pub(crate) left: f64,
}

/// Solves `A x = b` by least squares, for unknowns of different units.
///
/// Columns are first scaled to unit length. The solution then follows as in [`solve`].
pub(crate) fn solve_scaled(
    A: &DMatrix<f64>,
    b: &DVector<f64>,
    prior: &DVector<f64>,
    smallest: f64,
) -> Solution {
    let scale: Vec<f64> = A
        .column_iter()
        .map(|column| {
            let norm = column.norm();
            if norm > 0.0 { norm } else { 1.0 }
        })
        .collect();
    let mut scaled = A.clone();
    for (mut column, scale) in scaled.column_iter_mut().zip(&scale) {
        column /= *scale;
    }
    let each = prior.iter().zip(&scale).map(|(x, scale)| x * scale);
    let start = DVector::from_iterator(scale.len(), each);
    let mut found = solve(&scaled, b, &start, smallest);
    for (x, scale) in found.x.iter_mut().zip(&scale) {
        *x /= scale;
    }
    found
}

/// Solves `A x = b` by least squares, for unknowns of one unit. Combinations of unknowns that the equations do not determine keep their value in
/// `prior`. These are combinations with a singular value below `smallest` times the largest singular value.
pub(crate) fn solve(
    A: &DMatrix<f64>,
    b: &DVector<f64>,
    prior: &DVector<f64>,
    smallest: f64,
) -> Solution {
    let n = A.ncols();
    let right = b - A * prior;
    if n == 0 {
        return Solution {
            x: DVector::zeros(0),
            open: Vec::new(),
            left: right.amax(),
        };
    }
    // The triangular factor of the QR decomposition has the same singular values, and is small.
    let mut wide = A.clone().insert_column(n, 0.0);
    wide.set_column(n, &right);
    if wide.nrows() < n + 1 {
        let rows = wide.nrows();
        wide = wide.insert_rows(rows, n + 1 - rows, 0.0);
    }
    let R = wide.qr().r();
    let triangle = R.view((0, 0), (n, n)).clone_owned();
    let target = R.view((0, n), (n, 1)).column(0).clone_owned();
    let svd = triangle.svd(true, true);
    let (Some(U), Some(Vt)) = (svd.u, svd.v_t) else {
        unreachable!("both were asked for")
    };
    let largest = svd.singular_values.amax();
    let mut y = DVector::zeros(n);
    let mut open = vec![0.0; n];
    for (k, value) in svd.singular_values.iter().enumerate() {
        let direction = Vt.row(k).transpose();
        if *value > smallest * largest && *value > 0.0 {
            y += direction * (U.column(k).dot(&target) / value);
        } else {
            for (open, part) in open.iter_mut().zip(direction.iter()) {
                *open += part * part;
            }
        }
    }
    let left = (&right - A * &y).amax();
    Solution {
        x: prior + y,
        open,
        left,
    }
}
