//! Residual and Jacobian of the system equations.
//!
//! The module contains no iteration, step control or factorisation.

use super::chain::{add_block, add_wrench};
use super::contribution::Of;
use super::forces::DerivativeRequest;
use super::structure::{ParameterSource, StateRhs, System};
use super::{Configuration, NoValue, Parameters, Scratch, State};
use crate::linear::{NoMatrix, Sink};
use crate::mechanics::{Mat6, Vec3, skew};

impl System {
    /// Computes the residual of every equation: the force and torque balances about the reference points of the parts (ground axes), the
    /// constraints, the variables, and the rates of states.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element is undefined in this configuration.
    pub fn residual(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        g: &mut [f64],
    ) -> Result<(), NoValue> {
        self.assemble(parameters, state, scratch, g, &mut NoMatrix)
    }

    /// Computes the residual and passes the Jacobian to the sink. The Jacobian entries come in the same order every time.
    ///
    /// # Errors
    /// Returns [`NoValue`] if a function or an element is undefined in this configuration.
    pub fn assemble<S: Sink>(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        g: &mut [f64],
        sink: &mut S,
    ) -> Result<(), NoValue> {
        g.fill(0.0);
        scratch.largest = 0.0;
        let mut here = self.evaluate(parameters, state, scratch)?;
        here.add_gravity(g, sink);
        if here.moving() {
            here.add_inertia(g, sink);
        }
        let ask = if S::NEEDS_ENTRIES {
            DerivativeRequest::Tangent
        } else {
            DerivativeRequest::Value
        };
        for (number, element) in self.elements.iter().enumerate() {
            if element.active {
                here.element(number, ask)?;
                here.add(g, sink);
            }
        }
        for multi in self.multis.iter().filter(|m| m.active) {
            here.evaluate_multi(multi)?;
            for at in 0..multi.i.len() {
                here.multi(multi, at, S::NEEDS_ENTRIES);
                here.add(g, sink);
            }
        }
        for number in 0..self.joints.len() {
            here.add_joint(number, g, sink);
        }
        here.add_frictions(g, sink)?;
        here.add_conditions(g, sink)?;
        here.add_data(g, sink);
        Ok(())
    }

    /// Assembles residual and Jacobian even if functions are undefined. Undefined functions count as zero with zero slope; the number of
    /// undefined functions is returned.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element is undefined in this configuration.
    pub(crate) fn assemble_leniently<S: Sink>(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        g: &mut [f64],
        sink: &mut S,
    ) -> Result<usize, NoValue> {
        scratch.lacking = Some(0);
        let done = self.assemble(parameters, state, scratch, g, sink);
        let lacking = scratch.lacking.take().unwrap_or(0);
        done.map(|()| lacking)
    }

    /// Assembles only the equations of joints and motions. Functions, which may be undefined, are not evaluated; the Jacobian of these
    /// equations does not need their values. `scratch` must be new.
    pub(crate) fn assemble_joints<S: Sink>(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        g: &mut [f64],
        sink: &mut S,
    ) {
        let mut here = self.at(parameters, state, scratch);
        here.place_markers();
        // In statics, the displacements of rate motions are constant, so this cannot fail.
        let _ = here.drive();
        for number in 0..self.joints.len() {
            here.add_joint(number, g, sink);
        }
    }
}

