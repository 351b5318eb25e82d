use std::sync::Arc;

use super::interpolant::Interpolant;
use super::intrinsic::{self, Binary, Unary};
use super::step::{Shape, step};
use super::switch::{
    Piece, Seen, Switched, abs_on, dim_on, extreme_on, half_width, modulo_on, part_of, sign_on,
    stop_on, whole_on,
};
use super::{EvalError, Fault, Input, impact, series};

/// A FUNCTION expression compiled to a flat list of steps over numbered slots.
///
/// Slots hold, in this order, the inputs, the literals in use, the constants, and the results of the steps. Every step stores the
/// partial derivatives by its operands while it runs; going back over the steps that ran gives all derivatives at once (reverse
/// accumulation). Only the chosen branch of an IF runs.
#[derive(Clone, Debug)]
pub struct Program {
    /// The distinct state quantities it reads, in the order `eval` takes them.
    pub inputs: Vec<Input>,
    /// The literals it uses as values, as indices into `Expression::literals`; the others are ids and codes.
    pub parameters: Vec<usize>,
    pub(super) constants: Vec<f64>,
    pub(super) steps: Vec<Step>,
    pub(super) operands: Vec<u32>,
    pub(super) interpolants: Vec<(Arc<Interpolant>, usize)>,
    pub(super) slots: usize,
    pub(super) result: u32,
    pub(super) branches: bool,
    /// How many of its steps have pieces that a motion is held on.
    pub(super) switches: Vec<bool>,
}

/// The number of a step that is no switch.
pub(super) const NO_SWITCH: u32 = u32::MAX;

/// One step: its operands are `operands[first..first + count]`, its result goes to slot `target`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    pub(super) kind: Kind,
    pub(super) first: u32,
    pub(super) count: u32,
    pub(super) target: u32,
    /// Its number among those that have pieces, or [`NO_SWITCH`].
    pub(super) switch: u32,
}

