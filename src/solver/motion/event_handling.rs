//! Events of a motion, at which its discrete states change.
//!
//! Within a step, every piecewise function (IMPACT, IF, ABS) stays on one piece, and every friction either sticks or slides. The step ends
//! where one of these discrete states ceases to be valid. The next step starts with the changed discrete state.

use super::discrete_states::{Change, DiscreteStates};
use super::error::{MotionError, MotionFailure};
use super::event_location::Watched;
use super::integrator::Integrator;
use crate::function::between;
use crate::mechanics::Vec3;
use crate::system::{Parameters, State, System};

/// An event whose distance from the start of a step is below this share of the step counts as an event at the start.
const AT_START: f64 = 1e-9;
/// Largest number of successive changes of discrete states at the same time.
const CHANGES: usize = 4;
/// Distance beyond an event at which the next discrete state is determined, as a share of the step.
const BEYOND: f64 = 1e-9;
/// Factor by which the distance [`BEYOND`] grows from one try to the next.
const FARTHER: f64 = 8.0;
/// Largest relative change of the velocities in the first step after an event, in units of the square root of the tolerance.
const BEGINNING: f64 = 5.0;
/// Largest number of times that the first step after an event is shortened.
const TRIES: usize = 10;
/// Half width of the interval over which a function that is held between two pieces changes its value, as a share of the tolerance. It bounds
/// the creep of a sticking motion.
const CREEP: f64 = 1e-2;
/// Length of the trial step that shows whether a function is pushed back to its previous piece, as a share of the step.
const SOON: f64 = 1e-2;

/// Event function of the discrete states of a motion.
struct Watching<'a> {
    system: &'a System,
    parameters: &'a Parameters,
    regimes: &'a mut DiscreteStates,
}

impl Watched for Watching<'_> {
    fn excess(&mut self, state: &State) -> f64 {
        self.look(state);
        let grips = state.grips.iter().zip(&self.regimes.slips);
        // The slip of a friction that cannot stick is NaN, which the maximum ignores.
        let grips = grips.map(|(grip, slip)| if grip.sticking { *slip } else { -slip });
        let switches = self.regimes.scratch.seen.iter().map(|seen| seen.excess);
        grips.chain(switches).fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Watching<'_> {
    fn look(&mut self, state: &State) {
        let (system, parameters) = (self.system, self.parameters);
        let DiscreteStates { scratch, slips, .. } = &mut *self.regimes;
        if system.has_friction() {
            system.slips(parameters, state, scratch, slips);
        }
        // A function without a value shows no event; the iteration reports the error.
        if !system.switches.is_empty() {
            let _ = system.evaluate(parameters, state, scratch);
        }
    }

    /// Returns the changes of discrete states whose event has passed at a state.
    fn passed(&mut self, state: &State) -> Vec<Change> {
        self.look(state);
        let grips = state.grips.iter().zip(&self.regimes.slips).enumerate();
        let grips = grips.filter(|(_, (grip, slip))| {
            if grip.sticking {
                **slip > 0.0
            } else {
                **slip < 0.0
            }
        });
        let seen = self.regimes.scratch.seen.iter().zip(&state.pieces);
        let switches = seen.enumerate().filter_map(|(k, (seen, held))| {
            let other = seen.piece.filter(|_| seen.piece != *held)?;
            (seen.excess > 0.0).then_some(Change::Switch(k, other))
        });
        grips
            .map(|(k, _)| Change::StickSlip(k))
            .chain(switches)
            .collect()
    }
}

