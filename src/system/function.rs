//! FUNCTIONs in a configuration: values, and gradients by the unknowns.
//!
//! Knows how the inputs of a program hang on parts, multipliers, variables and states; not what the program computes.

use std::collections::BTreeMap;

use super::compiled_function::{CompiledFunction, Source};
use super::contribution::FunctionValue;
use super::{Configuration, NoValue, Reason, Scratch, State, System};
use crate::function::{Measure, MeasureKind, Piece, Program, RateMeasure, measure, rate};
use crate::mechanics::{Pose, Vec3, Vec6};
use crate::model::MarkerIx;

impl CompiledFunction {
    /// Zeros for the derivatives by inputs and literals.
    fn forget(&self, program: &Program, scratch: &mut Scratch) {
        scratch.by_input.clear();
        scratch.by_input.resize(program.inputs.len(), 0.0);
        scratch.by_literal.clear();
        scratch.by_literal.resize(self.literals.len(), 0.0);
    }

    /// Value of its program at the inputs in `scratch`, its switches held on these pieces, whose derivatives by inputs and literals are left there.
    pub(super) fn run(
        &self,
        program: &Program,
        theta: &[f64],
        pieces: &[Piece],
        scratch: &mut Scratch,
    ) -> Result<f64, NoValue> {
        self.forget(program, scratch);
        let value = program.eval_on_pieces(
            &scratch.inputs,
            &theta[self.literals.clone()],
            pieces,
            &mut scratch.program,
            (&mut scratch.by_input, &mut scratch.by_literal),
        );
        value.map_err(|error| NoValue {
            element: self.owner.clone(),
            reason: Reason::Function(error),
        })
    }
}

