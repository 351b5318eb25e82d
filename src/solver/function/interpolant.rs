use super::{akima, cubic};
use crate::model::Spline;

/// Method of interpolating a SPLINE in x.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Method {
    /// Akima's method: AKISPL.
    Akima,
    /// Natural cubic spline: CUBSPL, INTERP method 3.
    Cubic,
    /// Linear interpolation: INTERP method 1.
    Linear,
}

impl Method {
    /// Returns the slopes at the knots; none for linear interpolation.
    fn slopes(self, x: &[f64], y: &[f64]) -> Vec<f64> {
        match self {
            Self::Akima => akima::slopes(x, y),
            Self::Cubic => cubic::slopes(x, y),
            Self::Linear => Vec::new(),
        }
    }

    /// Returns the derivatives of the slopes along a change of the y values.
    fn slopes_along(self, x: &[f64], y: &[f64], along: &[f64]) -> Vec<f64> {
        match self {
            Self::Akima => akima::slopes_along(x, y, along),
            // The slopes of a cubic spline are linear in y.
            Self::Cubic => cubic::slopes(x, along),
            Self::Linear => Vec::new(),
        }
    }
}

/// SPLINE data prepared for interpolation, with the slopes at the knots of every row of y values. There is one row per z value.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Interpolant {
    method: Method,
    x: Vec<f64>,
    z: Vec<f64>,
    rows: Vec<Coefficients>,
    linear_extrapolate: bool,
}

#[derive(Clone, PartialEq, Debug)]
struct Coefficients {
    y: Vec<f64>,
    /// Slopes at the knots; empty for linear interpolation.
    slopes: Vec<f64>,
}

impl Interpolant {
    /// Prepares the data. Returns `None` if the data define no curve: fewer than two points, rows of different lengths, or x or z values
    /// that are not strictly increasing.
    pub(super) fn new(spline: &Spline, method: Method) -> Option<Self> {
        let n = spline.x.len();
        let rising = |values: &[f64]| values.windows(2).all(|pair| pair[0] < pair[1]);
        let sound = n >= 2
            && !spline.y.is_empty()
            && spline.y.len() == spline.z.len()
            && rising(&spline.x)
            && rising(&spline.z)
            && spline.y.iter().all(|row| row.len() == n);
        sound.then(|| Self {
            method,
            x: spline.x.clone(),
            z: spline.z.clone(),
            rows: spline
                .y
                .iter()
                .map(|y| Coefficients {
                    y: y.clone(),
                    slopes: method.slopes(&spline.x, y),
                })
                .collect(),
            linear_extrapolate: spline.linear_extrapolate,
        })
    }

    /// Prepares a curve for Akima's method with linear extrapolation, whatever extrapolation its SPLINE requests. Returns `None` for data
    /// that define no curve, and for a surface.
    pub(crate) fn akima_line(spline: &Spline) -> Option<Self> {
        let mut curve = Self::new(spline, Method::Akima).filter(|curve| !curve.is_surface())?;
        curve.linear_extrapolate = true;
        Some(curve)
    }

    /// Sets the y value of a knot of a curve.
    pub(super) fn set(&mut self, knot: usize, y: f64) {
        let row = &mut self.rows[0];
        row.y[knot] = y;
        row.slopes = self.method.slopes(&self.x, &row.y);
    }

    /// Returns the derivative of the value of [`Self::at`] with respect to the y value of a knot of a curve.
    pub(crate) fn by_knot(&self, knot: usize, x: f64, order: usize) -> f64 {
        let mut along = vec![0.0; self.x.len()];
        along[knot] = 1.0;
        let slopes = self.method.slopes_along(&self.x, &self.rows[0].y, &along);
        // The polynomials are linear in the y values and slopes together.
        let row = Coefficients { y: along, slopes };
        self.locate(x).derivatives(&row)[order]
    }

