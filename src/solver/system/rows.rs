//! Constraint equations along a motion: their gradients, their rates, and the part of their second time derivatives that does not depend on
//! the accelerations.

use super::NoValue;
use super::structure::{ConstraintEquation, ParameterSource, StateEquation, StateRhs};
use super::{Configuration, Parameters, Scratch, State, System};
use crate::constraint::Constraint;
use crate::linear::Sink;
use crate::mechanics::{Vec3, Vec6, exp};

/// Rows of the constraint Jacobian: the gradients of the constraint equations with respect to the motions of the parts.
#[derive(Clone, Debug, Default)]
pub(crate) struct Rows {
    first_equation: usize,
    first_variable: usize,
    time_column: usize,
    /// First column of the velocities.
    first_velocity: usize,
    /// Whether each row is nonholonomic. The gradient of a nonholonomic row is taken with respect to the velocities.
    of_velocities: Vec<bool>,
    /// Entries of the constraint Jacobian G as (row, column, derivative). Row 0 is the first constraint equation.
    pub entries: Vec<(u32, u32, f64)>,
    /// Derivative of each constraint equation with respect to time at constant part positions, so that `G V + time = 0` with G given by
    /// `entries`. [`Configuration::row_rates`] adds the part due to variables and states.
    pub time: Vec<f64>,
    /// Derivatives of the constraint equations with respect to variables and states: (row, unknown counted from the first variable,
    /// derivative).
    others: Vec<(u32, u32, f64)>,
}

impl Rows {
    /// Creates empty rows for a system.
    pub(crate) fn new(system: &System) -> Self {
        Self {
            first_equation: system.first_equation,
            first_variable: system.first_variable,
            time_column: 3 * system.moving_unknowns,
            first_velocity: system.moving_unknowns,
            of_velocities: system.is_nonholonomic.clone(),
            time: vec![0.0; system.equations],
            ..Self::default()
        }
    }

    /// Clears the rows before an assembly.
    pub(crate) fn clear(&mut self) {
        self.entries.clear();
        self.others.clear();
        self.time.fill(0.0);
    }

    /// Adds `G V` to `out`, which has one entry per constraint equation.
    pub(crate) fn times(&self, v: &[f64], out: &mut [f64]) {
        for &(row, column, value) in &self.entries {
            out[row as usize] += value * v[column as usize];
        }
    }

    /// Removes Jacobian entries that are zero.
    pub(crate) fn pack(&mut self) {
        self.entries.retain(|(_, _, value)| *value != 0.0);
    }
}

impl Sink for Rows {
    const NEEDS_ENTRIES: bool = false;
    const ROWS: bool = true;

    #[inline]
    fn add(&mut self, row: usize, column: usize, value: f64) {
        if row < self.first_equation || row >= self.first_variable {
            return;
        }
        let row = row - self.first_equation;
        if self.of_velocities[row] {
            let velocities = self.first_velocity..self.first_velocity + self.first_equation;
            if velocities.contains(&column) {
                let column = column - self.first_velocity;
                self.entries.push((row as u32, column as u32, value));
            }
        } else if column < self.first_equation {
            self.entries.push((row as u32, column as u32, value));
        } else if column >= self.time_column {
            self.time[row] += value;
        } else if column >= self.first_variable && value != 0.0 {
            let variable = column - self.first_variable;
            self.others.push((row as u32, variable as u32, value));
        }
    }
}

/// Fourth-order central difference that gives second time derivatives from first ones: offsets in steps, and weights.
const SIDES: [(f64, f64); 4] = [
    (-2.0, 1.0 / 12.0),
    (-1.0, -8.0 / 12.0),
    (1.0, 8.0 / 12.0),
    (2.0, -1.0 / 12.0),
];
/// Maximum rotation of a part within one difference step, in radians.
const CLOSE: f64 = 5e-3;
/// Maximum number of fixed-point passes for variables that read each other.
const PASSES: usize = 50;

impl System {
    /// Writes the velocities of the parts to `out`, in the order of the unknowns.
    pub(crate) fn velocity_vector(&self, state: &State, out: &mut Vec<f64>) {
        self.gathered(&state.velocities, out);
    }

    /// Writes the velocities or accelerations of the parts to `out`, in the order of the unknowns.
    pub(crate) fn gathered(&self, rates: &[super::PartRates], out: &mut Vec<f64>) {
        out.clear();
        for (body, rates) in self.bodies.iter().zip(rates) {
            let all = rates.linear.iter().chain(rates.angular.iter());
            out.extend(all.take(body.freedoms));
        }
    }

