/// Returns the slopes at the knots by Akima's rule (J. ACM 17, 1970). `x` must be strictly increasing. `x` and `y` must have equal lengths
/// of at least two.
///
/// ```text
/// m_i = (y_(i+1) - y_i) / (x_(i+1) - x_i)
/// t_i = (|m_(i+1) - m_i| m_(i-1) + |m_(i-1) - m_(i-2)| m_i) / (|m_(i+1) - m_i| + |m_(i-1) - m_(i-2)|)
/// ```
/// If both weights vanish, t_i is the mean of `m_(i-1)` and `m_i`. Two chords are added at each end: `m_0 = 2 m_1 - m_2`,
/// `m_(-1) = 2 m_0 - m_1`, and the mirror images at the other end.
pub(super) fn slopes(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    let m = chords(x, y);
    if n == 2 {
        return vec![m[2]; 2];
    }
    (0..n)
        .map(|i| {
            let (before, after) = ((m[i + 1] - m[i]).abs(), (m[i + 3] - m[i + 2]).abs());
            if before + after == 0.0 {
                0.5 * (m[i + 1] + m[i + 2])
            } else {
                (after * m[i + 1] + before * m[i + 2]) / (before + after)
            }
        })
        .collect()
}

/// Returns the derivatives of the slopes along a change of the y values. Where both weights vanish, the derivative of the mean of the two
/// chords is returned.
pub(super) fn slopes_along(x: &[f64], y: &[f64], along: &[f64]) -> Vec<f64> {
    let n = x.len();
    // Chords are linear in y.
    let (m, dm) = (chords(x, y), chords(x, along));
    if n == 2 {
        return vec![dm[2]; 2];
    }
    (0..n)
        .map(|i| {
            let (before, after) = (m[i + 1] - m[i], m[i + 3] - m[i + 2]);
            let sum = before.abs() + after.abs();
            if sum == 0.0 {
                return 0.5 * (dm[i + 1] + dm[i + 2]);
            }
            let slope = (after.abs() * m[i + 1] + before.abs() * m[i + 2]) / sum;
            let d_before = sign(before) * (dm[i + 1] - dm[i]);
            let d_after = sign(after) * (dm[i + 3] - dm[i + 2]);
            let by_weights = d_after * (m[i + 1] - slope) + d_before * (m[i + 2] - slope);
            (after.abs() * dm[i + 1] + before.abs() * dm[i + 2] + by_weights) / sum
        })
        .collect()
}

/// Returns the sign of a number; zero for zero.
fn sign(x: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x.signum() }
}

/// Returns the slopes of the chords, with two extra chords before and two after: chord k of the data is at index k + 2.
fn chords(x: &[f64], y: &[f64]) -> Vec<f64> {
    let n = x.len();
    let mut m = vec![0.0; n + 3];
    for k in 0..n - 1 {
        m[k + 2] = (y[k + 1] - y[k]) / (x[k + 1] - x[k]);
    }
    if n == 2 {
        return m;
    }
    m[1] = 2.0 * m[2] - m[3];
    m[0] = 2.0 * m[1] - m[2];
    m[n + 1] = 2.0 * m[n] - m[n - 1];
    m[n + 2] = 2.0 * m[n + 1] - m[n];
    m
}