/// What a step does.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    Negate,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    /// The function, and its name.
    Unary(Unary, &'static str),
    Binary(Binary, &'static str),
    Max,
    Min,
    Step(Shape, &'static str),
    Impact,
    Bistop,
    Poly,
    Shf,
    Forcos,
    Forsin,
    Cheby,
    Sweep,
    /// Which interpolant of the program, and the function's name.
    Interpolate(u32, &'static str),
    /// Goes on with the next step if the operand is negative, else jumps.
    Branch {
        zero: u32,
        positive: u32,
    },
    Jump(u32),
    /// The value of a branch becomes that of its IF.
    Move,
}

impl Kind {
    /// True for functions of several formulas of which the arguments choose one, but for those that change it at times known beforehand. The
    /// slopes are those of arguments that are linear in the time.
    pub(super) fn is_watched(self, mut slopes: impl Iterator<Item = Option<f64>>) -> bool {
        match self {
            Self::Impact | Self::Bistop => true,
            Self::Max
            | Self::Min
            | Self::Unary(Unary::Abs, _)
            | Self::Binary(Binary::Dim | Binary::Sign, _) => slopes.any(|slope| slope.is_none()),
            // A steady argument passes one piece after the other.
            Self::Unary(Unary::Nearest | Unary::Truncate, _) | Self::Binary(Binary::Modulo, _) => {
                slopes.any(|slope| slope != Some(0.0))
            }
            _ => false,
        }
    }

    fn failed(self, fault: Fault) -> EvalError {
        EvalError {
            function: self.name(),
            fault,
        }
    }

    /// As written in expressions.
    fn name(self) -> &'static str {
        match self {
            Self::Negate | Self::Subtract => "-",
            Self::Add => "+",
            Self::Multiply => "*",
            Self::Divide => "/",
            Self::Power => "**",
            Self::Unary(_, name)
            | Self::Binary(_, name)
            | Self::Step(_, name)
            | Self::Interpolate(_, name) => name,
            Self::Max => "MAX",
            Self::Min => "MIN",
            Self::Impact => "IMPACT",
            Self::Bistop => "BISTOP",
            Self::Poly => "POLY",
            Self::Shf => "SHF",
            Self::Forcos => "FORCOS",
            Self::Forsin => "FORSIN",
            Self::Cheby => "CHEBY",
            Self::Sweep => "SWEEP",
            Self::Branch { .. } | Self::Jump(_) | Self::Move => "IF",
        }
    }
}

/// Working memory of evaluations, shared by any number of programs. It grows to the largest and stays.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    pub(super) values: Vec<f64>,
    adjoints: Vec<f64>,
    pub(super) partials: Vec<f64>,
    arguments: Vec<f64>,
    pub(super) trace: Vec<u32>,
    blends: Vec<Blend>,
    seen: Vec<Seen>,
    /// Rates of all slots, from one call to the next.
    pub(super) rates: Vec<[f64; 2]>,
}

/// An IF that is held between its negative and its positive part while it is evaluated.
#[derive(Clone, Copy, Debug)]
struct Blend {
    /// Where its value goes, and where its derivative by the test.
    target: u32,
    by_test: usize,
    /// Where the positive part begins; none once it has.
    positive: Option<u32>,
    /// What each part counts, and how that changes with the test.
    weights: [f64; 2],
    slope: f64,
    /// The value of the negative part.
    negative: f64,
}

impl Scratch {
    /// What the last evaluation that was held on pieces saw of them.
    pub(crate) fn seen(&self) -> &[Seen] {
        &self.seen
    }

    fn fit(&mut self, program: &Program) {
        if self.values.len() < program.slots {
            self.values.resize(program.slots, 0.0);
            self.adjoints.resize(program.slots, 0.0);
        }
        if self.partials.len() < program.operands.len() {
            self.partials.resize(program.operands.len(), 0.0);
        }
        self.trace.clear();
    }
}

impl Program {
    /// True if an IF chooses between its parts.
    pub(crate) fn has_branches(&self) -> bool {
        self.branches
    }

    /// How many steps a motion can be held on pieces of: those of IMPACT, BISTOP, AINT, ANINT, MOD, and where not the time alone chooses, ABS,
    /// SIGN, DIM, MAX, MIN and IF. Of each, whether the time alone chooses its piece.
    pub(crate) fn switches(&self) -> &[bool] {
        &self.switches
    }

    /// Whether the value may jump where one of its switches changes, so that its sides can push against each other: SIGN and IF.
    pub(crate) fn may_jump(&self, switch: usize) -> bool {
        let steps = &self.steps;
        steps.iter().any(|step| {
            step.switch as usize == switch
                && matches!(
                    step.kind,
                    Kind::Branch { .. } | Kind::Binary(Binary::Sign, _)
                )
        })
    }

    /// The value at the given inputs (in the order of `inputs`) and literals (all of the expression, angles in radians).
    ///
    /// # Errors
    /// The function that has no value there, and why.
    pub fn eval(
        &self,
        inputs: &[f64],
        literals: &[f64],
        scratch: &mut Scratch,
    ) -> Result<f64, EvalError> {
        if self.steps.is_empty() {
            return Ok(self.plain(inputs, literals));
        }
        self.forward(inputs, literals, &[], scratch)
    }

    /// The value, and its derivatives by each input and by each literal (in radians for those in degrees); literals that are ids or
    /// codes have derivative zero.
    ///
    /// A derivative that is infinite at the very point (SQRT at 0, ASIN at 1) is taken as zero, so that an iteration can move on.
    ///
    /// # Errors
    /// As [`eval`](Self::eval).
    pub fn eval_with_derivatives(
        &self,
        inputs: &[f64],
        literals: &[f64],
        scratch: &mut Scratch,
        by_input: &mut [f64],
        by_literal: &mut [f64],
    ) -> Result<f64, EvalError> {
        self.eval_on_pieces(inputs, literals, &[], scratch, (by_input, by_literal))
    }

    /// The same with its switches held on these pieces, one each; with no pieces at all every switch is as its arguments have it. What is
    /// seen of the switches is left in the scratch.
    ///
    /// # Errors
    /// As [`eval`](Self::eval).
    pub(crate) fn eval_on_pieces(
        &self,
        inputs: &[f64],
        literals: &[f64],
        pieces: &[Piece],
        scratch: &mut Scratch,
        (by_input, by_literal): (&mut [f64], &mut [f64]),
    ) -> Result<f64, EvalError> {
        by_literal.fill(0.0);
        if self.steps.is_empty() {
            by_input.fill(0.0);
            let slot = self.result as usize;
            if slot < self.inputs.len() {
                by_input[slot] = 1.0;
            } else if let Some(&literal) = self.parameters.get(slot - self.inputs.len()) {
                by_literal[literal] = 1.0;
            }
            return Ok(self.plain(inputs, literals));
        }
        let value = self.forward(inputs, literals, pieces, scratch)?;
        self.backward(scratch);
        by_input.copy_from_slice(&scratch.adjoints[..self.inputs.len()]);
        for (k, &literal) in self.parameters.iter().enumerate() {
            by_literal[literal] = scratch.adjoints[self.inputs.len() + k];
        }
        Ok(value)
    }

    /// The result of a program without steps.
    fn plain(&self, inputs: &[f64], literals: &[f64]) -> f64 {
        let slot = self.result as usize;
        if let Some(&input) = inputs.get(slot) {
            return input;
        }
        let slot = slot - self.inputs.len();
        match self.parameters.get(slot) {
            Some(&literal) => literals[literal],
            None => self.constants[slot - self.parameters.len()],
        }
    }

    fn forward(
        &self,
        inputs: &[f64],
        literals: &[f64],
        pieces: &[Piece],
        scratch: &mut Scratch,
    ) -> Result<f64, EvalError> {
        scratch.fit(self);
        let Scratch {
            values,
            partials,
            arguments,
            trace,
            seen,
            blends,
            ..
        } = scratch;
        blends.clear();
        if !pieces.is_empty() {
            seen.clear();
            seen.resize(pieces.len(), Seen::NOTHING);
        }
        let (n, m) = (self.inputs.len(), self.parameters.len());
        values[..n].copy_from_slice(inputs);
        for (value, &literal) in values[n..n + m].iter_mut().zip(&self.parameters) {
            *value = literals[literal];
        }
        values[n + m..n + m + self.constants.len()].copy_from_slice(&self.constants);
        let mut at = 0;
        while let Some(step) = self.steps.get(at) {
            let range = step.first as usize..(step.first + step.count) as usize;
            let operands = &self.operands[range.clone()];
            let by_first = range.start;
            let by = &mut partials[range];
            let first = operands.first().map_or(0.0, |&slot| values[slot as usize]);
            if self.branches {
                trace.push(at as u32);
            }
            at += 1;
            let value = match step.kind {
                Kind::Branch { zero, positive } => {
                    let held = pieces.get(step.switch as usize);
                    let (part, saw) = part_of(first, held.copied().flatten());
                    at = [at, zero as usize, positive as usize][part as usize];
                    if held.is_some() {
                        seen[step.switch as usize] = saw;
                    }
                    by[0] = 0.0;
                    if let Some(width) = half_width(held.copied().flatten()) {
                        let share = 0.5 * first / width;
                        blends.push(Blend {
                            target: step.target,
                            by_test: by_first,
                            positive: Some(positive),
                            weights: [0.5 - share, 0.5 + share],
                            slope: 0.5 / width,
                            negative: 0.0,
                        });
                    }
                    continue;
                }
                Kind::Jump(to) => {
                    at = to as usize;
                    continue;
                }
                Kind::Move => match blends.last_mut() {
                    Some(blend) if blend.target == step.target => {
                        if let Some(positive) = blend.positive.take() {
                            at = positive as usize;
                            blend.negative = first;
                            by[0] = blend.weights[0];
                            blend.weights[0] * first
                        } else {
                            let Blend {
                                by_test,
                                weights: [_, weight],
                                slope,
                                negative,
                                ..
                            } = *blend;
                            by[0] = weight;
                            partials[by_test] = slope * (first - negative);
                            blends.pop();
                            values[step.target as usize] + weight * first
                        }
                    }
                    _ => {
                        by[0] = 1.0;
                        first
                    }
                },
                kind if (step.switch as usize) < pieces.len() => {
                    arguments.clear();
                    arguments.extend(operands.iter().map(|&slot| values[slot as usize]));
                    let held = pieces[step.switch as usize];
                    let switched =
                        held_on(kind, arguments, held, by).map_err(|fault| kind.failed(fault))?;
                    seen[step.switch as usize] = switched.seen;
                    switched.value
                }
                Kind::Negate => {
                    by[0] = -1.0;
                    -first
                }
                Kind::Unary(function, _) => {
                    let (value, slope) = function.at(first);
                    by[0] = slope;
                    value
                }
                Kind::Add
                | Kind::Subtract
                | Kind::Multiply
                | Kind::Divide
                | Kind::Power
                | Kind::Binary(..) => {
                    let second = values[operands[1] as usize];
                    let (value, slopes) = two(step.kind, first, second);
                    by.copy_from_slice(&slopes);
                    value
                }
                _ => {
                    arguments.clear();
                    arguments.extend(operands.iter().map(|&slot| values[slot as usize]));
                    self.call(step.kind, arguments, by)
                        .map_err(|fault| step.kind.failed(fault))?
                }
            };
            if !value.is_finite() {
                let undefined = value.is_nan() || step.kind == Kind::Divide;
                return Err(step.kind.failed(if undefined {
                    Fault::NotDefined
                } else {
                    Fault::TooLarge
                }));
            }
            values[step.target as usize] = value;
        }
        Ok(values[self.result as usize])
    }

    /// A function with more than two arguments.
    fn call(&self, kind: Kind, a: &[f64], by: &mut [f64]) -> Result<f64, Fault> {
        Ok(match kind {
            Kind::Max => intrinsic::extreme(true, a, by),
            Kind::Min => intrinsic::extreme(false, a, by),
            Kind::Step(shape, _) => step(shape, a, by)?,
            Kind::Impact => impact::impact(a, by)?,
            Kind::Bistop => impact::bistop(a, by)?,
            Kind::Poly => series::poly(a, by),
            Kind::Shf => series::shf(a, by),
            Kind::Forcos => series::fourier(false, a, by),
            Kind::Forsin => series::fourier(true, a, by),
            Kind::Cheby => series::cheby(a, by),
            Kind::Sweep => series::sweep(a, by)?,
            Kind::Interpolate(index, _) => {
                let (interpolant, order) = &self.interpolants[index as usize];
                let (value, slopes) =
                    interpolant.at(a[0], a.get(1).copied().unwrap_or(0.0), *order);
                by.copy_from_slice(&slopes[..by.len()]);
                value
            }
            _ => unreachable!("steps of one and two operands are evaluated in place"),
        })
    }

    /// Adjoints of all slots from the partial derivatives of the steps that ran.
    fn backward(&self, scratch: &mut Scratch) {
        let Scratch {
            adjoints,
            partials,
            trace,
            ..
        } = scratch;
        adjoints[..self.slots].fill(0.0);
        adjoints[self.result as usize] = 1.0;
        let mut pull = |step: &Step| {
            // What the chosen result does not depend on passes nothing back.
            let adjoint = adjoints[step.target as usize];
            if adjoint == 0.0 || matches!(step.kind, Kind::Jump(_)) {
                return;
            }
            let range = step.first as usize..(step.first + step.count) as usize;
            for (&slot, &partial) in self.operands[range.clone()].iter().zip(&partials[range]) {
                if partial.is_finite() {
                    adjoints[slot as usize] += adjoint * partial;
                }
            }
        };
        if self.branches {
            for &at in trace.iter().rev() {
                pull(&self.steps[at as usize]);
            }
        } else {
            for step in self.steps.iter().rev() {
                pull(step);
            }
        }
    }
}

/// A function that has pieces, on the one it is held on.
fn held_on(kind: Kind, a: &[f64], held: Piece, by: &mut [f64]) -> Result<Switched, Fault> {
    Ok(match kind {
        Kind::Max => extreme_on(true, a, held, by),
        Kind::Min => extreme_on(false, a, held, by),
        Kind::Unary(Unary::Nearest, _) => whole_on(true, a[0], held, by),
        Kind::Unary(Unary::Truncate, _) => whole_on(false, a[0], held, by),
        Kind::Unary(..) => abs_on(a[0], held, by),
        Kind::Binary(Binary::Modulo, _) => modulo_on(a[0], a[1], held, by),
        Kind::Binary(Binary::Dim, _) => dim_on(a[0], a[1], held, by),
        Kind::Binary(..) => sign_on(a[0], a[1], held, by),
        _ => return stop_on(a, held, by),
    })
}

fn two(kind: Kind, a: f64, b: f64) -> (f64, [f64; 2]) {
    match kind {
        Kind::Add => (a + b, [1.0, 1.0]),
        Kind::Subtract => (a - b, [1.0, -1.0]),
        Kind::Multiply => (a * b, [b, a]),
        Kind::Divide => {
            let value = a / b;
            (value, [1.0 / b, -value / b])
        }
        Kind::Power => intrinsic::power(a, b),
        Kind::Binary(function, _) => function.at(a, b),
        _ => unreachable!("only steps of two operands come here"),
    }
}
