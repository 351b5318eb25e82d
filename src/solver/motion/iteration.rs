//! Newton iteration of one step.

use super::coupled::Coupled;
use super::derivatives::Derivatives;
use super::error::NotSettled;
use super::error_scales::LargestComponent;
use super::integrator::Integrator;
use super::newton::Step;
use super::sequence::StageSequence;
use super::settings::INSIDE;
use crate::mechanics::exceeds;
use crate::system::NoValue;

/// Estimated remaining error, as a share of the tolerance, below which the iteration has converged.
const KAPPA: f64 = 1e-2;
/// Largest convergence rate at which the factors are kept for the next step.
const FAST: f64 = 0.1;
/// Convergence rate above which [`Derivatives::Kept`] reassembles the derivatives of all stages.
const SLUGGISH: f64 = 0.3;
/// Largest correction of positions and velocities, in tolerances, with which a step is accepted although its multipliers do not converge.
const SETTLED: f64 = 1e-1;
/// Number of step cuts after which [`SETTLED_AFTER_CUTS`] replaces [`SETTLED`]. Errors that shorter steps do not reduce are round-off.
const CUTS: usize = 3;
/// Replacement of [`SETTLED`] after [`CUTS`] cuts of the step. It is the ratio of ERROR to the internal tolerance, so corrections up to ERROR are
/// accepted.
const SETTLED_AFTER_CUTS: f64 = 1.0 / INSIDE;
/// Relative round-off of positions and velocities. The iteration ends when its corrections are smaller than this.
const ROUND_OFF: f64 = 1e-14;

impl Integrator<'_> {
    /// Runs the Newton iteration for a step of size `h` and returns the number of iterations.
    pub(super) fn solve(&mut self, h: f64, derivatives: Derivatives) -> Result<usize, NotSettled> {
        let several = derivatives != Derivatives::Single;
        let always = derivatives == Derivatives::Renewed;
        let mut before = 0.0;
        // True if the next iteration reassembles the derivatives of all stages.
        let mut renew = several;
        let limit = KAPPA * self.settings.corrector * (1.0 + self.settings.adaptivity / h);
        for iteration in 1..=self.settings.maxit {
            let worst = self
                .corrected(h, derivatives, renew)
                .map_err(|reason| NotSettled {
                    why: reason.to_string(),
                    no_value: true,
                })?;
            let size = worst.size;
            if !size.is_finite() {
                return Err(NotSettled::at("the iteration diverges"));
            }
            let floor = ROUND_OFF / self.tolerance();
            if size <= floor {
                return Ok(iteration);
            }
            if iteration > 1 {
                let theta: f64 = size / before;
                // A rate that was measured with derivatives of an earlier iterate does not show that the iteration diverges.
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
                // The first correction may lead far from the point of linearisation. Later corrections are small.
                renew = always || derivatives == Derivatives::Sequence;
            }
            before = size;
        }
        Err(NotSettled::at("the iteration does not converge"))
    }

    /// Returns the largest component of the last correction. VARIABLEs and multipliers are included only if `variables` is true.
    fn largest_change(&self, variables: bool) -> LargestComponent {
        let mut worst = LargestComponent::default();
        for (z, w) in self.change.z.iter().zip(&self.change.w) {
            let found = self.measured(z, w, variables);
            if exceeds(found.size, worst.size) {
                worst = found;
            }
        }
        worst
    }

    /// Decides whether a step is accepted although its iteration does not converge. Near a singular position, the multipliers follow from
    /// small differences. Round-off then dominates the multipliers, although the motion has converged. Such a step is accepted, and the next
    /// step does not extrapolate from it.
    ///
    /// `exact` is the iteration count if every stage has its own derivatives. It is `None` if the derivatives of one stage serve all stages,
    /// because slow convergence would then look the same.
    fn given_up(
        &mut self,
        worst: LargestComponent,
        exact: Option<usize>,
    ) -> Result<usize, NotSettled> {
        let multipliers = self.system.first_equation..self.system.first_variable;
        let settled = if self.cuts < CUTS {
            SETTLED
        } else {
            SETTLED_AFTER_CUTS
        };
        if let Some(iteration) = exact
            && !worst.is_velocity
            && multipliers.contains(&worst.index)
            && self.largest_change(false).size <= settled
        {
            self.loose = true;
            return Ok(iteration);
        }
        Err(NotSettled::at(&format!(
            "the iteration does not converge; the largest correction is that of {}",
            self.report_error(worst)
        )))
    }

    /// Runs one iteration and returns its largest correction, as [`Self::largest_change`] does. If `renew` is true, the derivatives of all
    /// stages are reassembled first. [`Derivatives::Single`] ignores `renew`.
    fn corrected(
        &mut self,
        h: f64,
        derivatives: Derivatives,
        renew: bool,
    ) -> Result<LargestComponent, NoValue> {
        let tolerance = self.tolerance();
        let (system, parameters, start) = (self.system, self.parameters, &self.state);
        let step = Step { start, h };
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
                    sequence.factor(equations, system, parameters, step, unknowns, weights)?;
                }
                equations.stage_residuals(system, parameters, start, h, unknowns)?;
                let taken = sequence.correct(equations, system, step, change);
                unknowns.add(1.0, &taken);
            }
            Derivatives::Kept | Derivatives::Renewed => {
                let new = || Box::new(Coupled::new(system));
                let coupled = self.coupled.get_or_insert_with(new);
                if renew {
                    coupled.factor(equations, system, parameters, step, unknowns)?;
                }
                equations.stage_residuals(system, parameters, start, h, unknowns)?;
                coupled.correct(equations, system, unknowns, change);
                unknowns.add(1.0, change);
            }
        }
        Ok(self.largest_change(true))
    }
}
