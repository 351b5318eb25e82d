//! Pages of mechanisms, comparisons, virtual rigs and new studies.

use std::collections::BTreeSet;
use std::path::PathBuf;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::front::{self, Error, ErrorKind};
use admire_diagnosis::SharedProgress;
use admire_results::Tolerance;
use admire_rig::effect::EffectSpec;
use admire_rig::{RigOptions, Tolerances, virtual_rig};
use admire_session::Sources;
use admire_study::permission::trust_study;
use admire_study::{Kind, Starter};

use super::work::work;

/// Files as pairs of name and bytes.
type Files<'py> = Vec<(String, Bound<'py, PyBytes>)>;

/// Compare two results files. Return the comparison as JSON, and whether the files agree.
#[pyfunction]
pub(super) fn compare_results(
    py: Python<'_>,
    a: PathBuf,
    b: PathBuf,
    relative: f64,
    absolute: f64,
    floor: f64,
) -> PyResult<(String, bool)> {
    let tolerance = Tolerance { absolute, relative };
    let job = move || front::compared(&a, &b, tolerance, floor);
    work(py, &SharedProgress::default(), None, job)
}

/// Measure the deck of a study on the virtual rig. Return the files of the new study, and the planted effects as text.
#[pyfunction]
pub(super) fn virtual_rig_run<'py>(
    py: Python<'py>,
    folder: PathBuf,
    seed: u64,
    sigma: Option<f64>,
    effects: Vec<String>,
    tolerances: &str,
) -> PyResult<(Files<'py>, String)> {
    let refused =
        |wrong: admire_syntax::diagnostic::Diagnostic| PyValueError::new_err(wrong.message);
    let effects: Result<Vec<EffectSpec>, _> =
        effects.iter().map(|text| EffectSpec::parse(text)).collect();
    let options = RigOptions {
        seed,
        sigma,
        effects: effects.map_err(refused)?,
        tolerances: if tolerances.is_empty() {
            Tolerances::default()
        } else {
            Tolerances::parse(tolerances).map_err(refused)?
        },
        ..RigOptions::default()
    };
    let job = move || {
        virtual_rig(&folder, &options)
            .map_err(|found| Error::new(ErrorKind::Input, &found, &Sources::default()))
    };
    let run = work(py, &SharedProgress::default(), None, job)?;
    let named = |(name, bytes): (PathBuf, Vec<u8>)| {
        (
            name.to_string_lossy().into_owned(),
            PyBytes::new(py, &bytes),
        )
    };
    Ok((run.files.into_iter().map(named).collect(), run.truth))
}

/// Return the files of a new study of a deck, and what was found in the deck as lines. `kinds` holds `marks`, `wheel`, `curves` or `readings`.
#[pyfunction]
pub(super) fn study_files(
    py: Python<'_>,
    deck: &super::deck::Deck,
    name: &str,
    kinds: Vec<String>,
    bushings: Vec<String>,
) -> PyResult<(Vec<(String, String)>, Vec<String>)> {
    let wanted: Option<BTreeSet<Kind>> = kinds
        .iter()
        .map(|word| match word.as_str() {
            "marks" => Some(Kind::Marks),
            "wheel" => Some(Kind::Wheel),
            "curves" => Some(Kind::Curves),
            "readings" => Some(Kind::Readings),
            _ => None,
        })
        .collect();
    let Some(wanted) = wanted.filter(|kinds| !kinds.is_empty()) else {
        let message =
            "`measured` must hold one or more of the words marks, wheel, curves, readings";
        return Err(PyValueError::new_err(message));
    };
    let (deck, name) = (deck.now(py), name.to_string());
    let job = move || {
        let model = deck.lowered()?;
        let starter = Starter::of(&model);
        Ok((starter.files(&name, &wanted, &bushings), starter.found()))
    };
    work(py, &SharedProgress::default(), None, job)
}

/// Record that the user created this study, so that its programs may be started. Return false if the record cannot be stored.
#[pyfunction]
pub(super) fn trust(folder: PathBuf) -> bool {
    trust_study(&folder).is_ok()
}
