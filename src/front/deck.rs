use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use serde_json::Value;

use admire_session::check::{Settings, table_above};
use admire_session::{Sources, check, folder_of, read_files};
use admire_solver::model::{Model, lint};
use admire_solver::system::System;
use admire_syntax::diagnostic::{Checked, Code, Diagnostic, Severity};
use admire_syntax::diff::{self, DiffTolerance, Difference};
use admire_syntax::lint::Options;
use admire_syntax::text::{Edit, Source};
use admire_syntax::{Address, CommandFile, Dataset};

use super::assignment::{Before, edits, new_errors, structure_digest};
use super::error::{Complaint, Error, ErrorKind};
use super::run::Run;
use super::sensitivity::{SensitivityTable, Unavailable};
use super::value::{address, typed, value};
use super::writing::{may_replace, replace_file};
use admire_diagnosis::{ProgressObserver, SharedProgress};

/// ADAMS dataset (.adm): access to its values by address, its equilibrium, and its simulation runs. Cloning is cheap.
///
/// An address is `BUSHING/12.K.2`, `front_arm.K` or `SFORCE/3`. In a pattern, `*` matches any id, any name or any index of a value. Numbers
/// are in the deck's units, angles in radians. A change keeps every byte of the file except the bytes of the changed value.
#[derive(Clone, Debug)]
pub struct Deck {
    pub(super) read: Arc<Checked<Dataset>>,
    /// Dataset as stored in its file, with its diagnostics.
    stored: Arc<Checked<Dataset>>,
    pub(super) path: Option<PathBuf>,
}

/// New value for an address.
#[derive(Clone, PartialEq, Debug)]
pub enum Setting {
    /// Number in the deck's units; angles in radians.
    Number(f64),
    /// All numbers of an argument.
    Numbers(Vec<f64>),
    /// Flag, on or off.
    Flag(bool),
    /// Number, function or word, as typed in a deck.
    Text(String),
}

impl From<f64> for Setting {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<Vec<f64>> for Setting {
    fn from(values: Vec<f64>) -> Self {
        Self::Numbers(values)
    }
}

impl From<bool> for Setting {
    fn from(on: bool) -> Self {
        Self::Flag(on)
    }
}

impl From<&str> for Setting {
    fn from(text: &str) -> Self {
        Self::Text(text.to_string())
    }
}

impl Setting {
    fn edits(
        &self,
        dataset: &Dataset,
        address: &Address,
        beside: &BTreeSet<&Address>,
    ) -> Result<Vec<Edit>, Diagnostic> {
        match self {
            Self::Number(value) => dataset.set_beside(address, *value, beside),
            Self::Numbers(values) => {
                let words: Vec<String> = values.iter().map(f64::to_string).collect();
                edits(dataset, address, &words.join(", "), beside)
            }
            Self::Flag(on) => dataset.set_flag(address, *on),
            Self::Text(text) => edits(dataset, address, text.trim(), beside),
        }
    }
}

impl Deck {
    /// Reads a dataset. A text with errors can still be inspected: [`check`](Self::check) reports them, and [`solve`](Self::solve) refuses
    /// the deck.
    ///
    /// # Errors
    /// When the file cannot be read.
    pub fn open(path: impl AsRef<Path>) -> Result<Self, Error> {
        let path = path.as_ref();
        let source = Source::read(path).map_err(|error| Error::unreadable(path, &error))?;
        let read = Arc::new(Dataset::parse(source));
        Ok(Self {
            stored: Arc::clone(&read),
            read,
            path: Some(path.to_path_buf()),
        })
    }

    /// Parses a dataset from its bytes. Files named in the dataset are looked up in the folder of `name`.
    pub fn parse(name: &str, bytes: impl Into<Vec<u8>>) -> Self {
        let read = Arc::new(Dataset::parse(Source::new(name, bytes)));
        Self {
            stored: Arc::clone(&read),
            read,
            path: None,
        }
    }

    /// Returns the title, which is the first line of the dataset.
    pub fn title(&self) -> String {
        self.dataset().title().into_owned()
    }

    /// Returns the path of the deck's file, or the name given to [`parse`](Self::parse).
    pub fn name(&self) -> &str {
        self.dataset().source().name()
    }

    /// Returns the current text as bytes.
    pub fn bytes(&self) -> &[u8] {
        self.dataset().bytes()
    }

