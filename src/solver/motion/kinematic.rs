//! Kinematic analysis: positions, velocities, accelerations and reactions of a mechanism without degrees of freedom.

use super::arrival::has_arrived;
use super::consistent::Consistent;
use super::error::{MotionError, MotionFailure};
use super::event_location::{EXACT, PLACES, Watched};
use super::root::narrow_bracket;
use crate::system::{Parameters, Scratch, State, System};

/// Largest number of times that a failing step is halved.
const HALVINGS: i32 = 10;
/// Largest number of changes between sticking and sliding that are located on the way to one time. Further changes take effect at the end of a
/// step.
const GRIPS: usize = 1000;

type Going =
    fn(&System, &Parameters, &mut State, &mut Consistent, f64, f64) -> Result<usize, MotionError>;

/// Advances the mechanism to time `end` in steps of at most `largest`, and returns the number of steps. If no positions are found for a step,
/// the step is halved.
///
/// A step ends where a friction begins or ceases to stick, because creep is counted from that point. A friction that sticks at the start of the
/// motion creeps from the start.
///
/// The next positions are predicted by `q + h V + h^2 A / 2` and corrected by Newton's method, which satisfies the constraints with the least
/// change. Velocities, accelerations and multipliers follow from linear equations.
///
/// # Errors
/// Returns [`MotionError`]; the state is then at the end of the last successful step.
pub fn advance(
    system: &System,
    parameters: &Parameters,
    state: &mut State,
    memory: &mut Consistent,
    end: f64,
    largest: f64,
) -> Result<usize, MotionError> {
    if !system.has_friction() {
        return freely(system, parameters, state, memory, end, largest);
    }
    let mut slips = Slips {
        system,
        parameters,
        scratch: Scratch::new(system),
        sticking: Vec::new(),
        over: Vec::new(),
    };
    let (of, to) = ((system, parameters), (end, largest));
    let mut steps = 0;
    system.advance_stiction(parameters, state, &mut memory.scratch);
    for _ in 0..GRIPS {
        let (taken, passed) = watching(freely, of, state, memory, to, &mut slips)?;
        steps += taken;
        if !passed {
            return Ok(steps);
        }
        if taken == 0 {
            break;
        }
    }
    Ok(steps + freely(system, parameters, state, memory, end, largest)?)
}

/// Event function of all frictions: changes between sticking and sliding.
struct Slips<'a> {
    system: &'a System,
    parameters: &'a Parameters,
    scratch: Scratch,
    /// Whether each friction sticks at the start of the interval.
    sticking: Vec<bool>,
    over: Vec<f64>,
}

impl Watched for Slips<'_> {
    fn begin(&mut self, state: &State) {
        self.sticking.clear();
        let grips = state.grips.iter().map(|grip| grip.sticking);
        self.sticking.extend(grips);
    }

    fn excess(&mut self, state: &State) -> f64 {
        let (parameters, scratch) = (self.parameters, &mut self.scratch);
        self.system
            .slips(parameters, state, scratch, &mut self.over);
        let all = self.sticking.iter().zip(&self.over);
        let all = all.map(|(sticking, slip)| if *sticking { *slip } else { -slip });
        all.fold(f64::NEG_INFINITY, f64::max)
    }
}

fn freely(
    system: &System,
    parameters: &Parameters,
    state: &mut State,
    memory: &mut Consistent,
    end: f64,
    largest: f64,
) -> Result<usize, MotionError> {
    let least = largest * 0.5_f64.powi(HALVINGS);
    let mut h = largest;
    let mut steps = 0;
    let mut correction = vec![0.0; system.moving_unknowns];
    let (mut v, mut a) = (Vec::new(), Vec::new());
    loop {
        let left = end - state.time;
        if has_arrived(state.time, end, largest) {
            return Ok(steps);
        }
        let count = (left / h - 1e-9).ceil().max(1.0);
        let step = left / count;
        let mut next = state.clone();
        next.time = if count == 1.0 { end } else { state.time + step };
        system.velocity_vector(state, &mut v);
        system.gathered(&state.accelerations, &mut a);
        correction.fill(0.0);
        for (k, correction) in correction[..v.len()].iter_mut().enumerate() {
            *correction = step * (v[k] + 0.5 * step * a[k]);
        }
        system.advance(&mut next, &correction);
        match place(system, parameters, &mut next, memory, step) {
            Ok(()) => {
                *state = next;
                steps += 1;
                h = largest;
            }
            Err(reason) => {
                h = 0.5 * step;
                if h < least {
                    return Err(reason.at(state.time));
                }
            }
        }
    }
}

