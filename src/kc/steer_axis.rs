//! Steer axis of a wheel, and the quantities derived from it.
//!
//! In the formulas, u is the unit direction of the axis. Axes: X rearward, Y right, Z up; angles in radians. Source of every formula: guide
//! page `kc`, section "Steer axis".

use super::Side;
use admire_solver::mechanics::{Vec3, Vec6};

/// Steer axis of a wheel, in general a screw axis.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct SteerAxis {
    /// Point on the axis.
    pub point: Vec3,
    /// Unit direction, pointing up.
    pub direction: Vec3,
    /// Advance along the axis per radian, a length; zero for the geometric axis. Scrub and trail are exact only if the pitch is small.
    pub pitch: f64,
}

impl SteerAxis {
    /// Returns the steer axis through two points. `None` if the points coincide or are at the same height.
    pub(crate) fn through(a: &Vec3, b: &Vec3) -> Option<Self> {
        Self::upward(*a, (b - a).try_normalize(0.0)?, 0.0)
    }

    /// Returns the screw axis of a motion of the carrier: velocity `v` of the point `centre`, rotation `w`. `None` without rotation, or if
    /// the axis is level.
    ///
    /// The point is `K = P + (w x v) / (w . w)`, the pitch `(w . v) / (w . w)`.
    pub(crate) fn of_motion(centre: &Vec3, motion: &Vec6) -> Option<Self> {
        let v: Vec3 = motion.fixed_rows::<3>(0).into();
        let w: Vec3 = motion.fixed_rows::<3>(3).into();
        let square = w.norm_squared();
        if !(square > 0.0 && square.is_finite()) {
            return None;
        }
        let point = centre + w.cross(&v) / square;
        Self::upward(point, w / square.sqrt(), w.dot(&v) / square)
    }

    /// Returns the mirror image about Y = 0. The pitch changes sign, because the mirrored screw is of the opposite hand.
    #[must_use]
    pub(crate) fn mirrored(&self) -> Self {
        let image = |v: &Vec3| Vec3::new(v.x, -v.y, v.z);
        Self {
            point: image(&self.point),
            direction: image(&self.direction),
            pitch: -self.pitch,
        }
    }

    fn upward(point: Vec3, direction: Vec3, pitch: f64) -> Option<Self> {
        // Caster is undefined for a level axis.
        (direction.z.abs() > 1e-9).then(|| Self {
            point,
            direction: direction * direction.z.signum(),
            pitch,
        })
    }

    /// Returns caster `atan(u.x / u.z)`, positive if the axis leans rearward; u is the direction of the axis.
    pub fn caster(&self) -> f64 {
        libm::atan(self.direction.x / self.direction.z)
    }

    /// Returns kingpin inclination, positive if the axis leans inboard. With the axis direction u, it is `atan(u.y / u.z)` on the left, and
    /// the same with opposite sign on the right.
    pub fn kingpin_inclination(&self, side: Side) -> f64 {
        libm::atan(-side.outboard_sign() * self.direction.y / self.direction.z)
    }

    /// Returns the point of the axis nearest to the wheel centre.
    pub fn location(&self, centre: &Vec3) -> Vec3 {
        let u = &self.direction;
        self.point + u * u.dot(&(centre - self.point))
    }

    /// Returns the point where the axis meets the road. The road is the plane through the contact point, normal to `normal`.
    pub fn road_point(&self, contact: &Vec3, normal: &Vec3) -> Vec3 {
        let along = normal.dot(&(contact - self.point)) / normal.dot(&self.direction);
        self.point + self.direction * along
    }

    /// Returns (scrub radius, caster trail), positive inboard and forward. They are the components of `I - C` across and along the heading
    /// of the wheel, from the contact point C to the point I where the axis meets the road. `steer` is positive to the right.
    pub fn scrub_and_trail(
        &self,
        side: Side,
        contact: &Vec3,
        normal: &Vec3,
        steer: f64,
    ) -> (f64, f64) {
        let d = self.road_point(contact, normal) - contact;
        // Forward and right axes of the road, rotated by the steer angle.
        let right = Vec3::new(0.0, normal.z, -normal.y);
        let forward = Vec3::new(-1.0, 0.0, 0.0);
        let (s, c) = libm::sincos(steer);
        let heading = forward * c + right * s;
        let lateral = right * c - forward * s;
        (-side.outboard_sign() * d.dot(&lateral), d.dot(&heading))
    }

