//! States that satisfy the constraints at all three levels: positions, velocities and accelerations.

use super::bordered::{Bordered, plain_weight};
use super::error::MotionFailure;
use crate::linear::{Entries, Levels, Lu};
use crate::mechanics::{Mat6, Pose, Vec3, exceeds, log};
use crate::system::{Parameters, Rows, Scratch, State, System};

/// Constraint violation at which the position iteration ends, as a share of the model's length.
const CLOSED: f64 = 1e-12;
/// Constraint violation that is accepted if the iteration does not reach [`CLOSED`], as a share of the model's length.
const OPEN: f64 = 1e-8;
/// Largest accepted violation of a constraint equation that was removed as redundant, as a share of the model's length. The limit also
/// applies to rates of violation and to nonholonomic equations, as a share of the largest speed. An equation is removed if it agrees with
/// the others within 1e-6; large motions increase the violation, so this limit is wider.
pub(super) const REMOVED: f64 = 1e-4;
/// Relative residual allowed in the equation of a variable or a state if the matrix is singular.
const UNDETERMINED: f64 = 1e-9;
/// Largest number of iterations for positions and for accelerations.
const ITERATIONS: usize = 50;
/// Largest rotation of a part in one iteration, radians.
const ALIMIT: f64 = std::f64::consts::FRAC_PI_6;

/// Work space for bringing states onto their constraints.
#[derive(Debug)]
pub struct Consistent {
    pub(super) scratch: Scratch,
    pub(super) rows: Rows,
    pub(super) bordered: Bordered,
    pub(super) levels: Levels,
    pub(super) factors: Lu,
    values: Vec<f64>,
    pub(super) g: Vec<f64>,
    dx: Vec<f64>,
    pub(super) step: Vec<f64>,
    pub(super) border: Vec<f64>,
    pub(super) v: Vec<f64>,
    gamma: Vec<f64>,
    /// Number of motions without inertia that are known to be restrained; `None` before the first check.
    pub(super) held: Option<usize>,
}

impl Consistent {
    /// Allocates the work space for a system.
    pub fn new(system: &System) -> Self {
        let n = system.moving_unknowns;
        Self {
            scratch: Scratch::new(system),
            rows: Rows::new(system),
            bordered: Bordered::new(system),
            levels: Levels::new(n),
            factors: Lu::for_many(n),
            values: Vec::new(),
            g: vec![0.0; n],
            dx: vec![0.0; n],
            step: vec![0.0; n],
            border: vec![0.0; system.first_equation + system.equations],
            v: Vec::new(),
            gamma: vec![0.0; system.equations],
            held: None,
        }
    }

    /// Marks the constraint equations that are redundant at the present positions.
    pub(super) fn find_redundant(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
    ) -> Result<(), MotionFailure> {
        state.redundant.clear();
        let Self {
            scratch, g, rows, ..
        } = self;
        system.constraints_and_rows(parameters, state, scratch, g, rows)?;
        state.redundant = system.redundant_rows(&rows.entries);
        for (redundant, multiplier) in state.redundant.iter().zip(&mut state.multipliers) {
            if *redundant {
                *multiplier = 0.0;
            }
        }
        Ok(())
    }