impl Integrator<'_> {
    /// Checks the step just taken. If a discrete state ceases to be valid within the step, the step is repeated so that it ends there, and the
    /// discrete state changes.
    ///
    /// # Errors
    /// Returns [`MotionError`] if the shorter step fails or a function chatters.
    pub(super) fn settle_regimes(&mut self) -> Result<(), MotionError> {
        let Some(mut regimes) = self.regimes.take() else {
            return Ok(());
        };
        let mut done = self.settle(&mut regimes);
        if let Err(MotionError {
            reason: MotionFailure::StepTooSmall { worst, .. },
            ..
        }) = &mut done
        {
            *worst += &regimes.describe(self.system);
        }
        self.regimes = Some(regimes);
        done
    }

    fn settle(&mut self, regimes: &mut DiscreteStates) -> Result<(), MotionError> {
        let (system, parameters) = (self.system, self.parameters);
        let mut changed = Vec::new();
        for _ in 0..CHANGES {
            let mut watching = Watching {
                system,
                parameters,
                regimes,
            };
            let Some((_, after)) = self.first_passage(&mut watching) else {
                let steps = self.statistics.steps;
                regimes.step_done(&mut self.state, steps);
                return Ok(());
            };
            let (from, to) = (self.origin.time, self.state.time);
            if after - from > AT_START * (to - from) {
                let mut held = false;
                if self.end_at_passage(&mut watching, after)? {
                    let changes = self.beyond(&mut watching, self.state.time);
                    held = self.change(regimes, &changes)?;
                }
                // The step was cut at the event. Its length therefore does not limit the length of the next step.
                self.set_step(self.h.max(to - from));
                if self.anew && !held {
                    self.h = self.first_step();
                }
                return Ok(());
            }
            // The discrete state valid at the end of the previous step is not valid in this one. The same step is repeated with the changed
            // discrete state.
            let changes = self.beyond(&mut watching, from);
            self.undo_step();
            self.restart();
            let held = self.change(regimes, &changes)?;
            self.h = (to - from).min(self.h);
            if self.anew && !held {
                self.h = self.first_step();
            }
            self.take_step(to - from, to)?;
            changed.extend(changes);
        }
        // The function is valid on neither piece. It is suspended, and the error control resolves the motion between its pieces.
        if regimes.suspend(&changed, self.statistics.steps) {
            let (from, to) = (self.origin.time, self.state.time);
            self.undo_step();
            self.restart();
            regimes.hold(system, parameters, &mut self.state);
            self.h = self.first_step();
            self.take_step(to - from, to)?;
        }
        Ok(())
    }

    /// Returns the changes of discrete states whose event has passed just after `time`, according to the dense-output polynomial of the last
    /// step.
    fn beyond(&self, watching: &mut Watching<'_>, time: f64) -> Vec<Change> {
        let step = self.state.time - self.origin.time;
        let mut reach = (BEYOND * step).max(4.0 * f64::EPSILON * time.abs());
        while reach <= step {
            let changes = watching.passed(&self.continued(time + reach));
            if !changes.is_empty() {
                return changes;
            }
            reach *= FARTHER;
        }
        Vec::new()
    }

    /// Applies changes of discrete states: sticking surfaces slide, sliding surfaces stick, and functions switch to other pieces. Returns true if a
    /// function is now held between two pieces. The next step then need not be shortened.
    fn change(
        &mut self,
        regimes: &mut DiscreteStates,
        changes: &[Change],
    ) -> Result<bool, MotionError> {
        let (system, parameters) = (self.system, self.parameters);
        let (time, steps) = (self.state.time, self.statistics.steps);
        let (mut switched, mut held) = (false, false);
        for change in changes {
            match change {
                Change::StickSlip(k) => {
                    let grip = &mut self.state.grips[*k];
                    grip.sticking = !self.origin.grips[*k].sticking;
                    grip.creep = Vec3::zeros();
                }
                Change::Switch(k, piece) => {
                    self.state.pieces[*k] = Some(*piece);
                    switched = true;
                    if self.is_pushed_back(regimes, *k) {
                        // The motion is pushed back on both pieces, so the function stays between them (Filippov).
                        self.state.pieces[*k] = Some(between(CREEP * self.tolerance()));
                        held = true;
                    }
                    regimes
                        .count_switches(system, *k, time, self.settings.output, steps)
                        .map_err(|reason| reason.at(time))?;
                }
            }
        }
        if !switched {
            return Ok(false);
        }
        regimes.hold(system, parameters, &mut self.state);
        // The forces may have jumped, and the accelerations with them.
        let mut anew = self.state.clone();
        let step = 1e-2 * self.settings.hmax;
        let found = self
            .consistent
            .accelerations(system, parameters, &mut anew, step);
        if found.is_ok() {
            self.state = anew;
        }
        self.restart();
        Ok(held)
    }

    /// Returns true if a function that has just switched to a piece would switch back at once. This requires that its value jumps and that a
    /// short trial step on the new piece ends beyond the end of this piece.
    fn is_pushed_back(&mut self, regimes: &mut DiscreteStates, k: usize) -> bool {
        let (system, parameters) = (self.system, self.parameters);
        let switch = system.switches[k];
        if switch.of_time || !switch.jumps {
            return false;
        }
        let step = SOON * self.h.min(self.settings.hmax);
        let Some(ahead) = self.ahead(step) else {
            return false;
        };
        system
            .evaluate(parameters, &ahead, &mut regimes.scratch)
            .is_ok()
            && regimes.scratch.seen[k].excess > 0.0
    }

    /// Returns the state after a short trial step, or `None` if the step fails. Everything except the factors is restored afterwards.
    fn ahead(&mut self, step: f64) -> Option<State> {
        let states = (self.state.clone(), self.origin.clone());
        let polynomial = self.polynomial.clone();
        let sizes = (self.sizes, self.sizes_before);
        let steps = (self.last, self.within, self.before, self.h);
        let statistics = self.statistics;
        self.restart();
        self.h = step;
        let found = self.take_step(step, self.state.time + step);
        let ahead = std::mem::replace(&mut self.state, states.0);
        self.origin = states.1;
        self.polynomial = polynomial;
        (self.sizes, self.sizes_before) = sizes;
        (self.last, self.within, self.before, self.h) = steps;
        self.statistics = statistics;
        self.restart();
        found.is_ok().then_some(ahead)
    }

    /// Returns a step size, at most the present one, with which the method can integrate accurately under forces that have just changed.
    ///
    /// If accelerations change by `da` over a step h, the motion changes on a time scale T with `da h = v (h/T)^2`, where v is the magnitude of
    /// the velocities. An error of fourth order is within the tolerance as long as `(h/T)^4` is within the tolerance.
    fn first_step(&mut self) -> f64 {
        let (system, parameters) = (self.system, self.parameters);
        let n = system.first_equation;
        let most = BEGINNING / self.tolerance().sqrt();
        let (mut now, mut then) = (Vec::new(), Vec::new());
        system.gathered(&self.state.accelerations, &mut now);
        let mut h = self.h;
        for _ in 0..TRIES {
            let mut ahead = self.continued(self.state.time + h);
            ahead.pieces.clone_from(&self.state.pieces);
            ahead.grips.clone_from(&self.state.grips);
            let apart = 1e-2 * self.settings.hmax;
            let found = self
                .consistent
                .accelerations(system, parameters, &mut ahead, apart);
            let size = if found.is_ok() {
                system.gathered(&ahead.accelerations, &mut then);
                let w: Vec<f64> = (0..n).map(|k| h * (then[k] - now[k])).collect();
                let mut z = vec![0.0; system.moving_unknowns];
                for (k, equation) in system.states.iter().enumerate() {
                    let change = ahead.state_rates[k] - self.state.state_rates[k];
                    z[equation.moving_unknown] = h * change;
                }
                self.measured(&z, &w, false).size / most
            } else {
                f64::INFINITY
            };
            if size <= 1.0 {
                break;
            }
            h *= (0.8 / size.sqrt()).max(0.1);
        }
        h.max(2.0 * self.settings.hmin).min(self.h)
    }
}
