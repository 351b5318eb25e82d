use std::collections::BTreeMap;
use std::io;
use std::path::Path;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use admire_results::{Catalogue, ResultsTable, SelectedColumn, Selection, StepKind};
use admire_session::{Ending, Session, Stop, folder_of};
use admire_solver::statics::Balance;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic, Severity};
use admire_syntax::{CommandFile, Dataset};

use super::error::{Complaint, Error, ErrorKind};
use super::results::{one_column, selected};
use super::writing::{may_replace, replace_file};
use admire_diagnosis::ProgressObserver;

/// Results of executing commands on a deck: results, messages and other files, all in memory.
///
/// Values have full precision, while the results file of `admire solve` or `mdi` rounds them. [`write`](Self::write) writes the same bytes
/// as these programs.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Run {
    ending: Ending,
    table: Option<ResultsTable>,
    complaints: Vec<Complaint>,
    files: BTreeMap<String, Vec<u8>>,
    balance: BTreeMap<String, (f64, String)>,
    elapsed: Duration,
}

impl Run {
    pub(super) fn execute(
        deck: &Checked<Dataset>,
        commands: &Checked<CommandFile>,
        start: Instant,
        watch: &dyn ProgressObserver,
    ) -> Self {
        let folders = [deck.value.source(), commands.value.source()].map(folder_of);
        let (ending, mut record) = Session::new(Box::new(io::sink()), Path::new(""))
            .confined(&folders)
            .watched(|moment| {
                watch.detail(format!("time {:.4} of {}", moment.time, moment.end));
                watch.goes_on()
            })
            .run_on(deck, commands);
        let mut files = record.files();
        files.insert("msg".to_string(), std::mem::take(&mut record.messages));
        let told = record.diagnostics.iter();
        let complaints = told
            .map(|found| Complaint::new(found, &record.sources))
            .collect();
        let Balance { force, torque, .. } = &record.balance;
        let kinds = [("force", force), ("torque", torque)];
        let left = kinds.into_iter().filter_map(|(kind, left)| {
            let left = left.as_ref()?;
            Some((kind.to_string(), (left.size, left.part.to_string())))
        });
        let balance = left.collect();
        let table = record.results.take();
        // The elapsed time includes the time to free the memory of the run.
        drop(record);
        Self {
            ending,
            table,
            complaints,
            files,
            balance,
            elapsed: start.elapsed(),
        }
    }

    /// Returns the way in which the run ended.
    pub fn ending(&self) -> &Ending {
        &self.ending
    }

    /// Checks the outcome of the run. The run has failed if `admire solve` would end with an exit code other than 0.
    ///
    /// # Errors
    /// When a command was not understood, was refused, or gave no result.
    pub fn succeeded(&self) -> Result<(), Error> {
        if self.ending.exit_code(true) == 0 {
            return Ok(());
        }
        let kind = match self.ending.stop {
            Stop::Simulation | Stop::Interrupted => ErrorKind::NoAnswer,
            Stop::Finished if self.ending.failed > 0 => ErrorKind::NoAnswer,
            Stop::Model | Stop::File | Stop::Finished => ErrorKind::Input,
        };
        let mut told = self.complaints.clone();
        told.sort_by_key(|complaint| std::cmp::Reverse(complaint.severity));
        if told.first().is_none_or(|c| c.severity != Severity::Error) {
            // The run was stopped without a diagnostic that is an error.
            let last = Diagnostic::error(Code::NoEquilibrium, "the run did not finish");
            let help = last.help("the messages of the run state the reason");
            return Err(Error::plain(kind, &help));
        }
        Err(Error {
            kind,
            complaints: told,
        })
    }

    /// Returns warnings and errors, in the order in which they occurred.
    pub fn complaints(&self) -> &[Complaint] {
        &self.complaints
    }

    /// Returns the worst imbalance on a part over all static solutions. The loads on each part are summed independently of the solver. The
    /// keys are `force` and `torque`; each value is the size of the imbalance in units of the deck, and the name of the part. The map is
    /// empty without static solutions.
    pub fn balance(&self) -> &BTreeMap<String, (f64, String)> {
        &self.balance
    }

    /// Returns the contents of the message file.
    pub fn messages(&self) -> String {
        let said = self.files.get("msg").map_or(&[][..], Vec::as_slice);
        String::from_utf8_lossy(said).into_owned()
    }

