//! Errors of the rig that every study may have: loads that are not held exactly, a measuring frame that moves, and a mount that yields. Random
//! effects represent them in every fit. If the readings do not need them, their standard deviations become small.

use super::diagnosis_problem::DiagnosisProblem;
use super::frame::{is_another, varying};
use crate::settings::{MAX_CASE_ERRORS, MAX_MOUNT_LOADS};
use admire_identify::Problem;
use admire_identify::tolerance::{EffectGroup, ScalePrior, applied_loads};
use admire_study::PriorSetting;

impl<'a> DiagnosisProblem<'a> {
    /// Creates the problem of a study, with the errors of the rig among its tolerances. `held_out` flags the cases that are held out.
    pub fn with_rig_errors(problem: &Problem<'a>, held_out: Vec<bool>) -> Self {
        let new = Self::new(problem, held_out);
        new.with_groups(rig_errors(&new))
    }
}

/// Returns the groups of random effects for errors of the rig whose size the study does not state.
fn rig_errors(subject: &DiagnosisProblem<'_>) -> Vec<(EffectGroup, ScalePrior)> {
    let problem = &subject.problem;
    let cases = problem.programme.cases.len();
    let millimetre = subject.millimetre();
    let stated = problem.tolerances;
    let mut groups = Vec::new();
    let load_errors = cases * applied_loads(problem.model, problem.programme).len();
    if stated.load_repeatability == PriorSetting::Estimate && load_errors <= MAX_CASE_ERRORS {
        groups.extend(ScalePrior::of_load_errors());
    }
    if subject.compares_marks() {
        let is_few = 6 * cases <= MAX_CASE_ERRORS;
        let of_frames = ScalePrior::of_frames(millimetre).into_iter();
        groups.extend(of_frames.filter(|(group, _)| is_few || *group == EffectGroup::FrameDrifts));
        if stated.alignment == PriorSetting::Estimate {
            if is_another(subject) {
                groups.push(ScalePrior::of_another_frame(millimetre));
            } else {
                groups.extend(ScalePrior::of_alignment(stated.alignment, millimetre));
            }
        }
        if stated.mount == PriorSetting::Estimate
            && varying(problem.programme).len() <= MAX_MOUNT_LOADS
        {
            groups.extend(ScalePrior::of_a_mount(millimetre));
        }
    }
    groups.retain(|(group, _)| subject.sizes.group(*group).is_none());
    groups
}
