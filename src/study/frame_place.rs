//! How marks sit from where a model has them, all alike: they are told in another frame.

use super::orientation::absolute_orientation;
use admire_solver::mechanics::{Vec3, log};

/// A frame is another one if marks are off all alike: what is left when it is moved is no more than this part of what they are off. Start
/// values that are a hundred times off leave more.
const ALIKE: f64 = 0.6;
/// A frame may be so many metres and degrees off: tolerances take that up.
const NEAR: (f64, f64) = (0.004, 0.5);

/// The motion that brings marks from where a model has them to where they were read, best in the sum of squares.
#[derive(Clone, PartialEq, Debug)]
pub struct FramePlace {
    /// Of the centre of the marks, in the deck's length unit and ground axes.
    pub shift: Vec3,
    /// The angle of the turn.
    pub degrees: f64,
    /// What the motion leaves, part of what they are off (rms).
    pub left: f64,
}

impl FramePlace {
    /// Of the same marks as a model has them and as they were read; `None` where they do not tell.
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

    /// True if it goes further than so many metres or degrees; `length` is the deck's unit in metres.
    pub fn is_beyond(&self, (metres, degrees): (f64, f64), length: f64) -> bool {
        self.shift.norm() * length > metres || self.degrees > degrees
    }

    /// True if the frame is another one than the deck's; `length` is the deck's unit in metres.
    pub fn is_another(&self, length: f64) -> bool {
        self.left <= ALIKE && self.is_beyond(NEAR, length)
    }
}
