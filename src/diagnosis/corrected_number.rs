use super::fit::FittedModel;
use admire_identify::Problem;
use admire_identify::settings::UNIDENTIFIABLE_LN_SD;

/// Identified number as estimated by the original model and by the extended model.
#[derive(Clone, PartialEq, Debug)]
pub struct CorrectedNumber {
    /// Address of the number in the deck.
    pub address: String,
    /// Unit of the number, spelled as in the result files.
    pub unit: String,
    /// Estimate and standard error of the original model.
    pub before: (f64, f64),
    /// Estimate and standard error of the extended model.
    pub after: (f64, f64),
    /// True if the model determines the number: for the original model, then for the extended model.
    pub identified: [bool; 2],
    /// True if the number is a change of the deck. Its bias is then a difference, because ratios of changes are meaningless.
    pub is_change: bool,
}

impl CorrectedNumber {
    /// Returns true if the readings determine the number in both models. Otherwise the two estimates cannot be compared.
    pub const fn is_identified(&self) -> bool {
        self.identified[0] && self.identified[1]
    }

    /// Returns the bias of the original model's estimate against the extended model's estimate. It is relative, or a difference if the
    /// number is a change.
    pub fn bias(&self) -> f64 {
        if self.is_change {
            self.before.0 - self.after.0
        } else {
            self.before.0 / self.after.0 - 1.0
        }
    }
}

/// Returns all identified numbers of a study as estimated by the original and the extended model.
pub(super) fn corrected(
    problem: &Problem<'_>,
    before: &FittedModel,
    after: &FittedModel,
) -> Vec<CorrectedNumber> {
    let unknowns = problem.unknowns.iter().enumerate();
    unknowns
        .map(|(k, unknown)| CorrectedNumber {
            address: unknown.address.to_string(),
            unit: unknown.unit.clone(),
            before: before.identified(k, unknown),
            after: after.identified(k, unknown),
            identified: [before, after].map(|fit| fit.coordinate_sd(k) <= UNIDENTIFIABLE_LN_SD),
            is_change: !unknown.is_logarithm(),
        })
        .collect()
}
