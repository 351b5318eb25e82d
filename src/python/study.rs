use std::path::PathBuf;

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::front;
use crate::front::{Error, ErrorKind, TuningOptions};
use admire_design::Aim;
use admire_diagnosis::{GainCheck, ProgressObserver as _, SharedProgress};
use admire_identify::global::Marginal;
use admire_identify::{Fit, LoadedStudy};
use admire_report::VERSION;
use admire_study::settings::Method;
use admire_sweep::uncertainty::{
    Kind, LEAST_DRAWS, LEAST_REPLICATES, MOST, RepeatOutput, Repeats, repeat,
};
use admire_sweep::{Progress, Row};
use admire_syntax::diagnostic::{Code, Diagnostic};

use super::block::Block;
use super::refusal::json;
use super::work::work;

/// A study folder: a deck, load cases and measurements.
#[pyclass(frozen, module = "admire._admire")]
pub(super) struct Study(front::Study);

#[pymethods]
impl Study {
    #[staticmethod]
    fn open(py: Python<'_>, folder: PathBuf) -> PyResult<Self> {
        let job = move || front::Study::open(&folder);
        work(py, &SharedProgress::default(), None, job).map(Self)
    }

    fn folder(&self) -> PathBuf {
        self.0.folder().to_path_buf()
    }

    fn deck(&self) -> PathBuf {
        self.0.deck()
    }

    /// Return the warnings and notes about the study as JSON.
    fn complaints(&self) -> String {
        json(self.0.complaints())
    }

    /// Return the command that is started for every equilibrium, or None if the study names none.
    fn starts_program(&self) -> Option<String> {
        self.0.starts_program().map(|words| words.join(" "))
    }

    /// Identify the stiffnesses.
    ///
    /// Return `identification.json`, a summary, the deck, the report, the remarks, and the parameters from the bootstrap fits and from the
    /// posterior draws, with one row for each repeat.
    #[pyo3(signature = (method, force, repeats, progress, allow_command))]
    #[allow(clippy::type_complexity)]
    fn identify<'py>(
        &self,
        py: Python<'py>,
        method: Option<&str>,
        force: bool,
        repeats: (Option<u64>, Option<u64>, u64, Option<usize>),
        progress: Option<Bound<'py, PyAny>>,
        allow_command: bool,
    ) -> PyResult<(
        String,
        String,
        Bound<'py, PyBytes>,
        String,
        Vec<String>,
        [Option<Block>; 2],
    )> {
        let mut study = self.permitted(allow_command);
        match method {
            None => {}
            Some("gauss-newton") => study.set_method(Method::GaussNewton),
            Some("regression") => study.set_method(Method::Regression),
            Some("direct") => study.set_method(Method::Direct),
            Some(other) => {
                let message =
                    format!("the method is gauss-newton, regression or direct, not `{other}`");
                return Err(PyValueError::new_err(message));
            }
        }
        let repeats = asked(repeats)?;
        let watched = SharedProgress::default();
        let watch = watched.clone();
        let job = move || repeated(&study, force, repeats.as_ref(), &watch);
        let (found, tables) = work(py, &watched, progress.as_ref(), job)?;
        let deck = PyBytes::new(py, &found.deck);
        Ok((
            found.fit.to_json(),
            found.lead,
            deck,
            found.html,
            found.remarks,
            tables,
        ))
    }

    /// Diagnose the model. Return `diagnosis.json`, the result as sentences, the extended deck, its command file, the report, and the
    /// remarks.
    #[pyo3(signature = (force, check, progress, allow_command))]
    #[allow(clippy::type_complexity)]
    fn diagnose<'py>(
        &self,
        py: Python<'py>,
        force: bool,
        check: &str,
        progress: Option<Bound<'py, PyAny>>,
        allow_command: bool,
    ) -> PyResult<(
        String,
        Vec<String>,
        Bound<'py, PyBytes>,
        String,
        String,
        Vec<String>,
    )> {
        let check = match check {
            "quick" => GainCheck::Quick,
            "held-out" => GainCheck::HeldOut,
            "folds" => GainCheck::Folds,
            other => {
                let message = format!("check_gain is quick, held-out or folds, not `{other}`");
                return Err(PyValueError::new_err(message));
            }
        };
        let study = self.permitted(allow_command);
        let watched = SharedProgress::default();
        let watch = watched.clone();
        let job = move || study.diagnose_checked(force, check, &watch);
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

    /// Search for the target. Return `tuning.json`, a summary, the tuned deck and the report.
    #[pyo3(signature = (restarts, draws, pareto, progress))]
    fn tune<'py>(
        &self,
        py: Python<'py>,
        restarts: Option<usize>,
        draws: Option<usize>,
        pareto: Option<(String, String)>,
        progress: Option<Bound<'py, PyAny>>,
    ) -> PyResult<(String, String, Bound<'py, PyBytes>, String)> {
        let options = TuningOptions {
            restarts,
            draws,
            pareto: pareto.map(|(first, second)| [first, second]),
        };
        let study = self.0.clone();
        let watched = SharedProgress::default();
        let watch = watched.clone();
        let job = move || study.tune(&options, &watch);
        let found = work(py, &watched, progress.as_ref(), job)?;
        let deck = PyBytes::new(py, &found.deck);
        Ok((found.json, found.summary, deck, found.html))
    }

    /// Plan further measurements. Return `plan.json`, and load cases as rows in the format of the study's load case file.
    #[pyo3(signature = (aim, count, force, progress))]
    fn plan(
        &self,
        py: Python<'_>,
        aim: &str,
        count: usize,
        force: bool,
        progress: Option<Bound<'_, PyAny>>,
    ) -> PyResult<(String, String)> {
        let aim = match aim {
            "all" => Aim::All,
            "stiffnesses" => Aim::Stiffnesses,
            "curves" => Aim::Curves,
            "causes" => Aim::Causes,
            other => {
                let message =
                    format!("the aim is all, stiffnesses, curves or causes, not `{other}`");
                return Err(PyValueError::new_err(message));
            }
        };
        let study = self.0.clone();
        let watched = SharedProgress::default();
        let watch = watched.clone();
        let job = move || study.plan(aim, count, force, &watch);
        let found = work(py, &watched, progress.as_ref(), job)?;
        Ok((found.plan.to_json(), found.suggested))
    }
}

