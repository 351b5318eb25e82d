//! Newton's iteration of a step, with the derivatives that it takes.

use super::coupled::Coupled;
use super::derivatives::Derivatives;
use super::error::NotSettled;
use super::integrator::Integrator;
use super::sequence::StageSequence;
use super::settings::INSIDE;
use crate::system::NoValue;

/// The iteration ends when what is left is this share of the tolerance.
const KAPPA: f64 = 1e-2;
/// Factors stay while the iteration falls by this.
const FAST: f64 = 0.1;
/// Derivatives of all stages stay while the iteration falls by this.
const SLUGGISH: f64 = 0.3;
/// A motion has settled, whatever its multipliers do, when its last correction is this share of the tolerance;
const SETTLED: f64 = 1e-1;
/// or, after so many cuts of the step, no more than ERROR: what cuts do not make smaller is round-off.
const CUTS: usize = 3;
const SETTLED_AFTER_CUTS: f64 = 1.0 / INSIDE;
/// Round-off of positions and velocities: what the iteration cannot go below.
const ROUND_OFF: f64 = 1e-14;

impl Integrator<'_> {
    /// Newton's iteration; gives how many iterations it took.
    pub(super) fn solve(&mut self, h: f64, derivatives: Derivatives) -> Result<usize, NotSettled> {
        let several = derivatives != Derivatives::Single;
        let always = derivatives == Derivatives::Renewed;
        let mut before = 0.0;
        // Whether the derivatives of all stages are to be made anew.
        let mut renew = several;
        let limit = KAPPA * self.settings.corrector * (1.0 + self.settings.adaptivity / h);
        for iteration in 1..=self.settings.maxit {
            let worst = self
                .corrected(h, derivatives, renew)
                .map_err(|reason| NotSettled {
                    why: reason.to_string(),
                    no_value: true,
                })?;
            let size = worst.0;
            if !size.is_finite() {
                return Err(NotSettled::at("the iteration leaves all bounds"));
            }
            let floor = ROUND_OFF / self.tolerance();
            if size <= floor {
                return Ok(iteration);
            }
            if iteration > 1 {
                let theta: f64 = size / before;
                // Derivatives of an earlier iteration say nothing of where this one ends.
                let fresh = renew || !several;
                if fresh && theta >= 0.99 && size > 10.0 * floor {
                    return self.given_up(worst, several.then_some(iteration));
                }
                let rate = theta.max(derivatives.slowest()).min(0.99);
                let left = rate / (1.0 - rate) * size;
                if left <= limit {
                    if theta > FAST {
                        self.factored = None;
                    }
                    return Ok(iteration);
                }
                let more = self.settings.maxit - iteration;
                if fresh && left * theta.powi(more as i32) > limit && more < 4 {
                    return self.given_up(worst, several.then_some(iteration));
                }
                let sluggish = derivatives == Derivatives::Kept && theta > SLUGGISH;
                renew = always || sluggish;
            } else if size <= 1e-2 * limit {
                return Ok(iteration);
            } else {
                // The first correction may lead far from where the derivatives were taken; what is left is small.
                renew = always || derivatives == Derivatives::Sequence;
            }
            before = size;
        }
        Err(NotSettled::at("the iteration does not settle"))
    }

    /// The largest component of the last correction, as [`Sizes::measured`] has it.
    fn largest_change(&self, variables: bool) -> (f64, usize, bool) {
        let mut worst = (0.0, 0, false);
        for (z, w) in self.change.z.iter().zip(&self.change.w) {
            let found = self.measured(z, w, variables);
            if !(found.0 <= worst.0) {
                worst = found;
            }
        }
        worst
    }

    /// The end of an iteration that does not settle. Next to a singular position multipliers follow from small differences, and round-off is
    /// all that is left of them while the motion has settled long since: it is taken, and the next step does not begin with their trend.
    /// `exact` is how many iterations it took with the derivatives of all stages: with those of one a slow iteration looks the same.
    fn given_up(
        &mut self,
        worst: (f64, usize, bool),
        exact: Option<usize>,
    ) -> Result<usize, NotSettled> {
        let multipliers = self.system.first_equation..self.system.first_variable;
        let settled = if self.cuts < CUTS {
            SETTLED
        } else {
            SETTLED_AFTER_CUTS
        };
        if let Some(iteration) = exact
            && !worst.2
            && multipliers.contains(&worst.1)
            && self.largest_change(false).0 <= settled
        {
            self.loose = true;
            return Ok(iteration);
        }
        Err(NotSettled::at(&format!(
            "the iteration does not settle {}",
            self.told(worst)
        )))
    }

    /// One iteration, with derivatives made anew where they are asked for; gives its largest correction.
    fn corrected(
        &mut self,
        h: f64,
        derivatives: Derivatives,
        renew: bool,
    ) -> Result<(f64, usize, bool), NoValue> {
        let tolerance = self.tolerance();
        let (system, parameters, start) = (self.system, self.parameters, &self.state);
        let (model, step) = ((system, parameters), (start, h));
        let (equations, unknowns, change) =
            (&mut self.equations, &mut self.unknowns, &mut self.change);
        match derivatives {
            Derivatives::Single => {
                equations.stage_residuals(system, parameters, start, h, unknowns)?;
                equations.correct(system, start, h, change);
                unknowns.add(1.0, change);
            }
            Derivatives::Sequence => {
                let new = || Box::new(StageSequence::new(system, equations));
                let sequence = self.sequence.get_or_insert_with(new);
                if renew {
                    let weights = self.sizes.weights(system, tolerance);
                    sequence.factor(equations, model, step, unknowns, weights)?;
                }
                equations.stage_residuals(system, parameters, start, h, unknowns)?;
                let taken = sequence.correct(equations, system, step, change);
                unknowns.add(1.0, &taken);
            }
            Derivatives::Kept | Derivatives::Renewed => {
                let new = || Box::new(Coupled::new(system));
                let coupled = self.coupled.get_or_insert_with(new);
                if renew {
                    coupled.factor(equations, model, step, unknowns)?;
                }
                equations.stage_residuals(system, parameters, start, h, unknowns)?;
                coupled.correct(equations, system, unknowns, change);
                unknowns.add(1.0, change);
            }
        }
        Ok(self.largest_change(true))
    }
}
