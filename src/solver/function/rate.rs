//! Velocities and accelerations of markers: the value, and its derivatives with respect to position, velocity and acceleration of each
//! marker.
//!
//! The module depends on the motion of the markers only. It is independent of the parts that carry the markers and of the part coordinates.

use super::{RateAxis, RateKind, RateMeasure};
use crate::mechanics::{Pose, Vec3};

/// Frame with its velocity and acceleration, in ground axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MovingFrame {
    /// Pose of the frame.
    pub pose: Pose,
    /// Velocity of the origin of the frame.
    pub v: Vec3,
    /// Angular velocity of the frame.
    pub w: Vec3,
    /// Acceleration of the origin of the frame.
    pub a: Vec3,
    /// Angular acceleration of the frame.
    pub b: Vec3,
}

impl MovingFrame {
    /// Returns the ground frame, which is at rest.
    pub(crate) fn ground() -> Self {
        Self {
            pose: Pose::identity(),
            v: Vec3::zeros(),
            w: Vec3::zeros(),
            a: Vec3::zeros(),
            b: Vec3::zeros(),
        }
    }
}

/// Derivatives with respect to the motion of one marker: the displacement of its origin, its rotation vector, and the four motion vectors
/// of [`MovingFrame`].
#[derive(Clone, Copy, PartialEq, Debug)]
#[allow(missing_docs)] // The letters are those of `MovingFrame`.
pub struct ByMotion {
    pub shift: Vec3,
    pub turn: Vec3,
    pub v: Vec3,
    pub w: Vec3,
    pub a: Vec3,
    pub b: Vec3,
}

impl Default for ByMotion {
    fn default() -> Self {
        let zero = Vec3::zeros();
        Self {
            shift: zero,
            turn: zero,
            v: zero,
            w: zero,
            a: zero,
            b: zero,
        }
    }
}

/// Velocity or acceleration with its derivatives with respect to the motion of I, J, K, L. The caller must omit the derivatives of absent
/// markers.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MeasuredRate {
    /// Value of the velocity or acceleration.
    pub value: f64,
    /// Derivatives with respect to the motion of I, J, K, L.
    pub by: [ByMotion; 4],
}

