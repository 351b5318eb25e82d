use std::path::PathBuf;
use std::sync::{Mutex, MutexGuard, PoisonError};

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::{PyBytes, PyList};
use serde_json::Value;

use crate::front;
use crate::front::{Beside, Setting};
use admire_diagnosis::SharedProgress;
use admire_kc::Convention;
use admire_syntax::diff::DiffTolerance;

use super::block::Block;
use super::refusal::{json, raised};
use super::run::Run;
use super::work::{at_once, work};

/// Commands that find a single equilibrium.
const EQUILIBRIUM: &str = "SIMULATE/STATICS\n";
/// Largest size in bytes of a deck whose equilibrium takes only milliseconds, whether it is found or not.
const SMALL: usize = 1 << 16;

/// An ADAMS dataset.
#[pyclass(frozen, module = "admire._admire")]
pub(super) struct Deck(Mutex<front::Deck>);

impl Deck {
    fn lock(&self) -> MutexGuard<'_, front::Deck> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns a copy of the current deck, so that work on the copy does not hold the lock.
    pub(super) fn now(&self, py: Python<'_>) -> front::Deck {
        py.detach(|| self.lock().clone())
    }

    fn of(deck: front::Deck) -> Self {
        Self(Mutex::new(deck))
    }
}

#[pymethods]
impl Deck {
    #[staticmethod]
    fn open(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let opened = work(py, &SharedProgress::default(), None, move || {
            front::Deck::open(&path)
        });
        opened.map(Self::of)
    }

    #[staticmethod]
    fn parse(py: Python<'_>, name: &str, bytes: Vec<u8>) -> PyResult<Self> {
        let name = name.to_string();
        let job = move || Ok(front::Deck::parse(&name, bytes));
        work(py, &SharedProgress::default(), None, job).map(Self::of)
    }

    fn copy(&self, py: Python<'_>) -> Self {
        Self::of(self.now(py))
    }

    fn name(&self, py: Python<'_>) -> String {
        self.now(py).name().to_string()
    }

    fn title(&self, py: Python<'_>) -> String {
        self.now(py).title()
    }