    /// Brings the positions onto the constraints. With anchors, the result is the position nearest to them in the weighted norm. Without
    /// anchors, each iteration changes the present positions as little as possible.
    ///
    /// # Errors
    /// Returns [`MotionFailure`] if no such positions are found.
    pub(super) fn positions(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        anchors: Option<(&[Pose], &dyn Fn(usize) -> Mat6)>,
    ) -> Result<(), MotionFailure> {
        let plain = plain_weight(system);
        let n = system.first_equation;
        let mut before = f64::INFINITY;
        let mut worst = (0, 0.0);
        for iteration in 0..ITERATIONS {
            let Self {
                scratch, g, rows, ..
            } = self;
            system.constraints_and_rows(parameters, state, scratch, g, rows)?;
            worst = self.worst(system, state);
            let closed = worst.1 <= CLOSED * system.length;
            // Newton's method doubles the number of correct digits in each iteration. A violation that no longer falls is round-off.
            let stalled = worst.1 <= OPEN * system.length && worst.1 >= 0.5 * before;
            if anchors.is_none() && (closed || stalled) {
                return Ok(());
            }
            self.border.fill(0.0);
            let holds = |k: usize| system.is_effective_holonomic(state, k);
            if let Some((poses, weight)) = anchors {
                for (part, body) in system.bodies.iter().enumerate() {
                    let apart = difference(&state.poses[part], &poses[part]);
                    let pull = weight(part) * apart;
                    for k in 0..body.freedoms {
                        self.border[body.first + k] = -pull[k];
                    }
                }
                self.bordered.factor(system, &self.rows, holds, weight);
            } else {
                self.bordered.factor(system, &self.rows, holds, |_| plain);
            }
            for k in 0..system.equations {
                self.border[n + k] = -self.g[n + k];
            }
            self.bordered.solve(&mut self.border);
            let mut limit = 1.0_f64;
            let mut size = 0.0_f64;
            for body in &system.bodies {
                for k in 0..body.freedoms {
                    let change = self.border[body.first + k].abs();
                    if k >= 3 {
                        limit = limit.min(ALIMIT / change.max(ALIMIT));
                        size = size.max(change);
                    } else {
                        size = size.max(change / system.length);
                    }
                }
            }
            if !size.is_finite() {
                break;
            }
            self.step.fill(0.0);
            for (step, change) in self.step.iter_mut().zip(&self.border[..n]) {
                *step = limit * change;
            }
            system.advance(state, &self.step);
            if anchors.is_some() && iteration > 0 && size < 1e-12 && (closed || stalled) {
                return Ok(());
            }
            before = worst.1;
        }
        if worst.1 <= OPEN * system.length {
            return Ok(());
        }
        Err(MotionFailure::NoPosition {
            equation: system.constraint_equation_name(worst.0).to_string(),
            violation: worst.1,
        })
    }

    /// Returns the index of the holonomic equation with the largest violation, and this violation.
    fn worst(&self, system: &System, state: &State) -> (usize, f64) {
        let mut worst = (0, 0.0);
        for k in 0..system.equations {
            let violation = self.g[system.first_equation + k].abs();
            if system.is_effective_holonomic(state, k) && exceeds(violation, worst.1) {
                worst = (k, violation);
            }
        }
        worst
    }

    /// Brings the velocities onto the constraints with the least change in the weighted norm.
    ///
    /// # Errors
    /// Returns [`MotionFailure`] if a function has no value.
    pub(super) fn velocities(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        weight: &dyn Fn(usize) -> Mat6,
    ) -> Result<(), MotionFailure> {
        let n = system.first_equation;
        let Self {
            scratch, g, rows, ..
        } = self;
        system.constraints_and_rows(parameters, state, scratch, g, rows)?;
        let takes_part = |k: usize| system.is_effective(state, k);
        self.bordered.factor(system, &self.rows, takes_part, weight);
        // Solves twice, because the first solution leaves round-off in proportion to the change of the velocities.
        for _ in 0..2 {
            self.border.fill(0.0);
            system.velocity_vector(state, &mut self.v);
            let mut rates = self.rows.time.clone();
            self.rows.times(&self.v, &mut rates);
            for k in 0..system.equations {
                let takes_part = system.is_effective(state, k);
                self.border[n + k] = if takes_part { -rates[k] } else { 0.0 };
            }
            self.bordered.solve(&mut self.border);
            for (v, change) in self.v.iter_mut().zip(&self.border[..n]) {
                *v += change;
            }
            system.scattered(&self.v, &mut state.velocities);
        }
        Ok(())
    }

    /// Returns the index of the constraint equation with the largest rate of violation, and this rate. Uses the gradients that
    /// [`Self::velocities`] evaluated last.
    pub(super) fn worst_rate(&mut self, system: &System, state: &State) -> (usize, f64) {
        system.velocity_vector(state, &mut self.v);
        let mut rates = self.rows.time.clone();
        self.rows.times(&self.v, &mut rates);
        let all = rates.iter().enumerate();
        all.filter(|(k, _)| system.is_effective(state, *k))
            .fold((0, 0.0), |worst, (k, rate)| {
                if rate.abs() <= worst.1 {
                    worst
                } else {
                    (k, rate.abs())
                }
            })
    }

