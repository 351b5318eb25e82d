//! The times at which the regimes of a motion change.
//!
//! Within a step every function with pieces (IMPACT, IF, ABS) stays on one, and every friction in one regime. The step ends where that ceases to be
//! right, and the next one begins anew on the other side.

use super::discrete_states::{Change, Regimes};
use super::error::{MotionError, MotionFailure};
use super::event_location::Watched;
use super::integrator::Integrator;
use crate::function::between;
use crate::mechanics::Vec3;
use crate::system::{Parameters, State, System};

/// A passage in this share of the step is one at its start.
const AT_START: f64 = 1e-9;
/// At one time regimes change so often at most.
const CHANGES: usize = 4;
/// Which side follows is seen so far beyond a passage, as a share of the step, or so many times farther.
const BEYOND: f64 = 1e-9;
const FARTHER: f64 = 8.0;
/// What the first step after a change may let velocities change, as a share of their size over the root of the tolerance.
const BEGINNING: f64 = 5.0;
/// And so often it is shortened for that.
const TRIES: usize = 10;
/// What is held between two sides creeps by this share of the tolerance at most.
const CREEP: f64 = 1e-2;
/// Whether it is pushed back is seen after this share of the step.
const SOON: f64 = 1e-2;

/// The regimes while they are watched.
struct Watching<'a> {
    system: &'a System,
    parameters: &'a Parameters,
    regimes: &'a mut Regimes,
}

impl Watched for Watching<'_> {
    fn excess(&mut self, state: &State) -> f64 {
        self.look(state);
        let grips = state.grips.iter().zip(&self.regimes.slips);
        // Of frictions that cannot stick the slip is no number, which the maximum leaves out.
        let grips = grips.map(|(grip, slip)| if grip.sticking { *slip } else { -slip });
        let switches = self.regimes.scratch.seen.iter().map(|seen| seen.excess);
        grips.chain(switches).fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Watching<'_> {
    fn look(&mut self, state: &State) {
        let (system, parameters) = (self.system, self.parameters);
        let Regimes { scratch, slips, .. } = &mut *self.regimes;
        if system.has_friction() {
            system.slips(parameters, state, scratch, slips);
        }
        // Where a function has no value nothing is seen; the iteration says so.
        if !system.switches.is_empty() {
            let _ = system.evaluate(parameters, state, scratch);
        }
    }

    /// What has passed its mark at a state.
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
            .map(|(k, _)| Change::Grip(k))
            .chain(switches)
            .collect()
    }
}

impl Integrator<'_> {
    /// Looks at the step that was just done: where a regime ceases to be right inside of it, the step ends there and the regime changes.
    ///
    /// # Errors
    /// [`MotionError`] where the shorter step is not found, or a function changes its piece over and over.
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
            *worst += &regimes.told(self.system);
        }
        self.regimes = Some(regimes);
        done
    }

    fn settle(&mut self, regimes: &mut Regimes) -> Result<(), MotionError> {
        let (system, parameters) = (self.system, self.parameters);
        let mut changed = Vec::new();
        for _ in 0..CHANGES {
            let mut watching = Watching {
                system,
                parameters,
                regimes,
            };
            let Some(passage) = self.first_passage(&mut watching) else {
                let steps = self.statistics.steps;
                regimes.step_done(&mut self.state, steps);
                return Ok(());
            };
            let (from, to) = (self.origin.time, self.state.time);
            if passage.1 - from > AT_START * (to - from) {
                let mut held = false;
                if self.end_at_passage(&mut watching, passage)? {
                    let changes = self.beyond(&mut watching, self.state.time);
                    held = self.change(regimes, &changes)?;
                }
                // The step was cut: how long it is says nothing of the next one.
                self.set_step(self.h.max(to - from));
                if self.anew && !held {
                    self.h = self.first_step();
                }
                return Ok(());
            }
            // What was right at the end of the step before is not right in this one: the same step in the other regime.
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
        // On neither side it is right: what holds it between them is for the error control to find.
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

    /// What has passed its mark just after a time, by the polynomial of the last step.
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

    /// Surfaces that stuck slide, those that slid stick from here on; functions go on with other pieces. True if one is held between its
    /// sides: such a motion needs no short steps.
    fn change(&mut self, regimes: &mut Regimes, changes: &[Change]) -> Result<bool, MotionError> {
        let (system, parameters) = (self.system, self.parameters);
        let (time, steps) = (self.state.time, self.statistics.steps);
        let (mut switched, mut held) = (false, false);
        for change in changes {
            match change {
                Change::Grip(k) => {
                    let grip = &mut self.state.grips[*k];
                    grip.sticking = !self.origin.grips[*k].sticking;
                    grip.creep = Vec3::zeros();
                }
                Change::Switch(k, piece) => {
                    self.state.pieces[*k] = Some(*piece);
                    switched = true;
                    if self.is_pushed_back(regimes, *k) {
                        // Both sides push here: it stays between them (Filippov).
                        self.state.pieces[*k] = Some(between(CREEP * self.tolerance()));
                        held = true;
                    }
                    let at = (time, self.settings.output);
                    regimes
                        .count_switches(system, *k, at, steps)
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

    /// True if a function, on the piece that it has just come to, at once goes back to where it came from: it jumps, and what it does there
    /// pushes it back.
    fn is_pushed_back(&mut self, regimes: &mut Regimes, k: usize) -> bool {
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

    /// Where a short step from here leads. All is as it was after it, but the factors.
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

    /// A step that the method can do under forces that have just changed, at most the one at hand.
    ///
    /// Accelerations that change by `da` over a step h tell the time T in which the motion changes: `da h = v (h/T)^2`, with v the size of
    /// velocities. An error of fourth order stays within the tolerance while `(h/T)^4` is of its size.
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
                self.measured(&z, &w, false).0 / most
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
