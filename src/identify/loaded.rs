use std::path::Path;

use super::stated_unknowns::add_stated;
use super::unknowns::{assigned, values_in};
use super::{Problem, Unknown, unknowns};
use admire_session::backend::{FreeMotions, LoadProgramme, Loads};
use admire_session::{FilePolicy, folder_of, read_files};
use admire_solver::model::Model;
use admire_solver::system::System;
use admire_study::settings::BackendChoice;
use admire_study::{CarLink, Measurement, Study, programme};
use admire_syntax::diagnostic::{Checked, Diagnostic, Severity};
use admire_syntax::text::Source;
use admire_syntax::{Address, Dataset};

/// A study with all names resolved in the model of its deck: the input of identification and diagnosis.
#[derive(Clone, Debug)]
pub struct LoadedStudy {
    /// Settings of the study and contents of its files.
    pub study: Study,
    /// Deck of the study.
    pub dataset: Dataset,
    /// Model of the deck.
    pub model: Model,
    /// Readings of the measurement.
    pub measurement: Measurement,
    /// Loads and load cases of the study.
    pub programme: LoadProgramme,
    /// Free (zero-stiffness) motions of the deck.
    pub free: FreeMotions,
    /// Parameters of the deck to identify.
    pub unknowns: Vec<Unknown>,
    /// Reference deck, for reports only.
    pub reference: Option<Dataset>,
    /// Objects of the subsystem of Adams/Car that are in the deck; `None` if the study names no subsystem. No fit reads it.
    pub car: Option<CarLink>,
}

impl LoadedStudy {
    /// Reads a study folder and all files it refers to. The value is `None` if an error makes a fit impossible.
    pub fn read(folder: &Path) -> Checked<Option<Self>> {
        let read = Study::read(folder);
        match read.value {
            Some(study) => Self::from_study(study, read.diagnostics),
            None => Checked {
                value: None,
                diagnostics: read.diagnostics,
            },
        }
    }

    /// Returns this study with its deck replaced by `deck`. The value is `None` if an error makes a fit impossible.
    pub fn with_deck(&self, deck: Source) -> Checked<Option<Self>> {
        let mut study = self.study.clone();
        study.deck = deck;
        Self::from_study(study, Vec::new())
    }

    fn from_study(study: Study, mut diagnostics: Vec<Diagnostic>) -> Checked<Option<Self>> {
        let parsed = Dataset::parse(study.deck.clone());
        let mut policy = FilePolicy::new(&study.folder);
        policy.confine();
        let folder = folder_of(parsed.value.source());
        let files = read_files(&parsed.value, &folder, &policy);
        let lowered = Model::lower_with(&parsed.value, &files.value);
        diagnostics.extend(parsed.diagnostics);
        diagnostics.extend(files.diagnostics);
        diagnostics.extend(lowered.diagnostics);
        let (dataset, model) = (parsed.value, lowered.value);
        let mut own = Vec::new();
        if !has_errors(&diagnostics) {
            let measured = Measurement::resolve(&study, &model);
            own.extend(measured.diagnostics);
            let programme = programme(&study, &dataset, &measured.value, &mut own);
            let car = CarLink::new(&study, &model, &mut own);
            let compiled = System::compile(&model);
            let is_whole = !has_errors(&compiled.diagnostics);
            let external = study.solver.backend != BackendChoice::Native;
            own.extend(compiled.diagnostics.into_iter().map(|mut diagnostic| {
                // An external solver may support elements that the built-in solver does not, so the errors become warnings.
                if external {
                    diagnostic.severity = diagnostic.severity.min(Severity::Warning);
                }
                diagnostic
            }));
            let system = compiled.value;
            let number = |text: &str| {
                let address = Address::parse(text, &dataset).ok()?;
                let slot = system.catalogue().slot(&address)?;
                let value = system.parameters().get(slot);
                Some((address, value, system.catalogue().info(slot).dimension))
            };
            let mut unknowns = unknowns(&study, &model, number, &mut own);
            let is_known = |address: &Address| system.catalogue().slot(address).is_some();
            add_stated(
                &study,
                (&dataset, &model),
                &is_known,
                &mut unknowns,
                &mut own,
            );
            if !has_errors(&own) {
                diagnostics.extend(own);
                let reference = study
                    .reference
                    .clone()
                    .map(|source| Dataset::parse(source).value);
                let measurement = measured.value;
                // An element that the built-in solver does not support may resist a motion that otherwise appears free.
                let loads = Loads::of(&system, &programme).ok().filter(|_| is_whole);
                let free = loads.map(|loads| FreeMotions::new(&dataset, &model, &system, loads));
                let loaded = Self {
                    study,
                    dataset,
                    model,
                    measurement,
                    programme,
                    free: free.unwrap_or_default(),
                    unknowns,
                    reference,
                    car,
                };
                return Checked {
                    value: Some(loaded),
                    diagnostics,
                };
            }
        }
        diagnostics.extend(own);
        Checked {
            value: None,
            diagnostics,
        }
    }

    /// Returns the inputs of the identification methods, borrowed from this study.
    pub fn problem(&self) -> Problem<'_> {
        Problem {
            dataset: &self.dataset,
            model: &self.model,
            programme: &self.programme,
            measurement: &self.measurement,
            settings: &self.study.identify,
            regression: &self.study.regression,
            tolerances: &self.study.tolerances,
            priors: &self.study.priors,
            free: &self.free,
            unknowns: self.unknowns.clone(),
        }
    }

    /// Returns the value of each unknown in the reference deck; `None` without a reference deck or without a value there.
    pub fn reference_values(&self) -> Vec<Option<f64>> {
        match &self.reference {
            None => vec![None; self.unknowns.len()],
            Some(reference) => values_in(&self.unknowns, |address| reference.value_at(address)),
        }
    }

    /// Returns the bytes of the deck with these values of the unknowns, as edits of the user's own file. All other text is unchanged.
    ///
    /// # Errors
    /// Fails if a value cannot be written into the deck.
    pub fn identified_deck(&self, values: &[f64]) -> Result<Vec<u8>, Diagnostic> {
        let assigned: Vec<(Address, f64)> = assigned(&self.unknowns, values.iter().copied())
            .into_iter()
            .map(|(address, value)| (address, significant(value)))
            .collect();
        let beside = assigned.iter().map(|(address, _)| address).collect();
        let mut edits = Vec::new();
        for (address, value) in &assigned {
            edits.extend(self.dataset.set_beside(address, *value, &beside)?);
        }
        let bytes = admire_syntax::text::apply_edits(self.dataset.bytes(), &edits);
        Ok(bytes.expect("every number of a deck has its own place"))
    }
}

fn has_errors(diagnostics: &[Diagnostic]) -> bool {
    diagnostics
        .iter()
        .any(|diagnostic| diagnostic.severity == Severity::Error)
}

/// Rounds a value to twelve significant digits. This is more than any estimate warrants, and short enough for readable lines.
fn significant(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}