    /// Returns the parsed dataset.
    pub(crate) fn dataset(&self) -> &Dataset {
        &self.read.value
    }

    /// Returns the value at an address: a number, a list of numbers, a text, or `true` for a flag. If the argument is missing in the deck,
    /// its default value is returned. For the address of an object alone, the statement is returned as text.
    ///
    /// # Errors
    /// When the address is invalid in this deck.
    pub fn get(&self, text: &str) -> Result<Value, Error> {
        let address = address(text, self.dataset()).map_err(usage)?;
        value(self.dataset(), &address, false).map_err(usage)
    }

    /// Returns the number at an address.
    ///
    /// # Errors
    /// When the value is not a single number.
    pub fn number(&self, text: &str) -> Result<f64, Error> {
        let found = self.get(text)?;
        found.as_f64().ok_or_else(|| {
            let message = format!("the value of `{text}` is not a single number");
            usage(Diagnostic::error(Code::WrongType, message))
        })
    }

    /// Returns the addresses that match a pattern, each with its value, in the order of the deck.
    ///
    /// # Errors
    /// When no address matches.
    pub fn values(&self, pattern: &str) -> Result<Vec<(String, Value)>, Error> {
        let found = self.matching(pattern)?;
        let each = |address: &Address| {
            let value = value(self.dataset(), address, false).map_err(usage)?;
            Ok((address.to_string(), value))
        };
        found.iter().map(each).collect()
    }

    pub(super) fn matching(&self, pattern: &str) -> Result<Vec<Address>, Error> {
        Address::matching(pattern, self.dataset()).map_err(|refused| usage(typed(refused, pattern)))
    }

    /// Sets the value at an address, or at all addresses that match a pattern. A marker is moved without rotation: ZP and XP move along
    /// with QP.
    ///
    /// # Errors
    /// When the address is invalid, or the deck would be unreadable with the value; the deck is then unchanged.
    pub fn set(&mut self, text: &str, setting: impl Into<Setting>) -> Result<&mut Self, Error> {
        let setting = setting.into();
        let addresses = self.matching(text)?;
        let beside: BTreeSet<&Address> = addresses.iter().collect();
        let dataset = self.dataset();
        let all: Result<Vec<_>, _> = addresses
            .iter()
            .map(|address| setting.edits(dataset, address, &beside))
            .collect();
        let all: Vec<Edit> = all.map_err(|refused| self.refused(&refused))?.concat();
        if all.is_empty() {
            return Ok(self);
        }
        if addresses.len() == 1 || dataset.text_after(&all).is_ok() {
            self.read = Arc::new(self.edited(&self.read, &all, &addresses, text)?);
            return Ok(self);
        }
        // Missing arguments would all be inserted at the same place, so they are written one after the other.
        let mut read = Arc::clone(&self.read);
        for address in &addresses {
            let found = setting.edits(&read.value, address, &beside);
            let found = found.map_err(|refused| self.refused(&refused))?;
            let one = std::slice::from_ref(address);
            read = Arc::new(self.edited(&read, &found, one, text)?);
        }
        self.read = read;
        Ok(self)
    }

    /// Applies edits to a dataset. Fails if the result has new errors, or if the edits would change anything besides the values at these
    /// addresses.
    fn edited(
        &self,
        before: &Checked<Dataset>,
        edits: &[Edit],
        addresses: &[Address],
        text: &str,
    ) -> Result<Checked<Dataset>, Error> {
        let dataset = &before.value;
        let changed = dataset.edited(edits).map_err(|conflict| {
            usage(Diagnostic::error(Code::CannotWrite, conflict.to_string()))
        })?;
        let new = new_errors(&before.diagnostics, &changed);
        if !new.is_empty() {
            let new: Vec<Diagnostic> = new.into_iter().cloned().collect();
            let sources = sources_of(&changed.value);
            return Err(Error::new(ErrorKind::Input, &new, &sources));
        }
        let places: BTreeSet<(usize, &str)> = addresses
            .iter()
            .filter_map(|address| {
                let argument = address.argument.as_deref().unwrap_or("FUNCTION");
                Some((dataset.position(&address.kind, address.id)?, argument))
            })
            .collect();
        let title = addresses.iter().any(|address| address.kind == "TITLE");
        if !title && structure_digest(dataset, &places) != structure_digest(&changed.value, &places)
        {
            let message = format!("the new value of `{text}` would change more than this value");
            let help = "set each argument by its own address";
            let refused = Diagnostic::error(Code::SyntaxError, message).help(help);
            return Err(usage(refused));
        }
        Ok(changed)
    }