/// Advances the mechanism to the time `end` like [`advance`], in steps of at most `largest`, and stops at the first watched event. Returns the
/// number of steps, and true if the state is at an event before that time.
///
/// # Errors
/// Returns the errors of [`advance`].
pub fn advance_watched(
    system: &System,
    parameters: &Parameters,
    state: &mut State,
    memory: &mut Consistent,
    end: f64,
    largest: f64,
    watched: &mut impl Watched,
) -> Result<(usize, bool), MotionError> {
    let (of, to) = ((system, parameters), (end, largest));
    watching(advance, of, state, memory, to, watched)
}

fn watching(
    going: Going,
    (system, parameters): (&System, &Parameters),
    state: &mut State,
    memory: &mut Consistent,
    (end, largest): (f64, f64),
    watched: &mut impl Watched,
) -> Result<(usize, bool), MotionError> {
    let from = state.time;
    watched.begin(state);
    let mut steps = 0;
    for part in PLACES {
        let before = state.clone();
        let to = if part < 1.0 {
            from + part * (end - from)
        } else {
            end
        };
        steps += going(system, parameters, state, memory, to, largest)?;
        let excess = watched.excess(state);
        if excess > 0.0 {
            let start = (before.time, watched.excess(&before));
            let mut failed = None;
            let at = |time: f64| {
                let mut there = before.clone();
                match going(system, parameters, &mut there, memory, time, largest) {
                    Ok(_) => watched.excess(&there),
                    Err(error) => {
                        failed = Some(error);
                        f64::NAN
                    }
                }
            };
            let (_, after) = narrow_bracket(at, start, (to, excess), EXACT * (end - from));
            if let Some(error) = failed {
                return Err(error);
            }
            if after < to {
                *state = before;
                steps += going(system, parameters, state, memory, after, largest)?;
            }
            return Ok((steps, after < end));
        }
        watched.go_on();
    }
    Ok((steps, false))
}

fn place(
    system: &System,
    parameters: &Parameters,
    state: &mut State,
    memory: &mut Consistent,
    step: f64,
) -> Result<(), MotionFailure> {
    system.settle_variables(parameters, state, &mut memory.scratch)?;
    memory.exchange_equations(system, parameters, state)?;
    memory.positions(system, parameters, state, None)?;
    system.drive_on(parameters, state, &mut memory.scratch)?;
    system.accept(parameters, state, &mut memory.scratch);
    memory.reconcile(system, parameters, state, 1e-2 * step)?;
    system.advance_stiction(parameters, state, &mut memory.scratch);
    Ok(())
}

/// Checks that a mechanism has neither degrees of freedom nor nonholonomic constraints.
///
/// # Errors
/// Returns [`MotionFailure::NotKinematic`] if degrees of freedom remain, and [`MotionFailure::HeldVelocities`] if a constraint is nonholonomic.
pub fn check_determined(system: &System, state: &State) -> Result<(), MotionError> {
    let freedoms = system.freedoms_left(state);
    if freedoms > 0 {
        return Err(MotionFailure::NotKinematic { freedoms }.at(state.time));
    }
    let of_velocities = |&k: &usize| system.is_nonholonomic[k] && system.is_effective(state, k);
    if let Some(k) = (0..system.equations).find(of_velocities) {
        let equation = system.constraint_equation_name(k).to_string();
        return Err(MotionFailure::HeldVelocities { equation }.at(state.time));
    }
    Ok(())
}
