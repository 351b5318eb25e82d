//! A run that keeps its dataset and selected result columns in memory, for thousands of variants of a deck.

use std::io;
use std::path::{Path, PathBuf};

use admire_results::{Catalogue, StepKind};
use admire_solver::model::Ignore;
use admire_solver::motion::Mode;
use admire_syntax::diagnostic::Severity;
use admire_syntax::text::Source;
use admire_syntax::{CommandFile, Dataset};

use super::ending::Ending;
use super::files::folder_of;
use super::run_state::Session;

/// Input of a run that is kept in memory.
#[derive(Clone, Copy, Debug)]
pub struct TrialInput<'t> {
    /// Dataset that replaces every dataset named in the commands. Files that it names are looked up in the folder given by its name.
    pub deck: &'t Source,
    /// The command file.
    pub commands: &'t Source,
    /// Ids of the result columns that are kept, as in the catalogue of the run.
    pub columns: &'t [usize],
    /// Statements that may be left out of the model if the solver does not support them.
    pub ignored: &'t [Ignore],
}

/// Output of a run that is kept in memory.
#[derive(Clone, Debug)]
pub struct InMemoryRun {
    /// Reason for the end of the run, and counts of failures.
    pub ending: Ending,
    /// Names of all result columns; `None` if no simulation was started.
    pub catalogue: Option<Catalogue>,
    /// Time and kept values of every output step. The step `input`, which shows the model as read, is left out. A column that the run does
    /// not have is NaN.
    pub steps: Vec<(f64, Vec<f64>)>,
    /// Modes of the last LINEAR/EIGENSOL, with one mode of each conjugate pair, in the same order as in `.modes.json`.
    pub modes: Vec<Mode>,
    /// Message of the first error, if there was one.
    pub error: Option<String>,
}

impl InMemoryRun {
    /// Runs the commands without writing files. SAVE keeps its state in memory, for RELOAD in the same run.
    pub fn run(input: TrialInput<'_>) -> Self {
        let folder = Path::new(input.commands.name())
            .parent()
            .map_or_else(PathBuf::new, Path::to_path_buf);
        let session = Session::new(Box::new(io::sink()), &folder)
            .confined(&[folder.clone(), folder_of(input.deck)])
            .ignoring(input.ignored.to_vec());
        let deck = Dataset::parse(input.deck.clone());
        let commands = CommandFile::parse(input.commands.clone());
        let (ending, record) = session.run_on(&deck, &commands);
        let mut steps = Vec::new();
        if let Some(table) = &record.results {
            let width = table.catalogue.len().max(1);
            for (kind, row) in table.kinds.iter().zip(table.values.chunks(width)) {
                if *kind != StepKind::Input {
                    let value = |id: &usize| row.get(id - 1).copied().unwrap_or(f64::NAN);
                    // The first column is the time.
                    steps.push((row[0], input.columns.iter().map(value).collect()));
                }
            }
        }
        let mut errors = record.diagnostics.iter();
        let first = errors.find(|told| told.severity == Severity::Error);
        Self {
            ending,
            catalogue: record.results.map(|table| table.catalogue),
            steps,
            modes: record.modes,
            error: first.map(|told| told.message.clone()),
        }
    }
}
