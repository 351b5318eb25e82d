use std::cell::{OnceCell, RefCell};
use std::collections::BTreeMap;
use std::sync::Arc;

use super::interpolant::{Interpolant, Method};
use super::intrinsic::{Binary, Unary};
use super::program::{Kind, Program, Step};
use super::step::Shape;
use super::{
    ElementIx, ForceComponent, ForceMeasure, Input, Measure, MeasureKind, Scratch, Sequence,
};
use crate::diagnostic::{Code, Diagnostic};
use crate::grammar::{FunctionDef, Solved};
use crate::model::{ArrayKind, MarkerIx, Model, VectorForceKind};
use crate::syntax::Expression;
use crate::syntax::expression::{BinaryOperator, Constant, Node};

/// Compiles expressions against the objects of one model; looks ids up fast and shares prepared splines.
#[derive(Debug)]
pub struct Compiler<'m> {
    model: &'m Model,
    ids: [OnceCell<BTreeMap<u32, usize>>; Space::COUNT],
    interpolants: RefCell<BTreeMap<(usize, Method), Arc<Interpolant>>>,
}

/// A list of the model whose objects have ids of their own.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
enum Space {
    Marker,
    Variable,
    Diff,
    Array,
    Sensor,
    Spline,
    Beam,
    Bushing,
    Field,
    SpringDamper,
    Sforce,
    Gforce,
    Vforce,
    Vtorque,
    Nforce,
    Joint,
    Primitive,
    Motion,
}

impl Space {
    const COUNT: usize = Self::Motion as usize + 1;

    fn keyword(self) -> &'static str {
        match self {
            Self::Marker => "MARKER",
            Self::Variable => "VARIABLE",
            Self::Diff => "DIFF",
            Self::Array => "ARRAY",
            Self::Sensor => "SENSOR",
            Self::Spline => "SPLINE",
            Self::Beam => "BEAM",
            Self::Bushing => "BUSHING",
            Self::Field => "FIELD",
            Self::SpringDamper => "SPRINGDAMPER",
            Self::Sforce => "SFORCE",
            Self::Gforce => "GFORCE",
            Self::Vforce => "VFORCE",
            Self::Vtorque => "VTORQUE",
            Self::Nforce => "NFORCE",
            Self::Joint => "JOINT",
            Self::Primitive => "JPRIM",
            Self::Motion => "MOTION",
        }
    }

    fn index(self, model: &Model) -> BTreeMap<u32, usize> {
        macro_rules! ids {
            ($list:ident) => {
                model
                    .$list
                    .iter()
                    .enumerate()
                    .map(|(index, object)| (object.header.id, index))
                    .collect()
            };
        }
        let vector = |kind: VectorForceKind| {
            model
                .vector_forces
                .iter()
                .enumerate()
                .filter(|(_, force)| force.kind == kind)
                .map(|(index, force)| (force.header.id, index))
                .collect()
        };
        match self {
            Self::Marker => ids!(markers),
            Self::Variable => ids!(variables),
            Self::Diff => ids!(diffs),
            Self::Array => ids!(arrays),
            Self::Sensor => ids!(sensors),
            Self::Spline => ids!(splines),
            Self::Beam => ids!(beams),
            Self::Bushing => ids!(bushings),
            Self::Field => ids!(fields),
            Self::SpringDamper => ids!(springdampers),
            Self::Sforce => ids!(sforces),
            Self::Gforce => vector(VectorForceKind::Gforce),
            Self::Vforce => vector(VectorForceKind::Vforce),
            Self::Vtorque => vector(VectorForceKind::Vtorque),
            Self::Nforce => ids!(nforces),
            Self::Joint => ids!(joints),
            Self::Primitive => ids!(primitives),
            Self::Motion => ids!(motions),
        }
    }
}

impl<'m> Compiler<'m> {
    /// A compiler for the objects of `model`.
    pub fn new(model: &'m Model) -> Self {
        Self {
            model,
            ids: std::array::from_fn(|_| OnceCell::new()),
            interpolants: RefCell::default(),
        }
    }

