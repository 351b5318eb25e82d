//! Offset between the measuring frame and the frame of the model, estimated from a common rigid motion of all marks.

use super::orientation::absolute_orientation;
use admire_solver::mechanics::{Vec3, log};

/// Largest rms deviation of the marks after the rigid motion, relative to the deviation before it, at which the readings may be in another
/// frame. Initial stiffnesses that are wrong by a factor of 100 give a larger ratio.
const ALIKE: f64 = 0.6;
/// Largest shift of a measuring frame that the tolerances still absorb, in metres.
const NEAR_METRES: f64 = 0.004;
/// Largest rotation of a measuring frame that the tolerances still absorb, in degrees.
const NEAR_DEGREES: f64 = 0.5;

/// Rigid motion that moves the marks from their positions in a model to their measured positions, by least squares.
#[derive(Clone, PartialEq, Debug)]
pub struct FramePlace {
    /// Displacement of the centroid of the marks, in ground axes and in the deck's length unit.
    pub shift: Vec3,
    /// Rotation angle of the motion, in degrees.
    pub degrees: f64,
    /// Ratio of the rms deviations of the marks after and before the motion.
    pub left: f64,
}

impl FramePlace {
    /// Fits the rigid motion. `model` holds the positions of the marks in the model, `read` the measured positions of the same marks. Returns
    /// `None` if the marks do not determine the motion.
    pub fn of(model: &[Vec3], read: &[Vec3]) -> Option<Self> {
        let found = absolute_orientation(model, read, 1.0).ok()?;
        let off = model.iter().zip(read).map(|(a, b)| (a - b).norm_squared());
        let before: f64 = off.sum();
        let after: f64 = found.residuals.iter().map(Vec3::norm_squared).sum();
        let centre = model.iter().sum::<Vec3>() / model.len() as f64;
        Some(Self {
            shift: found.pose.point(&centre) - centre,
            degrees: log(&found.pose.R).norm().to_degrees(),
            left: (after / before).sqrt(),
        })
    }

    /// Returns true if the motion exceeds this distance in metres or this angle in degrees; `length` is the deck's length unit in metres.
    pub fn is_beyond(&self, metres: f64, degrees: f64, length: f64) -> bool {
        self.shift.norm() * length > metres || self.degrees > degrees
    }

    /// Returns true if the readings are in a frame that differs from the frame of the deck. `length` is the deck's length unit in metres.
    pub fn is_another(&self, length: f64) -> bool {
        self.left <= ALIKE && self.is_beyond(NEAR_METRES, NEAR_DEGREES, length)
    }
}
