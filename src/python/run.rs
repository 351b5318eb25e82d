use std::path::PathBuf;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyDict, PyType};

use crate::front;
use admire_diagnosis::SharedProgress;
use admire_results::SelectedColumn;

use super::block::interface;
use super::refusal::{json, raised};
use super::work::work;

/// Results of executing commands on a deck.
#[pyclass(frozen, module = "admire._admire")]
pub(super) struct Run(std::sync::Arc<front::Run>);

impl Run {
    pub(crate) fn of(run: front::Run) -> Self {
        Self(std::sync::Arc::new(run))
    }
}

/// Returns the names and units of columns.
pub(super) fn named(columns: &[SelectedColumn]) -> Vec<(String, String)> {
    let each = |column: &SelectedColumn| {
        let units = column.units.clone().unwrap_or_default();
        (column.path.clone(), units)
    };
    columns.iter().map(each).collect()
}

#[pymethods]
impl Run {
    /// All values, with one row for each step. They are not copied, because a run never changes.
    #[getter]
    fn __array_interface__<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let table = self.0.table();
        let (width, values) = table.map_or((0, &[][..]), |table| {
            (table.catalogue.len(), table.values.as_slice())
        });
        let steps = values.len().checked_div(width).unwrap_or(0);
        interface(py, values, (steps, width))
    }

    /// Return the names and units of the columns, in the order of their values. Positions without a name are left out.
    fn columns(&self) -> Vec<(String, String)> {
        named(&self.0.columns())
    }

    /// Return the position, from 0, of each column within the values of a step.
    fn positions(&self) -> Vec<usize> {
        self.0
            .columns()
            .iter()
            .map(|column| column.id - 1)
            .collect()
    }

    fn position(&self, py: Python<'_>, name: &str) -> PyResult<usize> {
        let found = self.0.position(name);
        found.map_err(|error| raised(py, &error))
    }

    /// Return the columns that match patterns, each with its position within the values of a step.
    fn select(&self, py: Python<'_>, patterns: Vec<String>) -> PyResult<Vec<(String, usize)>> {
        let found = self.0.select(&patterns);
        let found = found.map_err(|error| raised(py, &error))?;
        let each = |column: SelectedColumn| (column.path, column.id - 1);
        Ok(found.into_iter().map(each).collect())
    }

    fn kinds(&self) -> Vec<&'static str> {
        self.0.kinds().iter().map(|kind| kind.step_type()).collect()
    }

    fn messages(&self) -> String {
        self.0.messages()
    }

    /// Return the warnings and errors as JSON.
    fn complaints(&self) -> String {
        json(self.0.complaints())
    }

    /// Return the exit code that the command line would give.
    fn exit_code(&self) -> u8 {
        self.0.ending().exit_code(true)
    }

    fn balance(&self) -> std::collections::BTreeMap<String, (f64, String)> {
        self.0.balance().clone()
    }

    fn elapsed(&self) -> f64 {
        self.0.elapsed().as_secs_f64()
    }

    /// Raise an exception if the run did not succeed.
    fn succeeded(&self, py: Python<'_>) -> PyResult<()> {
        self.0.succeeded().map_err(|error| raised(py, &error))
    }

    fn files(&self) -> Vec<String> {
        self.0.files().keys().cloned().collect()
    }

    fn file<'py>(&self, py: Python<'py>, name: &str) -> Option<Bound<'py, PyBytes>> {
        self.0
            .files()
            .get(name)
            .map(|bytes| PyBytes::new(py, bytes))
    }

    fn write(&self, py: Python<'_>, path: PathBuf, replace: bool) -> PyResult<()> {
        let run = std::sync::Arc::clone(&self.0);
        let job = move || run.write(&path, replace);
        work(py, &SharedProgress::default(), None, job)
    }

    /// Return the state for pickling: the run without its values as JSON, and the values as bytes.
    fn state<'py>(&self, py: Python<'py>) -> (String, Bound<'py, PyBytes>) {
        let text = serde_json::to_string(&*self.0).expect("runs hold only names and numbers");
        let values = self.0.table().map_or(&[][..], |table| &table.values);
        let bytes: Vec<u8> = values
            .iter()
            .flat_map(|value| value.to_le_bytes())
            .collect();
        (text, PyBytes::new(py, &bytes))
    }

    #[classmethod]
    fn restore(_class: &Bound<'_, PyType>, text: &str, values: &[u8]) -> PyResult<Self> {
        let mut run: front::Run = serde_json::from_str(text).map_err(|error| {
            PyValueError::new_err(format!(
                "the pickled run is not of this version of admire: {error}"
            ))
        })?;
        let (chunks, _) = values.as_chunks::<8>();
        run.set_values(
            chunks
                .iter()
                .map(|bytes| f64::from_le_bytes(*bytes))
                .collect(),
        );
        let whole = run
            .table()
            .is_none_or(|table| table.values.len() == table.kinds.len() * table.catalogue.len());
        if !whole {
            return Err(PyValueError::new_err(
                "the pickled run is damaged: values are missing",
            ));
        }
        Ok(Self::of(run))
    }
}
