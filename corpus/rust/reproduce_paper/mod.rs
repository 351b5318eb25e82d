//! The paper's three validations, run again on our own axles and put beside what it printed.
//!
//! Knows the paper's published numbers and what of them can be compared at all. Prints nothing.

mod curves;
mod experiment;
mod mcpherson;
mod multilink;

use std::path::Path;

use admire_identify::{Fit, IdentifyError, LoadedStudy, ParameterFit, Status};
use admire_report::{Comparison, Curve, ReproducedCurves, ReproducedSection as Section};
use admire_syntax::diagnostic::Diagnostic;

/// Why a section could not be made.
#[derive(Debug, thiserror::Error)]
pub enum ReproductionError {
    /// The study of a section has errors.
    #[error("the study in {folder} cannot be used")]
    Study {
        /// Its folder.
        folder: String,
        /// What is wrong with it.
        diagnostics: Vec<Diagnostic>,
    },
    /// A study that lacks what its section compares with.
    #[error("the study in {folder} has no {needs}")]
    Lacks {
        /// Its folder.
        folder: String,
        /// What.
        needs: &'static str,
    },
    /// An identification failed.
    #[error(transparent)]
    Identify(#[from] IdentifyError),
}

/// How many things `reproduce` tells of.
pub const STAGES: usize = mcpherson::STAGES + multilink::STAGES + experiment::STAGES;

/// Runs the paper's validations on the studies of a corpus: `pseudo-mcpherson`, `multilink` and, where it is there,
/// `kc-experiment`. `progress` is told what runs, [`STAGES`] times.
///
/// # Errors
/// A study that cannot be used, or an identification without any answer.
pub fn reproduce(
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

/// The reference value of every unknown.
fn truth(study: &LoadedStudy) -> Result<Vec<f64>, ReproductionError> {
    let values: Option<Vec<f64>> = study.reference_values().into_iter().collect();
    values.ok_or_else(|| ReproductionError::Lacks {
        folder: study.study.source.name().to_string(),
        needs: "reference deck with the value of every unknown",
    })
}

/// Numbers a fit leaves unidentified.
fn unidentified(fit: &Fit) -> usize {
    let open = |parameter: &&ParameterFit| parameter.status != Status::Identified;
    fit.parameters.iter().filter(open).count()
}

/// Identified over true, of the numbers the fit claims to have identified.
fn ratios(fit: &Fit, truth: &[f64]) -> Vec<f64> {
    let found = fit.parameters.iter().zip(truth);
    found
        .filter(|(parameter, _)| parameter.status == Status::Identified)
        .map(|(parameter, truth)| parameter.value / truth)
        .collect()
}

/// `0.84 to 1.01`.
fn range(ratios: &[f64]) -> String {
    let low = ratios.iter().copied().fold(f64::INFINITY, f64::min);
    let high = ratios.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    format!("{low:.2} to {high:.2}")
}

/// The median of |ln ratio|.
fn median_error(ratios: &[f64]) -> f64 {
    let mut errors: Vec<f64> = ratios.iter().map(|ratio| libm::log(*ratio).abs()).collect();
    errors.sort_by(f64::total_cmp);
    errors.get(errors.len() / 2).copied().unwrap_or(f64::NAN)
}

/// `40`, or `200, not converged`.
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
