use super::breaks::linear;
use super::build::{Build, ValueSlot};
use super::called::{between_component, measure_kind, plain_kind, rate_of, rate_places};
use super::compiler::Space;
use super::curves::CurveForm;
use super::input::FRICTION_NUMBERS;
use super::interpolant::Method;
use super::program::{Kind, Lookup};
use super::{
    ForceComponent, ForceMeasure, Input, Measure, MeasureKind, MeasuredElement, RateMeasure,
    RotationSequence,
};
use crate::model::{ArrayKind, MarkerIx};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::expression::Node;
use admire_syntax::grammar;
use admire_syntax::grammar::{FunctionDef, Solved};

/// Argument nodes of a function call.
type Arguments<'a> = &'a [Node];

impl Build<'_> {
    pub(super) fn call(
        &mut self,
        function: &'static FunctionDef,
        arguments: Arguments,
    ) -> Result<ValueSlot, Diagnostic> {
        let name = function.name;
        if let Some(kind) = plain_kind(name) {
            let before = self.readings;
            let places = arguments
                .iter()
                .map(|argument| self.node(argument))
                .collect::<Result<Vec<_>, _>>()?;
            let of_time = self.readings == before;
            let place = self.step(kind, &places);
            // If a piece depends on time alone, its switching times are known in advance, unless the function switches repeatedly.
            let slope = |argument| linear(self.expression, argument).map(|(slope, _)| slope);
            let watched = kind.is_watched(arguments.iter().map(slope));
            if watched && matches!(place, ValueSlot::Target(_)) {
                self.switch(of_time);
            }
            return Ok(place);
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
            name if rate_of(name).is_some() => self.rate(function, arguments),
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
            "PINVAL" => self.plant(function, arguments, Space::PlantInput),
            "POUVAL" => self.plant(function, arguments, Space::PlantOutput),
            "ARYVAL" => self.array(function, arguments),
            "FRICTION" => self.friction(function, arguments),
            _ => self.element(function, arguments),
        }
    }

    /// Compiles VX(i, j, k, l) and the other velocity and acceleration functions. Argument l is the frame of the time derivative.
    fn rate(
        &mut self,
        function: &'static FunctionDef,
        arguments: Arguments,
    ) -> Result<ValueSlot, Diagnostic> {
        let (kind, axis) = rate_of(function.name).ok_or_else(|| refusal(function))?;
        let mut markers = [None; 4];
        for (at, place) in (0..arguments.len()).zip(rate_places(kind, axis)) {
            markers[*place] = self.marker(function, arguments, at)?;
        }
        Ok(self.input(Input::Rate(RateMeasure {
            kind,
            axis,
            markers,
        })))
    }

    fn measure(
        &mut self,
        function: &'static FunctionDef,
        kind: MeasureKind,
        arguments: Arguments,
    ) -> Result<ValueSlot, Diagnostic> {
        let measure = Measure {
            kind,
            i: self.marker(function, arguments, 0)?,
            j: self.marker(function, arguments, 1)?,
            k: self.marker(function, arguments, 2)?,
        };
        Ok(self.input(Input::Measure(measure)))
    }

    /// Compiles ORIENT(type, component, i[, j]).
    fn orient(
        &mut self,
        function: &'static FunctionDef,
        arguments: Arguments,
    ) -> Result<ValueSlot, Diagnostic> {
        let kind = self.code_or_id(function, arguments, 0)?;
        let component = self.code_or_id(function, arguments, 1)?;
        let count = RotationSequence::components_of_orient(kind);
        if !(1..=count).contains(&component) {
            return Err(wrong(
                function,
                format!("component {component} is outside 1 to {count}"),
            ));
        }
        let which = component as usize - 1;
        let kind = match (kind, RotationSequence::of_orient(kind)) {
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

    /// Compiles AKISPL(x, z, id[, iord]) and CUBSPL.
    fn spline(
        &mut self,
        function: &'static FunctionDef,
        method: Method,
        arguments: Arguments,
    ) -> Result<ValueSlot, Diagnostic> {
        let x = self.node(&arguments[0])?;
        let z = self.node(&arguments[1])?;
        self.interpolate(function, method, &[x, z], arguments, 2)
    }

    /// Compiles INTERP(x, method, id[, iord]).
    fn interp(
        &mut self,
        function: &'static FunctionDef,
        arguments: Arguments,
    ) -> Result<ValueSlot, Diagnostic> {
        let method = match self.code_or_id(function, arguments, 1)? {
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

    /// Compiles a spline lookup. `id_at` is the position of the spline's id; the order of the derivative may follow it.
    fn interpolate(
        &mut self,
        function: &'static FunctionDef,
        method: Method,
        operands: &[ValueSlot],
        arguments: Arguments,
        id_at: usize,
    ) -> Result<ValueSlot, Diagnostic> {
        let spline = self.object(function, arguments, id_at, Space::Spline)?;
        let id = self.compiler.model.splines[spline].header.id;
        let order = if arguments.len() > id_at + 1 {
            self.code_or_id(function, arguments, id_at + 1)? as usize
        } else {
            0
        };
        let Some(curve) = self.compiler.curve(spline, CurveForm::By(method)) else {
            return Err(wrong(
                function,
                format!("SPLINE/{id} needs strictly increasing x values with one y for each x"),
            ));
        };
        if order > 2 {
            return Err(wrong(
                function,
                format!("the order of the derivative is {order}, not 0, 1 or 2"),
            ));
        }
        if order > 0 && self.compiler.model.splines[spline].is_surface() {
            return Err(wrong(
                function,
                format!(
                    "SPLINE/{id} is a surface, whose derivatives the built-in solver does not evaluate"
                ),
            ));
        }
        self.lookups.push(Lookup { curve, order });
        let index = self.lookups.len() as u32 - 1;
        Ok(self.step(Kind::Interpolate(index, function.name), operands))
    }

    /// Compiles ARYVAL(id, component).
    fn array(
        &mut self,
        function: &'static FunctionDef,
        arguments: Arguments,
    ) -> Result<ValueSlot, Diagnostic> {
        let array = self.object(function, arguments, 0, Space::Array)?;
        let component = self.code_or_id(function, arguments, 1)?;
        let data = &self.compiler.model.arrays[array];
        let size = self.compiler.model.array_size(data);
        let element = (component as usize).wrapping_sub(1);
        if element >= size {
            return Err(wrong(
                function,
                format!(
                    "element {component} is outside ARRAY/{}, whose size is {size}",
                    data.header.id
                ),
            ));
        }
        match &data.kind {
            ArrayKind::Numbers(numbers) => Ok(ValueSlot::Constant(numbers[element])),
            ArrayKind::Variables(variables) => {
                let id = variables[element];
                let variable = self
                    .compiler
                    .find(Space::Variable, id)
                    .ok_or_else(|| undefined(function, Space::Variable.keyword(), id))?;
                Ok(self.input(Input::Variable(variable)))
            }
            ArrayKind::States(_) | ArrayKind::Outputs(_) => {
                Ok(self.input(Input::ArrayValue { array, element }))
            }
        }
    }

    /// Compiles FRICTION(id, index).
    fn friction(
        &mut self,
        function: &'static FunctionDef,
        arguments: Arguments,
    ) -> Result<ValueSlot, Diagnostic> {
        let friction = self.object(function, arguments, 0, Space::Friction)?;
        let index = self.code_or_id(function, arguments, 1)?;
        if !(1..=FRICTION_NUMBERS).contains(&index) {
            return Err(wrong(
                function,
                format!("index {index} is outside 1 to {FRICTION_NUMBERS}"),
            ));
        }
        let which = index as usize - 1;
        Ok(self.input(Input::Friction { friction, which }))
    }

    /// Compiles PINVAL(id, component) and POUVAL, which read a VARIABLE listed in a PINPUT or POUTPUT.
    fn plant(
        &mut self,
        function: &'static FunctionDef,
        arguments: Arguments,
        space: Space,
    ) -> Result<ValueSlot, Diagnostic> {
        let list = self.object(function, arguments, 0, space)?;
        let component = self.code_or_id(function, arguments, 1)?;
        let list = &self.compiler.model.plant_ports[list];
        let Some(&id) = (component as usize)
            .checked_sub(1)
            .and_then(|index| list.variables.get(index))
        else {
            return Err(wrong(
                function,
                format!(
                    "component {component} is outside {}/{}, whose number of variables is {}",
                    list.kind,
                    list.header.id,
                    list.variables.len()
                ),
            ));
        };
        let variable = self
            .compiler
            .find(Space::Variable, id)
            .ok_or_else(|| undefined(function, Space::Variable.keyword(), id))?;
        Ok(self.input(Input::Variable(variable)))
    }

    /// Compiles NFORCE(id, marker, comp, rm), BUSH(id, jflag, comp, rm) and the functions of other elements with the same arguments as
    /// BUSH.
    fn element(
        &mut self,
        function: &'static FunctionDef,
        arguments: Arguments,
    ) -> Result<ValueSlot, Diagnostic> {
        let pair = grammar::statement(function.name).filter(|def| !def.laws.is_empty());
        if let Some(def) = pair {
            let id = self.code_or_id(function, arguments, 0)?;
            let found = self.compiler.find_pair_force(def.name, id);
            let index = found.ok_or_else(|| undefined(function, def.name, id))?;
            let on_j = self.on_j(function, arguments)?;
            return self.force_of(
                function,
                arguments,
                (MeasuredElement::PairForce(index), on_j),
            );
        }
        let space = match function.name {
            "BUSH" => Space::Bushing,
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
            Space::Bushing => MeasuredElement::Bushing(index),
            Space::SpringDamper => MeasuredElement::SpringDamper(index),
            Space::Sforce => MeasuredElement::Sforce(index),
            Space::Joint => MeasuredElement::Joint(index),
            Space::Primitive => MeasuredElement::Primitive(index),
            Space::Motion => MeasuredElement::Motion(index),
            Space::Nforce => MeasuredElement::Nforce {
                nforce: index,
                at: self.needed_marker(function, arguments, 1)?,
            },
            _ => MeasuredElement::VectorForce(index),
        };
        if space != Space::Nforce {
            on_j = self.on_j(function, arguments)?;
        }
        self.force_of(function, arguments, (element, on_j))
    }

    /// Returns the jflag argument of a force function: whether the force on J is measured.
    fn on_j(
        &self,
        function: &'static FunctionDef,
        arguments: Arguments,
    ) -> Result<bool, Diagnostic> {
        match self.code_or_id(function, arguments, 1)? {
            0 => Ok(false),
            1 => Ok(true),
            other => Err(wrong(function, format!("jflag {other} is neither 0 nor 1"))),
        }
    }

    /// Compiles the force component of an element. The component and the marker `rm` are the last two arguments of the force function.
    fn force_of(
        &mut self,
        function: &'static FunctionDef,
        arguments: Arguments,
        (element, on_j): (MeasuredElement, bool),
    ) -> Result<ValueSlot, Diagnostic> {
        let component = self.code_or_id(function, arguments, 2)?;
        let Some(&component) = (component as usize)
            .checked_sub(1)
            .and_then(|index| ForceComponent::ALL.get(index))
        else {
            return Err(wrong(
                function,
                format!("component {component} is outside 1 to 8"),
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

    /// Returns the marker given by an argument. Returns `None`, which denotes ground, if the argument is absent or 0.
    fn marker(
        &self,
        function: &'static FunctionDef,
        arguments: Arguments,
        at: usize,
    ) -> Result<Option<MarkerIx>, Diagnostic> {
        if at >= arguments.len() {
            return Ok(None);
        }
        match self.code_or_id(function, arguments, at)? {
            0 => Ok(None),
            id => self
                .compiler
                .find(Space::Marker, id)
                .map(|index| Some(MarkerIx(index)))
                .ok_or_else(|| undefined(function, Space::Marker.keyword(), id)),
        }
    }

    fn needed_marker(
        &self,
        function: &'static FunctionDef,
        arguments: Arguments,
        at: usize,
    ) -> Result<MarkerIx, Diagnostic> {
        self.marker(function, arguments, at)?
            .ok_or_else(|| wrong(function, "an argument is 0, but must be the id of a marker"))
    }

    fn object(
        &self,
        function: &'static FunctionDef,
        arguments: Arguments,
        at: usize,
        space: Space,
    ) -> Result<usize, Diagnostic> {
        let id = self.code_or_id(function, arguments, at)?;
        self.compiler
            .find(space, id)
            .ok_or_else(|| undefined(function, space.keyword(), id))
    }

    /// Returns an argument that is an id or a code: a non-negative integer.
    fn code_or_id(
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
                    "argument {} of {}({}) must be written as a whole number",
                    at + 1,
                    function.name,
                    function.arguments
                ),
            ))
        }
    }
}

fn undefined(function: &FunctionDef, kind: &str, id: u32) -> Diagnostic {
    Diagnostic::error(
        Code::UndefinedId,
        format!(
            "{kind}/{id}, which {} refers to, is not defined",
            function.name
        ),
    )
}

fn wrong(function: &FunctionDef, what: impl std::fmt::Display) -> Diagnostic {
    Diagnostic::error(
        Code::BadExpression,
        format!("{}({}): {what}", function.name, function.arguments),
    )
}

/// Returns the diagnostic for a vector expression. Vectors are parsed but not evaluated.
pub(super) fn vector_refusal() -> Diagnostic {
    Diagnostic::error(
        Code::NotSolvedNatively,
        "vector expressions are not evaluated by the built-in solver",
    )
    .help("give the components FX, FY, FZ, or use a command backend that runs ADAMS")
}

/// Returns the diagnostic for a function that the built-in solver does not evaluate.
pub(super) fn refusal(function: &FunctionDef) -> Diagnostic {
    if function.name == "USER" {
        return Diagnostic::error(
            Code::UserSubroutine,
            "USER calls a user-written subroutine; it must be the whole FUNCTION, not a part of an expression",
        );
    }
    let why = match function.solved {
        Solved::External(why) | Solved::Subroutine(why) | Solved::NoEffect(why) => why,
        Solved::Native(_) => "not evaluated by the built-in solver",
    };
    Diagnostic::error(Code::NotSolvedNatively, format!("{}: {why}", function.name))
        .help("use a command backend that runs ADAMS, or replace the function")
}
