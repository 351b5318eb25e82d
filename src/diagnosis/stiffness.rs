use super::fit::FittedModel;
use admire_identify::Problem;
use admire_identify::settings::UNIDENTIFIABLE_LN_SD;

/// Stiffness as estimated by the original model and by the extended model.
#[derive(Clone, PartialEq, Debug)]
pub struct CorrectedStiffness {
    /// Address of the stiffness in the deck.
    pub address: String,
    /// Estimate and standard error of the original model.
    pub before: (f64, f64),
    /// Estimate and standard error of the extended model.
    pub after: (f64, f64),
}

impl CorrectedStiffness {
    /// Returns true if the readings determine the stiffness in both models. Otherwise the two estimates cannot be compared.
    pub fn is_identified(&self) -> bool {
        [self.before, self.after]
            .iter()
            .all(|(value, error)| *error <= UNIDENTIFIABLE_LN_SD * value)
    }

    /// Returns the relative bias of the original model's estimate. The extended model's estimate is the reference.
    pub fn bias(&self) -> f64 {
        self.before.0 / self.after.0 - 1.0
    }
}

/// Returns all stiffnesses of a study as estimated by the original and the extended model.
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
