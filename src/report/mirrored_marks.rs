//! Check for measured marks that are a mirror image of the parts: one coordinate has the wrong sign, or two coordinates are exchanged.

use super::mark_scatter::rigidity;
use admire_identify::LoadedStudy;
use admire_solver::mechanics::Vec3;

/// Largest scatter of the corrected marks on their parts, relative to the uncorrected scatter, that proves a mirror image. Mirrored marks do
/// not fit a rigid part.
const RIGID: f64 = 0.2;
const NAMES: [&str; 3] = ["x", "y", "z"];

/// Returns a sentence with the correction if the marks are a mirror image, otherwise `None`. Every reflection makes the parts rigid again.
/// The correction that brings the marks nearest to their positions in the deck is chosen.
pub(super) fn mirrored(loaded: &LoadedStudy) -> Option<String> {
    let before = rigidity(loaded)?;
    let mends = |change: &dyn Fn(&Vec3) -> Vec3| {
        let mut mended = loaded.clone();
        let marks = mended.measurement.cases.iter_mut();
        for mark in marks.flat_map(|case| &mut case.marks) {
            mark.x = change(&mark.x);
        }
        let after = rigidity(&mended)?;
        (after < RIGID * before).then(|| from_deck(&mended))
    };
    let mut best: Option<(f64, String)> = None;
    let mut look = |off: Option<f64>, what: String| {
        if let Some(off) = off
            && best.as_ref().is_none_or(|(least, _)| off < *least)
        {
            best = Some((off, what));
        }
    };
    for axis in 0..3 {
        let flipped = |x: &Vec3| {
            let mut new = *x;
            new[axis] = -new[axis];
            new
        };
        look(
            mends(&flipped),
            format!("changing the sign of column `{}`", NAMES[axis]),
        );
        let others = ((axis + 1) % 3, (axis + 2) % 3);
        let exchanged = |x: &Vec3| {
            let mut new = *x;
            new.swap_rows(others.0, others.1);
            new
        };
        let (a, b) = (others.0.min(others.1), others.0.max(others.1));
        look(
            mends(&exchanged),
            format!("exchanging columns `{}` and `{}`", NAMES[a], NAMES[b]),
        );
    }
    let (_, what) = best?;
    Some(format!(
        "the measured marks are a mirror image of the parts; {what} corrects this"
    ))
}

/// Returns the rms distance of the marks from their positions in the deck's design position.
fn from_deck(loaded: &LoadedStudy) -> f64 {
    let to = &loaded.measurement;
    let (mut squares, mut count) = (0.0, 0_usize);
    for mark in to.cases.iter().flat_map(|case| &case.marks) {
        let part = &to.parts[mark.part];
        let pose = &loaded.model.parts[part.part.0].pose;
        squares += (pose.point(&part.marks[mark.mark].p) - mark.x).norm_squared();
        count += 1;
    }
    (squares / count.max(1) as f64).sqrt()
}