impl Configuration<'_> {
    /// Values and gradients of all functions of the equilibrium, into `scratch`.
    pub(super) fn evaluate_functions(&mut self) -> Result<(), NoValue> {
        self.scratch.gradient.clear();
        for &function in &self.system.order {
            self.evaluate_function(function)?;
        }
        Ok(())
    }

    /// Value and gradient of one function, into `scratch`; those it reads must be there.
    pub(super) fn evaluate_function(&mut self, number: usize) -> Result<(), NoValue> {
        let function = &self.system.functions[number];
        let first = self.scratch.gradient.len();
        let replacement = self.parameters.theta()[function.replacement];
        let replaced = !replacement.is_nan();
        let mut value = if replaced { replacement } else { 0.0 };
        if let Some(program) = &function.program {
            // The pattern of the gradient is the same whether the function is replaced or not.
            self.scratch.inputs.clear();
            self.scratch.spans.clear();
            for source in &function.sources {
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
                value = function.run(program, self.parameters.theta(), pieces, scratch)?;
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
        }
        self.scratch.functions[number] = FunctionValue {
            value,
            first,
            last: self.scratch.gradient.len(),
        };
        Ok(())
    }

    /// First and second rate of a function of the time and of variables that are such functions, at most so many one after the other; none of
    /// another function, and where a derivative does not exist.
    pub(super) fn rates_by_time(
        &mut self,
        number: usize,
        deep: usize,
    ) -> Result<Option<[f64; 2]>, NoValue> {
        let (system, state) = (self.system, self.state);
        let function = &system.functions[number];
        let replaced = !self.parameters.theta()[function.replacement].is_nan();
        let (Some(program), false) = (&function.program, replaced) else {
            return Ok(Some([0.0; 2]));
        };
        let mut inputs = Vec::with_capacity(function.sources.len());
        for source in &function.sources {
            inputs.push(match source {
                Source::Time => (state.time, [1.0, 0.0]),
                Source::Mode => (f64::from(state.mode), [0.0; 2]),
                Source::Constant(value) => (*value, [0.0; 2]),
                Source::Sensor(sensor) => {
                    (state.sensors.get(*sensor).copied().unwrap_or(0.0), [0.0; 2])
                }
                Source::Variable(k) if !system.variables[*k].active => {
                    (state.variables[*k], [0.0; 2])
                }
                Source::Variable(k) if deep > 0 => {
                    let read = system.variables[*k].function;
                    match self.rates_by_time(read, deep - 1)? {
                        Some(rates) => (state.variables[*k], rates),
                        None => return Ok(None),
                    }
                }
                _ => return Ok(None),
            });
        }
        let scratch = &mut *self.scratch;
        scratch.inputs.clear();
        scratch.inputs.extend(inputs.iter().map(|(value, _)| value));
        let pieces = state.pieces.get(function.switches.clone());
        let theta = self.parameters.theta();
        function.run(program, theta, pieces.unwrap_or_default(), scratch)?;
        let rates: Vec<[f64; 2]> = inputs.iter().map(|(_, rates)| *rates).collect();
        Ok(program.rates_along(&rates, &mut scratch.program))
    }

    /// Value of an input; its gradient is appended.
    fn source(&mut self, source: &Source) -> Result<f64, NoValue> {
        let (system, state, scratch) = (self.system, self.state, &mut *self.scratch);
        Ok(match source {
            Source::Time => {
                if state.moves() {
                    // The column of the time.
                    scratch.gradient.push((3 * system.moving_unknowns, 1.0));
                }
                state.time
            }
            Source::Moved(measure) => return Ok(self.moved(measure)),
            Source::Mode => f64::from(state.mode),
            Source::Constant(value) => *value,
            Source::Sensor(sensor) => state.sensors.get(*sensor).copied().unwrap_or(0.0),
            Source::Variable(variable) => {
                scratch
                    .gradient
                    .push((system.first_variable + variable, 1.0));
                state.variables[*variable]
            }
            Source::Through { variable, function } => {
                let value = scratch.functions[*function];
                let at = scratch.gradient.len();
                scratch.gradient.extend_from_within(value.first..value.last);
                if !system.variables[*variable].active {
                    // What is switched off is zero; the pattern of the gradient stays.
                    for (_, by) in &mut scratch.gradient[at..] {
                        *by = 0.0;
                    }
                    return Ok(0.0);
                }
                value.value
            }
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
                    value += d * state.variables[k];
                    scratch.gradient.push((system.first_variable + k, d));
                }
                value
            }
            Source::Measure(measure, angle) => {
                let measured = measured(measure, scratch, state.measure_angles[*angle]);
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

    /// A velocity or acceleration of markers; its gradient by positions, velocities and accelerations of the parts is appended.
    ///
    /// With r from the origin of the part to the marker, `dv = dV + dw x r + w x (dphi x r)` and
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

    /// Appends a gradient by the world motion of a marker, as one by the unknowns of its part.
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

impl System {
    /// The angles of functions whose turns are counted, each with its place in `State::measure_angles`.
    pub(crate) fn counted_angles(&self) -> BTreeMap<Measure, usize> {
        let sources = self.functions.iter().flat_map(|function| &function.sources);
        let counted = sources.filter_map(|source| match source {
            Source::Measure(measure, angle) => Some((*measure, *angle)),
            _ => None,
        });
        counted
            .filter(|(measure, _)| matches!(measure.kind, MeasureKind::ProjectedAngle(_)))
            .collect()
    }

    /// Counts turns on from those of a model before it was changed: of every angle that it counted too, whichever function asks for it.
    pub(crate) fn count_on(&self, state: &mut State, before: (&BTreeMap<Measure, usize>, &[f64])) {
        let (counted, angles) = before;
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

    /// Takes the angles that functions measure as those of an equilibrium.
    pub(crate) fn count_measured_turns(&self, state: &mut State, scratch: &Scratch) {
        for function in &self.functions {
            for source in &function.sources {
                if let Source::Measure(measure, angle) = source {
                    let reference = state.measure_angles[*angle];
                    state.measure_angles[*angle] = measured(measure, scratch, reference).value;
                }
            }
        }
    }
}

/// A measure in a configuration whose markers are placed.
fn measured(measure: &Measure, scratch: &Scratch, reference: f64) -> measure::Measured {
    let pose =
        |marker: Option<MarkerIx>| marker.map_or_else(Pose::identity, |m| scratch.markers[m.0]);
    measure::evaluate(
        measure,
        &pose(measure.i),
        &pose(measure.j),
        &pose(measure.k),
        reference,
    )
}
