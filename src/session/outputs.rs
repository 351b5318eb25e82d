use std::fs::File;
use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

use crate::diagnostic::{Code, Diagnostic};
use crate::model::Model;
use crate::results::{Header, NumberStyle, StepKind, Style, Timestamp, XrfWriter};
use crate::system::{Parameters, State, System};

use super::columns::Columns;
use super::measures::Measures;
use super::paths::WritePolicy;

/// Extensions of the files a run writes beside `.msg`.
const EXTENSIONS: [&str; 4] = ["res", "req", "gra", "out"];

/// The output files of one model.
///
/// What an earlier run left under the same names is emptied when the model is read, so that a failed run never leaves the
/// previous answer behind. Files are then written in place, flushed step by step.
pub(super) struct Outputs {
    prefix: PathBuf,
    results: Option<XrfWriter<BufWriter<File>>>,
    columns: Option<Columns>,
    begun: bool,
    values: Vec<f64>,
    /// Time of the last step written, until something is redefined.
    pub last: Option<f64>,
}

impl Outputs {
    /// Empties the output files of this prefix.
    ///
    /// # Errors
    /// When a file lies outside of the allowed folders or cannot be written.
    pub fn prepare(prefix: PathBuf, policy: &WritePolicy) -> Result<Self, Diagnostic> {
        for extension in EXTENSIONS {
            let path = with_extension(&prefix, extension);
            policy.check(&path)?;
            if path.exists() {
                File::create(&path).map_err(|error| cannot_write(&path, &error))?;
            }
        }
        policy.check(&with_extension(&prefix, "msg"))?;
        Ok(Self {
            prefix,
            results: None,
            columns: None,
            begun: false,
            values: Vec::new(),
            last: None,
        })
    }

    /// The path of the message file.
    pub fn message_file(&self) -> PathBuf {
        with_extension(&self.prefix, "msg")
    }

    /// Writes the head of each file that the model asks for, and the model as it was read. Does nothing the second time.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn begin(&mut self, model: &Model, initial: &State) -> Result<(), Diagnostic> {
        if self.begun {
            return Ok(());
        }
        self.begun = true;
        if !model.results.present {
            return Ok(());
        }
        let path = with_extension(&self.prefix, "res");
        let shown = std::path::absolute(&path).unwrap_or_else(|_| path.clone());
        let mut header = Header::new(
            &shown.display().to_string(),
            &model.title,
            &model.units,
            Timestamp::now(),
        );
        if !model.results.comment.is_empty() {
            header.comment.clone_from(&model.results.comment);
        }
        let columns = Columns::of(model);
        let style = Style {
            numbers: NumberStyle::Decimals(model.results.decimal_places.min(40) as u8),
            ..Style::default()
        };
        let results = File::create(&path).and_then(|file| {
            XrfWriter::create(BufWriter::new(file), &header, &columns.catalogue, style)
        });
        self.results = Some(results.map_err(|error| cannot_write(&path, &error))?);
        columns.input(initial, &mut self.values);
        self.columns = Some(columns);
        self.write(StepKind::Input)
    }

    /// Writes one step to every file.
    ///
    /// # Errors
    /// When a file cannot be written or a value is not a number.
    pub fn step(
        &mut self,
        kind: StepKind,
        model: &Model,
        system: &System,
        parameters: &Parameters,
        state: &State,
    ) -> Result<(), Diagnostic> {
        self.last = Some(state.time);
        let Some(columns) = &self.columns else {
            return Ok(());
        };
        let mut measures = Measures::new(system, parameters, state);
        columns.step(model, &mut measures, &mut self.values);
        self.write(kind)
    }

    fn write(&mut self, kind: StepKind) -> Result<(), Diagnostic> {
        let path = with_extension(&self.prefix, "res");
        match &mut self.results {
            Some(results) => results
                .step(kind, &self.values)
                .map_err(|error| cannot_write(&path, &error)),
            None => Ok(()),
        }
    }

    /// Closes the files of a run that came to its end.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn finish(&mut self) -> Result<(), Diagnostic> {
        let path = with_extension(&self.prefix, "res");
        match self.results.take() {
            Some(results) => results
                .finish("Successful")
                .map(drop)
                .map_err(|error| cannot_write(&path, &error)),
            None => Ok(()),
        }
    }
}

/// The prefix with a dot and an extension behind it: a prefix may hold dots of its own.
pub(super) fn with_extension(prefix: &Path, extension: &str) -> PathBuf {
    let mut path = prefix.as_os_str().to_owned();
    path.push(".");
    path.push(extension);
    PathBuf::from(path)
}

fn cannot_write(path: &Path, error: &io::Error) -> Diagnostic {
    Diagnostic::error(
        Code::CannotWrite,
        format!("`{}` cannot be written: {error}", path.display()),
    )
}
