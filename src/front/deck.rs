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
use admire_syntax::diff::{self, Difference, Tolerance};
use admire_syntax::lint::Options;
use admire_syntax::text::{Edit, Source};
use admire_syntax::{Address, CommandFile, Dataset};

use super::assignment::{Before, edits, new_errors, outline};
use super::error::{Complaint, Error, ErrorKind};
use super::run::Run;
use super::sensitivity::{SensitivityTable, Unavailable};
use super::value::{address, typed, value};
use super::writing::{may_replace, replace_file};
use admire_diagnosis::{ProgressObserver, SharedProgress};

/// A dataset (.adm): its values by address, its equilibrium, its runs. Cheap to clone.
///
/// An address is `BUSHING/12.K.2`, `front_arm.K`, `SFORCE/3`; in a pattern `*` stands for any id, name or place of a value. Numbers are in
/// the deck's units, angles in radians. A change keeps every byte of the file but those of the value.
#[derive(Clone, Debug)]
pub struct Deck {
    pub(super) read: Arc<Checked<Dataset>>,
    /// As the file holds it, with what was found wrong then.
    stored: Arc<Checked<Dataset>>,
    pub(super) path: Option<PathBuf>,
}

/// A new value for an address.
#[derive(Clone, PartialEq, Debug)]
pub enum Setting {
    /// A number in the deck's units, radians for angles.
    Number(f64),
    /// All numbers of an argument.
    Numbers(Vec<f64>),
    /// A flag, on or off.
    Flag(bool),
    /// A number, a function or a word as it would be typed.
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
    /// Reads a dataset. What is wrong with its text does not keep it from being looked at: [`check`](Self::check) tells it, and
    /// [`solve`](Self::solve) refuses it.
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

    /// A dataset from its bytes. Files it names are looked up beside `name`.
    pub fn parse(name: &str, bytes: impl Into<Vec<u8>>) -> Self {
        let read = Arc::new(Dataset::parse(Source::new(name, bytes)));
        Self {
            stored: Arc::clone(&read),
            read,
            path: None,
        }
    }

    /// The first line.
    pub fn title(&self) -> String {
        self.dataset().title().into_owned()
    }

    /// The path it was read from, or the name it was given.
    pub fn name(&self) -> &str {
        self.dataset().source().name()
    }

    /// The text as it is now.
    pub fn bytes(&self) -> &[u8] {
        self.dataset().bytes()
    }

    /// The parsed text.
    pub(crate) fn dataset(&self) -> &Dataset {
        &self.read.value
    }

    /// The value at an address: a number, a list of numbers, a text, `true` for a flag; what is not written has its default. An object
    /// alone gives its statement.
    ///
    /// # Errors
    /// When the address means nothing in this deck.
    pub fn get(&self, text: &str) -> Result<Value, Error> {
        let address = address(text, self.dataset()).map_err(usage)?;
        value(self.dataset(), &address, false).map_err(usage)
    }

    /// The number at an address.
    ///
    /// # Errors
    /// When there is none.
    pub fn number(&self, text: &str) -> Result<f64, Error> {
        let found = self.get(text)?;
        found.as_f64().ok_or_else(|| {
            let message = format!("`{text}` is not one number");
            usage(Diagnostic::error(Code::WrongType, message))
        })
    }

    /// The value of each address that a pattern names, in the order of the deck.
    ///
    /// # Errors
    /// When nothing matches.
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

    /// Gives an address, or each of a pattern, a new value. A marker is moved without being turned: ZP and XP move along with QP.
    ///
    /// # Errors
    /// When the address means nothing, or the deck could not be read with the value; the deck is as before then.
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
        // Values that are not written yet would be added at one place: one after the other.
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

