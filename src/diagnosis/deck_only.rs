use super::diagnosis_problem::DiagnosisProblem;
use super::fit::FittedModel;
use admire_identify::Problem;
use admire_identify::global::Predictor;
use admire_solver::system::{Parameters, State};

/// Prediction of a model as exported to a deck: with its causes and stiffnesses, and with all plain random effects set to zero.
#[derive(Clone, Debug)]
pub struct DeckOnlyPrediction {
    /// Deck parameters of each load case.
    pub thetas: Vec<Parameters>,
    /// Equilibrium of each load case.
    pub states: Vec<State>,
}

impl DeckOnlyPrediction {
    /// Solves all cases of a fitted model without its random effects. Returns `None` if a case has no equilibrium.
    pub fn new(subject: &DiagnosisProblem<'_>, fitted: &FittedModel) -> Option<Self> {
        let deck = &fitted.deck;
        let problem = Problem {
            dataset: &deck.dataset,
            model: &deck.model,
            ..subject.problem.clone()
        };
        let mut predictor = fitted.predictor(&problem)?;
        let parameters = deck.prepared.system.parameters();
        let mut x = fitted.x[..fitted.unknowns.len()].to_vec();
        for (k, x) in x.iter_mut().enumerate() {
            if !fitted.is_of_the_model(k) {
                *x = 0.0;
            }
        }
        let numbers = fitted.unknowns.numbers(&parameters, &x);
        predictor.predict(&numbers, None);
        subject.count_sweeps(1);
        let held = problem.free.held_weights(&deck.prepared.system);
        let (mut thetas, mut states) = (Vec::new(), Vec::new());
        for case in 0..fitted.states.len() {
            let (state, theta) = predictor.answer(case)?;
            let mut theta = theta.clone();
            for weight in &held {
                weight.release(&mut theta, &numbers.theta);
            }
            states.push(state.clone());
            thetas.push(theta);
        }
        Some(Self { thetas, states })
    }
}
