//! The chain rule from the relative motion of two markers to part coordinates: the one place that has it.
//!
//! A wrench w = (F, T) on part A at the I origin, with its opposite on part B at the same point, is given in the axes of a frame
//! on part C that sees I move. With r, s_B, s_C from the origins of A, B, C to the I origin, and q = (dp, dphi) in ground axes,
//!
//! ```text
//! motion of I in C     m  = X_r q_A - X_sC q_C,       X_r = [1, -r x; 0, 1]
//! change of w          dw = D m + (dphi_C x F, dphi_C x T)
//! balance of A         X_r' w,    balance of B  -X_sB' w
//! change of the arms   d(r x F)   = (dphi_A x r) x F
//!                      d(s_B x F) = (dp_A + dphi_A x r - dp_B) x F
//! ```

use crate::mechanics::{Mat3, Mat6, Vec3, Vec6, skew};

/// Receives the entries of the Jacobian. Entries of one place add up.
pub(crate) trait Sink {
    /// False if nobody wants the entries: they need not be worked out.
    const WANTED: bool = true;

    /// Adds to one entry.
    fn add(&mut self, row: usize, column: usize, value: f64);
}

/// Nobody wants the Jacobian.
pub(crate) struct NoJacobian;

impl Sink for NoJacobian {
    const WANTED: bool = false;
    fn add(&mut self, _: usize, _: usize, _: f64) {}
}

/// Place of a body among the unknowns.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub first: usize,
    pub freedoms: usize,
}

/// Turns J-axes derivatives into ground axes: blockdiag(R) D blockdiag(R').
pub(crate) fn turn(R: &Mat3, D: &Mat6) -> Mat6 {
    let mut out = Mat6::zeros();
    let Rt = R.transpose();
    for i in [0, 3] {
        for j in [0, 3] {
            let block = R * D.fixed_view::<3, 3>(i, j) * Rt;
            out.fixed_view_mut::<3, 3>(i, j).copy_from(&block);
        }
    }
    out
}

/// `X_r' M`: the lower rows gain `r x` the upper rows.
fn moved_rows(r: &Mat3, M: &Mat6) -> Mat6 {
    let mut out = *M;
    let lower = M.fixed_view::<3, 6>(3, 0) + r * M.fixed_view::<3, 6>(0, 0);
    out.fixed_view_mut::<3, 6>(3, 0).copy_from(&lower);
    out
}

/// `M X_r`: the right columns lose the left columns times `r x`.
pub(crate) fn moved_columns(M: &Mat6, r: &Mat3) -> Mat6 {
    let mut out = *M;
    let right = M.fixed_view::<6, 3>(0, 3) - M.fixed_view::<6, 3>(0, 0) * r;
    out.fixed_view_mut::<6, 3>(0, 3).copy_from(&right);
    out
}

/// Adds a block to the Jacobian, cut to the freedoms of the bodies.
pub(crate) fn add_block<S: Sink>(sink: &mut S, row: Place, column: Place, block: &Mat6) {
    for j in 0..column.freedoms {
        for i in 0..row.freedoms {
            sink.add(row.first + i, column.first + j, block[(i, j)]);
        }
    }
}

/// Adds a wrench at an arm to the balance of a body.
pub(crate) fn add_wrench(g: &mut [f64], place: Place, sign: f64, F: &Vec3, T: &Vec3, arm: &Vec3) {
    if place.freedoms == 0 {
        return;
    }
    for k in 0..3 {
        g[place.first + k] += sign * F[k];
    }
    if place.freedoms == 6 {
        let torque = T + arm.cross(F);
        for k in 0..3 {
            g[place.first + 3 + k] += sign * torque[k];
        }
    }
}

/// The wrench of one element and all the chain rule needs of its surroundings. Ground axes throughout.
pub(crate) struct Acting<'a> {
    pub F: Vec3,
    pub T: Vec3,
    /// Derivative by the motion of I as C sees it; `None` if the wrench is fixed in C.
    pub D: Option<&'a Mat6>,
    pub a: Place,
    pub r: Vec3,
    pub b: Option<(Place, Vec3)>,
    pub c: Option<(Place, Vec3)>,
}

