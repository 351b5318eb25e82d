//! A run that reads its dataset from memory and keeps columns of its results there: what thousands of variants need.

use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

use crate::model::{Ignore, Model};
use crate::motion::Mode;
use crate::results::Catalogue;
use crate::text::Source;

use super::columns::Columns;
use super::files::folder_of;
use super::measures::Measures;
use super::message::Messages;
use super::run::{Ending, Session};

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
pub struct Trial {
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

impl Trial {
    /// Runs the commands. Nothing is written: SAVE keeps its state for RELOAD of the same run.
    pub fn run(input: TrialInput<'_>) -> Self {
        let start = Instant::now();
        let folder = Path::new(input.commands.name())
            .parent()
            .map_or_else(PathBuf::new, Path::to_path_buf);
        let mut session = Session::new(Box::new(io::sink()), &folder)
            .confined(&[folder.clone(), folder_of(input.deck)])
            .ignoring(input.ignored.to_vec());
        session.messages = Messages::silent();
        session.memory = Some(Memory {
            deck: input.deck.clone(),
            tap: Tap {
                ids: input.columns.to_vec(),
                ..Tap::default()
            },
        });
        session.sources.add(input.deck.clone());
        let flow = session.execute(input.commands, 0);
        let ending = session.finish(flow, start);
        let tap = session.memory.take().map_or_else(Tap::default, |m| m.tap);
        Self {
            ending,
            catalogue: tap.layout.map(|layout| layout.catalogue),
            steps: tap.steps,
            modes: tap.modes,
            error: session.messages.first_error(),
        }
    }
}

/// What a run in memory has in place of files.
pub(super) struct Memory {
    pub deck: Source,
    pub tap: Tap,
}

/// Takes columns from the steps of a run.
#[derive(Default)]
pub(super) struct Tap {
    ids: Vec<usize>,
    layout: Option<Columns>,
    values: Vec<f64>,
    steps: Vec<(f64, Vec<f64>)>,
    pub modes: Vec<Mode>,
}

impl Tap {
    /// A simulation of this model begins.
    pub fn begin(&mut self, model: &Model) {
        self.layout = Some(Columns::of(model));
    }

    /// Takes a step.
    pub fn step(&mut self, model: &Model, measures: &mut Measures<'_>) {
        let Some(layout) = &self.layout else {
            return;
        };
        layout.step(model, measures, &mut self.values);
        let value = |id: &usize| self.values.get(id - 1).copied().unwrap_or(f64::NAN);
        let row = self.ids.iter().map(value).collect();
        self.steps.push((measures.state.time, row));
    }
}
