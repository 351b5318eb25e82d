//! Instruments that distinguish two explanations if no load distinguishes them.

use serde::Serialize;

use super::candidate::ProposedMeasurements;
use super::rivals::{Discrimination, discriminations};
use crate::settings::{MAX_SEPARATORS, SEPARATION_CHI_SQUARE};
use admire_diagnosis::{DiagnosisProblem, FittedModel};

/// Instrument that would distinguish two explanations.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Separator {
    /// Instruction for the measurement, in words.
    pub what: String,
    /// True if the laboratory of the study has the instrument.
    pub available: bool,
    /// Expected chi-square between the predictions of the two explanations.
    pub chi_square: f64,
}

impl std::fmt::Display for Separator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let not = if self.available {
            ""
        } else {
            ", not listed as available"
        };
        write!(f, "{} (chi-square {:.1}{not})", self.what, self.chi_square)
    }
}

/// Returns the marks, curves and load cells that distinguish two models. Available instruments come first, then those of larger chi-square.
pub(super) fn separators(
    subject: &DiagnosisProblem<'_>,
    fits: [&FittedModel; 2],
) -> Vec<Separator> {
    let (model, measurement) = (subject.problem.model, subject.problem.measurement);
    let mut instruments = ProposedMeasurements::default();
    instruments.marks(model, &measurement.available);
    instruments.curves(subject);
    instruments.load_cells(model, &measurement.available);
    let found = discriminations(subject, fits, &instruments).unwrap_or_default();
    let separator = |(candidate, found): (
        &super::candidate::ProposedMeasurement,
        Option<Discrimination>,
    )| {
        let chi_square = found?.chi_square;
        (chi_square > SEPARATION_CHI_SQUARE).then(|| Separator {
            what: candidate.what.clone(),
            available: candidate.is_available,
            chi_square,
        })
    };
    let each = instruments.list.iter().zip(found);
    let mut separators: Vec<Separator> = each.filter_map(separator).collect();
    separators.sort_by(|a, b| {
        let by_place = b.available.cmp(&a.available);
        by_place.then(b.chi_square.total_cmp(&a.chi_square))
    });
    separators.truncate(MAX_SEPARATORS);
    separators
}
