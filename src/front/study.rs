use admire_design::propose;
use std::path::{Path, PathBuf};

use admire_design::{Aim, Plan, plan};
use admire_diagnosis::{Diagnosis, GainCheck, Progress, diagnose_watched, held_out};
use admire_identify::global::Marginal;
use admire_identify::{Fit, LoadedStudy, estimate_noise};
use admire_report::{DiagnosisReport, IdentificationReport, Plausibility, lead};
use admire_session::Sources;
use admire_session::backend::Backend;
use admire_solver::model::lint;
use admire_study::settings::{BackendChoice, Method};
use admire_syntax::diagnostic::{Code, Diagnostic, Severity};
use admire_syntax::text::{Source, read_at_most};

use super::car_files;
use super::error::{Complaint, Error, ErrorKind};
use super::fit_view::{changed_lines, positions};
use super::foreign::foreign_parts;
use super::suggested::suggested;
#[cfg(feature = "kc")]
use super::tuning::{TuningAnswer, TuningOptions};
use admire_diagnosis::{ProgressObserver, study_fit as fit};
use admire_study::{NamedProgram, solver};

/// Largest size in bytes of a file that is read in order to show places in it.
const LARGEST_SHOWN: u64 = 64 << 20;

/// Study folder: a deck, load cases and measurements.
#[derive(Clone, Debug)]
pub struct Study {
    settings: admire_study::Study,
    /// Study with its model and readings; `None` if the study has a target but no readings.
    loaded: Option<LoadedStudy>,
    /// True if the external program of the study may be started.
    allowed: bool,
    complaints: Vec<Complaint>,
    sources: Sources,
}

/// Result of an identification: the identified stiffnesses of a study and their uncertainty.
#[derive(Clone, Debug)]
pub struct Identification {
    /// Contents of `identification.json`: the identified parameters, and the quality of the fit.
    pub fit: Fit,
    /// Summary of the result in a few sentences.
    pub lead: String,
    /// Deck with the identified parameters.
    pub deck: Vec<u8>,
    /// Report as a complete HTML page.
    pub html: String,
    /// Remarks of the study's solver backend.
    pub remarks: Vec<String>,
    /// Changed files for Adams/Car, as pairs of path (below an output folder) and contents. Empty if the study names no subsystem.
    pub car_files: Vec<(PathBuf, Vec<u8>)>,
}

/// Result of a diagnosis: the faults of a model that remain after its best fit.
#[derive(Clone, Debug)]
pub struct DiagnosisAnswer {
    /// Contents of `diagnosis.json`: verdict, findings and their evidence.
    pub diagnosis: Diagnosis,
    /// Result of the diagnosis, as sentences.
    pub sentences: Vec<String>,
    /// Deck to which the causes found have been added.
    pub deck: Vec<u8>,
    /// Command file that runs the extended deck on any ADAMS.
    pub commands: String,
    /// Report as a complete HTML page.
    pub html: String,
    /// Remarks of the study's solver backend.
    pub remarks: Vec<String>,
    /// Files in the terms of Adams/Car, each with its path below an output folder; empty if the study names no subsystem.
    pub car_files: Vec<(PathBuf, Vec<u8>)>,
}

/// Recommended further measurements for a study.
#[derive(Clone, Debug)]
pub struct PlanAnswer {
    /// Contents of `plan.json`: parameters that the readings leave undetermined, and the effect of each candidate measurement.
    pub plan: Plan,
    /// Load cases of the best candidates, as rows in the format of the study's load case file.
    pub suggested: String,
}

/// Callback that repeats the fit of a study and stores the results of the repetitions in the given [`Fit`].
pub(crate) type Again<'a> = dyn FnMut(&LoadedStudy, &Marginal, &mut Fit) -> Result<(), Error> + 'a;

