//! Continuation from an unstable equilibrium to a stable one.

use super::measures::{distance, force_imbalance, largest, limit};
use super::newton::Solver;
use super::path::add_damping;
use super::{Report, Softest, SolveError, StaticSettings};
use crate::system::{NoValue, Parameters, State, System};

/// Size of the displacement away from an unstable equilibrium, as a share of the model's length.
const PUSH: f64 = 1e-2;
/// Largest number of implicit steps in one descent.
const STEPS: usize = 400;
/// Distance from the start, in model lengths, beyond which a descent is given up.
const FAR: f64 = 1e4;

/// A stable equilibrium that was reached from an unstable one.
#[derive(Clone, Debug)]
pub struct StabilisedEquilibrium {
    /// Largest motion of any part from the unstable to the stable equilibrium, in length units. Rotations are multiplied by the model's length.
    pub moved: f64,
    /// Largest motion of any part to the stable equilibrium in the opposite direction; `None` if that direction leads to no stable equilibrium.
    pub other: Option<f64>,
    /// Report of the solution at the stable equilibrium.
    pub report: Report,
    /// Softest motion at the stable equilibrium; `None` if no part can move.
    pub softest: Option<Softest>,
}

/// Error: neither direction leads to a stable equilibrium. Contains the reason for each of the two directions.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("no stable equilibrium was found: in one direction, {0}; in the other, {1}")]
pub struct NoStableEquilibrium(pub String, pub String);

impl From<NoValue> for Descent {
    fn from(reason: NoValue) -> Self {
        Self(format!("the descent ends because of this error: {reason}"))
    }
}

impl From<SolveError> for Descent {
    fn from(reason: SolveError) -> Self {
        Self(format!("the descent ends because of this error: {reason}"))
    }
}

/// Reason why a descent ended without a stable equilibrium.
struct Descent(String);

impl Solver {
    /// Moves the state from an unstable equilibrium to a stable one. Both directions of the softest motion are followed, and the nearer result
    /// is taken.
    ///
    /// The parts are displaced along the softest motion. An overdamped descent follows, in implicit steps whose damping exceeds the magnitude
    /// of the negative stiffness. As soon as no stiffness is negative any more, Newton's method takes over. The stability of the result is
    /// checked.
    ///
    /// # Errors
    /// Returns [`NoStableEquilibrium`]; the state is then unchanged.
    pub fn settle(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        settings: &StaticSettings,
        softest: &Softest,
    ) -> Result<StabilisedEquilibrium, NoStableEquilibrium> {
        let mut found = Vec::new();
        let mut failures = Vec::new();
        for way in [1.0, -1.0] {
            let mut trial = state.clone();
            match self.overdamped_descent(system, parameters, &mut trial, settings, (softest, way))
            {
                Ok((report, softest)) => {
                    let moved = distance(system, state, &trial);
                    found.push((moved, trial, report, softest));
                }
                Err(Descent(reason)) => failures.push(reason),
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        let other = found.get(1).map(|second| second.0);
        match found.into_iter().next() {
            Some((moved, settled, report, softest)) => {
                *state = settled;
                Ok(StabilisedEquilibrium {
                    moved,
                    other,
                    report,
                    softest,
                })
            }
            None => Err(NoStableEquilibrium(failures.remove(0), failures.remove(0))),
        }
    }

    fn overdamped_descent(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        settings: &StaticSettings,
        (softest, way): (&Softest, f64),
    ) -> Result<(Report, Option<Softest>), Descent> {
        let start = state.clone();
        let newton = StaticSettings {
            continuation: false,
            budget: None,
            ..settings.clone()
        };
        self.perturb(system, parameters, state, settings, (softest, way));
        for _ in 0..STEPS {
            let here = Softest::of(system, parameters, state)?;
            let softness = here
                .as_ref()
                .map_or(0.0, |softest| softest.stiffness.min(0.0));
            if softness == 0.0 {
                let mut trial = state.clone();
                trial.redundant.clear();
                if let Ok(report) = self.solve(system, parameters, &mut trial, &newton) {
                    let there =
                        Softest::at_equilibrium(system, parameters, &trial, &mut self.scratch)?;
                    *state = trial;
                    match there {
                        // The result is another unstable equilibrium. The descent continues from it, away from the start.
                        Some(saddle) if saddle.is_unstable() => {
                            let way = self.onwards(system, parameters, &start, state, &saddle);
                            self.perturb(system, parameters, state, settings, (&saddle, way));
                            continue;
                        }
                        lasting => return Ok((report, lasting)),
                    }
                }
            }
            self.flow(system, parameters, state, settings, -softness)?;
            let moved = distance(system, &start, state);
            if !moved.is_finite() || moved > FAR * system.length.max(settings.tlimit) {
                return Err(Descent("the parts move away without limit".to_string()));
            }
        }
        Err(Descent(format!(
            "the search reaches its limit of {STEPS} steps"
        )))
    }

    /// Displaces the parts along the softest motion: in its direction if `way` is 1, and in the opposite direction if `way` is -1.
    fn perturb(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        settings: &StaticSettings,
        (softest, way): (&Softest, f64),
    ) {
        let mut dx = softest.motion.clone();
        dx.resize(system.unknowns(), 0.0);
        let size = way * PUSH * system.length;
        for x in &mut dx {
            *x *= size;
        }
        let limit = limit(system, settings, &dx);
        for x in &mut dx {
            *x *= limit;
        }
        system.advance(state, &dx);
        system.accept(parameters, state, &mut self.scratch);
    }

    /// Returns the direction of the softest motion (1 or -1) that leads away from `start`.
    fn onwards(
        &mut self,
        system: &System,
        parameters: &Parameters,
        start: &State,
        state: &State,
        softest: &Softest,
    ) -> f64 {
        let after = |solver: &mut Self, way: f64| {
            let mut trial = state.clone();
            let settings = StaticSettings::default();
            solver.perturb(system, parameters, &mut trial, &settings, (softest, way));
            distance(system, start, &trial)
        };
        if after(self, 1.0) >= after(self, -1.0) {
            1.0
        } else {
            -1.0
        }
    }

    /// Takes one implicit step of the overdamped descent. `negative` is the magnitude of the negative stiffness, or zero.
    fn flow(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        settings: &StaticSettings,
        negative: f64,
    ) -> Result<(), NoValue> {
        self.next.clear();
        let (scratch, g, next) = (&mut self.scratch, &mut self.g, &mut self.next);
        system.assemble(parameters, state, scratch, g, next)?;
        next.finish();
        let pull = force_imbalance(system, g) / settings.tlimit;
        add_damping(system, 2.0 * negative + pull, next);
        self.matrix.factor(next);
        // These factors are not the tangent of an equilibrium.
        self.poses.clear();
        let mut dx: Vec<f64> = self.g.iter().map(|g| -g).collect();
        self.matrix.solve(&mut dx);
        let limit = limit(system, settings, &dx);
        if limit * largest(&dx) > 0.0 {
            for x in &mut dx {
                *x *= limit;
            }
            system.advance(state, &dx);
            system.accept(parameters, state, &mut self.scratch);
        }
        Ok(())
    }
}