impl Acting<'_> {
    /// Adds the wrench to the balances and its derivative to the Jacobian.
    pub fn add<S: Sink>(&self, g: &mut [f64], sink: &mut S) {
        add_wrench(g, self.a, 1.0, &self.F, &self.T, &self.r);
        if let Some((b, s)) = &self.b {
            add_wrench(g, *b, -1.0, &self.F, &self.T, s);
        }
        if !S::WANTED {
            return;
        }
        let (r, Fx, Tx) = (skew(&self.r), skew(&self.F), skew(&self.T));
        let b = self.b.filter(|(place, _)| place.freedoms > 0);
        let c = self.c.filter(|(place, _)| place.freedoms > 0);
        let (on_a, on_b) = (self.a.freedoms > 0, b.is_some());
        let s_b = b.map_or_else(Mat3::zeros, |(_, s)| skew(&s));

        // dw by q_A and the turning of the arms.
        if on_a {
            let N = self.D.map_or_else(Mat6::zeros, |D| moved_columns(D, &r));
            let mut block = moved_rows(&r, &N);
            add33(&mut block, 3, 3, &(Fx * r));
            add_block(sink, self.a, self.a, &block);
            if let Some((place, _)) = b {
                let mut block = -moved_rows(&s_b, &N);
                add33(&mut block, 3, 0, &Fx);
                add33(&mut block, 3, 3, &(-Fx * r));
                add_block(sink, place, self.a, &block);
            }
        }
        if let Some((place, s)) = c {
            let mut N = self
                .D
                .map_or_else(Mat6::zeros, |D| -moved_columns(D, &skew(&s)));
            add33(&mut N, 0, 3, &-Fx);
            add33(&mut N, 3, 3, &-Tx);
            if on_a {
                add_block(sink, self.a, place, &moved_rows(&r, &N));
            }
            if let Some((row, _)) = b {
                add_block(sink, row, place, &-moved_rows(&s_b, &N));
            }
        }
        if on_b && let Some((place, _)) = b {
            let mut block = Mat6::zeros();
            add33(&mut block, 3, 0, &-Fx);
            add_block(sink, place, place, &block);
        }
    }

    /// The change of F and T when marker I moves by (`dp_i`, `dphi_i`) and marker C by (`dp_c`, `dphi_c`), both in ground axes.
    pub fn change(&self, i: &Twist, c: &Twist, d: &Vec3) -> (Vec3, Vec3) {
        let mut dF = c.turn.cross(&self.F);
        let mut dT = c.turn.cross(&self.T);
        if let Some(D) = self.D {
            // d = p_i - p_c; what C sees of the motion of I.
            let dp = i.shift - c.shift - c.turn.cross(d);
            let dphi = i.turn - c.turn;
            let m = Vec6::new(dp.x, dp.y, dp.z, dphi.x, dphi.y, dphi.z);
            let dw = D * m;
            dF += dw.fixed_rows::<3>(0);
            dT += dw.fixed_rows::<3>(3);
        }
        (dF, dT)
    }
}

/// A small motion of a frame, in ground axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Twist {
    /// Displacement of the origin.
    pub shift: Vec3,
    /// Rotation vector.
    pub turn: Vec3,
}

impl Twist {
    /// No motion.
    pub const fn zero() -> Self {
        Self {
            shift: Vec3::new(0.0, 0.0, 0.0),
            turn: Vec3::new(0.0, 0.0, 0.0),
        }
    }
}

/// Adds what the motion of another marker (on `b`, arm `r`) as seen from C changes of a wrench, to the balances in `rows` (body, sign,
/// arm of the wrench).
pub(crate) fn add_cross<S: Sink>(
    sink: &mut S,
    rows: &[(Place, f64, Vec3)],
    D: &Mat6,
    (b, r): (Place, &Vec3),
    (c, s): (Place, &Vec3),
) {
    let by_b = moved_columns(D, &skew(r));
    let by_c = -moved_columns(D, &skew(s));
    for (place, sign, arm) in rows {
        let arm = skew(arm);
        add_block(sink, *place, b, &(moved_rows(&arm, &by_b) * *sign));
        add_block(sink, *place, c, &(moved_rows(&arm, &by_c) * *sign));
    }
}

fn add33(M: &mut Mat6, i: usize, j: usize, block: &Mat3) {
    let mut view = M.fixed_view_mut::<3, 3>(i, j);
    view += block;
}