impl Study {
    /// Reads a study folder and all files that the study names.
    ///
    /// # Errors
    /// Diagnostics of the faults that make the study unusable.
    pub fn open(folder: impl AsRef<Path>) -> Result<Self, Error> {
        let folder = folder.as_ref();
        let read = admire_study::Study::read(folder);
        let (study, loaded, diagnostics) = match read.value {
            Some(study) if study.is_target_alone() && !has_errors(&read.diagnostics) => {
                (Some(study), None, read.diagnostics)
            }
            _ => {
                let read = LoadedStudy::read(folder);
                let study = read.value.as_ref().map(|loaded| loaded.study.clone());
                (study, read.value, read.diagnostics)
            }
        };
        let mut sources = Sources::default();
        if let Some(study) = &study {
            sources.add(study.source.clone());
            sources.add(study.deck.clone());
        }
        for label in diagnostics.iter().flat_map(|found| &found.labels) {
            // The files are kept so that places can be shown in them. For a huge file, only its name is shown.
            if sources.get(&label.file).is_none()
                && let Ok(bytes) = read_at_most(Path::new(&*label.file), LARGEST_SHOWN)
            {
                sources.add(Source::new(&*label.file, bytes).in_utf8());
            }
        }
        match study {
            Some(study) => Ok(Self {
                settings: study,
                loaded,
                allowed: false,
                complaints: diagnostics
                    .iter()
                    .map(|found| Complaint::new(found, &sources))
                    .collect(),
                sources,
            }),
            None => Err(Error::new(ErrorKind::Input, &diagnostics, &sources)),
        }
    }

    /// Returns the folder of the study.
    pub fn folder(&self) -> &Path {
        &self.settings.folder
    }

    /// Returns the warnings and notes about the study's files.
    pub fn complaints(&self) -> &[Complaint] {
        &self.complaints
    }

    /// Replaces the identification method of the study.
    pub fn set_method(&mut self, method: Method) {
        self.settings.identify.method = method;
        if let Some(loaded) = &mut self.loaded {
            loaded.study.identify.method = method;
        }
    }

    /// Returns the program and arguments that the study starts for every equilibrium; `None` if the study names no program.
    pub fn starts_program(&self) -> Option<&[String]> {
        let solver = &self.settings.solver;
        (solver.backend == BackendChoice::Command).then_some(&solver.command)
    }

    /// Allows this `Study` value to start the external program of the study. Without this call, the program is started only if the user has
    /// allowed the command before, or has created the study by `admire new`.
    pub fn allow_command(&mut self) {
        self.allowed = true;
    }

    fn may_start(&self) -> Result<(), Error> {
        match NamedProgram::of_study(&self.settings) {
            Some(program) if !self.allowed && !program.is_allowed() => {
                let help = "allow the program by `allow_command`; or run `admire identify` on a terminal, which asks once";
                Err(Error::plain(ErrorKind::Usage, &program.refusal(help)))
            }
            _ => Ok(()),
        }
    }

    /// Identifies the stiffnesses. `force` skips the plausibility check.
    ///
    /// # Errors
    /// When the study has no unknowns, when it is implausible, or when no fit is found.
    pub fn identify(
        &self,
        force: bool,
        watch: &dyn ProgressObserver,
    ) -> Result<Identification, Error> {
        self.identify_and(force, watch, None)
    }

    /// Identifies the stiffnesses, and repeats the fit by `again` before the result is reported.
    ///
    /// # Errors
    /// The errors of [`identify`](Self::identify) and of `again`. Also an error if the fit cannot be repeated.
    pub(crate) fn identify_and(
        &self,
        force: bool,
        watch: &dyn ProgressObserver,
        again: Option<&mut Again<'_>>,
    ) -> Result<Identification, Error> {
        let mut loaded = self.loaded()?.clone();
        if loaded.unknowns.is_empty() {
            return Err(self.refused(&[fit::nothing_to_identify(&loaded)]));
        }
        if again.is_some()
            && let Some(refused) = fit::not_repeatable(&loaded)
        {
            return Err(self.refused(&[refused]));
        }
        self.plausible(force)?;
        self.may_start()?;
        let mut backend = backend(&loaded);
        let found = fit::identify_with(&mut loaded, backend.as_mut(), watch, again.is_some());
        let (mut fit, marginal) = found.map_err(|error| self.no_fit(&error.to_string()))?;
        if let Some(again) = again {
            let Some(marginal) = marginal.filter(|_| fit.converged && !fit.interrupted) else {
                return Err(self.no_fit(
                    "the fit did not converge, so bootstrap and posterior were not computed",
                ));
            };
            again(&loaded, &marginal, &mut fit)?;
        }
        let positions = positions(&loaded, &fit, backend.as_mut());
        let deck = loaded
            .identified_deck(&fit.values())
            .map_err(|refused| self.refused(&[refused]))?;
        let diff = changed_lines(loaded.dataset.bytes(), &deck);
        let report = IdentificationReport {
            loaded: &loaded,
            fit: &fit,
            diff: &diff,
            positions: &positions,
        };
        let html = report
            .html()
            .map_err(|error| self.no_fit(&error.to_string()))?;
        let car = car_files::identified(&loaded, &fit, &deck);
        Ok(Identification {
            car_files: car.unwrap_or_default().files,
            lead: lead(&fit),
            deck,
            html,
            remarks: backend.remarks(),
            fit,
        })
    }

