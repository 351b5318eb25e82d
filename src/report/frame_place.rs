//! Check of the frame of the marks (measured points on parts): it must be the frame of the deck.

use super::check::Verdict;
use admire_identify::LoadedStudy;
use admire_solver::mechanics::Vec3;
use admire_study::{Case, FramePlace};

/// Fraction of the marks' rms offset that may remain after a rigid motion. Up to this fraction, the marks are certainly in a frame other
/// than the deck's frame.
const SURE: f64 = 0.4;
/// Shift in metres beyond which such a frame is certainly a mistake.
const FAR_METRES: f64 = 0.02;
/// Rotation in degrees beyond which such a frame is certainly a mistake.
const FAR_DEGREES: f64 = 2.0;

/// Returns a finding if one rigid motion separates all measured marks from the marks predicted at the start values, otherwise `None`.
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
    let verdict = if place.left < SURE && place.is_beyond(FAR_METRES, FAR_DEGREES, length.si) {
        Verdict::Impossible
    } else {
        Verdict::Doubtful
    };
    let mm = place.shift * (1e3 * length.si);
    let why = format!(
        "all marks are displaced alike, by ({:.1}, {:.1}, {:.1}) mm and {:.1} degrees from their positions in the model: are they given in the deck's frame?",
        mm.x, mm.y, mm.z, place.degrees
    );
    Some((verdict, why))
}