    /// Compiles one expression.
    ///
    /// # Errors
    /// As [`Program::compile`].
    pub fn compile(&self, expression: &Expression) -> Result<Program, Diagnostic> {
        let mut build = Build {
            compiler: self,
            expression,
            inputs: Vec::new(),
            parameters: Vec::new(),
            constants: Vec::new(),
            steps: Vec::new(),
            operands: Vec::new(),
            interpolants: Vec::new(),
            targets: 0,
            branches: false,
        };
        let result = build.node(&expression.root)?;
        Ok(build.finish(result))
    }

    fn find(&self, space: Space, id: u32) -> Option<usize> {
        self.ids[space as usize]
            .get_or_init(|| space.index(self.model))
            .get(&id)
            .copied()
    }

    fn interpolant(&self, spline: usize, method: Method) -> Option<Arc<Interpolant>> {
        let mut prepared = self.interpolants.borrow_mut();
        if let Some(found) = prepared.get(&(spline, method)) {
            return Some(Arc::clone(found));
        }
        let made = Arc::new(Interpolant::new(&self.model.splines[spline], method)?);
        prepared.insert((spline, method), Arc::clone(&made));
        Some(made)
    }
}

/// Where a value stands while the sizes of the tables are not known yet.
#[derive(Clone, Copy, PartialEq, Debug)]
enum Place {
    Input(usize),
    Literal(usize),
    Constant(f64),
    Target(usize),
}

struct Build<'a> {
    compiler: &'a Compiler<'a>,
    expression: &'a Expression,
    inputs: Vec<Input>,
    parameters: Vec<usize>,
    constants: Vec<f64>,
    /// Steps with their targets counted from 0.
    steps: Vec<Step>,
    operands: Vec<Place>,
    interpolants: Vec<(Arc<Interpolant>, usize)>,
    targets: usize,
    branches: bool,
}

/// The arguments of a call.
type Arguments<'a> = &'a [Node];