    /// Returns the elapsed time in which the commands were read and executed.
    pub fn elapsed(&self) -> Duration {
        self.elapsed
    }

    /// Returns the results as a table; `None` if no simulation started.
    pub(crate) fn table(&self) -> Option<&ResultsTable> {
        self.table.as_ref()
    }

    /// Restores the values of the table, which serialisation leaves out.
    #[cfg(feature = "python")]
    pub(crate) fn set_values(&mut self, values: Vec<f64>) {
        if let Some(table) = &mut self.table {
            table.values = values;
        }
    }

    /// Returns the columns, in the order of the values in a step.
    pub fn columns(&self) -> Vec<SelectedColumn> {
        self.table()
            .map_or_else(Vec::new, |table| Selection::all(&table.catalogue).columns)
    }

    /// Returns the kind of each step.
    pub fn kinds(&self) -> &[StepKind] {
        self.table().map_or(&[], |table| &table.kinds)
    }

    /// Returns the index, from 0, of a column within the values of a step. Examples of names: `KNUCKLE.X`, `knuckle_XFORM.X`,
    /// `BUSHING/1.FX`.
    ///
    /// # Errors
    /// When no column has this name, or when the name is ambiguous.
    pub fn position(&self, name: &str) -> Result<usize, Error> {
        let Some(table) = self.table() else {
            let none = Diagnostic::error(
                Code::CannotRead,
                "the run has no results, because no simulation started",
            );
            return Err(Error::plain(ErrorKind::Usage, &none));
        };
        Ok(one_column(&table.catalogue, name)?.id - 1)
    }

    /// Returns the columns that match patterns, by the same rules as [`Results::select`](super::Results::select).
    ///
    /// # Errors
    /// When a pattern matches no column.
    pub fn select(&self, patterns: &[String]) -> Result<Vec<SelectedColumn>, Error> {
        let patterns: Vec<&str> = patterns.iter().map(String::as_str).collect();
        let none = Catalogue::default();
        let catalogue = self.table().map_or(&none, |table| &table.catalogue);
        Ok(selected(catalogue, &patterns)?.columns)
    }

    /// Returns a column, one value for each step. The first step holds the model as read, before any simulation.
    ///
    /// # Errors
    /// As [`position`](Self::position).
    pub fn column(&self, name: &str) -> Result<Vec<f64>, Error> {
        let first = self.position(name)?;
        let table = self.table.iter();
        let values = table.flat_map(|table| {
            let width = table.catalogue.len();
            table.values.iter().skip(first).step_by(width)
        });
        Ok(values.copied().collect())
    }

    /// Returns the contents of all files other than the results file. The keys are the extensions `msg`, `req`, `gra` and `out`, and for
    /// files written by LINEAR commands their names.
    pub fn files(&self) -> &BTreeMap<String, Vec<u8>> {
        &self.files
    }

    /// Writes a file of the run, chosen by its extension: `.res`, `.msg`, `.req`, `.gra` or `.out`. An existing file is replaced only with
    /// `replace`.
    ///
    /// # Errors
    /// When the run has no such file, or when the file cannot be written.
    pub fn write(&self, path: impl AsRef<Path>, replace: bool) -> Result<(), Error> {
        let path = path.as_ref();
        let extension = path.extension().unwrap_or_default().to_string_lossy();
        let extension = extension.to_ascii_lowercase();
        let cannot = |error| Error::unwritable(path, &error);
        let mut results = Vec::new();
        let bytes = match (extension.as_str(), self.table()) {
            ("res", Some(table)) => {
                let mut header = table.header.clone();
                let shown = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
                header.uri = format!("file://{}", shown.display());
                table.write_as(&header, &mut results).map_err(cannot)?;
                &results
            }
            _ => self.files.get(&extension).ok_or_else(|| {
                let kinds: Vec<&str> = self.files.keys().map(String::as_str).collect();
                let message = format!("this run has no .{extension} file");
                let help = format!("the files of the run are res, {}", kinds.join(", "));
                let none = Diagnostic::error(Code::CannotWrite, message).help(help);
                Error::plain(ErrorKind::Usage, &none)
            })?,
        };
        may_replace(path, replace)?;
        replace_file(path, bytes).map_err(cannot)
    }
}