impl Study {
    /// Returns a copy of the study for a single call, with or without permission to start the study's program.
    fn permitted(&self, allow_command: bool) -> front::Study {
        let mut study = self.0.clone();
        if allow_command {
            study.allow_command();
        }
        study
    }
}

/// Checks the requested repetitions: numbers of bootstrap fits and posterior draws, seed, and number of threads.
fn asked(
    (bootstrap, posterior, seed, jobs): (Option<u64>, Option<u64>, u64, Option<usize>),
) -> PyResult<Option<Repeats>> {
    let counts = [
        ("bootstrap", bootstrap, LEAST_REPLICATES),
        ("posterior", posterior, LEAST_DRAWS),
    ];
    for (name, count, least) in counts {
        if count.is_some_and(|count| !(least..=MOST).contains(&count)) {
            let message = format!("{name} must be from {least} to {MOST}");
            return Err(PyValueError::new_err(message));
        }
    }
    let any = bootstrap.is_some() || posterior.is_some();
    Ok(any.then(|| Repeats {
        bootstrap,
        posterior,
        seed,
        threads: jobs.unwrap_or_else(|| {
            std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
        }),
    }))
}

/// Identifies a study with repetitions. Returns the identification, and the parameters from the bootstrap fits and from the posterior
/// draws.
fn repeated(
    study: &front::Study,
    force: bool,
    asked: Option<&Repeats>,
    watch: &SharedProgress,
) -> Result<(front::Identification, [Option<Block>; 2]), Error> {
    let mut tables = [None, None];
    let Some(asked) = asked else {
        return Ok((study.identify(force, watch)?, tables));
    };
    let failed =
        |why: &str| Error::plain(ErrorKind::NoAnswer, &Diagnostic::error(Code::NoFit, why));
    let mut again = |loaded: &LoadedStudy, marginal: &Marginal, fit: &mut Fit| {
        let (problem, numbers) = (loaded.problem(), fit.parameters.len());
        let mut told = None;
        let mut tell = |kind: Kind, progress: &Progress| {
            if told != Some(kind) {
                watch.stage(kind.word());
                told = Some(kind);
            }
            watch.count(progress.done as usize, Some(progress.all as usize), "");
            watch.goes_on()
        };
        let made = repeat(&problem, marginal, fit, asked, None, VERSION, &mut tell)
            .map_err(|error| failed(&error.to_string()))?
            .ok_or_else(|| failed("the repetitions of the fit were stopped before the end"))?;
        for (kind, made) in made {
            let RepeatOutput::Rows(rows) = made else {
                continue;
            };
            let none = vec![f64::NAN; numbers];
            let of = |row: &Row| row.outputs.get(..numbers).unwrap_or(&none).to_vec();
            let values = rows.iter().flat_map(of).collect();
            tables[usize::from(kind == Kind::Posterior)] = Some(Block::new(values, numbers));
        }
        Ok(())
    };
    let found = study.identify_and(force, watch, Some(&mut again))?;
    Ok((found, tables))
}
