use super::fit::FittedModel;
use admire_identify::Problem;
use admire_identify::global::UNIDENTIFIABLE;

/// A stiffness as the wrong model had it and as the extended model has it.
#[derive(Clone, PartialEq, Debug)]
pub struct CorrectedStiffness {
    /// Which.
    pub address: String,
    /// Estimate and standard error of the model as it was.
    pub before: (f64, f64),
    /// The same of the extended model.
    pub after: (f64, f64),
}

impl CorrectedStiffness {
    /// True where the readings determine it in both models; else its two estimates say nothing of each other.
    pub fn is_identified(&self) -> bool {
        [self.before, self.after]
            .iter()
            .all(|(value, error)| *error <= UNIDENTIFIABLE * value)
    }

    /// By how much the wrong model had biased it, as a part of the corrected value.
    pub fn bias(&self) -> f64 {
        self.before.0 / self.after.0 - 1.0
    }
}

/// All stiffnesses of a study, before and after.
pub(super) fn corrected(
    problem: &Problem<'_>,
    before: &FittedModel,
    after: &FittedModel,
) -> Vec<CorrectedStiffness> {
    let unknowns = problem.unknowns.iter().enumerate();
    unknowns
        .map(|(k, unknown)| CorrectedStiffness {
            address: unknown.address.to_string(),
            before: before.stiffness(k),
            after: after.stiffness(k),
        })
        .collect()
}
