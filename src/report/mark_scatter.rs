//! Noise of the marks (measured points on parts), estimated before any fit: from the rigidity of the parts, and from repeated loads.

use admire_identify::global::{Observed, SeenMark};
use admire_identify::{LoadedStudy, meet_marks};
use admire_solver::mechanics::{Pose, Vec3};

/// Returns the standard deviation of the mark readings per coordinate, from fits of rigid parts to their marks. Outlying fits are left out.
/// Returns `None` if there are too few marks.
pub(super) fn rigidity(loaded: &LoadedStudy) -> Option<f64> {
    let to = &loaded.measurement;
    let mut spreads: Vec<(f64, usize)> = Vec::new();
    for case in 0..to.cases.len() {
        for part in 0..to.parts.len() {
            let Ok(fit) = to.orientation(case, part) else {
                continue;
            };
            if fit.dof > 0 {
                spreads.push((fit.residuals.iter().map(Vec3::norm_squared).sum(), fit.dof));
            }
        }
    }
    let each = |(squares, dof): &(f64, usize)| (squares / *dof as f64).sqrt();
    spreads.sort_by(|a, b| each(a).total_cmp(&each(b)));
    let typical = each(spreads.get(spreads.len() / 2)?);
    spreads.retain(|spread| each(spread) <= 4.0 * typical);
    let (squares, dof) = spreads
        .iter()
        .fold((0.0, 0), |(a, n), (b, m)| (a + b, n + m));
    (dof >= 6).then(|| (squares / dof as f64).sqrt())
}

/// Returns the standard deviation of the mark readings per coordinate, from pairs of cases with the same loads, and the number of these pairs.
/// Zero-stiffness motions between the two cases of a pair are removed. Returns `None` if no mark was read in both cases of a pair.
pub(super) fn repeats(loaded: &LoadedStudy) -> Option<(f64, usize)> {
    let cases = &loaded.measurement.cases;
    let (mut squares, mut count, mut pairs) = (0.0, 0_usize, 0);
    for second in 1..cases.len() {
        let Some(first) = (0..second)
            .rev()
            .find(|first| cases[*first].loads == cases[second].loads)
        else {
            continue;
        };
        pairs += 1;
        let moved = moved(loaded, [first, second]);
        for a in &cases[first].marks {
            let same = cases[second]
                .marks
                .iter()
                .find(|b| (a.part, a.mark) == (b.part, b.mark));
            if let (Some(b), Some(moved)) = (same, &moved[a.part]) {
                squares += (moved.point(&a.x) - b.x).norm_squared();
                count += 3;
            }
        }
    }
    // The difference of two readings has twice the variance of one reading.
    (count > 0).then(|| ((squares / (2 * count) as f64).sqrt(), pairs))
}

/// Returns the zero-stiffness motion of each marked part between two cases with the same loads. A part without such a motion has the
/// identity. `None` for a part that has such a motion, but too few marks to determine it.
fn moved(loaded: &LoadedStudy, [first, second]: [usize; 2]) -> Vec<Option<Pose>> {
    let (to, free) = (&loaded.measurement, &loaded.free);
    let before: Vec<Option<Pose>> = (0..to.parts.len())
        .map(|part| Some(to.orientation(first, part).ok()?.pose))
        .collect();
    let observed = Observed::of(to);
    let mut poses: Vec<Pose> = loaded.model.parts.iter().map(|part| part.pose).collect();
    for (marked, pose) in to.parts.iter().zip(&before) {
        if let Some(pose) = pose {
            poses[marked.part.0] = *pose;
        }
    }
    let seen = |mark: &&SeenMark| {
        let part = observed.parts[mark.part];
        let known = to.parts.iter().position(|marked| marked.part == part);
        known.is_some_and(|known| before[known].is_some())
    };
    let marks: Vec<SeenMark> = observed.marks[second]
        .iter()
        .filter(seen)
        .copied()
        .collect();
    meet_marks(free, &mut poses, &observed, &marks);
    let between = |k: usize| {
        let part = to.parts[k].part;
        if !free.moves(part) {
            return Some(Pose::identity());
        }
        Some(poses[part.0].compose(&before[k]?.inverse()))
    };
    (0..before.len()).map(between).collect()
}
