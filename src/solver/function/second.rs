//! Second time derivatives of programs, given the time derivatives of their inputs.

use super::intrinsic::{Binary, Unary};
use super::program::{EvaluationMemory, Kind, Lookup, Program};
use super::{Curves, series};

/// First and second time derivative of a quantity.
pub(crate) type TimeRates = [f64; 2];

impl Program {
    /// Returns the exact first and second time derivatives of the value, given the time derivatives of the inputs. This program must have
    /// been evaluated before with the same curves and scratch.
    ///
    /// For a step `f(a, b, ..)` the time derivatives are `f_a a' + ..` and `f_a a'' + .. + f_aa a' a' + 2 f_ab a' b' + ..`. At a kink, they
    /// belong to the side whose derivatives the evaluation returned. Returns `None` where a step has no second derivatives.
    pub(crate) fn rates_along(
        &self,
        inputs: &[TimeRates],
        curves: &Curves,
        scratch: &mut EvaluationMemory,
    ) -> Option<TimeRates> {
        if self.steps.is_empty() {
            return Some(
                inputs
                    .get(self.result as usize)
                    .copied()
                    .unwrap_or([0.0; 2]),
            );
        }
        let mut slots = std::mem::take(&mut scratch.rates);
        slots.clear();
        slots.extend_from_slice(inputs);
        slots.resize(self.slots, [0.0; 2]);
        let mut arguments = Vec::new();
        let mut found = true;
        let mut pass = |at: usize| {
            let step = &self.steps[at];
            if matches!(step.kind, Kind::Branch { .. } | Kind::Jump(_)) {
                return;
            }
            let range = step.first as usize..(step.first + step.count) as usize;
            let operands = &self.operands[range.clone()];
            let by = &scratch.partials[range];
            arguments.clear();
            let taken = operands.iter().map(|&slot| slot as usize);
            arguments.extend(taken.map(|slot| (scratch.values[slot], slots[slot])));
            let mut rates = [0.0; 2];
            for (by, (_, [first, second])) in by.iter().zip(&arguments) {
                // An infinite partial derivative contributes only if its argument varies in time.
                for (rate, along) in rates.iter_mut().zip([first, second]) {
                    *rate += if *along == 0.0 { 0.0 } else { by * along };
                }
            }
            if arguments.iter().any(|(_, [first, _])| *first != 0.0) {
                match self.second_order_term(step.kind, curves, &arguments) {
                    Some(bend) => rates[1] += bend,
                    None => found = false,
                }
            }
            found &= rates[0].is_finite() && rates[1].is_finite();
            slots[step.target as usize] = rates;
        };
        if self.branches {
            scratch.trace.iter().for_each(|&at| pass(at as usize));
        } else {
            (0..self.steps.len()).for_each(&mut pass);
        }
        let rates = slots[self.result as usize];
        scratch.rates = slots;
        found.then_some(rates)
    }

    /// Returns `f_aa a' a' + 2 f_ab a' b' + ..` of a step, from the values and time derivatives of its arguments.
    fn second_order_term(
        &self,
        kind: Kind,
        curves: &Curves,
        arguments: &[(f64, TimeRates)],
    ) -> Option<f64> {
        let (x, [dx, _]) = arguments[0];
        let (y, [dy, _]) = arguments.get(1).copied().unwrap_or_default();
        // True if all arguments after the first are constant in time.
        let alone = arguments[1..].iter().all(|(_, [first, _])| *first == 0.0);
        let values = || -> Vec<f64> { arguments.iter().map(|(value, _)| *value).collect() };
        let of_first = |second: f64| alone.then_some(second * dx * dx);
        Some(match kind {
            Kind::Negate
            | Kind::Add
            | Kind::Subtract
            | Kind::Move
            | Kind::Max
            | Kind::Min
            | Kind::Binary(Binary::Dim | Binary::Modulo | Binary::Sign, _)
            | Kind::Branch { .. }
            | Kind::Jump(_) => 0.0,
            Kind::Binary(Binary::Atan2, _) => {
                let square = x * x + y * y;
                if square == 0.0 {
                    return None;
                }
                (2.0 * x * y * (dy * dy - dx * dx) + 2.0 * (x * x - y * y) * dx * dy)
                    / (square * square)
            }
            Kind::Multiply => 2.0 * dx * dy,
            Kind::Divide => 2.0 * dy * (x / y * dy - dx) / (y * y),
            Kind::Power => {
                let by_x = if dx == 0.0 || y == 0.0 || y == 1.0 {
                    0.0
                } else {
                    y * (y - 1.0) * libm::pow(x, y - 2.0) * dx * dx
                };
                if dy == 0.0 {
                    by_x
                } else if x > 0.0 {
                    let log = libm::log(x);
                    let mixed = libm::pow(x, y - 1.0) * (1.0 + y * log);
                    by_x + 2.0 * mixed * dx * dy + libm::pow(x, y) * log * log * dy * dy
                } else {
                    return None;
                }
            }
            Kind::Unary(function, _) => second(function, x) * dx * dx,
            Kind::Step(shape, _) => {
                let ends_stand = arguments[1].1[0] == 0.0 && arguments[3].1[0] == 0.0;
                let (x0, x1) = (arguments[1].0, arguments[3].0);
                let width = x1 - x0;
                let u = (x - x0) / width;
                if !ends_stand {
                    return None;
                }
                if u <= 0.0 || u >= 1.0 {
                    return Some(0.0);
                }
                let rise = arguments[4].0 - arguments[2].0;
                let rising = arguments[4].1[0] - arguments[2].1[0];
                let along = dx / width;
                rise * shape.second(u) * along * along + 2.0 * rising * shape.at(u).1 * along
            }
            Kind::Poly => return of_first(series::poly_second(&values())),
            Kind::Cheby => return of_first(series::cheby_second(&values())),
            Kind::Forcos => return of_first(series::fourier_second(false, &values())),
            Kind::Forsin => return of_first(series::fourier_second(true, &values())),
            Kind::Shf => {
                let (a, w, phi) = (arguments[2].0, arguments[3].0, arguments[4].0);
                return of_first(-a * w * w * libm::sin(w * (x - y) - phi));
            }
            Kind::Interpolate(index, _) => {
                let Lookup { curve, order } = self.lookups[index as usize];
                let (_, [by_x, by_z]) = curves.get(curve).at(x, y, order + 1);
                by_x * dx * dx + 2.0 * by_z * dx * dy
            }
            Kind::Sweep => return of_first(series::sweep_second(&values())),
            Kind::Impact | Kind::Bistop => return None,
        })
    }
}

/// Returns the second derivative of a function of one argument; zero at kinks and jumps.
fn second(function: Unary, x: f64) -> f64 {
    let (value, slope) = function.at(x);
    match function {
        Unary::Abs | Unary::Nearest | Unary::Truncate => 0.0,
        Unary::Acos | Unary::Asin => x * slope.powi(3),
        Unary::Atan => -2.0 * x * slope * slope,
        Unary::Cos | Unary::Sin => -value,
        Unary::Cosh | Unary::Exp | Unary::Sinh => value,
        Unary::Ln | Unary::Log10 => -slope / x,
        Unary::Sqrt => -0.5 * slope / x,
        Unary::Tan => 2.0 * value * slope,
        Unary::Tanh => -2.0 * value * slope,
    }
}
