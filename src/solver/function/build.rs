use std::collections::HashMap;

use super::breaks::linear;
use super::call::{refusal, vector_refusal};
use super::compiler::ExpressionCompiler;
use super::program::{Instruction, Kind, Lookup, NO_SWITCH, Program, ProgramNumbers};
use super::{EvaluationMemory, Input};
use admire_syntax::Expression;
use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::expression::{BinaryOperator, Constant, Node};

/// Location of a value during compilation, before the sizes of the tables are known.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) enum ValueSlot {
    Input(usize),
    Literal(usize),
    Constant(f64),
    Target(usize),
}

/// Compilation state of one expression.
pub(super) struct Build<'a> {
    pub(super) compiler: &'a ExpressionCompiler<'a>,
    pub(super) expression: &'a Expression,
    inputs: Vec<Input>,
    /// Index of each input in `inputs`.
    places: HashMap<Input, usize>,
    parameters: Vec<usize>,
    constants: Vec<f64>,
    /// Steps of the program. During compilation, their target slots are numbered from 0.
    steps: Vec<Instruction>,
    operands: Vec<ValueSlot>,
    pub(super) lookups: Vec<Lookup>,
    targets: usize,
    branches: bool,
    /// True for each switch whose piece (active formula) depends on time alone. A switch is a step with several pieces; a simulation can hold it on
    /// one of them.
    switches: Vec<bool>,
    /// Number of times that an input other than TIME has been read so far.
    pub(super) readings: usize,
}

impl<'a> Build<'a> {
    pub(super) fn new(compiler: &'a ExpressionCompiler<'a>, expression: &'a Expression) -> Self {
        Self {
            compiler,
            expression,
            inputs: Vec::new(),
            places: HashMap::new(),
            parameters: Vec::new(),
            constants: Vec::new(),
            steps: Vec::new(),
            operands: Vec::new(),
            lookups: Vec::new(),
            targets: 0,
            branches: false,
            switches: Vec::new(),
            readings: 0,
        }
    }

    pub(super) fn whole(mut self) -> Result<Program, Diagnostic> {
        let result = self.node(&self.expression.root)?;
        Ok(self.finish(result))
    }

    pub(super) fn node(&mut self, node: &Node) -> Result<ValueSlot, Diagnostic> {
        match node {
            Node::Literal(literal) => {
                // Every literal occurs once in the tree.
                self.parameters.push(*literal);
                Ok(ValueSlot::Literal(self.parameters.len() - 1))
            }
            Node::Constant(constant) => Ok(ValueSlot::Constant(match constant {
                Constant::Pi => std::f64::consts::PI,
                Constant::Rtod => 180.0 / std::f64::consts::PI,
                Constant::Dtor => std::f64::consts::PI / 180.0,
            })),
            Node::Name(function) => match function.name {
                "TIME" => Ok(self.input(Input::Time)),
                "MODE" => Ok(self.input(Input::Mode)),
                _ => Err(refusal(function)),
            },
            Node::Negate(inner) => {
                let inner = self.node(inner)?;
                Ok(self.step(Kind::Negate, &[inner]))
            }
            Node::Vector(_) => Err(vector_refusal()),
            Node::Binary(operator, left, right) => {
                let operands = [self.node(left)?, self.node(right)?];
                let kind = match operator {
                    BinaryOperator::Add => Kind::Add,
                    BinaryOperator::Subtract => Kind::Subtract,
                    BinaryOperator::Multiply => Kind::Multiply,
                    BinaryOperator::Divide => Kind::Divide,
                    BinaryOperator::Power => Kind::Power,
                    BinaryOperator::Cross => return Err(vector_refusal()),
                };
                Ok(self.step(kind, &operands))
            }
            Node::If(parts) => self.choice(parts),
            Node::Call {
                function,
                arguments,
                ..
            } => self.call(function, arguments),
        }
    }

    /// Compiles an IF: the test, then three parts of which only one is executed. Each part writes its value to the same target.
    fn choice(
        &mut self,
        [test, negative, zero, positive]: &[Node; 4],
    ) -> Result<ValueSlot, Diagnostic> {
        self.branches = true;
        // If the test is linear in time, the times of its zeros are known in advance.
        let known = linear(self.expression, test).is_some();
        let before = self.readings;
        let test = self.node(test)?;
        let of_time = self.readings == before;
        let branch = self.steps.len();
        let target = self.target();
        self.push(
            Kind::Branch {
                zero: 0,
                positive: 0,
            },
            &[test],
            target,
        );
        if !known {
            self.switch(of_time);
        }
        let mut starts = [0; 3];
        let mut jumps = Vec::new();
        for (part, start) in [negative, zero, positive].into_iter().zip(&mut starts) {
            *start = self.steps.len() as u32;
            let value = self.node(part)?;
            self.push(Kind::Move, &[value], target);
            jumps.push(self.steps.len());
            self.push(Kind::Jump(0), &[], 0);
        }
        let end = self.steps.len() as u32;
        for jump in jumps {
            self.steps[jump].kind = Kind::Jump(end);
        }
        self.steps[branch].kind = Kind::Branch {
            zero: starts[1],
            positive: starts[2],
        };
        Ok(ValueSlot::Target(target))
    }

