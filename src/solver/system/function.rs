//! FUNCTIONs in a configuration: their values, and their gradients with respect to the unknowns.
//!
//! This file relates the inputs of a program to parts, multipliers, variables and states. The formulas of the programs are defined
//! elsewhere.

use std::collections::{BTreeMap, BTreeSet};

use super::compiled_function::{CompiledFunction, Source};
use super::contribution::FunctionValue;
use super::scratch::FunctionNumber;
use super::{Configuration, NoValue, NoValueReason, Parameters, Scratch, State, System};
use crate::function::{
    Measure, Piece, Program, ProgramNumbers, RateMeasure, Reference, measure, rate,
};
use crate::mechanics::{Pose, Vec3, Vec6};

impl CompiledFunction {
    /// Sets the derivatives of the function with respect to inputs and literals to zero.
    fn forget(&self, program: &Program, scratch: &mut Scratch) {
        scratch.by_input.clear();
        scratch.by_input.resize(program.inputs.len(), 0.0);
        scratch.by_literal.clear();
        scratch.by_literal.resize(self.literals.len(), 0.0);
    }

    /// Evaluates the compiled function at the inputs in `scratch`. Each piecewise function stays on the piece that `pieces` gives. The derivatives
    /// with respect to inputs and literals are left in `scratch`.
    pub(super) fn run(
        &self,
        program: &Program,
        parameters: &Parameters,
        pieces: &[Piece],
        scratch: &mut Scratch,
    ) -> Result<f64, NoValue> {
        self.forget(program, scratch);
        let value = program.eval_on_pieces(
            &scratch.inputs,
            ProgramNumbers {
                literals: &parameters.theta()[self.literals.clone()],
                curves: parameters.curves(),
            },
            pieces,
            &mut scratch.program,
            &mut scratch.by_input,
            &mut scratch.by_literal,
        );
        value.map_err(|error| NoValue {
            element: self.owner.clone(),
            reason: NoValueReason::Function(error),
        })
    }
}

/// Value and derivatives of a function of time.
#[derive(Clone, Copy, Default)]
pub(super) struct InTime {
    pub value: f64,
    /// First derivative with respect to time.
    pub slope: f64,
    /// First and second time derivatives, if both exist.
    pub rates: Option<[f64; 2]>,
}

impl InTime {
    fn constant(value: f64) -> Self {
        Self {
            value,
            slope: 0.0,
            rates: Some([0.0; 2]),
        }
    }
}

