//! Predictions of a fitted model for load cases that have not been run, and for functions that have not been measured.

use std::sync::Arc;

use admire_diagnosis::{DiagnosisProblem, FittedModel, Known, Unknowns, with_zero_guesses};
use admire_identify::Problem;
use admire_identify::global::{
    CasePrediction, FitUnknown, FitUnknowns, Observations, Observed, Prediction, Prepared,
    UnknownTarget,
};
use admire_session::backend::LoadProgramme;
use admire_solver::model::PartIx;

/// Predictions of a fitted model in the load cases of a study and in further cases, with derivatives with respect to the unknowns of the
/// model's deck.
#[derive(Debug)]
pub(super) struct Forecast {
    /// Predictions of the load cases of the study.
    pub here: Prediction,
    /// Predictions of each sequence of further cases. `None` for a sequence in which a case has no equilibrium.
    pub there: Vec<Option<Vec<CasePrediction>>>,
    /// Quantities that the predictions contain. Parts that the study measures come before other parts.
    pub observed: Observed,
    /// Index of the first requested function among the channels of a prediction.
    pub first_function: usize,
}

/// Predictions that are requested in addition to the readings of the study.
#[derive(Clone, Copy, Debug)]
pub(super) struct ForecastRequest<'a> {
    /// Sequences of load cases, with one value per load in each case. Each sequence is applied after the cases of the study.
    pub sequences: &'a [Vec<Vec<f64>>],
    /// Parts whose motions are requested.
    pub parts: &'a [PartIx],
    /// Function expressions of the deck whose values are requested.
    pub functions: &'a [String],
}

impl Forecast {
    /// Solves the cases of the study and the further cases. Returns `None` if the deck cannot be compiled with these functions, or if a case
    /// of the study has no equilibrium.
    pub(super) fn new(
        subject: &DiagnosisProblem<'_>,
        fitted: &FittedModel,
        asked: ForecastRequest<'_>,
    ) -> Option<Self> {
        let problem = Problem {
            dataset: &fitted.deck.dataset,
            model: &fitted.deck.model,
            ..subject.problem.clone()
        };
        let prepared = if asked.functions.is_empty() {
            Arc::clone(&fitted.deck.prepared)
        } else {
            let plans = fitted.effects.iter().filter_map(|h| h.memory.as_ref());
            let measures = plans.map(|plan| plan.measure.clone());
            let all: Vec<String> = measures.chain(asked.functions.iter().cloned()).collect();
            Arc::new(Prepared::with(&problem, &all).ok()?)
        };
        let known = Known {
            unknowns: &fitted.unknowns,
            chosen: &fitted.effects,
            places: &fitted.parameter_index,
            x: &fitted.x,
        };
        let chosen = with_zero_guesses(fitted);
        let unknowns = Unknowns::new(subject, &problem, &prepared, &chosen, Some(known))?;
        let mut observed = observed(subject);
        for part in asked.parts {
            if !observed.parts.contains(part) {
                observed.parts.push(*part);
            }
        }
        let runs = Runs {
            problem: &problem,
            fitted,
            prepared: &prepared,
            unknowns: &unknowns,
            observed: &observed,
        };
        let count = problem.programme.cases.len();
        let mut here = runs.predict(asked.sequences)?;
        let mut rest = here.split_off(count).into_iter();
        let there = asked
            .sequences
            .iter()
            .map(|sequence| rest.by_ref().take(sequence.len()).collect())
            .collect();
        if !here.iter().all(Option::is_some) {
            return None;
        }
        Some(Self {
            here,
            there,
            observed,
            first_function: problem.measurement.channels.len() + fitted.memories.len(),
        })
    }
}

struct Runs<'a> {
    problem: &'a Problem<'a>,
    fitted: &'a FittedModel,
    prepared: &'a Prepared,
    unknowns: &'a Unknowns,
    observed: &'a Observed,
}

impl Runs<'_> {
    /// Predicts all cases of the study, then the further sequences. At the start of each sequence, laws with memory have the state that they
    /// reach at the end of the study.
    fn predict(&self, sequences: &[Vec<Vec<f64>>]) -> Option<Prediction> {
        let further: Vec<&[f64]> = sequences.iter().flatten().map(Vec::as_slice).collect();
        let further = further.as_slice();
        let counts: Vec<usize> = sequences.iter().map(Vec::len).collect();
        let programme = self.problem.programme;
        let mut cases: Vec<Vec<f64>> = programme.cases.iter().map(|c| c.values.clone()).collect();
        cases.extend(further.iter().map(|values| values.to_vec()));
        let list = self.unknowns.list.list().iter();
        let list = FitUnknowns::new(list.map(|own| continued(own, programme, further)).collect());
        let x = &self.fitted.x[..list.len()];
        let numbers = list.numbers(&self.unknowns.deck, x);
        let directions = list.directions(&numbers.theta, x);
        // Along zero-stiffness motions, a further case takes the mark positions of the nearest case of the study, so that models can be
        // compared.
        let mut observed = self.observed.clone();
        let near = further.iter().map(|values| {
            let nearest = nearest(programme, values);
            nearest.map_or_else(Vec::new, |case| self.observed.marks[case].clone())
        });
        observed.marks.extend(near);
        let mut predictor = self
            .prepared
            .native(self.problem, observed)
            .ok()?
            .with_cases(cases)
            .remembering(self.unknowns.memories.clone());
        let states = &self.fitted.states;
        for (case, state) in states.iter().enumerate() {
            predictor.start_from(case, state.clone(), numbers.theta.clone());
        }
        for (k, values) in further.iter().enumerate() {
            if let Some(nearest) = nearest(programme, values) {
                let state = states[nearest].clone();
                predictor.start_from(states.len() + k, state, numbers.theta.clone());
            }
        }
        Some(predictor.predict_apart(&numbers, Some(&directions), states.len(), &counts))
    }
}

