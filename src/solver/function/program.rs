use super::intrinsic::{self, Binary, Unary};
use super::step::{Shape, step};
use super::switch::{
    Piece, SwitchState, Switched, abs_on, dim_on, extreme_on, half_width, modulo_on, part_of,
    sign_on, stop_on, whole_on,
};
use super::{Curves, EvalError, Fault, Input, impact, series};

/// FUNCTION expression compiled to a flat list of steps over numbered slots.
///
/// The slots hold, in this order, the inputs, the literals in use, the constants, and the results of the steps. While it runs, every step
/// stores its partial derivatives with respect to its operands. A backward pass over the executed steps then gives all derivatives at once
/// (reverse accumulation). Only the selected branch of an IF runs.
#[derive(Clone, Debug)]
pub struct Program {
    /// Distinct state quantities that the program reads, in the order in which `eval` takes them.
    pub inputs: Vec<Input>,
    /// Literals used as values, as indices into `Expression::literals`. The other literals are ids and codes.
    pub parameters: Vec<usize>,
    pub(super) constants: Vec<f64>,
    pub(super) steps: Vec<Instruction>,
    pub(super) operands: Vec<u32>,
    pub(super) lookups: Vec<Lookup>,
    pub(super) slots: usize,
    pub(super) result: u32,
    pub(super) branches: bool,
    /// True for each switch whose piece (active formula) depends on time alone. A switch is a step with several pieces; a simulation can hold it on
    /// one of them.
    pub(super) switches: Vec<bool>,
}

/// Literals and curves that a program reads in addition to its inputs.
#[derive(Clone, Copy, Debug)]
pub struct ProgramNumbers<'a> {
    /// All literals of the expression, angles in radians.
    pub literals: &'a [f64],
    /// Curves returned by the compiler that made the program.
    pub curves: &'a Curves,
}

/// Use of a SPLINE in a program.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) struct Lookup {
    /// Index in [`Curves`].
    pub(super) curve: usize,
    /// Order of the derivative.
    pub(super) order: usize,
}

/// Value of [`Instruction::switch`] for a step that is not a switch.
pub(super) const NO_SWITCH: u32 = u32::MAX;

/// Step of a program. Its operands are `operands[first..first + count]`; its result is stored in slot `target`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Instruction {
    pub(super) kind: Kind,
    pub(super) first: u32,
    pub(super) count: u32,
    pub(super) target: u32,
    /// Index of the step among the switches, or [`NO_SWITCH`].
    pub(super) switch: u32,
}

/// Operation that a step performs.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Kind {
    Negate,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    /// Function of one argument, with its name.
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
    /// Spline interpolation: index of the lookup in the program, and the function name.
    Interpolate(u32, &'static str),
    /// Conditional jump: continues with the next step if the operand is negative, otherwise jumps to `zero` or `positive`.
    Branch {
        zero: u32,
        positive: u32,
    },
    Jump(u32),
    /// Copies the value of a branch to the target of its IF.
    Move,
}