impl Configuration<'_> {
    /// Evaluates values and gradients of functions into `scratch` and discards earlier results. Each function in `order` must come after
    /// the functions it reads.
    pub(super) fn evaluate_functions(&mut self, order: &[usize]) -> Result<(), NoValue> {
        self.scratch.gradient.clear();
        self.scratch.looks += 1;
        for &function in order {
            self.evaluate_function(function)?;
        }
        Ok(())
    }

    /// Returns the value of a function. The function is evaluated first if [`Configuration::evaluate`] omitted it because the equations do
    /// not need it. The gradient of the function is left in `scratch`.
    pub(super) fn value_of(&mut self, function: usize) -> Result<f64, NoValue> {
        let system = self.system;
        if !system.in_equations[function] {
            let reads = system.reads();
            let (mut open, mut missing) = (vec![function], BTreeSet::new());
            while let Some(function) = open.pop() {
                let known = self.scratch.looked[function] == self.scratch.looks;
                if !system.in_equations[function] && !known && missing.insert(function) {
                    open.extend(reads.of(function));
                }
            }
            let mut missing: Vec<usize> = missing.into_iter().collect();
            missing.sort_unstable_by_key(|&f| system.ranks[f]);
            for function in missing {
                self.evaluate_function(function)?;
                self.scratch.looked[function] = self.scratch.looks;
            }
        }
        Ok(self.scratch.functions[function].value)
    }

    /// Returns the value of a VARIABLE. [`Configuration::evaluate`] must have been called.
    ///
    /// # Errors
    /// Returns [`NoValue`] if the function of the VARIABLE is undefined in this configuration.
    pub fn read_variable(&mut self, variable: usize) -> Result<f64, NoValue> {
        match self.system.reads().explicit(variable) {
            Some(function) => self.value_of(function),
            None => Ok(self.unknown_variable(variable)),
        }
    }

    /// Returns the gradient of a VARIABLE with respect to the unknowns. [`Configuration::evaluate`] must have been called.
    ///
    /// # Errors
    /// Returns [`NoValue`] if the function of the VARIABLE is undefined in this configuration.
    pub(crate) fn variable_gradient(
        &mut self,
        variable: usize,
    ) -> Result<Vec<(usize, f64)>, NoValue> {
        let Some(function) = self.system.reads().explicit(variable) else {
            let unknown = self.system.variables[variable].unknown;
            return Ok(unknown.map(|unknown| (unknown, 1.0)).into_iter().collect());
        };
        self.value_of(function)?;
        let value = self.scratch.functions[function];
        Ok(self.scratch.gradient[value.first..value.last].to_vec())
    }

    /// Returns the value of a VARIABLE that is an unknown, or zero if the VARIABLE is inactive.
    fn unknown_variable(&self, variable: usize) -> f64 {
        if self.system.variables[variable].active {
            self.state.variables[variable]
        } else {
            0.0
        }
    }

    /// Returns the value of a VARIABLE that the equations read.
    pub(super) fn variable(&self, variable: usize) -> f64 {
        match self.system.reads().explicit(variable) {
            Some(function) => self.scratch.functions[function].value,
            None => self.unknown_variable(variable),
        }
    }

    /// Passes each entry of the gradient of a VARIABLE that the equations read, multiplied by a factor, to `put`.
    pub(super) fn each_of_variable(
        &self,
        variable: usize,
        factor: f64,
        mut put: impl FnMut(usize, f64),
    ) {
        match self.system.reads().explicit(variable) {
            Some(function) => {
                let value = self.scratch.functions[function];
                for &(unknown, by) in &self.scratch.gradient[value.first..value.last] {
                    put(unknown, factor * by);
                }
            }
            None => {
                if let Some(unknown) = self.system.variables[variable].unknown {
                    put(unknown, factor);
                }
            }
        }
    }

    /// Appends the gradient of a VARIABLE that the equations read, multiplied by a factor, and returns the value of the VARIABLE.
    fn push_variable(&mut self, variable: usize, factor: f64) -> f64 {
        let mut gradient = std::mem::take(&mut self.scratch.gradient);
        let at = gradient.len();
        match self.system.reads().explicit(variable) {
            Some(function) => {
                let value = self.scratch.functions[function];
                gradient.extend_from_within(value.first..value.last);
                for (_, by) in &mut gradient[at..] {
                    *by *= factor;
                }
            }
            None => gradient.extend(self.system.variables[variable].unknown.map(|u| (u, factor))),
        }
        self.scratch.gradient = gradient;
        self.variable(variable)
    }

    /// Evaluates value and gradient of one function into `scratch`. The functions that it reads must already be evaluated.
    pub(super) fn evaluate_function(&mut self, number: usize) -> Result<(), NoValue> {
        let function = &self.system.functions[number];
        let first = self.scratch.gradient.len();
        let replacement = self.parameters.theta()[function.replacement];
        let replaced = !replacement.is_nan();
        let mut value = if replaced { replacement } else { 0.0 };
        if let Some(program) = &function.program {
            // The gradient has the same pattern whether or not the function is replaced.
            self.scratch.inputs.clear();
            self.scratch.spans.clear();
            let mut chained = false;
            for source in &function.sources {
                chained |= matches!(
                    source,
                    Source::Variable(_) | Source::Output(_) | Source::Force(_)
                );
                let input = self.source(source)?;
                self.scratch.inputs.push(input);
                self.scratch.spans.push(self.scratch.gradient.len());
            }
            let scratch = &mut *self.scratch;
            if replaced {
                function.forget(program, scratch);
            } else {
                let pieces = self.state.pieces.get(function.switches.clone());
                let pieces = pieces.unwrap_or_default();
                match function.run(program, self.parameters, pieces, scratch) {
                    Ok(found) => value = found,
                    Err(why) => {
                        let Some(lacking) = &mut scratch.lacking else {
                            return Err(why);
                        };
                        *lacking += 1;
                        function.forget(program, scratch);
                    }
                }
                if !pieces.is_empty() {
                    let seen = &mut scratch.seen[function.switches.clone()];
                    seen.copy_from_slice(scratch.program.seen());
                }
            }
            let mut at = first;
            for (&end, &by) in scratch.spans.iter().zip(&scratch.by_input) {
                for (_, derivative) in &mut scratch.gradient[at..end] {
                    *derivative *= by;
                }
                at = end;
            }
            if chained {
                merge(&mut scratch.gradient, first);
            }
        }
        for k in 0..self.scratch.seeds.len() {
            let seed = self.scratch.seeds[k];
            if seed.function != number {
                continue;
            }
            let by = match seed.number {
                FunctionNumber::Value => 1.0,
                _ if replaced => 0.0,
                number => self.by_number(function.program.as_ref(), number),
            };
            self.scratch.gradient.push((seed.column, by));
        }
        self.scratch.functions[number] = FunctionValue {
            value,
            first,
            last: self.scratch.gradient.len(),
        };
        Ok(())
    }

    /// Returns the derivative of the function evaluated last with respect to one of its numbers, at constant inputs.
    pub(super) fn by_number(&self, program: Option<&Program>, number: FunctionNumber) -> f64 {
        match (number, program) {
            (FunctionNumber::Value, _) => 1.0,
            (FunctionNumber::Literal(k), _) => {
                self.scratch.by_literal.get(k).copied().unwrap_or(0.0)
            }
            (FunctionNumber::Knot(..), None) => 0.0,
            (FunctionNumber::Knot(spline, knot), Some(program)) => {
                let curves = self.parameters.curves();
                program.by_knot(curves, (spline, knot), &self.scratch.program)
            }
        }
    }

    /// Returns value and derivatives of a function at `time`. Returns `None` unless the function depends, also through VARIABLEs, only on
    /// time. With `on_pieces`, its switches are held on the pieces of the state; otherwise the arguments select the pieces.
    pub(super) fn in_time(
        &mut self,
        number: usize,
        time: f64,
        on_pieces: bool,
    ) -> Result<Option<InTime>, NoValue> {
        let (system, state) = (self.system, self.state);
        if !system.reads().only_time(number) {
            return Ok(None);
        }
        let mut found = BTreeMap::new();
        for read in system.in_turn(number) {
            let function = &system.functions[read];
            let replacement = self.parameters.theta()[function.replacement];
            let program = match &function.program {
                Some(program) if replacement.is_nan() => program,
                _ => {
                    let value = if replacement.is_nan() {
                        0.0
                    } else {
                        replacement
                    };
                    found.insert(read, InTime::constant(value));
                    continue;
                }
            };
            let inputs: Vec<InTime> = function
                .sources
                .iter()
                .map(|source| match source {
                    Source::Time => InTime {
                        value: time,
                        slope: 1.0,
                        rates: Some([1.0, 0.0]),
                    },
                    Source::Mode => InTime::constant(f64::from(state.mode)),
                    Source::Constant(value) => InTime::constant(*value),
                    Source::Sensor(k) => {
                        InTime::constant(state.sensors.get(*k).copied().unwrap_or(0.0))
                    }
                    Source::Variable(k) => {
                        let function = system.reads().explicit(*k);
                        let known = function.and_then(|f| found.get(&f));
                        known.copied().unwrap_or(InTime::constant(0.0))
                    }
                    _ => InTime::constant(0.0),
                })
                .collect();
            let scratch = &mut *self.scratch;
            scratch.inputs.clear();
            scratch
                .inputs
                .extend(inputs.iter().map(|input| input.value));
            let pieces = state.pieces.get(function.switches.clone());
            let pieces = pieces.filter(|_| on_pieces).unwrap_or_default();
            let value = function.run(program, self.parameters, pieces, scratch)?;
            let slopes = inputs.iter().zip(&scratch.by_input);
            let slope = slopes.map(|(input, by)| input.slope * by).sum();
            let rates: Option<Vec<[f64; 2]>> = inputs.iter().map(|input| input.rates).collect();
            let rates = rates.and_then(|rates| {
                program.rates_along(&rates, self.parameters.curves(), &mut scratch.program)
            });
            found.insert(
                read,
                InTime {
                    value,
                    slope,
                    rates,
                },
            );
        }
        Ok(found.remove(&number))
    }

    /// Returns the value of an input and appends its gradient.
    fn source(&mut self, source: &Source) -> Result<f64, NoValue> {
        let (system, state, scratch) = (self.system, self.state, &mut *self.scratch);
        Ok(match source {
            Source::Time => {
                if state.moves() {
                    // Column of the derivative with respect to time.
                    scratch.gradient.push((3 * system.moving_unknowns, 1.0));
                }
                state.time
            }
            Source::Moved(measure) => return Ok(self.moved(measure)),
            Source::Mode => f64::from(state.mode),
            Source::Constant(value) => *value,
            Source::Sensor(sensor) => state.sensors.get(*sensor).copied().unwrap_or(0.0),
            Source::Variable(variable) => self.push_variable(*variable, 1.0),
            Source::State(k) => {
                if let Some(unknown) = system.state_unknown(*k, state.moves()) {
                    scratch.gradient.push((unknown, 1.0));
                }
                state.states[*k]
            }
            Source::StateRate(k, _) if state.moves() => {
                let unknown = system.states[*k].moving_unknown;
                scratch
                    .gradient
                    .push((system.moving_unknowns + unknown, 1.0));
                state.state_rates[*k]
            }
            Source::StateRate(_, None) => 0.0,
            Source::StateRate(_, Some(function)) => {
                let value = scratch.functions[*function];
                scratch.gradient.extend_from_within(value.first..value.last);
                value.value
            }
            Source::Output((by_state, by_variable)) => {
                let mut value = 0.0;
                for &(k, c) in by_state {
                    value += c * state.states[k];
                    if let Some(unknown) = system.state_unknown(k, state.moves()) {
                        scratch.gradient.push((unknown, c));
                    }
                }
                for &(k, d) in by_variable {
                    value += d * self.push_variable(k, d);
                }
                value
            }
            Source::Measure(measure, angle) => {
                let [i, j, k] = measured_poses(measure, scratch);
                let reference = &state.measure_angles[*angle];
                let measured = measure::evaluate(measure, &i, &j, &k, reference);
                for (marker, by) in [
                    (measure.i, measured.by_i),
                    (measure.j, measured.by_j),
                    (measure.k, measured.by_k),
                ] {
                    if let Some(marker) = marker {
                        self.push_motion(marker.0, &by);
                    }
                }
                measured.value
            }
            Source::Force(force) => self.measure_force(force)?,
            Source::Friction(id, which) => self.measure_friction(*id, *which)?,
        })
    }

    /// Returns a velocity or acceleration of markers, and appends its gradient with respect to positions, velocities and accelerations of
    /// the parts.
    ///
    /// Let `r` be the vector from the origin of the part to the marker. `V` and `A` are the velocity and acceleration of the origin. `w` and `b`
    /// are the angular velocity and angular acceleration of the part. Then `dv = dV + dw x r + w x (dphi x r)` and
    /// `da = dA + db x r + b x (dphi x r) + dw x (w x r) + w x (dw x r) + w x (w x (dphi x r))`.
    pub(super) fn moved(&mut self, measure: &RateMeasure) -> f64 {
        if !self.moving() {
            return 0.0;
        }
        let frames = measure.markers.map(|m| self.moving_frame(m.map(|m| m.0)));
        let found = rate::evaluate(measure, frames.each_ref());
        let second = measure.kind.is_second();
        let n = self.system.moving_unknowns;
        for (marker, by) in measure.markers.iter().zip(&found.by) {
            let Some(marker) = marker.map(|m| m.0) else {
                continue;
            };
            let part = self.system.owners[marker];
            let place = self.system.place(part);
            if place.freedoms == 0 {
                continue;
            }
            let (w, b) = (
                self.state.velocities[part].angular,
                self.state.accelerations[part].angular,
            );
            let r = self.scratch.arms[marker];
            let (e_w, a_w) = (by.v.cross(&w), by.a.cross(&w));
            let shift = by.shift;
            let turn = by.turn + r.cross(&(by.shift + e_w + by.a.cross(&b) + a_w.cross(&w)));
            let by_v = by.v;
            let by_w = by.w + r.cross(&by.v) + w.cross(&r).cross(&by.a) + r.cross(&a_w);
            let levels = [
                Some((shift, turn)),
                Some((by_v, by_w)),
                second.then(|| (by.a, by.b + r.cross(&by.a))),
            ];
            for (level, halves) in levels.iter().enumerate() {
                let Some((linear, angular)) = halves else {
                    continue;
                };
                for k in 0..place.freedoms {
                    let by = if k < 3 { linear[k] } else { angular[k - 3] };
                    let column = level * n + place.first + k;
                    self.scratch.gradient.push((column, by));
                }
            }
        }
        found.value
    }

    /// Appends a gradient with respect to the motion of a marker in ground, converted to the unknowns of its part.
    pub(super) fn push_motion(&mut self, marker: usize, by: &Vec6) {
        let place = self.system.place(self.system.owners[marker]);
        let scratch = &mut *self.scratch;
        if place.freedoms == 0 {
            return;
        }
        let shift = Vec3::new(by[0], by[1], by[2]);
        let turn = Vec3::new(by[3], by[4], by[5]) + scratch.arms[marker].cross(&shift);
        for k in 0..3 {
            scratch.gradient.push((place.first + k, shift[k]));
        }
        if place.freedoms == 6 {
            for k in 0..3 {
                scratch.gradient.push((place.first + 3 + k, turn[k]));
            }
        }
    }
}