    /// Diagnoses the faults of the model that remain after its best fit. `force` skips the plausibility check.
    ///
    /// # Errors
    /// When the readings do not belong to the deck's parts, when the study is implausible, or when no fit is found.
    pub fn diagnose(
        &self,
        force: bool,
        watch: &dyn ProgressObserver,
    ) -> Result<DiagnosisAnswer, Error> {
        self.diagnose_checked(force, GainCheck::default(), watch)
    }

    /// Diagnoses the model as [`diagnose`](Self::diagnose) does. `check` sets how thoroughly the gain of each cause is verified.
    ///
    /// # Errors
    /// As for [`diagnose`](Self::diagnose).
    pub fn diagnose_checked(
        &self,
        force: bool,
        check: GainCheck,
        watch: &dyn ProgressObserver,
    ) -> Result<DiagnosisAnswer, Error> {
        self.may_start()?;
        let (loaded, progress) = self.for_diagnosis(force, watch)?;
        let held = held_out(&loaded.study, &loaded.measurement);
        let problem = loaded.problem();
        let found = diagnose_watched(&problem, held, check, &progress);
        let mut outcome = found.map_err(|error| self.no_fit(&error.to_string()))?;
        propose(&mut outcome);
        let mut remarks = Vec::new();
        if loaded.study.solver.backend != BackendChoice::Native {
            let mut backend = backend(&loaded);
            remarks.extend(outcome.by_the_study(backend.as_mut()));
            remarks.extend(backend.remarks());
        }
        let deck = outcome.extended_deck();
        let diff = changed_lines(loaded.dataset.bytes(), &deck);
        let report = DiagnosisReport {
            loaded: &loaded,
            outcome: &outcome,
            diff: &diff,
        };
        let html = report
            .html()
            .map_err(|error| self.no_fit(&error.to_string()))?;
        let car = car_files::diagnosed(&loaded, &outcome, &deck);
        Ok(DiagnosisAnswer {
            car_files: car.unwrap_or_default().files,
            sentences: admire_report::diagnosis_sentences(&outcome),
            commands: outcome.extended_commands(),
            deck,
            html,
            remarks,
            diagnosis: outcome.diagnosis,
        })
    }

    /// Ranks possible further measurements by their gain for the study. The load cases of the first `count` candidates are suggested as
    /// rows for the study's load case file. `force` skips the plausibility check.
    ///
    /// ```
    /// use admire::{Aim, SharedProgress, Study};
    ///
    /// # fn main() -> Result<(), admire::Error> {
    /// let study = Study::open("corpus/pseudo-mcpherson")?;
    /// let found = study.plan(Aim::Stiffnesses, 5, false, &SharedProgress::default())?.plan;
    /// // The best candidate makes the worst-known combination of stiffnesses better known.
    /// assert!(found.candidates[0].sd_log[0] < found.combinations[0].sd_log);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// When the study has no unknowns for this aim, when the readings do not belong to the deck's parts, when the study is implausible, or
    /// when no fit is found.
    pub fn plan(
        &self,
        aim: Aim,
        count: usize,
        force: bool,
        watch: &dyn ProgressObserver,
    ) -> Result<PlanAnswer, Error> {
        let loaded = self.loaded()?;
        if aim == Aim::Stiffnesses && loaded.unknowns.is_empty() {
            return Err(self.refused(&[fit::nothing_to_identify(loaded)]));
        }
        let (loaded, progress) = self.for_diagnosis(force, watch)?;
        let found = plan(&loaded.problem(), aim, &progress);
        let found = found.map_err(|error| self.no_fit(&error.to_string()))?;
        if aim == Aim::Curves && found.curves.is_none() {
            return Err(self.refused(&[fit::no_wheel()]));
        }
        Ok(PlanAnswer {
            suggested: suggested(&loaded, &found, count),
            plan: found,
        })
    }

