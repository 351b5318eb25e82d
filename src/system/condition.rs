use super::assemble::NoValue;
use super::chain::Sink;
use super::structure::Rate;
use super::{Parameters, Scratch, State, System, Twist};

impl System {
    /// Values and gradients of all functions of the equilibrium, into `scratch`.
    pub(crate) fn evaluate_functions(
        &self,
        parameters: &Parameters,
        _state: &State,
        scratch: &mut Scratch,
    ) -> Result<(), NoValue> {
        scratch.gradient.clear();
        for &k in &self.order {
            let function = &self.functions[k];
            let replacement = parameters.theta()[function.replacement];
            let value = if replacement.is_nan() {
                function.sign * parameters.theta()[function.literals]
            } else {
                replacement
            };
            scratch.functions[k].value = value;
        }
        Ok(())
    }

    /// GCONs.
    pub(crate) fn add_conditions<S: Sink>(
        &self,
        _parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        g: &mut [f64],
        sink: &mut S,
    ) -> Result<(), NoValue> {
        for condition in &self.conditions {
            let row = self.first_equation + condition.equation;
            let lambda = state.multipliers[condition.equation];
            let out = !condition.active || state.redundant.get(condition.equation) == Some(&true);
            sink.add(row, row, f64::from(u8::from(out)));
            let value = &scratch.functions[condition.function];
            g[row] = if out { lambda } else { value.value };
            let on = f64::from(u8::from(!out));
            for &(unknown, derivative) in &scratch.gradient[value.first..value.last] {
                sink.add(row, unknown, on * derivative);
                if unknown < self.first_equation {
                    g[unknown] -= on * lambda * derivative;
                    sink.add(unknown, row, -on * derivative);
                }
            }
        }
        Ok(())
    }

    /// Derivative of a function by one of its literals, the unknowns staying as they are.
    pub(crate) fn function_by_literal(
        &self,
        parameters: &Parameters,
        _state: &State,
        _scratch: &mut Scratch,
        function: usize,
        _literal: usize,
    ) -> Result<f64, NoValue> {
        let function = &self.functions[function];
        if parameters.theta()[function.replacement].is_nan() {
            Ok(function.sign)
        } else {
            Ok(0.0)
        }
    }

    /// Variables, rates and GCONs change with a function at this rate.
    pub(crate) fn data_by_function(
        &self,
        state: &State,
        _scratch: &mut Scratch,
        (function, rate): (usize, f64),
        dg: &mut [f64],
    ) {
        for (k, variable) in self.variables.iter().enumerate() {
            if variable.active && variable.function == function {
                dg[self.first_variable + k] -= rate;
            }
        }
        for equation in &self.states {
            if let (Rate::Function(f), Some(row)) = (&equation.rate, equation.unknown)
                && *f == function
            {
                dg[row] += rate;
            }
        }
        for condition in &self.conditions {
            if condition.active
                && condition.function == function
                && state.redundant.get(condition.equation) != Some(&true)
            {
                dg[self.first_equation + condition.equation] += rate;
            }
        }
    }

    /// Functions that measure a marker change when it moves on its part.
    pub(crate) fn functions_by_marker(
        &self,
        _parameters: &Parameters,
        _state: &State,
        _scratch: &mut Scratch,
        _moving: (usize, &Twist),
        _dg: &mut [f64],
    ) -> Result<(), NoValue> {
        Ok(())
    }
}