    /// Computes accelerations, multipliers, variables and rates of the states from positions, velocities and states. The equations are
    /// `[ M - F_A, G' - F_lambda; G, 0 ] [ A; lambda ] = [ F - h; -gamma ]`. Newton's method solves them where forces depend on these unknowns.
    ///
    /// Functions of reactions and accelerations may be undefined before the first solution. They count as zero until then.
    ///
    /// `step` is the time step of the finite differences for second derivatives of functions. Accelerations of motions without inertia are left
    /// unchanged.
    ///
    /// # Errors
    /// Returns [`MotionFailure`] if an element has no value, or if a motion has no inertia and is not restrained.
    pub(super) fn accelerations(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        step: f64,
    ) -> Result<(), MotionFailure> {
        let n = system.first_equation;
        let (equations, m) = (n..system.first_variable, system.moving_unknowns);
        let first_state = system.first_state();
        {
            let (mut here, _) = system.evaluate_leniently(parameters, state, &mut self.scratch)?;
            here.gamma(step, &mut self.gamma)?;
        }
        let mut before = f64::INFINITY;
        let mut lacking_before = usize::MAX;
        for _ in 0..ITERATIONS {
            self.levels.clear();
            let (scratch, g, levels) = (&mut self.scratch, &mut self.g, &mut self.levels);
            let lacking = system.assemble_leniently(parameters, state, scratch, g, levels)?;
            if lacking > 0 && lacking >= lacking_before {
                // Further iterations would not give these functions a value. The evaluation therefore reports the error.
                system.evaluate(parameters, state, &mut self.scratch)?;
            }
            lacking_before = lacking;
            self.levels.finish();
            let matrix = self.levels.combined(&mut self.values, |row, column| {
                if equations.contains(&row) {
                    let of_velocities = system.is_nonholonomic[row - n];
                    if column < n && of_velocities {
                        [0.0, 1.0, 0.0]
                    } else if column < system.first_variable {
                        [1.0, 0.0, 0.0]
                    } else {
                        [0.0; 3]
                    }
                } else if column < n {
                    [0.0, 0.0, 1.0]
                } else if column < first_state {
                    [1.0, 0.0, 0.0]
                } else {
                    [0.0, 1.0, 0.0]
                }
            });
            self.factors.factor_entries(&matrix);
            system.gathered(&state.accelerations, &mut self.v);
            for k in 0..system.equations {
                if system.is_effective(state, k) {
                    self.g[n + k] = self.gamma[k];
                }
            }
            for (row, column, [by_place, by_rate, _]) in self.levels.entries() {
                if equations.contains(&row) && column < n {
                    let of_velocities = system.is_nonholonomic[row - n];
                    let by = if of_velocities { by_rate } else { by_place };
                    self.g[row] += by * self.v[column];
                }
            }
            for (dx, g) in self.dx.iter_mut().zip(&self.g) {
                *dx = -g;
            }
            self.factors.solve(&mut self.dx);
            if self.factors.deficiency() > 0
                && let Some(what) = undetermined(system, &matrix, &self.dx, &self.g)
            {
                return Err(MotionFailure::Undetermined { what });
            }
            self.check_held(system, step)?;
            for (v, change) in self.v.iter_mut().zip(&self.dx[..n]) {
                *v += change;
            }
            system.scattered(&self.v, &mut state.accelerations);
            let mut relative = 0.0_f64;
            let size = self.v.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            let change = self.dx[..n].iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            relative = relative.max(change / size.max(f64::MIN_POSITIVE));
            let force = &self.dx[n..system.first_variable];
            let change = force.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
            for (multiplier, change) in state.multipliers.iter_mut().zip(force) {
                *multiplier += change;
            }
            let size = state
                .multipliers
                .iter()
                .fold(0.0_f64, |a, b| a.max(b.abs()));
            relative = relative.max(change / size.max(f64::MIN_POSITIVE));
            for (k, unknown) in system.implicit_variables() {
                let (variable, change) = (&mut state.variables[k], self.dx[unknown]);
                *variable += change;
                relative = relative.max(change.abs() / variable.abs().max(1e-12));
            }
            for (k, rate) in state.state_rates.iter_mut().enumerate() {
                let unknown = system.states[k].moving_unknown;
                let change = self.dx[unknown];
                *rate += change;
                relative = relative.max(change.abs() / rate.abs().max(1e-12));
            }
            debug_assert_eq!(self.dx.len(), m);
            if lacking > 0 {
                continue;
            }
            if relative.is_nan() {
                break;
            }
            if relative < 1e-13 || (relative < 1e-9 && relative >= 0.1 * before) {
                break;
            }
            before = relative;
        }
        Ok(())
    }