    /// The deck after edits, if it can be read and nothing but these addresses has changed.
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
        if !title && outline(dataset, &places) != outline(&changed.value, &places) {
            let message = format!("`{text}` would change more than it names");
            let help = "change each argument by its own address";
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

    /// Writes the deck back into its own file, whole or not at all.
    ///
    /// # Errors
    /// When it has no file, the file was changed since it was read, the deck has an error that it had not when it was read (`force`
    /// writes it all the same), or the file cannot be written.
    pub fn save(&mut self, force: bool) -> Result<(), Error> {
        let Some(path) = self.path.clone() else {
            let nameless = Diagnostic::error(Code::CannotWrite, "this deck was read from no file");
            return Err(usage(nameless.help("name a file to save it as")));
        };
        let there = std::fs::read(&path);
        if !force && there.is_ok_and(|there| there != self.stored.value.bytes()) {
            let message = format!("`{}` was changed since it was read", path.display());
            let help = "read it again, or save with force";
            let changed = Diagnostic::error(Code::CannotWrite, message).help(help);
            let kind = ErrorKind::File(std::io::ErrorKind::AlreadyExists);
            return Err(Error::plain(kind, &changed));
        }
        self.store(&path, force)
    }

    /// Writes the deck into a file, which is its own from then on. A file that is there already is replaced only with `replace`.
    ///
    /// # Errors
    /// Those of [`save`](Self::save), and when another file is there.
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

    /// Everything there is to say of the deck, each fault once, in the order of the file: what `admire check` tells, with the
    /// `admire.toml` of its folder or above.
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

    /// What changed from this deck to another, object by object, whatever their layout.
    pub fn diff(&self, other: &Self, tolerance: Tolerance) -> Vec<Difference> {
        diff::diff(self.dataset(), other.dataset(), tolerance)
    }

    /// The static equilibrium, as SIMULATE/STATICS finds it from the positions of the deck.
    ///
    /// # Errors
    /// When the deck has errors or there is no equilibrium.
    pub fn solve(&self) -> Result<Run, Error> {
        let run = self.run_watched("SIMULATE", "SIMULATE/STATICS\n", &SharedProgress::default());
        run.succeeded()?;
        Ok(run)
    }

    /// Executes a command file on this deck, whatever model it names. Nothing is written: the run holds what files would.
    ///
    /// # Errors
    /// When the command file cannot be read. What the commands come to is told by the run.
    pub fn run(&self, commands: impl AsRef<Path>) -> Result<Run, Error> {
        self.run_file_watched(commands.as_ref(), &SharedProgress::default())
    }

    /// The same; the run ends early when the watch says so.
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
        Ok(Run::execute(&self.read, &parsed, (start, watch)))
    }

    /// Executes commands that are given as text; files they name are looked up beside `name`. The run ends early when the watch says so.
    pub fn run_watched(&self, name: &str, commands: &str, watch: &dyn ProgressObserver) -> Run {
        let start = Instant::now();
        let parsed = CommandFile::parse_commands(Source::new(name, commands.as_bytes()));
        Run::execute(&self.read, &parsed, (start, watch))
    }

    /// How the equilibrium at a time changes with the numbers of the deck. `of`: parts (their motion), forces and joints (their force on
    /// I), `REQUEST/1.F2`. `by`: numbers such as `BUSHING/1.K`, all that have an effect if there are none.
    ///
    /// # Errors
    /// When a name means nothing, the deck has errors or there is no equilibrium.
    pub fn sensitivity(
        &self,
        of: &[String],
        by: &[String],
        time: f64,
    ) -> Result<SensitivityTable, Error> {
        let (model, system) = self.compiled()?;
        let parts = (self.dataset(), &model, &system);
        SensitivityTable::new(parts, of, by, time).map_err(|why| match why {
            Unavailable::Word(refused) => usage(refused),
            Unavailable::NoAnswer(error) => {
                let none = Diagnostic::error(Code::NoEquilibrium, error.to_string());
                Error::plain(ErrorKind::NoAnswer, &none)
            }
        })
    }

    /// The model of the deck.
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