    pub(super) fn input(&mut self, input: Input) -> ValueSlot {
        self.readings += usize::from(input != Input::Time);
        let next = self.inputs.len();
        let at = *self.places.entry(input).or_insert(next);
        if at == next {
            self.inputs.push(input);
        }
        ValueSlot::Input(at)
    }

    fn target(&mut self) -> usize {
        self.targets += 1;
        self.targets - 1
    }

    fn push(&mut self, kind: Kind, operands: &[ValueSlot], target: usize) {
        self.steps.push(Instruction {
            kind,
            first: self.operands.len() as u32,
            count: operands.len() as u32,
            target: target as u32,
            switch: NO_SWITCH,
        });
        self.operands.extend_from_slice(operands);
    }

    /// Marks the last pushed step as a switch: a step with several formulas (pieces), which a simulation can hold on one piece. `of_time` states
    /// whether the active piece depends on time alone.
    pub(super) fn switch(&mut self, of_time: bool) {
        let step = self.steps.last_mut().expect("a step was pushed");
        step.switch = self.switches.len() as u32;
        self.switches.push(of_time);
    }

    /// Adds a step with its own target. If all operands are constants and the value exists, the value is computed now and returned as a
    /// constant.
    pub(super) fn step(&mut self, kind: Kind, operands: &[ValueSlot]) -> ValueSlot {
        let constants: Vec<f64> = operands
            .iter()
            .map_while(|place| match place {
                ValueSlot::Constant(value) => Some(*value),
                _ => None,
            })
            .collect();
        // The points of a SPLINE can change.
        if constants.len() == operands.len()
            && !matches!(kind, Kind::Interpolate(..))
            && let Some(value) = fold(kind, &constants)
        {
            return ValueSlot::Constant(value);
        }
        let target = self.target();
        self.push(kind, operands, target);
        ValueSlot::Target(target)
    }

    fn finish(mut self, result: ValueSlot) -> Program {
        let (inputs, parameters) = (self.inputs.len(), self.parameters.len());
        for place in self.operands.iter().chain([&result]) {
            if let ValueSlot::Constant(value) = place {
                // Comparing bits keeps +0 and -0 apart.
                if !self
                    .constants
                    .iter()
                    .any(|c| c.to_bits() == value.to_bits())
                {
                    self.constants.push(*value);
                }
            }
        }
        let base = inputs + parameters + self.constants.len();
        let slot = |place: &ValueSlot| match place {
            ValueSlot::Input(index) => *index as u32,
            ValueSlot::Literal(index) => (inputs + index) as u32,
            ValueSlot::Constant(value) => {
                let index = self
                    .constants
                    .iter()
                    .position(|c| c.to_bits() == value.to_bits())
                    .expect("every constant was entered above");
                (inputs + parameters + index) as u32
            }
            ValueSlot::Target(index) => (base + index) as u32,
        };
        let operands = self.operands.iter().map(slot).collect();
        let result = slot(&result);
        for step in &mut self.steps {
            step.target += base as u32;
        }
        Program {
            slots: base + self.targets.max(1),
            inputs: self.inputs,
            parameters: self.parameters,
            constants: self.constants,
            steps: self.steps,
            operands,
            lookups: self.lookups,
            result,
            branches: self.branches,
            switches: self.switches,
        }
    }
}

/// Returns the value of a step whose operands are all constants, or `None` if the step is undefined for them.
fn fold(kind: Kind, constants: &[f64]) -> Option<f64> {
    let count = constants.len() as u32;
    let program = Program {
        inputs: Vec::new(),
        parameters: Vec::new(),
        constants: constants.to_vec(),
        steps: vec![Instruction {
            kind,
            first: 0,
            count,
            target: count,
            switch: NO_SWITCH,
        }],
        operands: (0..count).collect(),
        lookups: Vec::new(),
        slots: constants.len() + 1,
        result: count,
        branches: false,
        switches: Vec::new(),
    };
    program
        .eval(&[], ProgramNumbers::NONE, &mut EvaluationMemory::default())
        .ok()
}
