use std::path::{Path, PathBuf};

use pyo3::prelude::*;

use crate::front::{Error, ErrorKind, replace_file};
use admire_diagnosis::{ProgressObserver, SharedProgress};
use admire_report::VERSION;
use admire_session::Sources;
use admire_sweep::{
    Manifest, Runner, Shard, Summary, SweepFolder, SweepPlan, merge, page, run_shard,
};
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};

use super::work::work;

/// Run the unfinished cases of a sweep or of one of its shards. After a whole sweep, join the shards and return `summary.json`; after a
/// shard, return None.
#[pyfunction]
#[pyo3(signature = (plan, out, jobs, shard, progress, allow_command))]
pub(super) fn sweep<'py>(
    py: Python<'py>,
    plan: PathBuf,
    out: PathBuf,
    jobs: Option<usize>,
    shard: Option<(u64, u64)>,
    progress: Option<Bound<'py, PyAny>>,
    allow_command: bool,
) -> PyResult<Option<String>> {
    let watched = SharedProgress::default();
    let watch = watched.clone();
    let job = move || run((&plan, allow_command), &out, jobs, shard, &watch);
    work(py, &watched, progress.as_ref(), job)
}

/// Join the shards of a sweep and return `summary.json`.
#[pyfunction]
pub(super) fn merge_shards(py: Python<'_>, folder: PathBuf) -> PyResult<String> {
    let job = move || {
        let opened = SweepFolder::open(&folder);
        joined(&opened.map_err(|wrong| refused(&[wrong], &Sources::default()))?)
    };
    work(py, &SharedProgress::default(), None, job)
}

/// Return the command that is started for every case, or None if neither the plan nor its study names one. Errors in the plan are reported
/// by `sweep`.
#[pyfunction]
pub(super) fn program_of_sweep(py: Python<'_>, plan: PathBuf) -> PyResult<Option<String>> {
    let job = move || {
        let plan = SweepPlan::read(&plan).value;
        Ok(plan.and_then(|plan| plan.starts_program().map(|words| words.join(" "))))
    };
    work(py, &SharedProgress::default(), None, job)
}

fn refused(found: &[Diagnostic], sources: &Sources) -> Error {
    Error::new(ErrorKind::Input, found, sources)
}

fn failed(code: Code, error: &dyn std::fmt::Display) -> Error {
    Error::plain(
        ErrorKind::Input,
        &Diagnostic::error(code, error.to_string()),
    )
}

fn run(
    (path, allow_command): (&Path, bool),
    out: &Path,
    jobs: Option<usize>,
    shard: Option<(u64, u64)>,
    watch: &SharedProgress,
) -> Result<Option<String>, Error> {
    let shard = match shard {
        None => Shard::WHOLE,
        Some((number, of)) => format!("{number}/{of}")
            .parse()
            .map_err(|error| failed(Code::OutOfRange, &error))?,
    };
    watch.stage("reading");
    let read = SweepPlan::read(path);
    let mut sources = Sources::default();
    for source in read.value.iter().flat_map(|plan| &plan.inputs) {
        sources.add(source.clone());
    }
    let Some(plan) = read.value else {
        if let Ok(source) = admire_syntax::text::Source::read(path) {
            sources.add(source);
        }
        let errors: Vec<Diagnostic> = read
            .diagnostics
            .into_iter()
            .filter(|d| d.severity == Severity::Error)
            .collect();
        return Err(refused(&errors, &sources));
    };
    let one = |wrong: Diagnostic| refused(&[wrong], &sources);
    if let Some(program) = plan.named_program()
        && !allow_command
        && !program.is_allowed()
    {
        let help = "allow the program by `allow_command=True`; or run `admire sweep` on a terminal, which asks once";
        return Err(Error::plain(ErrorKind::Usage, &program.refusal(help)));
    }
    let manifest = Manifest::of(&plan, shard.of, VERSION);
    SweepFolder::look(out, manifest.clone()).map_err(one)?;
    let runner = Runner::prepare(&plan).map_err(|wrong| refused(&wrong, &sources))?;
    let folder = SweepFolder::begin(out, manifest).map_err(one)?;
    if shard != Shard::WHOLE || !folder.results().is_file() {
        watch.stage("sweep");
        let threads =
            jobs.unwrap_or_else(|| std::thread::available_parallelism().map_or(1, usize::from));
        let done = run_shard(&runner, &plan, &folder, shard, threads, |progress| {
            let most = (progress.all - progress.before) as usize;
            watch.count(progress.done as usize, Some(most), "cases");
            watch.goes_on()
        })
        .map_err(|error| failed(Code::CannotWrite, &error))?;
        if !done.is_complete() {
            return Err(failed(
                Code::CannotWrite,
                &"the sweep was stopped; the same call continues where it stopped",
            ));
        }
    }
    if shard != Shard::WHOLE {
        return Ok(None);
    }
    joined(&folder).map(Some)
}

/// Joins the shards and writes `summary.json` and `report.html`. Returns the text of `summary.json`.
fn joined(folder: &SweepFolder) -> Result<String, Error> {
    merge(folder).map_err(|wrong| refused(&wrong, &Sources::default()))?;
    let summary = Summary::of(folder).map_err(|error| failed(Code::CannotRead, &error))?;
    let json = serde_json::to_string_pretty(&summary).expect("numbers print") + "\n";
    let html = page(folder, &summary).map_err(|error| failed(Code::CannotWrite, &error))?;
    for (name, text) in [("summary.json", &json), ("report.html", &html)] {
        let path = folder.path.join(name);
        replace_file(&path, text.as_bytes()).map_err(|error| Error::unwritable(&path, &error))?;
    }
    Ok(json)
}
