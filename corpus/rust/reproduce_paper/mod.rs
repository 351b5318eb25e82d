//! The three validations of the paper, repeated on our own axles and compared with the printed results.
//!
//! This module holds the published numbers of the paper and states which of them can be compared. It prints nothing.

mod curves;
mod experiment;
mod mcpherson;
mod multilink;

use std::path::Path;

use admire_identify::{Fit, IdentifyError, LoadedStudy, ParameterFit, Status};
use admire_report::{Comparison, Curve, ReproducedCurves, ReproducedSection as Section};
use admire_syntax::diagnostic::Diagnostic;

/// Error because of which a section of the comparison cannot be computed.
#[derive(Debug, thiserror::Error)]
pub(crate) enum ReproductionError {
    /// The study of a section has errors.
    #[error("the study in {folder} cannot be used")]
    Study {
        /// Folder of the study.
        folder: String,
        /// Errors of the study.
        diagnostics: Vec<Diagnostic>,
    },
    /// A study lacks an input that its section needs.
    #[error("the study in {folder} has no {needs}")]
    Lacks {
        /// Folder of the study.
        folder: String,
        /// Missing input.
        needs: &'static str,
    },
    /// An identification failed.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
}

/// Number of progress reports that [`reproduce`] makes.
pub(crate) const STAGES: usize = mcpherson::STAGES + multilink::STAGES + experiment::STAGES;

/// Repeats the paper's validations on the studies `pseudo-mcpherson`, `multilink` and `kc-experiment` of a corpus folder. `progress` is
/// called [`STAGES`] times with a description of the running stage.
///
/// # Errors
/// Fails if a study cannot be used, or if an identification has no result.
pub(crate) fn reproduce(
    corpus: &Path,
    progress: &mut dyn FnMut(&str),
) -> Result<Vec<Section>, ReproductionError> {
    Ok(vec![
        mcpherson::section(&study(corpus, "pseudo-mcpherson")?, progress)?,
        multilink::section(&study(corpus, "multilink")?, progress)?,
        experiment::section(&study(corpus, "kc-experiment")?, progress)?,
    ])
}

fn study(corpus: &Path, name: &str) -> Result<LoadedStudy, ReproductionError> {
    let folder = corpus.join(name);
    let checked = LoadedStudy::read(&folder);
    checked.value.ok_or_else(|| ReproductionError::Study {
        folder: folder.display().to_string(),
        diagnostics: checked.diagnostics,
    })
}

/// Returns the reference value of every unknown of a study.
fn truth(study: &LoadedStudy) -> Result<Vec<f64>, ReproductionError> {
    let values: Option<Vec<f64>> = study.reference_values().into_iter().collect();
    values.ok_or_else(|| ReproductionError::Lacks {
        folder: study.study.source.name().to_string(),
        needs: "reference deck with the value of every unknown",
    })
}

/// Returns the number of unknowns that a fit does not identify.
fn unidentified(fit: &Fit) -> usize {
    let open = |parameter: &&ParameterFit| parameter.status != Status::Identified;
    fit.parameters.iter().filter(open).count()
}

/// Returns the ratio of identified to true value for each identified parameter.
fn ratios(fit: &Fit, truth: &[f64]) -> Vec<f64> {
    let found = fit.parameters.iter().zip(truth);
    found
        .filter(|(parameter, _)| parameter.status == Status::Identified)
        .map(|(parameter, truth)| parameter.value / truth)
        .collect()
}

/// Formats the smallest and largest ratio, such as `0.84 to 1.01`.
fn range(ratios: &[f64]) -> String {
    let low = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let high = ratios.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    format!("{low:.2} to {high:.2}")
}

/// Returns the median of |ln ratio|, the relative error of a typical parameter.
fn median_error(ratios: &[f64]) -> f64 {
    let mut errors: Vec<f64> = ratios.iter().map(|ratio| ratio.ln().abs()).collect();
    errors.sort_by(f64::total_cmp);
    errors.get(errors.len() / 2).copied().unwrap_or(f64::NAN)
}

/// Formats the number of iterations of a fit, such as `40` or `200, not converged`.
fn iterations(fit: &Fit) -> String {
    if fit.converged {
        fit.iterations.to_string()
    } else {
        format!("{}, not converged", fit.iterations)
    }
}

fn texts<const N: usize>(words: [&str; N]) -> Vec<String> {
    words.map(str::to_string).to_vec()
}