    /// Distributes values in the order of the unknowns to the rates of the parts. This is the inverse of [`Self::gathered`].
    pub(crate) fn scattered(&self, values: &[f64], rates: &mut [super::PartRates]) {
        for (body, rates) in self.bodies.iter().zip(rates) {
            for k in 0..body.freedoms {
                let value = values[body.first + k];
                if k < 3 {
                    rates.linear[k] = value;
                } else {
                    rates.angular[k - 3] = value;
                }
            }
        }
    }

    /// Computes the residuals and the Jacobian rows of the constraints alone.
    ///
    /// # Errors
    /// Returns [`NoValue`] if a function has no value in this state.
    pub(crate) fn constraints_and_rows(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        g: &mut [f64],
        rows: &mut Rows,
    ) -> Result<(), NoValue> {
        rows.clear();
        g.fill(0.0);
        let mut here = self.at(parameters, state, scratch);
        here.evaluate_constraints()?;
        for number in 0..self.joints.len() {
            here.add_joint(number, g, rows);
        }
        here.add_conditions(g, rows)?;
        if !rows.others.is_empty() {
            let rates = here.data_rates();
            here.row_rates(&mut rows.time, &rows.others, &rates);
        }
        here.add_nonholonomic_offset(&mut rows.time);
        Ok(())
    }
}