impl Build<'_> {
    fn node(&mut self, node: &Node) -> Result<Place, Diagnostic> {
        match node {
            Node::Literal(literal) => {
                // Every literal stands once in the tree.
                self.parameters.push(*literal);
                Ok(Place::Literal(self.parameters.len() - 1))
            }
            Node::Constant(constant) => Ok(Place::Constant(match constant {
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
            Node::Binary(operator, left, right) => {
                let operands = [self.node(left)?, self.node(right)?];
                let kind = match operator {
                    BinaryOperator::Add => Kind::Add,
                    BinaryOperator::Subtract => Kind::Subtract,
                    BinaryOperator::Multiply => Kind::Multiply,
                    BinaryOperator::Divide => Kind::Divide,
                    BinaryOperator::Power => Kind::Power,
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

    /// IF: the test, then three pieces of which one runs; each moves its value to the same target.
    fn choice(
        &mut self,
        [test, negative, zero, positive]: &[Node; 4],
    ) -> Result<Place, Diagnostic> {
        self.branches = true;
        let test = self.node(test)?;
        let branch = self.steps.len();
        self.push(
            Kind::Branch {
                zero: 0,
                positive: 0,
            },
            &[test],
            0,
        );
        let target = self.target();
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
        Ok(Place::Target(target))
    }

    fn call(
        &mut self,
        function: &'static FunctionDef,
        arguments: Arguments,
    ) -> Result<Place, Diagnostic> {
        let name = function.name;
        if let Some(kind) = plain_kind(name) {
            let places = arguments
                .iter()
                .map(|argument| self.node(argument))
                .collect::<Result<Vec<_>, _>>()?;
            return Ok(self.step(kind, &places));
        }
        if let Some(kind) = measure_kind(name) {
            return self.measure(function, kind, arguments);
        }
        if let Some(component) = between_component(name) {
            let measure = ForceMeasure::Between {
                component,
                i: self.needed_marker(function, arguments, 0)?,
                j: self.marker(function, arguments, 1)?,
                k: self.marker(function, arguments, 2)?,
            };
            return Ok(self.input(Input::Force(measure)));
        }
        match name {
            // Everything is at rest in statics.
            "VX" | "VY" | "VZ" | "VM" | "VR" | "WX" | "WY" | "WZ" | "WM" | "ACCX" | "ACCY"
            | "ACCZ" | "ACCM" | "WDTX" | "WDTY" | "WDTZ" | "WDTM" => {
                for k in 0..arguments.len() {
                    self.marker(function, arguments, k)?;
                }
                Ok(Place::Constant(0.0))
            }
            "ORIENT" => self.orient(function, arguments),
            "AKISPL" => self.spline(function, Method::Akima, arguments),
            "CUBSPL" => self.spline(function, Method::Cubic, arguments),
            "INTERP" => self.interp(function, arguments),
            "VARVAL" => {
                let variable = self.object(function, arguments, 0, Space::Variable)?;
                Ok(self.input(Input::Variable(variable)))
            }
            "DIF" => {
                let diff = self.object(function, arguments, 0, Space::Diff)?;
                Ok(self.input(Input::Dif(diff)))
            }
            "DIF1" => {
                let diff = self.object(function, arguments, 0, Space::Diff)?;
                Ok(self.input(Input::DifRate(diff)))
            }
            "SENVAL" => {
                let sensor = self.object(function, arguments, 0, Space::Sensor)?;
                Ok(self.input(Input::SensorValue(sensor)))
            }
            "ARYVAL" => self.array(function, arguments),
            _ => self.element(function, arguments),
        }
    }

    fn measure(
        &mut self,
        function: &'static FunctionDef,
        kind: MeasureKind,
        arguments: Arguments,
    ) -> Result<Place, Diagnostic> {
        let measure = Measure {
            kind,
            i: self.marker(function, arguments, 0)?,
            j: self.marker(function, arguments, 1)?,
            k: self.marker(function, arguments, 2)?,
        };
        Ok(self.input(Input::Measure(measure)))
    }

    /// ORIENT(type, component, i[, j]).
    fn orient(
        &mut self,
        function: &'static FunctionDef,
        arguments: Arguments,
    ) -> Result<Place, Diagnostic> {
        let kind = self.whole(function, arguments, 0)?;
        let component = self.whole(function, arguments, 1)?;
        let count = if kind == 27 { 4 } else { 3 };
        if !(1..=count).contains(&component) {
            return Err(wrong(
                function,
                format!("component {component} is not one of 1 to {count}"),
            ));
        }
        let which = component as usize - 1;
        let kind = match (kind, Sequence::of_orient(kind)) {
            (27, _) => MeasureKind::EulerParameter(which),
            (_, Some(sequence)) => MeasureKind::Angle {
                sequence,
                which,
                minus: false,
            },
            _ => {
                return Err(Diagnostic::error(
                    Code::NotSolvedNatively,
                    format!("ORIENT of type {kind} is not evaluated by the built-in solver"),
                ));
            }
        };
        self.measure(function, kind, &arguments[2..])
    }

    /// AKISPL(x, z, id[, iord]) and CUBSPL.
    fn spline(
        &mut self,
        function: &'static FunctionDef,
        method: Method,
        arguments: Arguments,
    ) -> Result<Place, Diagnostic> {
        let x = self.node(&arguments[0])?;
        let z = self.node(&arguments[1])?;
        self.interpolate(function, method, &[x, z], arguments, 2)
    }

    /// INTERP(x, method, id[, iord]).
    fn interp(
        &mut self,
        function: &'static FunctionDef,
        arguments: Arguments,
    ) -> Result<Place, Diagnostic> {
        let method = match self.whole(function, arguments, 1)? {
            1 => Method::Linear,
            3 => Method::Cubic,
            other => {
                return Err(wrong(
                    function,
                    format!("method {other} is neither 1 (linear) nor 3 (cubic)"),
                ));
            }
        };
        let x = self.node(&arguments[0])?;
        self.interpolate(function, method, &[x], arguments, 2)
    }

    /// `id_at` is the place of the spline's id; the order of the derivative may follow.
    fn interpolate(
        &mut self,
        function: &'static FunctionDef,
        method: Method,
        operands: &[Place],
        arguments: Arguments,
        id_at: usize,
    ) -> Result<Place, Diagnostic> {
        let spline = self.object(function, arguments, id_at, Space::Spline)?;
        let id = self.compiler.model.splines[spline].header.id;
        let order = if arguments.len() > id_at + 1 {
            self.whole(function, arguments, id_at + 1)? as usize
        } else {
            0
        };
        let Some(interpolant) = self.compiler.interpolant(spline, method) else {
            return Err(wrong(
                function,
                format!("SPLINE/{id} has no strictly increasing x values with one y each"),
            ));
        };
        if order > 2 {
            return Err(wrong(
                function,
                format!("the order of the derivative is {order}, not 0, 1 or 2"),
            ));
        }
        if order > 0 && interpolant.is_surface() {
            return Err(wrong(
                function,
                format!("SPLINE/{id} is a surface, which has no derivatives here"),
            ));
        }
        self.interpolants.push((interpolant, order));
        let index = self.interpolants.len() as u32 - 1;
        Ok(self.step(Kind::Interpolate(index, function.name), operands))
    }

    /// ARYVAL(id, component).
    fn array(
        &mut self,
        function: &'static FunctionDef,
        arguments: Arguments,
    ) -> Result<Place, Diagnostic> {
        let array = self.object(function, arguments, 0, Space::Array)?;
        let component = self.whole(function, arguments, 1)?;
        let data = &self.compiler.model.arrays[array];
        let size = match &data.kind {
            ArrayKind::Numbers(numbers) => numbers.len(),
            ArrayKind::Variables(variables) => variables.len(),
            ArrayKind::States(size) | ArrayKind::Outputs(size) => *size,
        };
        let element = (component as usize).wrapping_sub(1);
        if element >= size {
            return Err(wrong(
                function,
                format!(
                    "ARRAY/{} has {size} elements, not {component}",
                    data.header.id
                ),
            ));
        }
        match &data.kind {
            ArrayKind::Numbers(numbers) => Ok(Place::Constant(numbers[element])),
            ArrayKind::Variables(variables) => {
                let id = variables[element];
                let variable = self
                    .compiler
                    .find(Space::Variable, id)
                    .ok_or_else(|| undefined(function, Space::Variable, id))?;
                Ok(self.input(Input::Variable(variable)))
            }
            ArrayKind::States(_) | ArrayKind::Outputs(_) => {
                Ok(self.input(Input::ArrayValue { array, element }))
            }
        }
    }

    /// BUSH(id, jflag, comp, rm) and its like; NFORCE(id, marker, comp, rm).
    fn element(
        &mut self,
        function: &'static FunctionDef,
        arguments: Arguments,
    ) -> Result<Place, Diagnostic> {
        let space = match function.name {
            "BEAM" => Space::Beam,
            "BUSH" => Space::Bushing,
            "FIELD" => Space::Field,
            "SPDP" => Space::SpringDamper,
            "SFORCE" => Space::Sforce,
            "GFORCE" => Space::Gforce,
            "VFORCE" => Space::Vforce,
            "VTORQ" => Space::Vtorque,
            "NFORCE" => Space::Nforce,
            "JOINT" => Space::Joint,
            "JPRIM" => Space::Primitive,
            "MOTION" => Space::Motion,
            _ => return Err(refusal(function)),
        };
        let index = self.object(function, arguments, 0, space)?;
        let mut on_j = false;
        let element = match space {
            Space::Beam => ElementIx::Beam(index),
            Space::Bushing => ElementIx::Bushing(index),
            Space::Field => ElementIx::Field(index),
            Space::SpringDamper => ElementIx::SpringDamper(index),
            Space::Sforce => ElementIx::Sforce(index),
            Space::Joint => ElementIx::Joint(index),
            Space::Primitive => ElementIx::Primitive(index),
            Space::Motion => ElementIx::Motion(index),
            Space::Nforce => ElementIx::Nforce {
                nforce: index,
                at: self.needed_marker(function, arguments, 1)?,
            },
            _ => ElementIx::VectorForce(index),
        };
        if space != Space::Nforce {
            on_j = match self.whole(function, arguments, 1)? {
                0 => false,
                1 => true,
                other => return Err(wrong(function, format!("jflag {other} is neither 0 nor 1"))),
            };
        }
        let component = self.whole(function, arguments, 2)?;
        let Some(&component) = (component as usize)
            .checked_sub(1)
            .and_then(|index| ForceComponent::ALL.get(index))
        else {
            return Err(wrong(
                function,
                format!("component {component} is not one of 1 to 8"),
            ));
        };
        let measure = ForceMeasure::Element {
            element,
            on_j,
            component,
            rm: self.marker(function, arguments, 3)?,
        };
        Ok(self.input(Input::Force(measure)))
    }

    /// The marker named by an argument; `None` if it is absent or 0, which is ground.
    fn marker(
        &self,
        function: &'static FunctionDef,
        arguments: Arguments,
        at: usize,
    ) -> Result<Option<MarkerIx>, Diagnostic> {
        if at >= arguments.len() {
            return Ok(None);
        }
        match self.whole(function, arguments, at)? {
            0 => Ok(None),
            id => self
                .compiler
                .find(Space::Marker, id)
                .map(|index| Some(MarkerIx(index)))
                .ok_or_else(|| undefined(function, Space::Marker, id)),
        }
    }

    fn needed_marker(
        &self,
        function: &'static FunctionDef,
        arguments: Arguments,
        at: usize,
    ) -> Result<MarkerIx, Diagnostic> {
        self.marker(function, arguments, at)?
            .ok_or_else(|| wrong(function, "a marker is needed here, not 0".to_string()))
    }

    fn object(
        &self,
        function: &'static FunctionDef,
        arguments: Arguments,
        at: usize,
        space: Space,
    ) -> Result<usize, Diagnostic> {
        let id = self.whole(function, arguments, at)?;
        self.compiler
            .find(space, id)
            .ok_or_else(|| undefined(function, space, id))
    }

    /// An argument that is an id or a code: a whole number that is not negative.
    fn whole(
        &self,
        function: &'static FunctionDef,
        arguments: Arguments,
        at: usize,
    ) -> Result<u32, Diagnostic> {
        let value = match arguments.get(at) {
            Some(Node::Literal(literal)) => self.expression.literals[*literal].value,
            _ => f64::NAN,
        };
        if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) {
            Ok(value as u32)
        } else {
            Err(Diagnostic::error(
                Code::WrongType,
                format!(
                    "argument {} of {}({}) has to be a whole number that is written out",
                    at + 1,
                    function.name,
                    function.arguments
                ),
            ))
        }
    }

    fn input(&mut self, input: Input) -> Place {
        Place::Input(position(&mut self.inputs, input))
    }

    fn target(&mut self) -> usize {
        self.targets += 1;
        self.targets - 1
    }

    fn push(&mut self, kind: Kind, operands: &[Place], target: usize) {
        self.steps.push(Step {
            kind,
            first: self.operands.len() as u32,
            count: operands.len() as u32,
            target: target as u32,
        });
        self.operands.extend_from_slice(operands);
    }

    /// A step with a result of its own; computed now if all operands are constants and the value exists.
    fn step(&mut self, kind: Kind, operands: &[Place]) -> Place {
        let constants: Vec<f64> = operands
            .iter()
            .map_while(|place| match place {
                Place::Constant(value) => Some(*value),
                _ => None,
            })
            .collect();
        if constants.len() == operands.len() {
            if let Some(value) = fold(kind, &constants, &self.interpolants) {
                return Place::Constant(value);
            }
        }
        let target = self.target();
        self.push(kind, operands, target);
        Place::Target(target)
    }

    fn finish(mut self, result: Place) -> Program {
        let (inputs, parameters) = (self.inputs.len(), self.parameters.len());
        for place in self.operands.iter().chain([&result]) {
            if let Place::Constant(value) = place {
                // Zeros of either sign are kept apart, hence the bits.
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
        let slot = |place: &Place| match place {
            Place::Input(index) => *index as u32,
            Place::Literal(index) => (inputs + index) as u32,
            Place::Constant(value) => {
                let index = self
                    .constants
                    .iter()
                    .position(|c| c.to_bits() == value.to_bits())
                    .expect("every constant was entered above");
                (inputs + parameters + index) as u32
            }
            Place::Target(index) => (base + index) as u32,
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
            interpolants: self.interpolants,
            result,
            branches: self.branches,
        }
    }
}

/// The value of one step of constants.
fn fold(kind: Kind, constants: &[f64], interpolants: &[(Arc<Interpolant>, usize)]) -> Option<f64> {
    let count = constants.len() as u32;
    let program = Program {
        inputs: Vec::new(),
        parameters: Vec::new(),
        constants: constants.to_vec(),
        steps: vec![Step {
            kind,
            first: 0,
            count,
            target: count,
        }],
        operands: (0..count).collect(),
        interpolants: interpolants.to_vec(),
        slots: constants.len() + 1,
        result: count,
        branches: false,
    };
    program.eval(&[], &[], &mut Scratch::default()).ok()
}

/// The index of an item in a list that holds each once.
fn position<T: PartialEq>(list: &mut Vec<T>, item: T) -> usize {
    list.iter()
        .position(|other| *other == item)
        .unwrap_or_else(|| {
            list.push(item);
            list.len() - 1
        })
}

/// Functions whose arguments are all values.
fn plain_kind(name: &'static str) -> Option<Kind> {
    if let Some(function) = Unary::named(name) {
        return Some(Kind::Unary(function, name));
    }
    if let Some(function) = Binary::named(name) {
        return Some(Kind::Binary(function, name));
    }
    Some(match name {
        "MAX" => Kind::Max,
        "MIN" => Kind::Min,
        "STEP" => Kind::Step(Shape::Cubic, name),
        "STEP5" => Kind::Step(Shape::Quintic, name),
        "HAVSIN" => Kind::Step(Shape::Haversine, name),
        "IMPACT" => Kind::Impact,
        "BISTOP" => Kind::Bistop,
        "POLY" => Kind::Poly,
        "SHF" => Kind::Shf,
        "FORCOS" => Kind::Forcos,
        "FORSIN" => Kind::Forsin,
        "CHEBY" => Kind::Cheby,
        "SWEEP" => Kind::Sweep,
        _ => return None,
    })
}

fn measure_kind(name: &str) -> Option<MeasureKind> {
    let angle = |sequence, which, minus| MeasureKind::Angle {
        sequence,
        which,
        minus,
    };
    Some(match name {
        "DX" => MeasureKind::Displacement(0),
        "DY" => MeasureKind::Displacement(1),
        "DZ" => MeasureKind::Displacement(2),
        "DM" => MeasureKind::Distance,
        "AX" => MeasureKind::ProjectedAngle(0),
        "AY" => MeasureKind::ProjectedAngle(1),
        "AZ" => MeasureKind::ProjectedAngle(2),
        "PSI" => angle(Sequence::BODY_313, 0, false),
        "THETA" => angle(Sequence::BODY_313, 1, false),
        "PHI" => angle(Sequence::BODY_313, 2, false),
        "YAW" => angle(Sequence::BODY_321, 0, false),
        "PITCH" => angle(Sequence::BODY_321, 1, true),
        "ROLL" => angle(Sequence::BODY_321, 2, false),
        "INCANG" => MeasureKind::IncludedAngle,
        _ => return None,
    })
}

fn between_component(name: &str) -> Option<ForceComponent> {
    let names = ["FM", "FX", "FY", "FZ", "TM", "TX", "TY", "TZ"];
    names
        .iter()
        .position(|known| *known == name)
        .map(|index| ForceComponent::ALL[index])
}

fn undefined(function: &FunctionDef, space: Space, id: u32) -> Diagnostic {
    Diagnostic::error(
        Code::UndefinedId,
        format!(
            "{}/{id}, which {} refers to, is not defined",
            space.keyword(),
            function.name
        ),
    )
}

fn wrong(function: &FunctionDef, what: String) -> Diagnostic {
    Diagnostic::error(
        Code::BadExpression,
        format!("{}({}): {what}", function.name, function.arguments),
    )
}

/// Why a function is not evaluated here.
fn refusal(function: &FunctionDef) -> Diagnostic {
    if function.name == "USER" {
        return Diagnostic::error(
            Code::UserSubroutine,
            "USER calls a user-written subroutine, and only as the whole of a FUNCTION",
        );
    }
    let why = match function.solved {
        Solved::External(why) | Solved::NoEffect(why) => why,
        Solved::Native(_) => "the built-in solver does not evaluate it",
    };
    Diagnostic::error(Code::NotSolvedNatively, format!("{}: {why}", function.name))
        .help("use a command backend that runs ADAMS, or replace the function")
}