    /// Changes numbers of the deck until its K&C characteristics meet the goals of the section `[target]`, like `admire tune`. Writes no
    /// files.
    ///
    /// ```
    /// use admire::{SharedProgress, Study, TuningOptions};
    ///
    /// # fn main() -> Result<(), admire::Error> {
    /// let study = Study::open("corpus/double-wishbone")?;
    /// let options = TuningOptions { restarts: Some(0), ..TuningOptions::default() };
    /// assert!(study.tune(&options, &SharedProgress::default())?.converged);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// When the study has no target or its target is wrong, or when the axle has no equilibrium at any start.
    #[cfg(feature = "kc")]
    pub fn tune(
        &self,
        options: &TuningOptions,
        watch: &dyn ProgressObserver,
    ) -> Result<TuningAnswer, Error> {
        super::tuning::answer(self.folder(), options, watch)
    }

    /// Prepares a diagnosis. Returns the study, with the noise level estimated from its marks (measured points), and the object that stores the
    /// progress of the diagnosis.
    fn for_diagnosis(
        &self,
        force: bool,
        watch: &dyn ProgressObserver,
    ) -> Result<(LoadedStudy, Progress), Error> {
        let mut loaded = self.loaded()?.clone();
        let foreign = foreign_parts(&loaded);
        if !foreign.is_empty() {
            return Err(self.refused(&foreign));
        }
        self.plausible(force)?;
        let progress = Progress::default();
        watch.diagnoses(&progress);
        estimate_noise(&mut loaded, None).map_err(|error| self.no_fit(&error.to_string()))?;
        Ok((loaded, progress))
    }

    /// Returns the path of the study's deck.
    pub fn deck(&self) -> PathBuf {
        PathBuf::from(self.settings.deck.name())
    }

    /// Returns the study with its readings.
    fn loaded(&self) -> Result<&LoadedStudy, Error> {
        let refused = || {
            let message = "the study has only a target, and no measurements";
            let refused = Diagnostic::error(Code::MissingSetting, message)
                .label(self.settings.source.name(), self.settings.place(&["target"]), "")
                .help("use `admire tune` to meet the target; a fit needs the sections [loads] and [marks], [wheel], [kc] or [readings]");
            self.refused(&[refused])
        };
        self.loaded.as_ref().ok_or_else(refused)
    }

    fn plausible(&self, force: bool) -> Result<(), Error> {
        match Plausibility::of(self.loaded()?).refusal() {
            Some(message) if !force => {
                let refused = Diagnostic::error(Code::ImplausibleStudy, message);
                let refused = refused.help("`force` fits the study anyway");
                Err(self.failed(ErrorKind::Input, refused))
            }
            _ => Ok(()),
        }
    }

    fn no_fit(&self, why: &str) -> Error {
        self.failed(ErrorKind::NoAnswer, Diagnostic::error(Code::NoFit, why))
    }

    /// Creates the error for a failed fit, with the deck's warnings as possible reasons.
    fn failed(&self, kind: ErrorKind, why: Diagnostic) -> Error {
        let mut all = vec![why];
        if let Some(loaded) = &self.loaded {
            all.extend(lint::check(&loaded.dataset, &loaded.model));
        }
        Error::new(kind, &all, &self.sources)
    }

    fn refused(&self, found: &[Diagnostic]) -> Error {
        Error::new(ErrorKind::Input, found, &self.sources)
    }
}

fn has_errors(diagnostics: &[Diagnostic]) -> bool {
    diagnostics
        .iter()
        .any(|found| found.severity == Severity::Error)
}

/// Creates the solver backend of the study. [`Study::starts_program`] returns the external program of the backend, if it has one.
fn backend(loaded: &LoadedStudy) -> Box<dyn Backend> {
    solver::backend(&loaded.study, None, &|_| {})
}
