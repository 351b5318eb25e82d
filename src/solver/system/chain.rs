//! Small matrices of the chain rule, and insertion of blocks into the Jacobian. The chain rule is explained in `contribution`.

use crate::linear::Sink;
use crate::mechanics::{Mat3, Mat6, Vec3, Vec6};

/// Infinitesimal motion of a frame, in ground axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Twist {
    /// Displacement of the origin of the frame.
    pub shift: Vec3,
    /// Rotation vector of the frame.
    pub turn: Vec3,
}

impl Twist {
    /// Returns zero motion.
    pub(crate) const fn zero() -> Self {
        Self {
            shift: Vec3::new(0.0, 0.0, 0.0),
            turn: Vec3::new(0.0, 0.0, 0.0),
        }
    }
}

/// Columns of a body among the unknowns: the first column, and the number of degrees of freedom.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BodyColumns {
    pub first: usize,
    pub freedoms: usize,
}

/// Transforms a 6 by 6 derivative D from J axes to ground axes: blockdiag(R) D blockdiag(R').
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

/// Returns `X_r' M` with `X_r = [1, -r x; 0, 1]`: the upper rows of M, multiplied by `r x`, are added to the lower rows.
pub(super) fn moved_rows(r: &Mat3, M: &Mat6) -> Mat6 {
    let mut out = *M;
    let lower = M.fixed_view::<3, 6>(3, 0) + r * M.fixed_view::<3, 6>(0, 0);
    out.fixed_view_mut::<3, 6>(3, 0).copy_from(&lower);
    out
}

/// Returns `M X_r` with `X_r = [1, -r x; 0, 1]`: the left columns of M, multiplied by `r x`, are subtracted from the right columns.
pub(super) fn moved_columns(M: &Mat6, r: &Mat3) -> Mat6 {
    let mut out = *M;
    let right = M.fixed_view::<6, 3>(0, 3) - M.fixed_view::<6, 3>(0, 0) * r;
    out.fixed_view_mut::<6, 3>(0, 3).copy_from(&right);
    out
}

/// Adds a block to the Jacobian, truncated to the degrees of freedom of the bodies.
pub(crate) fn add_block<S: Sink>(
    sink: &mut S,
    row: BodyColumns,
    column: BodyColumns,
    block: &Mat6,
) {
    for (j, values) in block.as_slice().chunks_exact(6).enumerate() {
        if j < column.freedoms {
            sink.add_column(row.first, column.first + j, &values[..row.freedoms]);
        }
    }
}

/// Adds a wrench that acts at the end of an arm to the force and torque balance of a body.
pub(crate) fn add_wrench(
    g: &mut [f64],
    place: BodyColumns,
    sign: f64,
    F: &Vec3,
    T: &Vec3,
    arm: &Vec3,
) {
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

/// Returns the motion of a marker relative to a frame: (translation, rotation) in ground axes. Marker and frame are each given as a twist
/// and an origin.
pub(super) fn seen_motion(i: &Twist, origin_i: &Vec3, frame: Option<(Twist, &Vec3)>) -> Vec6 {
    let (mut dp, mut dphi) = (i.shift, i.turn);
    if let Some((c, origin)) = frame {
        dp -= c.shift + c.turn.cross(&(origin_i - origin));
        dphi -= c.turn;
    }
    Vec6::new(dp.x, dp.y, dp.z, dphi.x, dphi.y, dphi.z)
}

pub(super) fn add33(M: &mut Mat6, i: usize, j: usize, block: &Mat3) {
    let mut view = M.fixed_view_mut::<3, 3>(i, j);
    view += block;
}