/// Sums the entries of a gradient that belong to the same column, starting at index `first`. The resulting sparsity pattern is the same
/// every time.
fn merge(gradient: &mut Vec<(usize, f64)>, first: usize) {
    gradient[first..].sort_unstable_by_key(|entry| entry.0);
    let mut last = first;
    for at in first + 1..gradient.len() {
        if gradient[at].0 == gradient[last].0 {
            gradient[last].1 += gradient[at].1;
        } else {
            last += 1;
            gradient[last] = gradient[at];
        }
    }
    gradient.truncate(gradient.len().min(last + 1));
}

impl System {
    /// Returns the angle measures of functions whose full turns are counted, each with its index in `State::measure_angles`.
    pub fn counted_angles(&self) -> BTreeMap<Measure, usize> {
        let sources = self.functions.iter().flat_map(|function| &function.sources);
        let counted = sources.filter_map(|source| match source {
            Source::Measure(measure, angle) => Some((*measure, *angle)),
            _ => None,
        });
        counted
            .filter(|(measure, _)| measure.kind.counts_turns())
            .collect()
    }

    /// Copies the reference angles for counting full turns from an earlier version of the model into `state`. Copies every angle that the
    /// earlier version also counted, whichever function reads the angle. `counted` and `angles` are the
    /// [`counted_angles`](Self::counted_angles) and `State::measure_angles` of the earlier version.
    pub fn count_on(
        &self,
        state: &mut State,
        counted: &BTreeMap<Measure, usize>,
        angles: &[Reference],
    ) {
        for function in &self.functions {
            for source in &function.sources {
                if let Source::Measure(measure, angle) = source
                    && let Some(&old) = counted.get(measure)
                {
                    state.measure_angles[*angle] = angles[old];
                }
            }
        }
    }

    /// Updates the reference angles of functions to their values in an accepted equilibrium.
    pub(crate) fn count_measured_turns(&self, state: &mut State, scratch: &Scratch) {
        for function in &self.functions {
            for source in &function.sources {
                if let Source::Measure(measure, angle) = source {
                    let [i, j, k] = measured_poses(measure, scratch);
                    let reference = &mut state.measure_angles[*angle];
                    *reference = measure::next_reference(measure, &i, &j, &k, reference);
                }
            }
        }
    }
}

/// Returns the poses of I, J and K of a measure. The marker poses must already be computed.
fn measured_poses(measure: &Measure, scratch: &Scratch) -> [Pose; 3] {
    [measure.i, measure.j, measure.k]
        .map(|marker| marker.map_or_else(Pose::identity, |m| scratch.markers[m.0]))
}
