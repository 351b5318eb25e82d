use std::path::PathBuf;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

use crate::front;
use admire_diagnosis::SharedProgress;
use admire_results::{StepFilter, StepKind};

use super::block::Block;
use super::run::named;
use super::work::work;

/// A results file.
#[pyclass(frozen, module = "admire._admire")]
pub(super) struct Results(front::Results);

#[pymethods]
impl Results {
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let job = move || front::Results::open(&path);
        work(py, &SharedProgress::default(), None, job).map(Self)
    }

    fn path(&self) -> PathBuf {
        self.0.path().to_path_buf()
    }

    fn title(&self) -> String {
        self.0.header().title.clone()
    }

    fn solver(&self) -> String {
        self.0.header().solver.clone()
    }

    fn columns(&self) -> Vec<(String, String)> {
        named(self.0.columns())
    }

    fn column(&self, py: Python<'_>, name: &str) -> PyResult<Block> {
        let (results, name) = (self.0.clone(), name.to_string());
        let watched = SharedProgress::default();
        let watch = watched.clone();
        let job = move || results.column(&name, &watch);
        Ok(Block::new(work(py, &watched, None, job)?, 1))
    }

    /// Return the names and units of the columns, the kinds of the steps, and the values with one row for each step.
    #[allow(clippy::type_complexity)]
    fn select(
        &self,
        py: Python<'_>,
        patterns: Vec<String>,
        steps: &str,
        kinds: Vec<String>,
        times: (f64, f64),
    ) -> PyResult<(Vec<(String, String)>, Vec<&'static str>, Block)> {
        let mut filter = StepFilter {
            from: times.0,
            to: times.1,
            ..StepFilter::default()
        };
        let wrong = |word: &str, what: &str| PyValueError::new_err(format!("`{word}` is {what}"));
        filter.positions(steps).map_err(|word| {
            wrong(
                &word,
                "not a step; steps are counted from 1: 3, 2-5, 7-, last",
            )
        })?;
        for word in &kinds {
            let mut named = StepKind::NAMED.into_iter();
            let kind = named.find(|kind| kind.step_type().eq_ignore_ascii_case(word));
            filter.kinds.push(kind.ok_or_else(|| {
                let all = StepKind::NAMED.map(StepKind::step_type).join(", ");
                wrong(word, &format!("not a kind of step; write one of {all}"))
            })?);
        }
        let results = self.0.clone();
        let watched = SharedProgress::default();
        let watch = watched.clone();
        let job = move || {
            let patterns: Vec<&str> = patterns.iter().map(String::as_str).collect();
            results.select(&patterns, &filter, &watch)
        };
        let rows = work(py, &watched, None, job)?;
        let values = Block::new(rows.values, rows.columns.len());
        let kinds = rows.kinds.iter().map(|kind| kind.step_type()).collect();
        Ok((named(&rows.columns), kinds, values))
    }
}