impl Configuration<'_> {
    /// Adds `scratch.contribution` to the balances and its derivative to the Jacobian.
    pub(super) fn add<S: Sink>(&mut self, g: &mut [f64], sink: &mut S) {
        let scratch = &mut *self.scratch;
        let wrench = &scratch.contribution;
        scratch.largest = scratch.largest.max(wrench.size(self.system.length));
        wrench.balance(g);
        if S::NEEDS_ENTRIES {
            wrench.tangent_by_motion(sink);
            wrench.tangent_by_functions(&scratch.functions, &scratch.gradient, sink);
        }
    }

    fn add_gravity<S: Sink>(&mut self, g: &mut [f64], sink: &mut S) {
        let theta = self.parameters.theta();
        let gravity = self.system.gravity_vector(theta);
        for (part, body) in self.system.bodies.iter().enumerate() {
            let place = self.system.place(part);
            let mut block = Mat6::zeros();
            if let (Some(cm), true) = (body.cm, body.freedoms > 0) {
                let F = gravity * theta[body.mass];
                self.scratch.largest = self.scratch.largest.max(F.amax());
                let r = self.scratch.arms[cm];
                add_wrench(g, place, 1.0, &F, &Vec3::zeros(), &r);
                // d(r x F) = (dphi x r) x F
                let by_turn = skew(&F) * skew(&r);
                block.fixed_view_mut::<3, 3>(3, 3).copy_from(&by_turn);
            }
            // Every part has its diagonal block in the sparsity pattern.
            if S::NEEDS_ENTRIES {
                add_block(sink, place, place, &block);
            }
        }
    }

    pub(super) fn add_joint<S: Sink>(&mut self, number: usize, g: &mut [f64], sink: &mut S) {
        let system = self.system;
        let joint = &system.joints[number];
        let first = system.first_equation + joint.first;
        let out = joint.out(self.state);
        for k in 0..joint.count {
            // The row of a removed equation sets its multiplier to zero.
            if S::ROWS {
                sink.add(first + k, first + k, f64::from(u8::from(out[k])));
            }
            g[first + k] = if out[k] {
                self.state.multipliers[joint.first + k]
            } else {
                -joint.offset
            };
        }
        if !joint.active && !S::ROWS {
            return;
        }
        for (at, term) in joint.terms.iter().enumerate() {
            self.term(number, at, S::ROWS);
            if S::NEEDS_ENTRIES {
                self.set_reaction_stiffness();
            }
            for k in 0..joint.count {
                if !out[k] {
                    g[first + k] += term.scale * self.scratch.equations.residual[k];
                }
            }
            if S::ROWS {
                // A row of the constraint Jacobian is minus the effect of its multiplier on the balances.
                let reaction = &self.scratch.contribution;
                for scalar in &reaction.scalars {
                    let Of::Unknown(row) = scalar.of else {
                        continue;
                    };
                    for (place, column) in reaction.column(scalar) {
                        sink.add_reaction(row, place.first, &column[..place.freedoms]);
                    }
                }
            }
            self.add(g, sink);
        }
        if S::ROWS
            && let ParameterSource::Rate(drive) = joint.drive
            && self.moving()
            && !out[0]
        {
            let by = self.scratch.equations.residual_by_parameter * joint.terms[0].scale;
            let rate = self.scratch.driven[drive.index][1];
            sink.add(first, 3 * system.moving_unknowns, by * rate);
        }
        if S::ROWS
            && let ParameterSource::Function(function) = joint.drive
        {
            let value = &self.scratch.functions[function];
            let by = if out[0] {
                0.0
            } else {
                self.scratch.equations.residual_by_parameter * joint.terms[0].scale
            };
            for &(unknown, derivative) in &self.scratch.gradient[value.first..value.last] {
                sink.add(first, unknown, by * derivative);
            }
        }
    }

    fn add_data<S: Sink>(&self, g: &mut [f64], sink: &mut S) {
        let (system, state, scratch) = (self.system, self.state, &*self.scratch);
        for (k, row) in system.implicit_variables() {
            let value = &scratch.functions[system.variables[k].function];
            sink.add(row, row, 1.0);
            g[row] = state.variables[k] - value.value;
            for &(unknown, derivative) in &scratch.gradient[value.first..value.last] {
                sink.add(row, unknown, -derivative);
            }
        }
        let moving = state.moves();
        let n = system.moving_unknowns;
        for (number, equation) in system.states.iter().enumerate() {
            let Some(row) = system.state_unknown(number, moving) else {
                continue;
            };
            let rate = if moving {
                if !equation.implicit {
                    g[row] -= state.state_rates[number];
                    sink.add(row, n + row, -1.0);
                }
                &equation.moving
            } else {
                &equation.rate
            };
            match rate {
                StateRhs::Held => {}
                StateRhs::Function(function) => {
                    let value = &scratch.functions[*function];
                    g[row] += value.value;
                    for &(unknown, derivative) in &scratch.gradient[value.first..value.last] {
                        sink.add(row, unknown, derivative);
                    }
                }
                StateRhs::Linear(by_state, by_variable) => {
                    for &(k, a) in by_state {
                        g[row] += a * state.states[k];
                        if let Some(unknown) = system.state_unknown(k, moving) {
                            sink.add(row, unknown, a);
                        }
                    }
                    for &(k, b) in by_variable {
                        g[row] += b * self.variable(k);
                        self.each_of_variable(k, b, |unknown, by| sink.add(row, unknown, by));
                    }
                }
            }
        }
    }
}