    pub(super) fn refused(&self, diagnostic: &Diagnostic) -> Error {
        let sources = sources_of(self.dataset());
        let found = std::slice::from_ref(diagnostic);
        Error::new(ErrorKind::Usage, found, &sources)
    }

    /// Writes the deck back to its own file, atomically.
    ///
    /// # Errors
    /// An error in each of these cases: the deck has no file; the file has changed since it was read; the deck has an error that its stored
    /// text does not have; the file cannot be written. With `force`, the deck is saved even in the second and third case.
    pub fn save(&mut self, force: bool) -> Result<(), Error> {
        let Some(path) = self.path.clone() else {
            let nameless =
                Diagnostic::error(Code::CannotWrite, "this deck was not read from a file");
            return Err(usage(nameless.help("give the name of the file to write")));
        };
        let there = std::fs::read(&path);
        if !force && there.is_ok_and(|there| there != self.stored.value.bytes()) {
            let message = format!("`{}` was changed since it was read", path.display());
            let help = "read the deck again, or save it with `force`";
            let changed = Diagnostic::error(Code::CannotWrite, message).help(help);
            let kind = ErrorKind::File(std::io::ErrorKind::AlreadyExists);
            return Err(Error::plain(kind, &changed));
        }
        self.store(&path, force)
    }

    /// Writes the deck to a file, which becomes the deck's own file. An existing file is replaced only with `replace`.
    ///
    /// # Errors
    /// The errors of [`save`](Self::save). Also an error if the path exists and `replace` is false.
    pub fn save_as(
        &mut self,
        path: impl AsRef<Path>,
        replace: bool,
        force: bool,
    ) -> Result<(), Error> {
        let path = path.as_ref();
        may_replace(path, replace)?;
        self.store(path, force)?;
        self.path = Some(path.to_path_buf());
        Ok(())
    }

    fn store(&mut self, path: &Path, force: bool) -> Result<(), Error> {
        if !force && !Arc::ptr_eq(&self.read, &self.stored) {
            let new = Before::of(&self.stored).new_faults(&self.read);
            if !new.is_empty() {
                let sources = sources_of(self.dataset());
                return Err(Error::new(ErrorKind::Input, &new, &sources));
            }
        }
        replace_file(path, self.bytes()).map_err(|error| Error::unwritable(path, &error))?;
        self.stored = Arc::clone(&self.read);
        Ok(())
    }

    /// Checks the deck as `admire check` does, with the settings in `admire.toml` of the deck's folder or of a folder above it. Each fault
    /// is reported once, in the order of the file.
    ///
    /// # Errors
    /// When `admire.toml` cannot be used.
    pub fn check(&self) -> Result<Vec<Complaint>, Error> {
        let settings = match table_above(Path::new(self.name())) {
            Some(path) => {
                let source = Source::read(&path).map_err(|e| Error::unreadable(&path, &e))?;
                let mut sources = Sources::default();
                sources.add(source.clone());
                Settings::parse(&source)
                    .map_err(|wrong| Error::new(ErrorKind::Input, &wrong, &sources))?
            }
            None => Settings::default(),
        };
        let folder = folder_of(self.dataset().source());
        let files = read_files(self.dataset(), &folder, &check::policy(&folder));
        let mut sources = sources_of(self.dataset());
        for source in files.value.sources() {
            sources.add(source.clone());
        }
        let options = Options {
            fortran: settings.fortran,
        };
        let found = check::dataset((*self.read).clone(), files, &options, || false);
        let loud = found.unwrap_or_default().into_iter();
        Ok(loud
            .filter(|found| !found.silenced && settings.shows(&found.diagnostic))
            .map(|found| Complaint::new(&found.diagnostic, &sources))
            .collect())
    }

    /// Returns the differences from this deck to another deck, object by object, regardless of layout.
    pub fn diff(&self, other: &Self, tolerance: DiffTolerance) -> Vec<Difference> {
        diff::diff(self.dataset(), other.dataset(), tolerance)
    }

