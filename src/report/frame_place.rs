//! Whether the marks are told in the deck's frame.

use super::check::Verdict;
use admire_identify::LoadedStudy;
use admire_solver::mechanics::Vec3;
use admire_study::{Case, FramePlace};

/// It is surely another one where the motion leaves no more than this part,
const SURE: f64 = 0.4;
/// and goes beyond so many metres or degrees: it cannot be meant.
const FAR: (f64, f64) = (0.02, 2.0);

/// What is odd of the place of the marks, beside those the model predicts at the start values.
pub(super) fn odd_frame(loaded: &LoadedStudy, predicted: &[Case]) -> Option<(Verdict, String)> {
    let to = &loaded.measurement;
    let of = |cases: &[Case]| -> Vec<Vec3> {
        let fitted = to.fitted_cases().flat_map(|case| &cases[case].marks);
        fitted.map(|mark| mark.x).collect()
    };
    let length = loaded.model.units.length;
    let place = FramePlace::of(&of(predicted), &of(&to.cases))?;
    if !place.is_another(length.si) {
        return None;
    }
    let verdict = if place.left < SURE && place.is_beyond(FAR, length.si) {
        Verdict::Impossible
    } else {
        Verdict::Doubtful
    };
    let mm = place.shift * (1e3 * length.si);
    let why = format!(
        "all marks sit alike ({:.1}, {:.1}, {:.1}) mm and {:.1} degrees from where the model has them: are they told in the deck's frame?",
        mm.x, mm.y, mm.z, place.degrees
    );
    Some((verdict, why))
}