impl Configuration<'_> {
    /// Adds the part due to variables and states to `time`, which holds the rates of the constraint rows. `rates` holds the rates of the
    /// variables and states.
    fn row_rates(&self, time: &mut [f64], others: &[(u32, u32, f64)], rates: &[f64]) {
        for &(row, unknown, by) in others {
            time[row as usize] += by * rates[unknown as usize];
        }
    }

    /// Completes the rates of the constraint rows at an integrator stage. Nonholonomic rows get their full rate. Other rows get the part
    /// due to variables and states.
    ///
    /// The dynamic states use the rates of the integrator stage, which determine their increments. The constraint rows use the same rates,
    /// so that the corrections of states and constraints agree.
    pub(super) fn stage_rates(&self, rates: &mut [f64], others: &[(u32, u32, f64)]) {
        self.add_nonholonomic_offset(rates);
        if !others.is_empty() {
            let own = |k: usize, _: &StateEquation| self.state.state_rates[k];
            self.row_rates(rates, others, &self.rates_of_data(own));
        }
    }

    /// Returns the time derivatives of the unknowns from the first variable on, along the motion.
    ///
    /// Variables satisfy `v' - e_v v' = e_q V + e_t`, solved by fixed-point passes. Explicit states have the rates given by their
    /// equations. MOTIONs and GCONs that read velocities are rejected when the model is compiled, so no velocities are read here.
    fn data_rates(&self) -> Vec<f64> {
        let state = self.state;
        self.rates_of_data(|k, equation| match &equation.moving {
            StateRhs::Function(function) if !equation.implicit => {
                self.scratch.functions[*function].value
            }
            StateRhs::Linear(by_state, by_variable) => {
                let own: f64 = by_state.iter().map(|&(k, a)| a * state.states[k]).sum();
                let input = by_variable.iter().map(|&(k, b)| b * self.variable(k));
                own + input.sum::<f64>()
            }
            StateRhs::Function(_) | StateRhs::Held => {
                state.state_rates.get(k).copied().unwrap_or(0.0)
            }
        })
    }

    /// Returns the time derivatives of the unknowns from the first variable on. `of_state` gives the rate of each dynamic state.
    fn rates_of_data(&self, of_state: impl Fn(usize, &StateEquation) -> f64) -> Vec<f64> {
        let system = self.system;
        let mut rates = vec![0.0; system.moving_unknowns - system.first_variable];
        if !system.data_constrain {
            // Nothing reads these rates, and the functions they depend on may not have been evaluated.
            return rates;
        }
        for (k, equation) in system.states.iter().enumerate() {
            rates[equation.moving_unknown - system.first_variable] = of_state(k, equation);
        }
        for _ in 0..PASSES {
            let mut change = 0.0_f64;
            for (at, &k) in system.implicit.iter().enumerate() {
                let rate = self.rate_along(system.variables[k].function, &rates);
                change = change.max((rate - rates[at]).abs());
                rates[at] = rate;
            }
            if change == 0.0 {
                break;
            }
        }
        rates
    }

    /// Returns the component of the part velocities that belongs to a part unknown.
    pub(super) fn velocity_of(&self, unknown: usize) -> f64 {
        let bodies = &self.system.bodies;
        let body = bodies.partition_point(|b| b.first + b.freedoms <= unknown);
        let velocity = &self.state.velocities[body];
        let k = unknown - bodies[body].first;
        if k < 3 {
            velocity.linear[k]
        } else {
            velocity.angular[k - 3]
        }
    }

    /// Returns the time derivative of a function along the motion, at constant velocities. `variables` holds the rates of variables and
    /// states.
    fn rate_along(&self, function: usize, variables: &[f64]) -> f64 {
        let system = self.system;
        let n = system.moving_unknowns;
        let value = self.scratch.functions[function];
        let mut rate = 0.0;
        for &(column, by) in &self.scratch.gradient[value.first..value.last] {
            if column >= 3 * n {
                rate += by;
            } else if column < system.first_equation {
                rate += by * self.velocity_of(column);
            } else if (system.first_variable..n).contains(&column) {
                let k = column - system.first_variable;
                rate += by * variables.get(k).copied().unwrap_or(0.0);
            }
        }
        rate
    }

    /// Computes gamma of every constraint equation. For accelerations A, the second time derivative of the equation is `G A + gamma`.
    /// [`Configuration::evaluate`] must have been called.
    ///
    /// For one term, let u be the rates of I in J (J axes), r the Jacobian row, C the derivative of the row along the motion and s the
    /// parameter. Its gamma is `r . b + u_t' C u_t + 2 s' r_s . u + f_s s''`. Here b is the part of the second derivatives of p_ij_j and of
    /// the rotation that contains no part accelerations: `b_p = R_j' (a_i - a_j - 2 w_j x (v_i - v_j) + w_j x (w_j x d))` and `b_t = -R_j'
    /// (w_j x w_i)`, where a is the centripetal acceleration of the arms alone.
    ///
    /// Functions of time alone are differentiated exactly. Other functions use fourth-order differences of their exact rates along the
    /// motion, with steps of at most `step`. For a nonholonomic GCON, gamma is the first time derivative of its function.
    ///
    /// # Errors
    /// Returns [`NoValue`] if a function has no value at a neighbouring point.
    pub(crate) fn gamma(&mut self, step: f64, gamma: &mut [f64]) -> Result<(), NoValue> {
        let system = self.system;
        gamma.fill(0.0);
        let mut functions: Vec<usize> = system
            .joints
            .iter()
            .filter_map(|joint| match joint.drive {
                ParameterSource::Function(function) if joint.active => Some(function),
                _ => None,
            })
            .collect();
        functions.extend(
            system
                .conditions
                .iter()
                .filter(|c| c.active)
                .map(|c| c.function),
        );
        let rates = self.function_rates(&functions, step)?;
        let found = |function: usize| -> [f64; 2] {
            let at = functions.iter().position(|f| *f == function);
            at.map_or([0.0; 2], |at| rates[at])
        };
        for joint in &system.joints {
            let out = joint.out(self.state);
            if !joint.active {
                continue;
            }
            let driven = match joint.drive {
                ParameterSource::Function(function) => found(function),
                ParameterSource::Rate(drive) => {
                    let [_, rate, second] = self.scratch.driven[drive.index];
                    [rate, second]
                }
                ParameterSource::Theta(_) | ParameterSource::Constant(_) => [0.0; 2],
            };
            self.joint_gamma(joint, driven, gamma);
            for k in 0..joint.count {
                if out[k] {
                    gamma[joint.first + k] = 0.0;
                }
            }
        }
        for condition in system.conditions.iter().filter(|c| !self.is_out(c)) {
            let [first, second] = found(condition.function);
            let of_velocities = system.is_nonholonomic[condition.equation];
            gamma[condition.equation] = if of_velocities { first } else { second };
        }
        Ok(())
    }

    fn joint_gamma(
        &mut self,
        joint: &ConstraintEquation,
        [rate, second]: [f64; 2],
        gamma: &mut [f64],
    ) {
        for (at, term) in joint.terms.iter().enumerate() {
            let u = self.relative_rates(term.i, term.j);
            let b = self.convective(term.i, term.j);
            let turning = Vec3::new(u[3], u[4], u[5]);
            for k in 0..joint.count {
                let mut unit = [0.0; 6];
                unit[k] = 1.0;
                self.evaluate_term(joint, at, &unit);
                let equations = &self.scratch.equations;
                let mut second_rate =
                    equations.jacobian[k].dot(&b) + turning.dot(&(equations.curvature * turning));
                if k == 0 && term.law.parameter_count() > 0 {
                    second_rate += 2.0 * rate * equations.jacobian_by_parameter.dot(&u)
                        + equations.residual_by_parameter * second;
                }
                gamma[joint.first + k] += term.scale * second_rate;
            }
        }
    }

    /// Returns the part of the second derivatives of `p_ij_j` and of the rotation of I in J that contains no part acceleration, J axes.
    fn convective(&self, i: usize, j: usize) -> Vec6 {
        let arms = |marker: usize| {
            let frame = self.moving_frame(Some(marker));
            let w = frame.w;
            let a = w.cross(&w.cross(&self.scratch.arms[marker]));
            (frame, a)
        };
        let ((i, a_i), (j, a_j)) = (arms(i), arms(j));
        let R = j.pose.R.transpose();
        let d = i.pose.p - j.pose.p;
        let p = R * (a_i - a_j - 2.0 * j.w.cross(&(i.v - j.v)) + j.w.cross(&j.w.cross(&d)));
        let t = R * -j.w.cross(&i.w);
        Vec6::new(p.x, p.y, p.z, t.x, t.y, t.z)
    }

    /// Returns the first and second time derivatives of functions along the motion, at zero accelerations. The derivatives are exact for
    /// functions of time alone. For other functions, the second derivative uses the difference formula [`SIDES`].
    fn function_rates(&mut self, functions: &[usize], step: f64) -> Result<Vec<[f64; 2]>, NoValue> {
        if functions.is_empty() {
            return Ok(Vec::new());
        }
        let mut exact = Vec::with_capacity(functions.len());
        for &function in functions {
            let found = self.in_time(function, self.state.time, true)?;
            exact.push(found.and_then(|found| found.rates));
        }
        if let Some(rates) = exact.iter().copied().collect() {
            return Ok(rates);
        }
        let turning = self.state.velocities.iter().map(|v| v.angular.norm());
        let step = step.min(CLOSE / turning.fold(0.0, f64::max));
        let variables = self.data_rates();
        let mut rates: Vec<[f64; 2]> = functions
            .iter()
            .map(|&f| [self.rate_along(f, &variables), 0.0])
            .collect();
        let system = self.system;
        let mut scratch = Scratch::new(system);
        for (side, weight) in SIDES {
            let mut near = self.state.clone();
            let h = side * step;
            near.time += h;
            for (pose, velocity) in near.poses.iter_mut().zip(&self.state.velocities) {
                pose.p += velocity.linear * h;
                pose.R = exp(&(velocity.angular * h)) * pose.R;
            }
            for (value, equation) in near.states.iter_mut().zip(&system.states) {
                *value += variables[equation.moving_unknown - system.first_variable] * h;
            }
            system.settle_variables(self.parameters, &mut near, &mut scratch)?;
            let mut here = system.at(self.parameters, &near, &mut scratch);
            here.evaluate_constraints()?;
            let variables = here.data_rates();
            for (rate, &function) in rates.iter_mut().zip(functions) {
                rate[1] += weight / step * here.rate_along(function, &variables);
            }
        }
        for (rate, exact) in rates.iter_mut().zip(exact) {
            *rate = exact.unwrap_or(*rate);
        }
        Ok(rates)
    }
}

impl System {
    /// Iterates the VARIABLEs that read themselves, in fixed-point passes, until each equals the value of its function. A function without
    /// a value counts as zero.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element that a function measures has no value in this state.
    pub(crate) fn settle_variables(
        &self,
        parameters: &Parameters,
        state: &mut State,
        scratch: &mut Scratch,
    ) -> Result<(), NoValue> {
        for _ in 0..PASSES {
            let mut change = 0.0_f64;
            if self.implicit.is_empty() {
                break;
            }
            self.evaluate_leniently(parameters, state, scratch)?;
            for &k in &self.implicit {
                let value = scratch.functions[self.variables[k].function].value;
                change = change.max((value - state.variables[k]).abs());
                state.variables[k] = value;
            }
            if change == 0.0 {
                break;
            }
        }
        Ok(())
    }
}
