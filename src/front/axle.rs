use std::path::{Path, PathBuf};

use serde_json::Value;

use admire_kc::{Bench, BenchError, Config, Convention, KcRun, output, run};
use admire_session::Sources;
use admire_solver::model::Model;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::files::Files;
use admire_syntax::text::Source;

use super::deck::Deck;
use super::error::{Complaint, Error, ErrorKind};
use super::kc_measured::measured;
use super::kc_page::{KcDeck, kc_page};

/// Characteristics of an axle under the standard K&C tests.
#[derive(Clone, Debug)]
pub struct AxleTests {
    /// Contents of `kc.json`: curves, gradients and the state at ride height.
    pub values: Value,
    /// Contents of `curves.csv`: one row for each solved state of each test.
    pub curves: String,
    /// Contents of `gradients.csv`: one row for each gradient.
    pub gradients: String,
    /// Report as a complete HTML page.
    pub html: String,
    /// Diagnostics of the configuration.
    pub complaints: Vec<Complaint>,
}

/// Other decks and measured curves, for comparison in the report of an axle's tests.
#[derive(Clone, Debug, Default)]
pub struct Beside {
    /// Other decks that run the same tests, with their names in the report.
    pub decks: Vec<(String, Deck)>,
    /// Path of a table of measured curves: CSV with the columns test, value, and characteristics such as `toe_angle.left [deg]`.
    pub measured: Option<PathBuf>,
}

impl Deck {
    /// Runs the standard K&C tests of a configuration (`kc.toml`) on the axle of the deck.
    ///
    /// # Errors
    /// When the configuration or the deck cannot be used, or when a test has no equilibrium.
    pub fn kc(&self, config: impl AsRef<Path>, convention: Convention) -> Result<AxleTests, Error> {
        self.kc_beside(config, convention, &Beside::default())
    }

    /// Runs the tests as [`kc`](Self::kc) does. The report also shows the results of other decks and the measured curves.
    ///
    /// # Errors
    /// The errors of [`kc`](Self::kc) for any of the decks. Also an error if another deck has other units, or if the measured curves cannot
    /// be read.
    pub fn kc_beside(
        &self,
        config: impl AsRef<Path>,
        convention: Convention,
        beside: &Beside,
    ) -> Result<AxleTests, Error> {
        let path = config.as_ref();
        let source = Source::read(path).map_err(|error| Error::unreadable(path, &error))?;
        let (model, files) = self.model()?;
        let units = model.units;
        let mut sources = Sources::default();
        sources.add(source.clone());
        sources.add(self.dataset().source().clone());
        let refused = |found: &[Diagnostic]| Error::new(ErrorKind::Input, found, &sources);
        let read = Config::read(&source, 1e-3 / units.length.si, 1.0 / units.force.si);
        let Some(config) = read.value else {
            return Err(refused(&read.diagnostics));
        };
        let mut told = read.diagnostics;
        let curves = match &beside.measured {
            Some(path) => {
                let source = Source::read(path).map_err(|error| Error::unreadable(path, &error))?;
                let found =
                    measured(&source, &config, &units).map_err(|wrong| refused(&[wrong]))?;
                told.extend(found.diagnostics);
                found.value
            }
            None => Vec::new(),
        };
        let found = self.tests(&config, (&model, &files), (&sources, &mut told))?;
        let mut others = Vec::new();
        for (name, deck) in &beside.decks {
            let (model, files) = deck.model()?;
            if model.units != units {
                let message = format!(
                    "the units of `{}` differ from those of `{}`",
                    deck.name(),
                    self.name()
                );
                let wrong = Diagnostic::error(Code::BadSetting, message);
                return Err(refused(&[
                    wrong.help("convert the units of one of the decks")
                ]));
            }
            let mut sources = Sources::default();
            sources.add(deck.dataset().source().clone());
            others.push((
                name.clone(),
                deck.tests(&config, (&model, &files), (&sources, &mut told))?,
            ));
        }
        let complaints = told.iter();
        let complaints = complaints.map(|found| Complaint::new(found, &sources));
        let complaints = complaints.collect();
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        let deck = KcDeck {
            path: Path::new(self.name()),
            dataset: self.dataset(),
            files: &files,
            model: &model,
        };
        let html =
            kc_page(&deck, &config, &found, &others, &curves, convention).map_err(|error| {
                let failed = Diagnostic::error(Code::CannotWrite, error.to_string());
                Error::plain(ErrorKind::Input, &failed)
            })?;
        Ok(AxleTests {
            values: output::json(&found, &config, &units, convention),
            curves: text(output::curves_csv(&found, &config, &units, convention)),
            gradients: text(output::gradients_csv(&found, &config, &units, convention)),
            html,
            complaints,
        })
    }

    fn tests(
        &self,
        config: &Config,
        (model, files): (&Model, &Files),
        (sources, told): (&Sources, &mut Vec<Diagnostic>),
    ) -> Result<KcRun, Error> {
        let refused = |found: &[Diagnostic]| Error::new(ErrorKind::Input, found, sources);
        let bench = Bench::new(config, self.dataset(), files, model);
        let mut bench = bench.map_err(|found| refused(&found))?;
        told.extend(bench.implausible());
        run(&mut bench, &model.units).map_err(|why| match why {
            BenchError::Deck(found) => refused(&found),
            other => {
                let message = format!("`{}`: {other}", self.name());
                let none = Diagnostic::error(Code::NoEquilibrium, message);
                Error::plain(ErrorKind::NoAnswer, &none)
            }
        })
    }
}