    /// Finds the static equilibrium, starting from the positions in the deck, as SIMULATE/STATICS does.
    ///
    /// # Errors
    /// When the deck has errors or there is no equilibrium.
    pub fn solve(&self) -> Result<Run, Error> {
        let run = self.run_watched("SIMULATE", "SIMULATE/STATICS\n", &SharedProgress::default());
        run.succeeded()?;
        Ok(run)
    }

    /// Executes a command file on this deck, whichever model the file names. No file is written: the run contains the contents of all
    /// output files.
    ///
    /// # Errors
    /// When the command file cannot be read. Failures of single commands are reported by the run.
    pub fn run(&self, commands: impl AsRef<Path>) -> Result<Run, Error> {
        self.run_file_watched(commands.as_ref(), &SharedProgress::default())
    }

    /// Executes a command file on this deck. The run stops early when `watch` requests it.
    ///
    /// # Errors
    /// As [`run`](Self::run).
    pub fn run_file_watched(
        &self,
        path: &Path,
        watch: &dyn ProgressObserver,
    ) -> Result<Run, Error> {
        let start = Instant::now();
        let source = Source::read(path).map_err(|error| Error::unreadable(path, &error))?;
        let parsed = CommandFile::parse(source);
        Ok(Run::execute(&self.read, &parsed, start, watch))
    }

    /// Executes commands given as text. Files named in them are looked up in the folder of `name`. The run stops early when `watch`
    /// requests it.
    pub fn run_watched(&self, name: &str, commands: &str, watch: &dyn ProgressObserver) -> Run {
        let start = Instant::now();
        let parsed = CommandFile::parse_commands(Source::new(name, commands.as_bytes()));
        Run::execute(&self.read, &parsed, start, watch)
    }

    /// Computes the derivatives of the equilibrium at a time with respect to parameters of the deck.
    ///
    /// `of` names the results: parts (their motion), forces and joints (their force on I), or request components such as `REQUEST/1.F2`.
    /// `by` names the parameters, such as `BUSHING/1.K`. If `by` is empty, all parameters with an effect are used.
    ///
    /// # Errors
    /// When a name is invalid, the deck has errors or there is no equilibrium.
    pub fn sensitivity(
        &self,
        of: &[String],
        by: &[String],
        time: f64,
    ) -> Result<SensitivityTable, Error> {
        let (model, system) = self.compiled()?;
        SensitivityTable::new(self.dataset(), &model, &system, of, by, time).map_err(
            |why| match why {
                Unavailable::Word(refused) => usage(refused),
                Unavailable::NoAnswer(error) => {
                    let none = Diagnostic::error(Code::NoEquilibrium, error.to_string());
                    Error::plain(ErrorKind::NoAnswer, &none)
                }
            },
        )
    }

    /// Builds the model of the deck. Returns the model and the files that the deck names.
    pub(super) fn model(&self) -> Result<(Model, admire_syntax::files::Files), Error> {
        let folder = folder_of(self.dataset().source());
        let files = read_files(self.dataset(), &folder, &check::policy(&folder));
        let lowered = Model::lower_with(self.dataset(), &files.value);
        let mut found = self.read.diagnostics.clone();
        found.extend(files.diagnostics);
        found.extend(lowered.diagnostics);
        self.unless_errors(&found)?;
        Ok((lowered.value, files.value))
    }

    /// Builds the model of the deck, without returning the files that the deck names.
    #[cfg(feature = "python")]
    pub(crate) fn lowered(&self) -> Result<Model, Error> {
        Ok(self.model()?.0)
    }

    fn compiled(&self) -> Result<(Model, System), Error> {
        let (model, _) = self.model()?;
        let compiled = System::compile(&model);
        let mut found = compiled.diagnostics;
        found.extend(lint::implausible_units(self.dataset(), &model));
        self.dataset().locate(&mut found);
        self.unless_errors(&found)?;
        Ok((model, compiled.value))
    }

    fn unless_errors(&self, found: &[Diagnostic]) -> Result<(), Error> {
        if found.iter().all(|d| d.severity != Severity::Error) {
            return Ok(());
        }
        let sources = sources_of(self.dataset());
        Err(Error::new(ErrorKind::Input, found, &sources))
    }
}

pub(super) fn sources_of(dataset: &Dataset) -> Sources {
    let mut sources = Sources::default();
    sources.add(dataset.source().clone());
    sources
}

pub(super) fn usage(refused: Diagnostic) -> Error {
    Error::plain(ErrorKind::Usage, &refused)
}
