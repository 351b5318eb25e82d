use super::RotationSequence;
use crate::mechanics::{Mat3, Vec3};

/// Threshold for the sine (or cosine) of the middle angle. Below this threshold, the first and third axes coincide, and the whole rotation
/// is assigned to the first angle, as ADAMS does for PSI (guide/formats.md 4.1).
const PARALLEL: f64 = 1e-12;

impl RotationSequence {
    /// Body-fixed 3-1-3: PSI, THETA, PHI.
    pub(crate) const BODY_313: Self = Self::body([2, 0, 2]);
    /// Body-fixed 3-2-1: YAW, negative PITCH, ROLL.
    pub(crate) const BODY_321: Self = Self::body([2, 1, 0]);

    const fn body(axes: [usize; 3]) -> Self {
        Self {
            axes,
            space_fixed: false,
        }
    }

    /// Returns the number of components of an ORIENT type. The direction cosines have nine components; the available help does not state
    /// whether type 25 or type 26 denotes them, so both return 9.
    pub(crate) const fn components_of_orient(kind: u32) -> u32 {
        match kind {
            27 => 4,
            25 | 26 => 9,
            _ => 3,
        }
    }

    /// Returns the rotation sequence of an ORIENT type. Types 1 to 12 are body-fixed; types 13 to 24 are the same sequences about axes
    /// fixed in space.
    pub(crate) fn of_orient(kind: u32) -> Option<Self> {
        const AXES: [[usize; 3]; 12] = [
            [0, 1, 2],
            [1, 2, 0],
            [2, 0, 1],
            [0, 2, 1],
            [1, 0, 2],
            [2, 1, 0],
            [0, 1, 0],
            [0, 2, 0],
            [1, 0, 1],
            [1, 2, 1],
            [2, 0, 2],
            [2, 1, 2],
        ];
        let index = (kind as usize).checked_sub(1).filter(|&index| index < 24)?;
        Some(Self {
            axes: AXES[index % 12],
            space_fixed: index >= 12,
        })
    }

    /// Returns angle `which` of the rotation R, in radians, and its derivative with respect to a rotation vector `dtheta` in the base axes
    /// (`R <- exp(dtheta) R`).
    ///
    /// The middle angle lies in [0, pi] if the first and last axis are the same, otherwise in [-pi/2, pi/2]. Where the sequence is
    /// singular, the derivative is returned as zero.
    ///
    /// Body-fixed: `R = R_a(t1) R_b(t2) R_c(t3)`. For axes fixed in space, the order of the product is reversed.
    pub(crate) fn angle(self, R: &Mat3, which: usize) -> (f64, Vec3) {
        let ([a, b, c], which) = if self.space_fixed {
            let [a, b, c] = self.axes;
            ([c, b, a], 2 - which)
        } else {
            (self.axes, which)
        };
        let angles = body_angles(R, [a, b, c]);
        // dtheta = A1 dt1 + A2 dt2 + A3 dt3; the rows of the inverse are the dual basis.
        let axis1 = Vec3::ith(a, 1.0);
        let (sin, cos) = libm::sincos(angles[0]);
        let turned = Vec3::ith(b, 1.0);
        let axis2 = turned * cos + axis1.cross(&turned) * sin;
        let axis3: Vec3 = R.column(c).into();
        let volume = axis1.dot(&axis2.cross(&axis3));
        let dual = match which {
            0 => axis2.cross(&axis3),
            1 => axis3.cross(&axis1),
            _ => axis1.cross(&axis2),
        };
        let row = if volume.abs() < PARALLEL {
            Vec3::zeros()
        } else {
            dual / volume
        };
        (angles[which], row)
    }
}

fn body_angles(R: &Mat3, [a, b, c]: [usize; 3]) -> [f64; 3] {
    // Axis towards which b rotates about a: e_a x e_b = sign e_third.
    let third = 3 - a - b;
    let sign = if (b + 3 - a) % 3 == 1 { 1.0 } else { -1.0 };
    let (sin, cos, last) = if a == c {
        let sin = libm::hypot(R[(b, a)], R[(third, a)]);
        (sin, R[(a, a)], libm::atan2(R[(a, b)], sign * R[(a, third)]))
    } else {
        let cos = libm::hypot(R[(a, a)], R[(a, b)]);
        (
            sign * R[(a, c)],
            cos,
            libm::atan2(-sign * R[(a, b)], R[(a, a)]),
        )
    };
    let parallel = if a == c { sin } else { cos } < PARALLEL;
    if parallel {
        return [
            libm::atan2(sign * R[(third, b)], R[(b, b)]),
            libm::atan2(sin, cos),
            0.0,
        ];
    }
    let first = if a == c {
        libm::atan2(R[(b, a)], -sign * R[(third, a)])
    } else {
        libm::atan2(-sign * R[(b, c)], R[(c, c)])
    };
    [first, libm::atan2(sin, cos), last]
}
