use serde::Serialize;

use super::{Placed, Scene};
use admire_solver::mechanics::{Mat3, Pose, Vec3};

/// Wheel of the vehicle, drawn as a disc with its tyre.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Wheel {
    /// Index of the wheel carrier in [`Scene::parts`].
    pub part: usize,
    /// Wheel centre and wheel axes in the frame of the carrier: z is the spin axis.
    pub at: Placed,
    /// Unloaded radius of the tyre.
    pub radius: f64,
}

/// Tyre radius in metres of a wheel whose deck does not state one.
const USUAL_RADIUS: f64 = 0.31;
/// Plausible tyre radii in metres. They decide whether the distance of a load below the wheel centre counts as a tyre radius.
const RADII: std::ops::Range<f64> = 0.2..0.6;

impl Scene {
    /// Adds a wheel on a part. `local` holds the wheel centre and the spin axis (z) in the frame of the part. Without a radius, the lowest load below
    /// the wheel centre counts as the contact patch. `metre` is the length of a metre in units of the scene.
    pub fn add_wheel(&mut self, part: usize, local: &Pose, radius: Option<f64>, metre: f64) {
        let radius = radius.unwrap_or_else(|| {
            let up = Vec3::from(self.up);
            let height = |part: usize, p: Vec3| self.design(part).point(&p).dot(&up);
            let centre = height(part, local.p);
            let forces = self.objects.iter();
            let forces = forces.filter(|object| object.kind == super::Kind::Force);
            let depths = forces.map(|object| {
                let [x, y, z, ..] = object.i.at.0;
                (centre - height(object.i.part, Vec3::new(x, y, z))) / metre
            });
            let patch = depths
                .filter(|depth| RADII.contains(depth))
                .reduce(f64::max);
            if patch.is_none() {
                let length = &self.length;
                let note = format!(
                    "The deck has no tyre: wheels are drawn with a radius of {} {length}.",
                    USUAL_RADIUS * metre
                );
                if !self.notes.contains(&note) {
                    self.notes.push(note);
                }
            }
            patch.unwrap_or(USUAL_RADIUS) * metre
        });
        self.wheels.push(Wheel {
            part,
            at: Placed::new(local),
            radius,
        });
    }

    /// Turns the front view to the axis of travel, which is normal to the spin axis of a wheel. `spin` is in ground axes.
    pub fn look_along(&mut self, spin: &Vec3) {
        self.along = super::along(&Vec3::from(self.up), spin);
    }

    /// Returns the design pose of a part.
    fn design(&self, part: usize) -> Pose {
        let [x, y, z, w, i, j, k] = self.parts[part].design.0;
        let q = nalgebra::UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(w, i, j, k));
        Pose {
            p: Vec3::new(x, y, z),
            R: q.to_rotation_matrix().into_inner(),
        }
    }
}

/// Returns the pose of a wheel in the frame of its marker's part. The origin is at the marker, and z is the spin axis. `axis` is the axis of the
/// marker that is the spin axis.
pub(crate) fn on_marker(marker: &Pose, axis: usize) -> Pose {
    let columns = [axis + 1, axis + 2, axis].map(|k| marker.R.column(k % 3).into_owned());
    Pose {
        p: marker.p,
        R: Mat3::from_columns(&columns),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// If the y axis of a marker is the spin axis, the wheel still has a right-handed frame with the spin axis as z.
    #[test]
    fn the_spin_axis_is_z() {
        let local = on_marker(&Pose::identity(), 1);
        assert_eq!(local.R.column(2).into_owned(), Vec3::y());
        assert!((local.R.determinant() - 1.0).abs() < 1e-12);
    }
}