    fn bytes<'py>(&self, py: Python<'py>) -> Bound<'py, PyBytes> {
        PyBytes::new(py, self.now(py).bytes())
    }

    /// Return the value at an address.
    fn get<'py>(&self, py: Python<'py>, address: &str) -> PyResult<Bound<'py, PyAny>> {
        let found = self.now(py).get(address);
        object(py, &found.map_err(|error| raised(py, &error))?)
    }

    /// Return the addresses that match a pattern, each with its value.
    fn values<'py>(
        &self,
        py: Python<'py>,
        pattern: &str,
    ) -> PyResult<Vec<(String, Bound<'py, PyAny>)>> {
        let found = self.now(py).values(pattern);
        let found = found.map_err(|error| raised(py, &error))?;
        let each = |(address, value): (String, Value)| Ok((address, object(py, &value)?));
        found.into_iter().map(each).collect()
    }

    /// Set all values, or none if one of them is refused.
    fn set(&self, py: Python<'_>, values: Vec<(String, Given)>) -> PyResult<()> {
        let changed = py.detach(|| {
            let mut held = self.lock();
            let mut deck = held.clone();
            for (address, value) in values {
                deck.set(&address, Setting::from(value))?;
            }
            *held = deck;
            Ok(())
        });
        changed.map_err(|error| raised(py, &error))
    }

    fn save(&self, py: Python<'_>, force: bool) -> PyResult<()> {
        let saved = py.detach(|| self.lock().save(force));
        saved.map_err(|error| raised(py, &error))
    }

    fn save_as(&self, py: Python<'_>, path: PathBuf, replace: bool, force: bool) -> PyResult<()> {
        let saved = py.detach(|| self.lock().save_as(path, replace, force));
        saved.map_err(|error| raised(py, &error))
    }

    /// Return the complaints of the check as JSON.
    fn check(&self, py: Python<'_>) -> PyResult<String> {
        let deck = self.now(py);
        let job = move || deck.check();
        Ok(json(&work(py, &SharedProgress::default(), None, job)?))
    }

    /// Return the differences to another deck as JSON.
    fn diff(&self, py: Python<'_>, other: &Self, relative: f64, absolute: f64) -> PyResult<String> {
        let (a, b) = (self.now(py), other.now(py));
        let tolerance = DiffTolerance { absolute, relative };
        let job = move || Ok(a.diff(&b, tolerance));
        let found = work(py, &SharedProgress::default(), None, job)?;
        Ok(serde_json::to_string(&found).expect("differences hold only names and numbers"))
    }

    /// Set values, then execute the command file at `path`, or the text `commands` if there is no path.
    #[pyo3(signature = (values, path, commands, progress))]
    fn run(
        &self,
        py: Python<'_>,
        values: Vec<(String, Given)>,
        path: Option<PathBuf>,
        commands: &str,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<Run> {
        let mut deck = self.now(py);
        let commands = commands.to_string();
        let short = path.is_none() && commands == EQUILIBRIUM && deck.bytes().len() <= SMALL;
        let watched = SharedProgress::default();
        let watch = watched.clone();
        let job = move || {
            for (address, value) in values {
                deck.set(&address, Setting::from(value))?;
            }
            match path {
                Some(path) => deck.run_file_watched(&path, &watch),
                None => Ok(deck.run_watched("commands", &commands, &watch)),
            }
        };
        if short {
            at_once(py, job).map(Run::of)
        } else {
            work(py, &watched, progress.as_ref(), job).map(Run::of)
        }
    }

    /// Return the names of the columns, the addresses, the values, and the derivatives with one row for each address.
    #[allow(clippy::type_complexity)]
    fn sensitivity(
        &self,
        py: Python<'_>,
        of: Vec<String>,
        by: Vec<String>,
        time: f64,
    ) -> PyResult<(Vec<String>, Vec<String>, Vec<f64>, Block)> {
        let deck = self.now(py);
        let job = move || deck.sensitivity(&of, &by, time);
        let table = work(py, &SharedProgress::default(), None, job)?;
        let (mut addresses, mut values, mut rows) = (Vec::new(), Vec::new(), Vec::new());
        for row in table.by {
            addresses.push(row.address);
            values.push(row.value);
            rows.extend(row.derivatives);
        }
        let block = Block::new(rows, table.of.len());
        Ok((table.of, addresses, values, block))
    }

    /// Return a page that shows the mechanism, moving through the steps of a results file if one is given.
    #[pyo3(signature = (results, highlight))]
    fn page(
        &self,
        py: Python<'_>,
        results: Option<PathBuf>,
        highlight: Vec<String>,
    ) -> PyResult<String> {
        let deck = self.now(py);
        let job = move || deck.mechanism_page(results.as_deref(), &highlight);
        work(py, &SharedProgress::default(), None, job)
    }

    /// Run the K&C tests. Return `kc.json`, `curves.csv`, `gradients.csv`, the report, and the complaints as JSON.
    ///
    /// The report compares the results with other decks, given with their names, and with a table of measured curves.
    #[pyo3(signature = (config, convention, compare, measured))]
    fn kc(
        &self,
        py: Python<'_>,
        config: PathBuf,
        convention: &str,
        compare: Vec<(String, Py<Self>)>,
        measured: Option<PathBuf>,
    ) -> PyResult<(String, String, String, String, String)> {
        let convention = match convention {
            "adams-car" => Convention::AdamsCar,
            "iso" => Convention::Iso,
            "sae" => Convention::Sae,
            other => {
                let message = format!("the convention is adams-car, iso or sae, not `{other}`");
                return Err(PyValueError::new_err(message));
            }
        };
        let deck = self.now(py);
        let others = compare.into_iter();
        let beside = Beside {
            decks: others
                .map(|(name, other)| (name, other.get().now(py)))
                .collect(),
            measured,
        };
        let job = move || deck.kc_beside(&config, convention, &beside);
        let found = work(py, &SharedProgress::default(), None, job)?;
        let values = found.values.to_string();
        let told = json(&found.complaints);
        Ok((values, found.curves, found.gradients, found.html, told))
    }
}

/// Value that Python passes for a setting.
#[derive(FromPyObject)]
pub(super) enum Given {
    Flag(bool),
    Number(f64),
    Text(String),
    Numbers(Vec<f64>),
}

impl From<Given> for Setting {
    fn from(given: Given) -> Self {
        match given {
            Given::Flag(on) => Self::Flag(on),
            Given::Number(value) => Self::Number(value),
            Given::Text(text) => Self::Text(text),
            Given::Numbers(values) => Self::Numbers(values),
        }
    }
}

/// Converts a value to a Python object.
fn object<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Bool(on) => on.into_pyobject(py)?.to_owned().into_any(),
        Value::Number(number) => match number.as_i64() {
            Some(whole) => whole.into_pyobject(py)?.into_any(),
            None => number.as_f64().into_pyobject(py)?.into_any(),
        },
        Value::String(text) => text.into_pyobject(py)?.into_any(),
        Value::Array(all) => {
            let each: PyResult<Vec<_>> = all.iter().map(|value| object(py, value)).collect();
            PyList::new(py, each?)?.into_any()
        }
        Value::Null | Value::Object(_) => py.None().into_bound(py),
    })
}
