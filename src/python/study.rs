use std::path::PathBuf;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::front::{self, Watched};
use crate::rig::settings::Method;

use super::refusal::json;
use super::work::work;

/// A study folder.
#[pyclass(frozen, module = "admire._admire")]
pub(super) struct Study(front::Study);

#[pymethods]
impl Study {
    #[staticmethod]
    fn open(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        let job = move || front::Study::open(&folder);
        work(py, &Watched::default(), None, job).map(Self)
    }

    fn folder(&self) -> PathBuf {
        self.0.folder().to_path_buf()
    }

    fn deck(&self) -> PathBuf {
        self.0.deck()
    }

    /// Warnings and notes as JSON.
    fn complaints(&self) -> String {
        json(self.0.complaints())
    }

    /// The command that is started for every equilibrium, if the study names one.
    fn starts_program(&self) -> Option<String> {
        self.0.starts_program().map(|words| words.join(" "))
    }

    /// `identification.json`, the answer in a sentence, the deck, the report, remarks.
    #[pyo3(signature = (method, force, progress))]
    #[allow(clippy::type_complexity)]
    fn identify<'py>(
        &self,
        py: Python<'py>,
        method: Option<&str>,
        force: bool,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<(String, String, Bound<'py, PyBytes>, String, Vec<String>)> {
        let mut study = self.0.clone();
        match method {
            None => {}
            Some("gauss-newton") => study.set_method(Method::GaussNewton),
            Some("regression") => study.set_method(Method::Regression),
            Some("direct") => study.set_method(Method::Direct),
            Some(other) => {
                let message = format!("`{other}` is none of gauss-newton, regression, direct");
                return Err(PyValueError::new_err(message));
            }
        }
        let watched = Watched::default();
        let watch = watched.clone();
        let job = move || study.identify(force, &watch);
        let found = work(py, &watched, progress.as_ref(), job)?;
        let deck = PyBytes::new(py, &found.deck);
        Ok((
            found.fit.to_json(),
            found.lead,
            deck,
            found.html,
            found.remarks,
        ))
    }

    /// `diagnosis.json`, sentences, the extended deck and its command file, the report, remarks.
    #[pyo3(signature = (force, progress))]
    #[allow(clippy::type_complexity)]
    fn diagnose<'py>(
        &self,
        py: Python<'py>,
        force: bool,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<(
        String,
        Vec<String>,
        Bound<'py, PyBytes>,
        String,
        String,
        Vec<String>,
    )> {
        let study = self.0.clone();
        let watched = Watched::default();
        let watch = watched.clone();
        let job = move || study.diagnose(force, &watch);
        let found = work(py, &watched, progress.as_ref(), job)?;
        Ok((
            found.diagnosis.to_json(),
            found.sentences,
            PyBytes::new(py, &found.deck),
            found.commands,
            found.html,
            found.remarks,
        ))
    }
}
