//! Run of a complete deck with its own command file, by an external program with the command line of ADAMS.

use std::io::BufReader;
use std::path::{Path, PathBuf};
use std::time::Duration;

use super::answer::run_command;
use super::licence::patiently;
use super::process::tail;
use super::run_folder::{RunFiles, STEM};
use super::{Recording, RunError};
use admire_results::{Catalogue, StepKind, XrfReader};
use admire_syntax::Dataset;
use admire_syntax::text::{Source, open_to_read};

/// An external program with the command line of ADAMS, and a recording of its runs.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct ProgramRun {
    command: Option<Vec<String>>,
    recording: Option<Recording>,
    timeout: Duration,
    licence_wait: Duration,
}

/// Input of a run of a complete deck.
#[derive(Clone, Copy, Debug)]
pub struct DeckRun<'r> {
    /// The deck. RESULTS/XRF is added if the deck lacks it.
    pub deck: &'r Source,
    /// The command file. The deck replaces any model that it names.
    pub commands: &'r Source,
    /// The user's original deck. Files that the deck names are looked up in the folder of the original.
    pub original: &'r Dataset,
    /// Ids of the result columns to be read.
    pub columns: &'r [usize],
}

/// Result of a run of a complete deck.
#[derive(Clone, PartialEq, Debug)]
pub struct DeckAnswer {
    /// Names of all columns in the results file.
    pub catalogue: Catalogue,
    /// Time and selected values of every output step. The step `input`, which shows the model as read, is left out.
    pub steps: Vec<(f64, Vec<f64>)>,
    /// True if the results file reports a successful run and contains at least one step.
    pub successful: bool,
    /// Last lines that the run printed, if it was not successful; empty otherwise.
    pub complaint: String,
}

impl ProgramRun {
    /// Creates a runner from a command line, in which `{acf}` is replaced by the name of the command file.
    ///
    /// A run is killed after `timeout_s` seconds. If the program gets no licence, the run is repeated for up to `licence_wait_s` seconds.
    ///
    /// A run that was recorded before is read from the recording, and a new run is added to the recording. Without a command, only recorded
    /// runs are available.
    pub fn new(
        command: Option<Vec<String>>,
        recording: Option<Recording>,
        timeout_s: f64,
        licence_wait_s: f64,
    ) -> Self {
        let seconds = |s: f64| Duration::try_from_secs_f64(s).unwrap_or(Duration::MAX);
        Self {
            command,
            recording,
            timeout: seconds(timeout_s),
            licence_wait: seconds(licence_wait_s),
        }
    }

    /// Runs a deck in a temporary folder, or reads the run from the recording if it was recorded before.
    ///
    /// # Errors
    /// Returns a [`RunError`] if the run gives no valid result.
    pub fn run(&self, run: &DeckRun<'_>) -> Result<DeckAnswer, RunError> {
        let own = RunFiles::of_deck(run.deck, run.commands, run.original);
        if let Some(folder) = self.recording.as_ref().and_then(|all| all.find(&own)) {
            return read(&results_in(&folder)?, run.columns, &folder);
        }
        let Some(command) = &self.command else {
            let place = self
                .recording
                .as_ref()
                .map(|all| all.folder.display().to_string());
            return Err(RunError::NotRecorded {
                key: own.key(),
                folder: place.unwrap_or_default(),
            });
        };
        patiently(self.licence_wait, || self.attempt(command, &own, run))
    }

    fn attempt(
        &self,
        command: &[String],
        own: &RunFiles,
        run: &DeckRun<'_>,
    ) -> Result<DeckAnswer, RunError> {
        let files = |error: std::io::Error| RunError::Files(error.to_string());
        let folder = tempfile::Builder::new()
            .prefix("admire-run-")
            .tempdir()
            .map_err(files)?;
        let folder = folder.path();
        own.write(folder).map_err(files)?;
        run_command(command, folder, self.timeout)?;
        let mut path = results_in(folder)?;
        if let Some(recording) = &self.recording {
            // In a recording, the results file always has the same name.
            let usual = folder.join(format!("{STEM}.res"));
            std::fs::rename(&path, &usual).map_err(files)?;
            recording.keep(own, folder).map_err(files)?;
            path = usual;
        }
        read(&path, run.columns, folder)
    }
}

/// Returns the results file of a run. If the command file gave it another name than usual, it must be the only results file.
fn results_in(folder: &Path) -> Result<PathBuf, RunError> {
    let usual = folder.join(format!("{STEM}.res"));
    if usual.is_file() {
        return Ok(usual);
    }
    let all = std::fs::read_dir(folder).map_err(|error| RunError::Files(error.to_string()))?;
    let is_one = |path: &PathBuf| {
        path.extension()
            .is_some_and(|e| e.eq_ignore_ascii_case("res"))
    };
    let mut found: Vec<PathBuf> = all
        .flatten()
        .map(|entry| entry.path())
        .filter(is_one)
        .collect();
    match (found.pop(), found.is_empty()) {
        (Some(path), true) => Ok(path),
        (first, _) => Err(RunError::Results {
            reason: match first {
                None => "the run wrote no results".to_string(),
                Some(_) => {
                    "the run wrote several results files, so the right one is unknown".to_string()
                }
            },
            tail: tail(folder),
        }),
    }
}

fn read(path: &Path, columns: &[usize], folder: &Path) -> Result<DeckAnswer, RunError> {
    let wrong = |reason: String| RunError::Results {
        reason,
        tail: tail(folder),
    };
    let file = open_to_read(path).map_err(|error| wrong(error.to_string()))?;
    let name = path.display().to_string();
    let mut reader =
        XrfReader::open(name, BufReader::new(file)).map_err(|error| wrong(error.to_string()))?;
    let catalogue = reader.catalogue().clone();
    let time = catalogue
        .columns()
        .find(|column| column.component.name.eq_ignore_ascii_case("TIME"))
        .map_or(1, |column| column.component.id);
    // The reader requires column ids in ascending order.
    let mut ids: Vec<usize> = columns.iter().copied().chain([time]).collect();
    ids.sort_unstable();
    ids.dedup();
    let place = |id: &usize| ids.binary_search(id).unwrap_or_default();
    let mut steps = Vec::new();
    loop {
        let step = reader
            .next_step()
            .map_err(|error| wrong(error.to_string()))?;
        let Some(step) = step else { break };
        if step.kind == StepKind::Input {
            continue;
        }
        let mut values = Vec::with_capacity(ids.len());
        step.pick(&ids, &mut values)
            .map_err(|error| wrong(error.to_string()))?;
        let row = columns.iter().map(|id| values[place(id)]).collect();
        steps.push((values[place(&time)], row));
    }
    let successful = reader.run_status() == Some("Successful") && !steps.is_empty();
    Ok(DeckAnswer {
        catalogue,
        steps,
        successful,
        complaint: if successful {
            String::new()
        } else {
            tail(folder)
        },
    })
}