    /// Brings a moving state onto its constraints at the levels of positions, velocities and accelerations, so that its output is consistent.
    /// The changes are small. `step` is the time step of finite differences.
    ///
    /// # Errors
    /// Returns [`MotionFailure`] if one of the three levels fails or a removed constraint equation is violated.
    pub fn reconcile(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        step: f64,
    ) -> Result<(), MotionFailure> {
        let plain = plain_weight(system);
        self.exchange_equations(system, parameters, state)?;
        self.positions(system, parameters, state, None)?;
        self.velocities(system, parameters, state, &|_| plain)?;
        self.accelerations(system, parameters, state, step)?;
        self.check_removed(system, parameters, state, |_| true)
    }

    /// Checks that the removed constraint equations are satisfied. Only equations whose index `looked_at` accepts are checked.
    pub(super) fn check_removed(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
        looked_at: impl Fn(usize) -> bool,
    ) -> Result<(), MotionFailure> {
        if !self.look_at_removed(system, parameters, state)? {
            return Ok(());
        }
        let out = |k: &usize| state.redundant[*k] && looked_at(*k);
        for k in (0..state.redundant.len()).filter(out) {
            let violation = self.g[system.first_equation + k].abs();
            let size = if system.is_nonholonomic[k] {
                largest_speed(system, state)
            } else {
                system.length
            };
            if violation > REMOVED * size.max(1.0) {
                return Err(MotionFailure::RedundantViolated {
                    equation: system.constraint_equation_name(k).to_string(),
                    violation,
                });
            }
        }
        Ok(())
    }

    /// Checks that the rate of violation of every removed constraint equation is at most `most`.
    pub(super) fn check_removed_rates(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
        most: f64,
    ) -> Result<(), MotionFailure> {
        if !self.look_at_removed(system, parameters, state)? {
            return Ok(());
        }
        system.velocity_vector(state, &mut self.v);
        let mut rates = self.rows.time.clone();
        self.rows.times(&self.v, &mut rates);
        let violated = |(k, rate): &(usize, &f64)| state.redundant[*k] && !(rate.abs() <= most);
        match rates.iter().enumerate().find(violated) {
            Some((k, rate)) => Err(MotionFailure::VelocityConflict {
                equation: system.constraint_equation_name(k).to_string(),
                violation: rate.abs(),
            }),
            None => Ok(()),
        }
    }

    /// Evaluates all constraint equations, including the removed ones. Returns false, without an evaluation, if no equation is removed.
    pub(super) fn look_at_removed(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
    ) -> Result<bool, MotionFailure> {
        if !state.redundant.contains(&true) {
            return Ok(false);
        }
        let mut whole = state.clone();
        whole.redundant.clear();
        let Self {
            scratch, g, rows, ..
        } = self;
        system.constraints_and_rows(parameters, &whole, scratch, g, rows)?;
        Ok(true)
    }
}

/// Returns the name of the first variable or implicit state whose equation `A dx + g = 0` the solution with a singular matrix does not satisfy.
/// A state whose equation does not contain its rate is skipped, because such an equation restricts positions and states, not accelerations.
fn undetermined(
    system: &System,
    matrix: &Entries<'_, f64>,
    dx: &[f64],
    g: &[f64],
) -> Option<String> {
    let first = system.first_variable;
    let mut left = g.to_vec();
    for (row, column, value) in matrix.iter().filter(|(row, ..)| *row >= first) {
        left[row] += value * dx[column];
    }
    let violated = |row: &usize| left[*row].abs() > UNDETERMINED * g[*row].abs().max(1.0);
    let variables = first..system.first_state();
    let states = (0..system.states.len()).filter(|&k| system.state_reads_rate(k));
    let mut rows = variables.chain(states.map(|k| system.states[k].moving_unknown));
    rows.find(violated).map(|row| system.equation_name(row))
}

/// Returns the largest speed of any part; angular velocities are multiplied by the model's length. The result is at least one model length per
/// unit of time.
pub(super) fn largest_speed(system: &System, state: &State) -> f64 {
    let speeds = state.velocities.iter();
    let speeds = speeds.map(|v| v.linear.norm().max(v.angular.norm() * system.length));
    speeds.fold(system.length, f64::max)
}

/// Returns the translation and the rotation vector that lead from pose `from` to `pose`.
pub(super) fn difference(pose: &Pose, from: &Pose) -> crate::mechanics::Vec6 {
    let p: Vec3 = pose.p - from.p;
    let turn = log(&(pose.R * from.R.transpose()));
    crate::mechanics::Vec6::new(p.x, p.y, p.z, turn.x, turn.y, turn.z)
}