    /// Returns the distance between the wheel centre and the axis.
    pub fn offset(&self, centre: &Vec3) -> f64 {
        (centre - self.location(centre)).norm()
    }

    /// Returns the (lateral, longitudinal) components of the offset `d = P - K` from the nearest point K of the axis to the wheel centre P.
    /// Let u be the axis direction, and e the normalised component of the spin axis normal to u. The lateral component is `d . e`, positive
    /// outboard. The longitudinal component, positive rearward, is `d . (e x u)` on the right, and the same with opposite sign on the left.
    pub fn offset_parts(&self, side: Side, centre: &Vec3, spin: &Vec3) -> (f64, f64) {
        let u = &self.direction;
        let across = spin - u * u.dot(spin);
        let Some(e) = across.try_normalize(0.0) else {
            return (f64::NAN, f64::NAN);
        };
        let d = centre - self.location(centre);
        (d.dot(&e), side.outboard_sign() * d.dot(&e.cross(u)))
    }

    /// Returns the lever of a vertical load at the contact point about the axis: `scrub tan(caster) + trail tan(kingpin)`.
    pub(crate) fn load_lever(&self, side: Side, scrub: f64, trail: f64) -> f64 {
        scrub * libm::tan(self.caster()) + trail * libm::tan(self.kingpin_inclination(side))
    }

    /// Returns `hub_lead` as Adams/Car writes it: [`Self::load_lever`] with the angles in radians mistaken for degrees.
    pub fn hub_lead(&self, side: Side, scrub: f64, trail: f64) -> f64 {
        let tan = |angle: f64| libm::tan(angle.to_radians());
        scrub * tan(self.caster()) + trail * tan(self.kingpin_inclination(side))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// In the golden state, the axis through the foot point with the caster and kingpin angles of Adams/Car also gives its road point,
    /// scrub and trail.
    #[test]
    fn golden_axis() {
        let (caster, kingpin): (f64, f64) = (-0.398819456, 0.428462047);
        let direction = Vec3::new(caster.tan(), kingpin.tan(), 1.0).normalize();
        let centre = Vec3::new(3002.999997352012, -770.0002984255863, 160.93);
        let axis = SteerAxis {
            point: Vec3::new(3007.90612, -695.876785, 129.140727),
            direction,
            pitch: 0.0,
        };
        assert!((axis.caster() - caster).abs() < 1e-12);
        assert!((axis.kingpin_inclination(Side::Left) - kingpin).abs() < 1e-12);
        assert!((axis.location(&centre) - axis.point).norm() < 1e-4);
        let contact = Vec3::new(3002.999997, -770.0042913, -134.1329051);
        let at = axis.road_point(&contact, &Vec3::z());
        assert!((at - Vec3::new(3003.0 + 115.850241, -816.129885, contact.z)).norm() < 1e-4);
        let (scrub, trail) = axis.scrub_and_trail(Side::Left, &contact, &Vec3::z(), -1.33379878e-6);
        assert!((scrub + 46.1257485).abs() < 1e-4, "{scrub}");
        assert!((trail + 115.850182).abs() < 1e-4, "{trail}");
    }

    #[test]
    fn the_screw_axis_of_a_turn_is_its_axis() {
        let axis =
            SteerAxis::through(&Vec3::new(1.0, 2.0, 3.0), &Vec3::new(2.0, 4.0, 9.0)).unwrap();
        let centre = Vec3::new(-30.0, 50.0, 4.0);
        let v = axis.direction.cross(&(centre - axis.point)) + axis.direction * 0.7;
        let u = axis.direction;
        let motion = Vec6::new(v.x, v.y, v.z, u.x, u.y, u.z) * -3.0;
        let found = SteerAxis::of_motion(&centre, &motion).unwrap();
        assert!((found.direction - axis.direction).norm() < 1e-12);
        assert!((found.pitch - 0.7).abs() < 1e-12);
        assert!((found.point - axis.location(&centre)).norm() < 1e-11);
    }
}
