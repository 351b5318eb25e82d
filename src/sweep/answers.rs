//! Cases that are identifications or diagnoses: the study runs with the deck of the case.

use admire_design::propose;
use serde_json::Value;

use super::answer_path::{AnswerPath, ResultFile};
use super::kept::{Output, OutputSource, OutputSpec};
use super::row::Status;
use admire_diagnosis::{
    GainCheck, Progress, SharedProgress, diagnose_watched, held_out, study_fit as fit,
};
use admire_identify::{LoadedStudy, estimate_noise};
use admire_study::settings::BackendChoice;
use admire_study::solver;
use admire_syntax::diagnostic::Severity;
use admire_syntax::text::{Source, Span};

/// Result files of a study, as far as the sweep records numbers from them.
#[derive(Debug, Default)]
pub(crate) struct StudyResults {
    identification: Value,
    diagnosis: Value,
}

impl StudyResults {
    /// Runs the study with `deck` in place of its own deck.
    ///
    /// # Errors
    /// Status and reason of the failure.
    pub(crate) fn of(
        study: &LoadedStudy,
        deck: &Source,
        keeps: &[(OutputSpec, Option<String>, Span)],
        check: GainCheck,
    ) -> Result<Self, (Status, String)> {
        let read = study.with_deck(deck.clone());
        let Some(loaded) = read.value else {
            let mut errors = read.diagnostics.into_iter();
            let error = errors.find(|d| d.severity == Severity::Error);
            let why = error.map_or_else(|| "the study has errors".to_string(), |d| d.message);
            return Err((Status::Invalid, why));
        };
        let asks = |answer: ResultFile| {
            let mut keeps = keeps.iter();
            keeps
                .any(|(keep, ..)| matches!(keep, OutputSpec::Answer(path) if path.answer == answer))
        };
        let no_answer = |why: String| (Status::NoAnswer, why);
        let mut new = Self::default();
        if asks(ResultFile::Identification) {
            let mut own = loaded.clone();
            let mut backend = solver::backend(&own.study, None, &|_| ());
            let found = fit::identify(&mut own, backend.as_mut(), &SharedProgress::default());
            let found = found.map_err(|error| no_answer(error.to_string()))?;
            if !found.converged {
                return Err(no_answer("the fit did not converge".to_string()));
            }
            new.identification = value(&found);
        }
        if asks(ResultFile::Diagnosis) {
            let mut own = loaded;
            let failed = |error: &dyn std::fmt::Display| no_answer(error.to_string());
            estimate_noise(&mut own, None).map_err(|error| failed(&error))?;
            let held = held_out(&own.study, &own.measurement);
            let problem = own.problem();
            let mut outcome = diagnose_watched(&problem, held, check, &Progress::default())
                .map_err(|error| failed(&error))?;
            propose(&mut outcome);
            if own.study.solver.backend != BackendChoice::Native {
                let mut backend = solver::backend(&own.study, None, &|_| ());
                if let Some(refused) = outcome.by_the_study(backend.as_mut()) {
                    return Err(no_answer(refused));
                }
            }
            new.diagnosis = value(&outcome.diagnosis);
        }
        Ok(new)
    }

    fn answer(&self, path: &AnswerPath) -> &Value {
        match path.answer {
            ResultFile::Identification => &self.identification,
            ResultFile::Diagnosis => &self.diagnosis,
        }
    }

    /// Expands a path into paths without `*`, each with the names that its stars match.
    ///
    /// # Errors
    /// The reason why a path has no number.
    pub(crate) fn matching(&self, path: &AnswerPath) -> Result<Vec<(AnswerPath, String)>, String> {
        let answer = self.answer(path);
        let found = path.matching(answer);
        let wrong = found.iter().find_map(|(path, _)| path.refused(answer));
        match wrong {
            Some(why) => Err(why),
            None if found.is_empty() => Err(path.refused(answer).unwrap_or_default()),
            None => Ok(found),
        }
    }

    /// Returns the numbers at the paths of all output columns; NaN for a column that is not from a study.
    pub(crate) fn numbers(&self, outputs: &[Output]) -> Vec<f64> {
        let number = |output: &Output| match &output.origin {
            OutputSource::Answer(path) => path.number(self.answer(path)),
            _ => f64::NAN,
        };
        outputs.iter().map(number).collect()
    }
}

fn value(answer: &impl serde::Serialize) -> Value {
    serde_json::to_value(answer).expect("an answer holds only names and numbers")
}
