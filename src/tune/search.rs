//! Searches from several starts.

use sobol::Sobol;
use sobol::params::JoeKuoD6;

use crate::descent::search_from;
use crate::evaluation::Evaluator;
use crate::found::Found;
use crate::outcome::Outcome;
use crate::tune_error::TuneError;
use crate::tuning::Tuning;

/// Number of dimensions up to which the small table of direction numbers of the Sobol sequence is large enough.
const SMALL_TABLE: usize = 100;

impl Tuning {
    /// Searches from the start of the study and from Sobol points within the bounds.
    ///
    /// `watch` receives the number of the start and the number of evaluations so far. It returns false to stop. A stopped search still has an
    /// outcome.
    ///
    /// # Errors
    /// [`TuneError`] if the axle has no equilibrium at any start.
    pub fn search(
        &self,
        watch: &mut dyn FnMut(usize, usize) -> bool,
    ) -> Result<Outcome, TuneError> {
        let mut evaluator = Evaluator::new(self);
        let mut found: Vec<Found> = Vec::new();
        let mut goes_on = true;
        for (k, start) in self.starts().into_iter().enumerate() {
            if !goes_on {
                break;
            }
            let mut tell = |evaluations: usize| {
                goes_on = watch(k, evaluations);
                goes_on
            };
            found.push(search_from(&mut evaluator, &start, &mut tell));
        }
        Outcome::of(self, &mut evaluator, found)
    }

    /// Returns the starts of the search: the start of the study, then points of a Sobol sequence within the bounds. The first point of the
    /// sequence is left out.
    fn starts(&self) -> Vec<Vec<f64>> {
        let (count, restarts) = (self.unknowns.len(), self.target.restarts);
        let mut all = vec![self.start()];
        if restarts == 0 {
            return all;
        }
        let table = if count > SMALL_TABLE {
            JoeKuoD6::standard()
        } else {
            JoeKuoD6::minimal()
        };
        let points = Sobol::<f64>::new(count, &table).skip(1).take(restarts);
        all.extend(points.map(|point| {
            let each = self.unknowns.iter().zip(point);
            each.map(|(unknown, u)| {
                let [least, most] = unknown.bounds;
                least + u * (most - least)
            })
            .collect()
        }));
        all
    }
}
