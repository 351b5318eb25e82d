use nalgebra::{DMatrix, DVector};

use super::least_squares::solve_scaled;
use super::settings::{LINEAR_RELATIVE, PRELOAD_SPLINE_INTERVALS};

/// Law of one axis of a bushing: force or torque as a function of the deflection or angle.
#[derive(Clone, PartialEq, Debug)]
pub enum AxisLaw {
    /// F = preload - stiffness d.
    Linear {
        /// Force at d = 0.
        preload: f64,
        /// Stiffness.
        stiffness: f64,
    },
    /// F as a curve of d through these points, which are in increasing order of d.
    Curve(Vec<(f64, f64)>),
    /// F = preload - X(r) d/r, where r is the radial deflection and X is an odd curve through the origin and `points`.
    Odd {
        /// Force at d = 0.
        preload: f64,
        /// Points of the curve X, in increasing order of r, without the origin.
        points: Vec<(f64, f64)>,
    },
    /// The axis did not move. The force is this constant, and the stiffness is unknown.
    Unseen(f64),
}

/// Laws of a bushing in J axes.
#[derive(Clone, PartialEq, Debug)]
pub struct Law {
    /// Laws of FX, FY, FZ.
    pub force: [AxisLaw; 3],
    /// Laws of TX, TY, TZ as functions of the angles AX, AY, AZ.
    pub torque: [AxisLaw; 3],
    /// Axes whose curves share the radial deflection.
    pub coupled: Option<[usize; 2]>,
}

impl Law {
    /// Returns true if every axis is linear or did not move. The element is then a BUSHING.
    pub fn is_linear(&self) -> bool {
        let mut all = self.force.iter().chain(&self.torque);
        all.all(|law| matches!(law, AxisLaw::Linear { .. } | AxisLaw::Unseen(_)))
    }
}

impl AxisLaw {
    /// Returns the linear law of an axis, or [`Self::Unseen`] if no deflection differs from the mean by more than `least`. Returns `None` if the
    /// force is not linear.
    pub(crate) fn linear(d: &[f64], f: &[f64], least: f64) -> Option<Self> {
        let count = d.len() as f64;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / count;
        let (mean_d, mean_f) = (mean(d), mean(f));
        let most =
            |values: &[f64], mean: f64| values.iter().map(|v| (v - mean).abs()).fold(0.0, f64::max);
        if most(d, mean_d) <= least {
            return Some(Self::Unseen(mean_f));
        }
        let (mut across, mut along) = (0.0, 0.0);
        for (d, f) in d.iter().zip(f) {
            across += (d - mean_d) * (f - mean_f);
            along += (d - mean_d) * (d - mean_d);
        }
        let stiffness = -across / along;
        let preload = mean_f + stiffness * mean_d;
        let left = d
            .iter()
            .zip(f)
            .map(|(d, f)| (f - preload + stiffness * d).abs())
            .fold(0.0, f64::max);
        let room = LINEAR_RELATIVE * most(f, mean_f).max(1e-9 * mean_f.abs());
        (left <= room).then_some(Self::Linear { preload, stiffness })
    }

    /// Returns the curve through the forces, with one point for each deflection in the states.
    pub(crate) fn curve(d: &[f64], f: &[f64]) -> Self {
        let points = d.iter().copied().zip(f.iter().copied()).collect();
        Self::Curve(thinned(points))
    }

    /// Returns the odd law of an axis without coupling, and its largest residual force.
    pub(crate) fn odd(d: &[f64], f: &[f64]) -> (Self, f64) {
        Self::radial(d, &vec![0.0; d.len()], f)
    }