/// Returns the case of the study with the nearest loads. Distances are measured in units of each load's range.
pub(super) fn nearest(programme: &LoadProgramme, values: &[f64]) -> Option<usize> {
    let range = |load: usize| {
        let all = programme.cases.iter().map(|case| case.values[load]);
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        (high - low).max(f64::MIN_POSITIVE)
    };
    let ranges: Vec<f64> = (0..programme.loads.len()).map(range).collect();
    let far = |case: &usize| -> f64 {
        let own = programme.cases[*case].values.iter();
        let each = own.zip(values).zip(&ranges);
        each.map(|((a, b), range)| ((a - b) / range).powi(2)).sum()
    };
    (0..programme.cases.len()).min_by(|a, b| far(a).total_cmp(&far(b)))
}

/// Extends the per-case factors of an unknown to the further cases.
fn continued(unknown: &FitUnknown, programme: &LoadProgramme, further: &[&[f64]]) -> FitUnknown {
    let mut unknown = unknown.clone();
    if let UnknownTarget::PerCase(slots) = &mut unknown.target {
        for (_, factors) in slots {
            let more = followed(factors, programme, further);
            factors.extend(more);
        }
    }
    unknown
}

/// Returns the factors of an unknown in the further cases. Factors that are proportional to a load stay proportional to it, and constant
/// factors stay constant. Any other unknown has the factor zero in the further cases.
fn followed(factors: &[f64], programme: &LoadProgramme, further: &[&[f64]]) -> Vec<f64> {
    let follows = (0..programme.loads.len()).find_map(|load| {
        let values = programme.cases.iter().map(|case| case.values[load]);
        let (at, most) = values
            .clone()
            .enumerate()
            .max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
        let ratio = factors[at] / most;
        let same = values
            .zip(factors)
            .all(|(v, f)| (v * ratio - f).abs() <= 1e-9 * factors[at].abs());
        (ratio.is_finite() && ratio != 0.0 && same).then_some((load, ratio))
    });
    let constant = factors.first().filter(|f| factors.iter().all(|g| g == *f));
    let of = |values: &&[f64]| match follows {
        Some((load, ratio)) => values[load] * ratio,
        None => constant.copied().unwrap_or(0.0),
    };
    further.iter().map(of).collect()
}

/// Returns the quantities that a predictor must report to predict the readings of the study.
fn observed(subject: &DiagnosisProblem<'_>) -> Observed {
    Observations::new(subject.problem.measurement, subject.problem.model, &[]).observed
}

#[cfg(test)]
mod tests {
    use super::followed;
    use admire_session::backend::{Load, LoadCase, LoadProgramme};
    use admire_syntax::text::Source;
    use admire_syntax::{Address, Dataset};

    fn programme(cases: &[[f64; 2]]) -> LoadProgramme {
        let text = b"t\nSFORCE/1, I=1, J=2, FUNCTION=0\nSFORCE/2, I=1, J=2, FUNCTION=0\nEND\n";
        let dataset = Dataset::parse(Source::new("model.adm", text.to_vec())).value;
        let load = |name: &str| Load {
            name: name.to_string(),
            target: Address::parse(name, &dataset).unwrap(),
        };
        LoadProgramme {
            loads: vec![load("SFORCE/1"), load("SFORCE/2")],
            cases: cases
                .iter()
                .map(|values| LoadCase {
                    label: String::new(),
                    values: values.to_vec(),
                })
                .collect(),
        }
    }

    #[test]
    fn errors_of_loads_go_on_with_the_loads() {
        let programme = programme(&[[1.0, 0.0], [2.0, 5.0], [-4.0, 1.0]]);
        let further: [&[f64]; 2] = [&[8.0, 0.0], &[0.0, -3.0]];
        let of = |factors: &[f64]| followed(factors, &programme, &further);
        assert_eq!(of(&[0.5, 1.0, -2.0]), [4.0, 0.0]);
        assert_eq!(of(&[0.0, 50.0, 10.0]), [0.0, -30.0]);
        // The first unknown is equal in all cases, like a zero offset. The second is a load error in a single case.
        assert_eq!(of(&[3.0, 3.0, 3.0]), [3.0, 3.0]);
        assert_eq!(of(&[0.0, 1.0, 0.0]), [0.0, 0.0]);
    }
}
