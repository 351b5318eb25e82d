use std::sync::Arc;

use nalgebra::DVector;

use super::background::Background;
use super::effort::Budget;
use crate::identify::Problem;
use crate::identify::global::{Observations, Row};

/// A study under diagnosis: what a fit may see, and in which order readings become rows.
#[derive(Clone, Debug)]
pub struct Subject<'a> {
    /// The study's problem.
    pub problem: Problem<'a>,
    /// All cases, held out or not.
    pub rows: Vec<Row>,
    /// Sd of a mark coordinate.
    pub sigma: f64,
    /// Ids of bushings whose assembly offset is no nuisance but a hypothesis like any other.
    pub offsets_in_question: Vec<u32>,
    /// Errors of hardpoints and loads that are part of the noise: of the fitted cases, and of all.
    pub backgrounds: Option<[Arc<Background>; 2]>,
    /// What the whole search may cost.
    pub budget: Arc<Budget>,
    held_out: Vec<bool>,
}

impl<'a> Subject<'a> {
    /// With these cases held out.
    pub fn new(problem: &Problem<'a>, held_out: Vec<bool>) -> Self {
        let cases: Vec<usize> = (0..held_out.len()).collect();
        let observations = Observations::new(problem.measurement, problem.model, &cases);
        Self {
            problem: problem.clone(),
            sigma: observations.sigma,
            rows: observations.rows,
            offsets_in_question: Vec::new(),
            backgrounds: None,
            budget: Arc::new(Budget::default()),
            held_out,
        }
    }

    /// Whether no fit sees a case.
    pub fn is_held_out(&self, case: usize) -> bool {
        self.held_out[case]
    }

    /// True if some case is held out.
    pub fn holds_out(&self) -> bool {
        self.held_out.iter().any(|held| *held)
    }

    /// What whitens the rows of a fit of this data.
    pub fn background(&self, data: Data) -> Option<Arc<Background>> {
        let [fitted, all] = self.backgrounds.as_ref()?;
        Some(Arc::clone(match data {
            Data::Fitted => fitted,
            Data::All => all,
        }))
    }

    /// Weight of each row in a fit.
    pub fn weights(&self, data: Data) -> DVector<f64> {
        let weight = |row: &Row| match data {
            Data::All => 1.0,
            Data::Fitted => f64::from(u8::from(!self.held_out[row.case()])),
        };
        DVector::from_iterator(self.rows.len(), self.rows.iter().map(weight))
    }
}

/// What a fit sees.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Data {
    /// The cases that are not held out.
    Fitted,
    /// Every case.
    All,
}
