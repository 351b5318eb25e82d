//! A run that reads its dataset from memory and keeps columns of its results there: what thousands of variants need.

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

/// What a run in memory begins with.
#[derive(Clone, Copy, Debug)]
pub struct TrialInput<'t> {
    /// Takes the place of every dataset that the commands name. Files it names are looked up from the folder of its name.
    pub deck: &'t Source,
    /// The command file.
    pub commands: &'t Source,
    /// The columns that are kept, by their ids in the catalogue of the run.
    pub columns: &'t [usize],
    /// What may be left out of the model.
    pub ignored: &'t [Ignore],
}

/// What came of a run in memory.
#[derive(Clone, Debug)]
pub struct InMemoryRun {
    /// How it ended.
    pub ending: Ending,
    /// All columns the run has; `None` if no simulation began.
    pub catalogue: Option<Catalogue>,
    /// Time and the values of the kept columns of every step, without that of the dataset itself (`input`). A column that the run does
    /// not have is NaN.
    pub steps: Vec<(f64, Vec<f64>)>,
    /// The modes of the last LINEAR/EIGENSOL, one of each pair, in the order of `.modes.json`.
    pub modes: Vec<Mode>,
    /// The first error.
    pub error: Option<String>,
}

impl InMemoryRun {
    /// Runs the commands. Nothing is written: SAVE keeps its state for RELOAD of the same run.
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