/// Evaluates a velocity or acceleration. For an absent marker, pass [`MovingFrame::ground`].
///
/// With d = p_i - p_j, and w and b the angular velocity and acceleration of L (the frame of the time derivative), the measured vector u is:
/// - velocity: `u = v_i - v_j - w x d`;
/// - angular velocity: `u = w_i - w_j`;
/// - acceleration: `u = a_i - a_j - b x d - 2 w x (v_i - v_j) + w x (w x d)`;
/// - angular acceleration: `u = b_i - b_j - w x (w_i - w_j)`.
///
/// The value is the component of u along an axis of K, the magnitude of u, or (VR) the component of u along d. Where u or d vanishes, the
/// derivative of its magnitude or direction is returned as zero. Source: Adams Solver help, `cfunc_vx`, `cfunc_accx`, `cfunc_wdtx`; the
/// formulas follow from the kinematics of a moving frame.
pub fn evaluate(measure: &RateMeasure, [i, j, k, l]: [&MovingFrame; 4]) -> MeasuredRate {
    let d = i.pose.p - j.pose.p;
    let v = i.v - j.v;
    let turning = i.w - j.w;
    let w = l.w;
    let u: Vec3 = match measure.kind {
        RateKind::Velocity => v - w.cross(&d),
        RateKind::AngularVelocity => turning,
        RateKind::Acceleration => {
            i.a - j.a - l.b.cross(&d) - 2.0 * w.cross(&v) + w.cross(&w.cross(&d))
        }
        RateKind::AngularAcceleration => i.b - j.b - w.cross(&turning),
    };
    let mut by = [ByMotion::default(); 4];
    // The value is e . u. The derivatives that come from the change of e are set here.
    let (value, e) = match measure.axis {
        RateAxis::Axis(axis) => {
            let e: Vec3 = k.pose.R.column(axis).into();
            by[2].turn = e.cross(&u);
            (u.dot(&e), e)
        }
        RateAxis::Magnitude => {
            let size = u.norm();
            (size, u.try_normalize(0.0).unwrap_or_else(Vec3::zeros))
        }
        RateAxis::Along => {
            let length = d.norm();
            let e = d.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
            let value = u.dot(&e);
            if length > 0.0 {
                let by_d = (u - e * value) / length;
                by[0].shift = by_d;
                by[1].shift = -by_d;
            }
            (value, e)
        }
    };
    match measure.kind {
        RateKind::Velocity => {
            (by[0].v, by[1].v) = (e, -e);
            by[3].w = -d.cross(&e);
            let by_d = -e.cross(&w);
            by[0].shift += by_d;
            by[1].shift -= by_d;
        }
        RateKind::AngularVelocity => (by[0].w, by[1].w) = (e, -e),
        RateKind::Acceleration => {
            (by[0].a, by[1].a) = (e, -e);
            let by_v = -2.0 * e.cross(&w);
            (by[0].v, by[1].v) = (by_v, -by_v);
            by[3].b = -d.cross(&e);
            by[3].w = -2.0 * v.cross(&e) + e * w.dot(&d) + d * e.dot(&w) - w * (2.0 * e.dot(&d));
            let by_d = -e.cross(&l.b) + w * e.dot(&w) - e * w.norm_squared();
            by[0].shift += by_d;
            by[1].shift -= by_d;
        }
        RateKind::AngularAcceleration => {
            (by[0].b, by[1].b) = (e, -e);
            let by_w = -e.cross(&w);
            (by[0].w, by[1].w) = (by_w, -by_w);
            by[3].w = -turning.cross(&e);
        }
    }
    MeasuredRate { value, by }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mechanics::exp;

    fn frame(seed: f64) -> MovingFrame {
        let vector = |k: f64| {
            Vec3::new(
                (1.3 * seed + k).sin(),
                (0.7 * seed - 2.0 * k).cos(),
                (2.1 * seed + 0.4 * k).sin(),
            )
        };
        MovingFrame {
            pose: Pose {
                p: vector(1.0),
                R: exp(&vector(2.0)),
            },
            v: vector(3.0),
            w: vector(4.0),
            a: vector(5.0),
            b: vector(6.0),
        }
    }

    fn moved(frame: &MovingFrame, freedom: usize, h: f64) -> MovingFrame {
        let mut new = *frame;
        let step = Vec3::ith(freedom % 3, h);
        match freedom / 3 {
            0 => new.pose.p += step,
            1 => new.pose.R = exp(&step) * new.pose.R,
            2 => new.v += step,
            3 => new.w += step,
            4 => new.a += step,
            _ => new.b += step,
        }
        new
    }

    #[test]
    fn derivatives_are_those_of_central_differences() {
        use RateKind::{Acceleration, AngularAcceleration, AngularVelocity, Velocity};
        let frames = [frame(0.3), frame(1.9), frame(2.8), frame(4.1)];
        let mut measures = Vec::new();
        for kind in [Velocity, AngularVelocity, Acceleration, AngularAcceleration] {
            for axis in [0, 1, 2] {
                measures.push((kind, RateAxis::Axis(axis)));
            }
            measures.push((kind, RateAxis::Magnitude));
        }
        measures.push((Velocity, RateAxis::Along));
        for (kind, axis) in measures {
            let measure = RateMeasure {
                kind,
                axis,
                markers: [None; 4],
            };
            let at = |frames: &[MovingFrame; 4]| evaluate(&measure, frames.each_ref());
            let exact = at(&frames).by;
            for (which, by) in exact.iter().enumerate() {
                let all = [by.shift, by.turn, by.v, by.w, by.a, by.b];
                for freedom in 0..18 {
                    let value = |h: f64| {
                        let mut frames = frames;
                        frames[which] = moved(&frames[which], freedom, h);
                        at(&frames).value
                    };
                    let difference = (value(1e-6) - value(-1e-6)) / 2e-6;
                    let exact = all[freedom / 3][freedom % 3];
                    assert!(
                        (difference - exact).abs() < 1e-8,
                        "{kind:?} {axis:?} by {which}.{freedom}: {exact} and {difference}"
                    );
                }
            }
        }
    }

    /// For markers that move on curved paths, the rates equal the derivatives of the positions, taken in a rotating frame.
    #[test]
    fn rates_are_the_derivatives_of_what_the_frame_sees() {
        let (wl, h) = (Vec3::new(0.3, -0.8, 0.5), 1e-3);
        let path = |t: f64| Vec3::new((2.0 * t).sin(), t * t, (3.0 * t).cos());
        let at = 0.4;
        // L rotates about a fixed axis and J is ground; the position seen from L is R_l(t)' p(t).
        let seen = |t: f64| exp(&(wl * t)).transpose() * path(t);
        let R = exp(&(wl * at));
        let rate = |f: &dyn Fn(f64) -> Vec3| {
            let d = |h: f64| (f(at + h) - f(at - h)) / (2.0 * h);
            (d(h / 2.0) * 4.0 - d(h)) / 3.0
        };
        let second = |f: &dyn Fn(f64) -> Vec3| {
            let d = |h: f64| (f(at + h) - f(at) * 2.0 + f(at - h)) / (h * h);
            (d(h / 2.0) * 4.0 - d(h)) / 3.0
        };
        let i = MovingFrame {
            pose: Pose {
                p: path(at),
                R: exp(&Vec3::zeros()),
            },
            v: rate(&path),
            a: second(&path),
            ..MovingFrame::ground()
        };
        let l = MovingFrame {
            w: wl,
            ..MovingFrame::ground()
        };
        let ground = MovingFrame::ground();
        for (kind, expected) in [
            (RateKind::Velocity, R * rate(&seen)),
            (RateKind::Acceleration, R * second(&seen)),
        ] {
            for axis in 0..3 {
                let measure = RateMeasure {
                    kind,
                    axis: RateAxis::Axis(axis),
                    markers: [None; 4],
                };
                let found = evaluate(&measure, [&i, &ground, &ground, &l]).value;
                assert!((found - expected[axis]).abs() < 1e-7, "{kind:?} {axis}");
            }
        }
    }
}