impl Kind {
    /// Returns whether a step must be watched as a switch: its function has several formulas, and the arguments select one of them. Steps
    /// whose switching times are known in advance are excluded. `slopes` holds the time slope of each argument; it is `None` for an
    /// argument that is not linear in time.
    pub(super) fn is_watched(self, mut slopes: impl Iterator<Item = Option<f64>>) -> bool {
        match self {
            Self::Impact | Self::Bistop => true,
            Self::Max
            | Self::Min
            | Self::Unary(Unary::Abs, _)
            | Self::Binary(Binary::Dim | Binary::Sign, _) => slopes.any(|slope| slope.is_none()),
            // An argument that varies linearly in time passes from piece to piece repeatedly.
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

    /// Returns the name as written in expressions.
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

/// Working memory of evaluations, shared by any number of programs. It grows to the largest program and is then reused.
#[derive(Clone, Debug, Default)]
pub struct EvaluationMemory {
    pub(super) values: Vec<f64>,
    adjoints: Vec<f64>,
    pub(super) partials: Vec<f64>,
    arguments: Vec<f64>,
    pub(super) trace: Vec<u32>,
    blends: Vec<Blend>,
    seen: Vec<SwitchState>,
    /// First and second time derivatives of all slots, kept to avoid reallocation.
    pub(super) rates: Vec<[f64; 2]>,
}

/// State of an IF that is held between its negative and its positive part during an evaluation.
#[derive(Clone, Copy, Debug)]
struct Blend {
    /// Target slot of the IF.
    target: u32,
    /// Index in `partials` of the derivative of the IF with respect to its test.
    by_test: usize,
    /// Start of the positive part; `None` once that part has started.
    positive: Option<u32>,
    /// Weights of the negative and the positive part.
    weights: [f64; 2],
    /// Derivative of the weight of the positive part with respect to the test.
    slope: f64,
    /// Value of the negative part.
    negative: f64,
}

impl ProgramNumbers<'static> {
    /// No literals and no curves.
    pub(super) const NONE: Self = Self {
        literals: &[],
        curves: &Curves::NONE,
    };
}

impl EvaluationMemory {
    /// Returns the observed switch states of the last evaluation with held pieces.
    pub(crate) fn seen(&self) -> &[SwitchState] {
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
    /// Returns whether the program contains an IF that selects between its parts.
    pub(crate) fn has_branches(&self) -> bool {
        self.branches
    }

    /// Returns, for each switch, whether its piece depends on time alone. A switch is a step with several formulas (pieces); a simulation can hold it
    /// on one of them. IMPACT, BISTOP, AINT, ANINT and MOD are always switches. ABS, SIGN, DIM, MAX, MIN and IF are switches unless their switching
    /// times are known in advance.
    pub(crate) fn switches(&self) -> &[bool] {
        &self.switches
    }

    /// Returns whether the function at a switch can jump (SIGN and IF). Both sides of a jump can push towards the switching point (sliding
    /// mode).
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

    /// Returns the value for the given inputs (in the order of `inputs`).
    ///
    /// # Errors
    /// Returns [`EvalError`] with the function that has no value for these inputs, and the reason.
    pub fn eval(
        &self,
        inputs: &[f64],
        numbers: ProgramNumbers<'_>,
        scratch: &mut EvaluationMemory,
    ) -> Result<f64, EvalError> {
        if self.steps.is_empty() {
            return Ok(self.plain(inputs, numbers.literals));
        }
        self.forward(inputs, numbers, &[], scratch)
    }

    /// Returns the value and its derivatives with respect to each input and each literal. For a literal in degrees, the derivative is per
    /// radian. Literals that are ids or codes have derivative zero.
    ///
    /// A derivative that is infinite at the evaluation point (SQRT at 0, ASIN at 1) is replaced by zero, so that an iteration can continue.
    ///
    /// # Errors
    /// Returns the errors of [`eval`](Self::eval).
    pub fn eval_with_derivatives(
        &self,
        inputs: &[f64],
        numbers: ProgramNumbers<'_>,
        scratch: &mut EvaluationMemory,
        by_input: &mut [f64],
        by_literal: &mut [f64],
    ) -> Result<f64, EvalError> {
        self.eval_on_pieces(inputs, numbers, &[], scratch, by_input, by_literal)
    }

    /// Returns the value and the derivatives like [`Self::eval_with_derivatives`], but holds each switch on its entry of `pieces`. If
    /// `pieces` is empty, the arguments select the piece of every switch. The observed switch states are left in `scratch`.
    ///
    /// # Errors
    /// Returns the errors of [`eval`](Self::eval).
    pub(crate) fn eval_on_pieces(
        &self,
        inputs: &[f64],
        numbers: ProgramNumbers<'_>,
        pieces: &[Piece],
        scratch: &mut EvaluationMemory,
        by_input: &mut [f64],
        by_literal: &mut [f64],
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
            return Ok(self.plain(inputs, numbers.literals));
        }
        let value = self.forward(inputs, numbers, pieces, scratch)?;
        self.backward(scratch);
        by_input.copy_from_slice(&scratch.adjoints[..self.inputs.len()]);
        for (k, &literal) in self.parameters.iter().enumerate() {
            by_literal[literal] = scratch.adjoints[self.inputs.len() + k];
        }
        Ok(value)
    }

    /// Returns the result of a program without steps.
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
        numbers: ProgramNumbers<'_>,
        pieces: &[Piece],
        scratch: &mut EvaluationMemory,
    ) -> Result<f64, EvalError> {
        scratch.fit(self);
        let EvaluationMemory {
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
            seen.resize(pieces.len(), SwitchState::NOTHING);
        }
        let (n, m) = (self.inputs.len(), self.parameters.len());
        values[..n].copy_from_slice(inputs);
        for (value, &literal) in values[n..n + m].iter_mut().zip(&self.parameters) {
            *value = numbers.literals[literal];
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
                    self.call(step.kind, arguments, numbers.curves, by)
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

    /// Evaluates a function that takes its arguments as a slice.
    fn call(&self, kind: Kind, a: &[f64], curves: &Curves, by: &mut [f64]) -> Result<f64, Fault> {
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
                let Lookup { curve, order } = self.lookups[index as usize];
                let z = a.get(1).copied().unwrap_or(0.0);
                let (value, slopes) = curves.get(curve).at(a[0], z, order);
                by.copy_from_slice(&slopes[..by.len()]);
                value
            }
            _ => unreachable!("steps of one and two operands are evaluated in place"),
        })
    }

    /// Returns whether the program reads a SPLINE, given by its index in the model.
    pub(crate) fn reads_spline(&self, curves: &Curves, spline: usize) -> bool {
        let mut lookups = self.lookups.iter();
        lookups.any(|lookup| curves.is_of(lookup.curve, spline))
    }

    /// Returns the derivative of the value with respect to the y value of a knot of a SPLINE, given by its index in the model. This program
    /// must have been evaluated with derivatives before, with the same curves and scratch.
    pub(crate) fn by_knot(
        &self,
        curves: &Curves,
        (spline, knot): (usize, usize),
        scratch: &EvaluationMemory,
    ) -> f64 {
        let mut sum = 0.0;
        for step in &self.steps {
            // Steps that do not run have the adjoint zero.
            let adjoint = scratch.adjoints[step.target as usize];
            if let Kind::Interpolate(index, _) = step.kind
                && adjoint != 0.0
            {
                let Lookup { curve, order } = self.lookups[index as usize];
                if curves.is_of(curve, spline) {
                    let x = scratch.values[self.operands[step.first as usize] as usize];
                    sum += adjoint * curves.get(curve).by_knot(knot, x, order);
                }
            }
        }
        sum
    }

    /// Computes the adjoints of all slots from the partial derivatives of the executed steps.
    fn backward(&self, scratch: &mut EvaluationMemory) {
        let EvaluationMemory {
            adjoints,
            partials,
            trace,
            ..
        } = scratch;
        adjoints[..self.slots].fill(0.0);
        adjoints[self.result as usize] = 1.0;
        let mut pull = |step: &Instruction| {
            // Slots that do not affect the result contribute nothing.
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

/// Evaluates a piecewise function on the piece `held`, or on the piece that the arguments select if `held` is `None`.
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
