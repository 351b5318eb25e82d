/// Returns the slopes at the knots of the natural cubic spline, whose second derivative is continuous and zero at both ends. `x` must be
/// strictly increasing. `x` and `y` must have equal lengths of at least two.
///
/// With `h_i = x_(i+1) - x_i` and chord slopes `m_i`, continuity of the second derivative at inner knots gives
/// `t_(i-1) / h_(i-1) + 2 t_i (1/h_(i-1) + 1/h_i) + t_(i+1) / h_i = 3 (m_(i-1) / h_(i-1) + m_i / h_i)`. The end conditions are
/// `2 t_0 + t_1 = 3 m_0` and `t_(n-2) + 2 t_(n-1) = 3 m_(n-2)`. The system is tridiagonal and diagonally dominant.
pub(super) fn slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    let chord = |k: usize| (y[k + 1] - y[k]) / (x[k + 1] - x[k]);
    let inverse = |k: usize| 1.0 / (x[k + 1] - x[k]);
    // Thomas algorithm: `upper` holds the scaled upper diagonal, `t` the scaled right-hand side and finally the solution.
    let mut upper = vec![0.0; n];
    let mut t = vec![0.0; n];
    for i in 0..n {
        let (lower, diagonal, above, right) = if i == 0 {
            (0.0, 2.0, 1.0, 3.0 * chord(0))
        } else if i == n - 1 {
            (1.0, 2.0, 0.0, 3.0 * chord(n - 2))
        } else {
            let (a, b) = (inverse(i - 1), inverse(i));
            (a, 2.0 * (a + b), b, 3.0 * (chord(i - 1) * a + chord(i) * b))
        };
        let (before, value) = if i == 0 {
            (0.0, 0.0)
        } else {
            (upper[i - 1], t[i - 1])
        };
        let pivot = diagonal - lower * before;
        upper[i] = above / pivot;
        t[i] = (right - lower * value) / pivot;
    }
    for i in (0..n - 1).rev() {
        t[i] -= upper[i] * t[i + 1];
    }
    t
}
