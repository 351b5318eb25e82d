//! Angles and displacements that follow from the position of a wheel alone.
//!
//! All vectors are in the axes of [`Frame`](super::Frame): X rearward, Y to the right, Z up. `o` is the unit spin axis pointing outboard.
//! Angles are in radians. Source of every formula: guide page `kc`, section "Geometry".

use super::Side;
use admire_solver::mechanics::{Mat3, Vec3};

/// Position and orientation of a wheel in one state.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Wheel {
    /// Side of the vehicle.
    pub side: Side,
    /// Wheel centre P.
    pub centre: Vec3,
    /// Unit spin axis o, pointing outboard.
    pub spin: Vec3,
    /// Rotation of the carrier since design: `R R_design^T`.
    pub turn: Mat3,
}

impl Wheel {
    /// Returns the mirror image about Y = 0.
    #[must_use]
    pub(crate) fn mirrored(&self) -> Self {
        let image = Mat3::from_diagonal(&Vec3::new(1.0, -1.0, 1.0));
        Self {
            side: self.side.other(),
            centre: image * self.centre,
            spin: image * self.spin,
            turn: image * self.turn * image,
        }
    }
}

/// Returns the toe angle between the wheel plane and the vehicle's longitudinal plane, positive for toe-in: `atan(-o.x / |o.y|)`.
pub fn toe(o: &Vec3) -> f64 {
    libm::atan(-o.x / o.y.abs())
}

/// Returns the camber angle relative to the vehicle's vertical, positive with the top outboard: `-asin(o.z)`.
pub fn camber(o: &Vec3) -> f64 {
    -libm::asin(o.z.clamp(-1.0, 1.0))
}

/// Returns the inclination relative to the road normal, positive with the top leaning to the vehicle's left on both sides. It is
/// `-asin(o . n)` for the left wheel and `asin(o . n)` for the right wheel.
pub fn inclination(side: Side, o: &Vec3, normal: &Vec3) -> f64 {
    side.outboard_sign() * libm::asin(o.dot(normal).clamp(-1.0, 1.0))
}

/// Returns the steer angle about the road normal, positive to the right on both sides: `atan(o.x / o.ey)`, where ey is the road's lateral
/// axis.
pub fn steer(o: &Vec3, normal: &Vec3) -> f64 {
    let lateral = Vec3::new(0.0, normal.z, -normal.y);
    libm::atan(o.x / o.dot(&lateral))
}

/// Returns the pitch of the carrier since design, positive with the top rearward: `-atan(A31 / A11)`.
pub fn side_view_angle(turn: &Mat3) -> f64 {
    -libm::atan(turn[(2, 0)] / turn[(0, 0)])
}

/// Returns the point on the spin axis 1000 length units outboard of the wheel centre; Adams/Car calls it `wheel_axis`.
pub(crate) fn axis_point(wheel: &Wheel) -> Vec3 {
    wheel.centre + wheel.spin * 1000.0
}

/// Returns the rates of toe, camber and steer on a level road for a rotation rate `w` of the wheel, from `do = w x o`. The toe rate differs
/// from the rotation rate about z: a cambered wheel that pitches changes its toe.
pub fn angle_rates(side: Side, o: &Vec3, w: &Vec3) -> AngleRates {
    let d = w.cross(o);
    // Derivative of |o.y|.
    let (m, dm) = (o.y.abs(), d.y * o.y.signum());
    let toe = -(d.x * m - o.x * dm) / (m * m + o.x * o.x);
    AngleRates {
        toe,
        camber: -d.z / (1.0 - o.z * o.z).sqrt(),
        steer: -side.outboard_sign() * toe,
    }
}

/// Rates of the toe, camber and steer angles.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct AngleRates {
    /// Rate of [`toe`].
    pub toe: f64,
    /// Rate of [`camber`].
    pub camber: f64,
    /// Rate of [`steer`].
    pub steer: f64,
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_solver::mechanics::exp;

    /// Left wheel of a real Adams/Car axle at design, the golden state.
    #[test]
    fn golden_angles() {
        let o = Vec3::new(
            1.3337987822204048e-6,
            -0.9999999999075484,
            1.3532336586056393e-5,
        );
        assert!((toe(&o) + 1.33379878e-6).abs() < 1e-14);
        assert!((camber(&o) + 1.35323366e-5).abs() < 1e-13);
        assert!((steer(&o, &Vec3::z()) + 1.33379878e-6).abs() < 1e-14);
        assert!((inclination(Side::Left, &o, &Vec3::z()) + 1.35323366e-5).abs() < 1e-13);
    }

    /// A right wheel steered to the right toes out. With its top outboard it leans to the right.
    #[test]
    fn signs_of_the_right_wheel() {
        let o = Vec3::new(0.01, 1.0, -0.02).normalize();
        assert!(toe(&o) < 0.0 && steer(&o, &Vec3::z()) > 0.0);
        assert!(camber(&o) > 0.0 && inclination(Side::Right, &o, &Vec3::z()) < 0.0);
    }

    #[test]
    fn rates_are_the_derivatives() {
        for side in Side::BOTH {
            let o = Vec3::new(0.03, side.outboard_sign(), -0.07).normalize();
            let w = Vec3::new(0.3, -0.8, 0.5);
            let h = 1e-5;
            let difference = |f: &dyn Fn(&Vec3) -> f64| {
                (f(&(exp(&(w * h)) * o)) - f(&(exp(&(w * -h)) * o))) / (2.0 * h)
            };
            let rates = angle_rates(side, &o, &w);
            assert!((difference(&toe) - rates.toe).abs() < 1e-9);
            assert!((difference(&camber) - rates.camber).abs() < 1e-9);
            assert!((difference(&|o| steer(o, &Vec3::z())) - rates.steer).abs() < 1e-9);
        }
    }
}
