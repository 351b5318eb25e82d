use std::path::Path;

use serde_json::Value;

use crate::diagnostic::{Code, Diagnostic};
use crate::kc::{Bench, BenchError, Config, Convention, output, run};
use crate::session::Sources;
use crate::text::Source;

use super::deck::Deck;
use super::error::{Complaint, Error, ErrorKind};
use super::kc_page::kc_page;

/// Characteristics of an axle under the standard K&C tests.
#[derive(Clone, Debug)]
pub struct AxleTests {
    /// Curves, gradients and the state at ride height: what `kc.json` holds.
    pub values: Value,
    /// `curves.csv`: a row for each state of each test.
    pub curves: String,
    /// `gradients.csv`.
    pub gradients: String,
    /// The report, a whole HTML page.
    pub html: String,
    /// Remarks on the configuration.
    pub complaints: Vec<Complaint>,
}

impl Deck {
    /// Drives the axle of the deck through the standard K&C tests that a configuration (`kc.toml`) asks for.
    ///
    /// # Errors
    /// When the configuration or the deck cannot be used, or a test has no equilibrium.
    pub fn kc(&self, config: impl AsRef<Path>, convention: Convention) -> Result<AxleTests, Error> {
        let path = config.as_ref();
        let source = Source::read(path).map_err(|error| Error::unreadable(path, &error))?;
        let (model, files) = self.model()?;
        let units = model.units;
        let mut sources = Sources::default();
        sources.add(source.clone());
        sources.add(self.dataset().source().clone());
        let refused = |found: &[Diagnostic]| Error::new(ErrorKind::Input, found, &sources);
        let read = Config::read(&source, (1e-3 / units.length.si, 1.0 / units.force.si));
        let Some(config) = read.value else {
            return Err(refused(&read.diagnostics));
        };
        let complaints = read.diagnostics.iter();
        let complaints = complaints.map(|found| Complaint::new(found, &sources));
        let complaints = complaints.collect();
        let bench = Bench::new(&config, (self.dataset(), &files, &model));
        let mut bench = bench.map_err(|found| refused(&found))?;
        let found = run(&mut bench, &units).map_err(|why| match why {
            BenchError::Deck(found) => refused(&found),
            other => {
                let none = Diagnostic::error(Code::NoEquilibrium, other.to_string());
                Error::plain(ErrorKind::NoAnswer, &none)
            }
        })?;
        let text = |bytes: Vec<u8>| String::from_utf8_lossy(&bytes).into_owned();
        let deck = (Path::new(self.name()), &units);
        let html = kc_page(deck, (&config, &found), (&[], &[]), convention).map_err(|error| {
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
}
