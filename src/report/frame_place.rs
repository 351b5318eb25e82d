//! Whether the marks are told in the deck's frame.

use super::check::Verdict;
use crate::identify::LoadedStudy;
use crate::mechanics::{Vec3, log};
use crate::rig::Case;
use crate::rig::orientation::absolute_orientation;

/// A frame is another one if marks are off all alike: what is left when it is moved is below this part of what they are off. Start values
/// that are a hundred times off leave more.
const ALIKE: f64 = 0.6;
/// It surely is below this part.
const SURE: f64 = 0.4;
/// A frame may be so many metres and degrees off, tolerances take that up;
const NEAR: (f64, f64) = (0.004, 0.5);
/// and beyond these it cannot be meant.
const FAR: (f64, f64) = (0.02, 2.0);

/// What is odd of the place of the marks, beside those the model predicts at the start values.
pub(super) fn odd_frame(loaded: &LoadedStudy, predicted: &[Case]) -> Option<(Verdict, String)> {
    let to = &loaded.measurement;
    let of = |cases: &[Case]| -> Vec<Vec3> {
        let fitted = to.fitted_cases().flat_map(|case| &cases[case].marks);
        fitted.map(|mark| mark.x).collect()
    };
    let (model, read) = (of(predicted), of(&to.cases));
    let found = absolute_orientation(&model, &read, 1.0).ok()?;
    let before: f64 = model
        .iter()
        .zip(&read)
        .map(|(a, b)| (a - b).norm_squared())
        .sum();
    let after: f64 = found.residuals.iter().map(Vec3::norm_squared).sum();
    let centre = model.iter().sum::<Vec3>() / model.len() as f64;
    let shift = found.pose.point(&centre) - centre;
    let degrees = log(&found.pose.R).norm().to_degrees();
    let length = loaded.model.units.length;
    let metres = shift.norm() * length.si;
    let beyond = |(shift, turn): (f64, f64)| metres > shift || degrees > turn;
    let left = (after / before).sqrt();
    if left > ALIKE || !beyond(NEAR) {
        return None;
    }
    let verdict = if left < SURE && beyond(FAR) {
        Verdict::Impossible
    } else {
        Verdict::Doubtful
    };
    let mm = shift * (1e3 * length.si);
    let why = format!(
        "all marks sit alike ({:.1}, {:.1}, {:.1}) mm and {degrees:.1} degrees from where the model has them: are they told in the deck's frame?",
        mm.x, mm.y, mm.z
    );
    Some((verdict, why))
}
