//! Placement of equilibria along free (zero-stiffness) motions at the best fit of the measured marks, for solutions of any solver.

use super::global::{CaseChanges, Observed, SeenMark, step};
use crate::settings::FREE_MAX_STEPS;
use admire_session::backend::{FreeMotions, Sweep, Twist};
use admire_solver::mechanics::Pose;
use admire_study::Measurement;

/// Moves the parts along the free motions until their marks fit the measured positions in `marks` best.
pub fn meet_marks(free: &FreeMotions, poses: &mut [Pose], observed: &Observed, marks: &[SeenMark]) {
    if free.is_empty() {
        return;
    }
    for _ in 0..FREE_MAX_STEPS {
        let each = free.twists().iter().map(|motion| {
            let parts = observed.parts.iter();
            parts
                .map(|part| in_ground(&poses[part.0], &motion[part.0]))
                .collect()
        });
        let twists: Vec<Vec<Twist>> = each.collect();
        let pose = |part: usize| poses[observed.parts[part].0];
        let Some(amounts) = step(marks, &pose, &twists) else {
            return;
        };
        for (motion, amount) in free.twists().iter().zip(amounts) {
            for (pose, own) in poses.iter_mut().zip(motion) {
                let (v, w) = in_ground(pose, own);
                *pose = pose.displaced(&(amount * v), &(amount * w));
            }
        }
    }
}

/// Returns the derivatives of the observed part poses with respect to each free motion. All channels are assumed constant; `channels` is their
/// number.
pub(crate) fn changes_along(
    free: &FreeMotions,
    poses: &[Pose],
    observed: &Observed,
    channels: usize,
) -> CaseChanges {
    let mut out = CaseChanges::with_capacity(free.twists().len(), observed.parts.len(), channels);
    for motion in free.twists() {
        let parts = observed.parts.iter().map(|part| {
            let (v, w) = in_ground(&poses[part.0], &motion[part.0]);
            [v.x, v.y, v.z, w.x, w.y, w.z]
        });
        out.push(parts, std::iter::repeat_n(0.0, channels));
    }
    out
}

/// Moves the parts in the solutions of all cases along the free motions to the best fit of the measured marks.
pub fn meet_marks_of_all(free: &FreeMotions, sweep: &mut Sweep, measurement: &Measurement) {
    if free.is_empty() {
        return;
    }
    let observed = Observed::of(measurement);
    for (answer, marks) in sweep.cases.iter_mut().zip(&observed.marks) {
        if let Ok(answer) = answer {
            meet_marks(free, &mut answer.poses, &observed, marks);
        }
    }
}

fn in_ground(pose: &Pose, (v, w): &Twist) -> Twist {
    (pose.R * v, pose.R * w)
}