    /// Returns the largest magnitude of the x values.
    pub(crate) fn reach(&self) -> f64 {
        self.x.iter().fold(0.0, |most, x| x.abs().max(most))
    }

    /// Returns whether the spline is a surface: it has more than one row (z value).
    pub(super) fn is_surface(&self) -> bool {
        self.rows.len() > 1
    }

    /// Returns the derivative of the given order with respect to x at (x, z), and the derivatives of that result with respect to x and z. A
    /// surface is interpolated linearly in z between its rows. Outside the rows it is extrapolated linearly from the two nearest rows.
    pub(crate) fn at(&self, x: f64, z: f64, order: usize) -> (f64, [f64; 2]) {
        let local = self.locate(x);
        let of = |row: &Coefficients| {
            let derivatives = local.derivatives(row);
            let get = |order: usize| derivatives.get(order).copied().unwrap_or(0.0);
            (get(order), get(order + 1))
        };
        if !self.is_surface() {
            let (value, slope) = of(&self.rows[0]);
            return (value, [slope, 0.0]);
        }
        let k = self.z[1..self.z.len() - 1].partition_point(|&knot| knot <= z);
        let width = self.z[k + 1] - self.z[k];
        let share = (z - self.z[k]) / width;
        let ((a, da), (b, db)) = (of(&self.rows[k]), of(&self.rows[k + 1]));
        (
            a + share * (b - a),
            [da + share * (db - da), (b - a) / width],
        )
    }

    fn locate(&self, x: f64) -> Interval<'_> {
        let n = self.x.len();
        let inside = x >= self.x[0] && x <= self.x[n - 1];
        let first = if inside || self.linear_extrapolate || n == 2 {
            self.x[1..n - 1].partition_point(|&knot| knot <= x)
        } else if x < self.x[0] {
            0
        } else {
            n - 3
        };
        Interval {
            knots: &self.x,
            first,
            x,
            polynomial: if inside {
                Polynomial::Segment
            } else if self.linear_extrapolate || n == 2 {
                Polynomial::Line
            } else {
                Polynomial::Parabola
            },
        }
    }
}

#[derive(Clone, Copy)]
enum Polynomial {
    /// Cubic or linear segment between knots `first` and `first + 1`.
    Segment,
    /// Line through knots `first` and `first + 1`.
    Line,
    /// Parabola through knots `first` to `first + 2`.
    Parabola,
}

struct Interval<'a> {
    knots: &'a [f64],
    first: usize,
    x: f64,
    polynomial: Polynomial,
}

impl Interval<'_> {
    /// Returns the value at `x` and its derivatives of order 1, 2 and 3.
    fn derivatives(&self, row: &Coefficients) -> [f64; 4] {
        let k = self.first;
        let (x0, x1) = (self.knots[k], self.knots[k + 1]);
        let (y0, y1) = (row.y[k], row.y[k + 1]);
        let h = x1 - x0;
        let m = (y1 - y0) / h;
        let u = self.x - x0;
        let (b, c, d) = match self.polynomial {
            // y0 + b u + c u^2 + d u^3 with the slopes b at x0 and t1 at x1.
            Polynomial::Segment if !row.slopes.is_empty() => {
                let (t0, t1) = (row.slopes[k], row.slopes[k + 1]);
                (
                    t0,
                    (3.0 * m - 2.0 * t0 - t1) / h,
                    (t0 + t1 - 2.0 * m) / (h * h),
                )
            }
            Polynomial::Segment | Polynomial::Line => (m, 0.0, 0.0),
            Polynomial::Parabola => {
                // Newton's divided differences about x0.
                let x2 = self.knots[k + 2];
                let bend = ((row.y[k + 2] - y1) / (x2 - x1) - m) / (x2 - x0);
                (m - bend * h, bend, 0.0)
            }
        };
        [
            y0 + u * (b + u * (c + u * d)),
            b + u * (2.0 * c + u * 3.0 * d),
            2.0 * c + 6.0 * d * u,
            6.0 * d,
        ]
    }
}