    /// Returns the law of an axis that shares its radial deflection with a partner, and its largest residual force.
    ///
    /// A cubic spline with equally spaced knots is fitted together with the preload. The curve then gets one point per deflection in the states.
    pub(crate) fn radial(d: &[f64], partner: &[f64], f: &[f64]) -> (Self, f64) {
        let r: Vec<f64> = d
            .iter()
            .zip(partner)
            .map(|(x, y)| libm::hypot(*x, *y))
            .collect();
        let most = r.iter().copied().fold(0.0, f64::max);
        let step = most / PRELOAD_SPLINE_INTERVALS as f64;
        // X(r)/r is even and smooth: X(r) d/r = (c0 + sum of cubic B-splines of r) d.
        let columns = PRELOAD_SPLINE_INTERVALS + 4;
        let mut A = DMatrix::zeros(d.len(), columns);
        let mut right = DVector::zeros(d.len());
        for (k, r) in r.iter().enumerate() {
            A[(k, 0)] = 1.0;
            for (column, value) in splines(r / step) {
                A[(k, 1 + column)] -= value * d[k];
            }
            right[k] = f[k];
        }
        let found = solve_scaled(&A, &right, &DVector::zeros(columns), 1e-9);
        let preload = found.x[0];
        let far = d.iter().map(|d| d.abs()).fold(0.0, f64::max);
        let of = |k: usize| (r[k], (preload - f[k]) * r[k] / d[k]);
        let seen = (0..d.len()).filter(|k| d[*k].abs() > 0.05 * r[*k] && d[*k].abs() > 1e-3 * far);
        let points = thinned(seen.map(of).collect());
        (Self::Odd { preload, points }, found.left)
    }
}

/// Returns (index, value) of each of the four uniform cubic B-splines that are nonzero at `u` knot intervals from the first knot.
fn splines(u: f64) -> [(usize, f64); 4] {
    let at = (u.floor().max(0.0) as usize).min(PRELOAD_SPLINE_INTERVALS - 1);
    let t = u - at as f64;
    let s = 1.0 - t;
    [
        (at, s * s * s / 6.0),
        (at + 1, (3.0 * t * t * t - 6.0 * t * t + 4.0) / 6.0),
        (at + 2, (3.0 * s * s * s - 6.0 * s * s + 4.0) / 6.0),
        (at + 3, t * t * t / 6.0),
    ]
}

/// Sorts points by their first coordinate, and replaces neighbouring points by their mean. Points are neighbours if they are closer than a thousandth
/// of the range.
pub(crate) fn thinned(mut points: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    points.sort_by(|a, b| a.0.total_cmp(&b.0));
    let range = match (points.first(), points.last()) {
        (Some(first), Some(last)) => last.0 - first.0,
        _ => 0.0,
    };
    let mut kept: Vec<(f64, f64, f64)> = Vec::new();
    for (x, y) in points {
        match kept.last_mut() {
            Some((at, value, count)) if x - *at / *count <= 1e-3 * range => {
                *at += x;
                *value += y;
                *count += 1.0;
            }
            _ => kept.push((x, y, 1.0)),
        }
    }
    kept.into_iter()
        .map(|(x, y, count)| (x / count, y / count))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_is_linear_and_a_cubic_is_a_curve() {
        let d: Vec<f64> = (-20..=20).map(|k| f64::from(k) * 0.1).collect();
        let line: Vec<f64> = d.iter().map(|d| 12.0 - 300.0 * d).collect();
        let Some(AxisLaw::Linear { preload, stiffness }) = AxisLaw::linear(&d, &line, 0.0) else {
            panic!("linear")
        };
        assert!((preload - 12.0).abs() < 1e-9 && (stiffness - 300.0).abs() < 1e-9);
        let cubic: Vec<f64> = d
            .iter()
            .map(|d| 12.0 - 300.0 * d - 40.0 * d * d * d)
            .collect();
        assert_eq!(AxisLaw::linear(&d, &cubic, 0.0), None);
    }

    #[test]
    fn the_preload_of_an_odd_curve_is_found() {
        let d: Vec<f64> = (-50..=50).map(|k| f64::from(k) * 0.05).collect();
        let partner: Vec<f64> = d.iter().map(|d| 0.3 * d * d).collect();
        let X = |r: f64| 200.0 * r + 30.0 * r * r * r;
        let f: Vec<f64> = d
            .iter()
            .zip(&partner)
            .map(|(x, y)| {
                let r = x.hypot(*y);
                if r > 0.0 { 55.0 - X(r) * x / r } else { 55.0 }
            })
            .collect();
        let (law, left) = AxisLaw::radial(&d, &partner, &f);
        let AxisLaw::Odd { preload, points } = law else {
            panic!("odd")
        };
        assert!((preload - 55.0).abs() < 1e-2, "{preload} {left}");
        for (r, value) in points {
            assert!((value - X(r)).abs() < 0.5, "{r} {value}");
        }
    }
}
