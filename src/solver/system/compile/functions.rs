//! Compilation of FUNCTIONs to programs, and resolution of their inputs in the system.

use super::{Function, Name, SystemCompiler, name, way_out};
use crate::function::{ForceMeasure, Input, MeasuredElement, time_breaks};
use crate::model::{ArrayKind, MarkerIx, RequestKind, effect_of};
use crate::system::catalogue::{GroupDimensions, Role};
use crate::system::compiled_function::{CompiledFunction, Exerted, Force, LinearRow, Source};
use crate::system::parameters::SplineSlots;
use crate::system::structure::{Element, StateRhs};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::units::Dimension;

impl SystemCompiler<'_> {
    /// Compiles a function and returns its index. The inputs of all functions are resolved at the end, when all indices are known.
    pub(super) fn function(
        &mut self,
        function: &Function,
        owner: &Name,
        argument: Option<&'static str>,
        dimension: Dimension,
    ) -> usize {
        let at = self.functions.len();
        let read_only = matches!(owner.kind, "REQUEST" | "SENSOR");
        let mut breaks = Vec::new();
        let id = (owner.kind, Some(owner.id));
        let (program, literals) = match function {
            Function::Expression(expression) => {
                if !read_only {
                    breaks = time_breaks(expression);
                }
                let literals: Vec<f64> = expression.literals.iter().map(|n| n.value).collect();
                match self.programs.compile(expression) {
                    Ok(program) => (Some(program), literals),
                    Err(mut diagnostic) => {
                        diagnostic.message = format!("{owner}: {}", diagnostic.message);
                        self.complain_of(owner, diagnostic.about(owner.object()));
                        (None, literals)
                    }
                }
            }
            Function::User(text) => {
                if !self.model.is_off(owner.kind, owner.id) {
                    self.users.push(owner.clone());
                }
                let effect = effect_of(owner.kind)
                    .unwrap_or("without it, functions that read it have no value");
                let diagnostic = Diagnostic::error(
                    Code::UserSubroutine,
                    format!("{owner} calls a user-written subroutine: {text}; {effect}"),
                );
                let help = way_out(owner.kind, "real ADAMS runs it");
                self.complain_of(owner, diagnostic.about(owner.object()).help(help));
                (None, Vec::new())
            }
        };
        let none = (GroupDimensions::Same(Dimension::NONE), f64::NEG_INFINITY);
        let word = Some(argument.unwrap_or("FUNCTION"));
        let literals = self.numbers(id, word, &literals, none, Role::Literals(at));
        let whole = (GroupDimensions::Same(dimension), f64::NEG_INFINITY);
        let replacement = self
            .numbers(id, argument, &[f64::NAN], whole, Role::Override(at))
            .start;
        self.breaks.push(breaks);
        self.functions.push(CompiledFunction {
            owner: owner.clone(),
            program,
            switches: 0..0,
            sources: Vec::new(),
            literals,
            replacement,
        });
        at
    }

    /// Compiles the functions of REQUESTs and SENSORs.
    pub(super) fn readings(&mut self) {
        const ARGUMENTS: [&str; 8] = ["F1", "F2", "F3", "F4", "F5", "F6", "F7", "F8"];
        for request in &self.model.requests {
            let owner = name("REQUEST", &request.header);
            let mut numbers = [None; 8];
            let mut forces = Vec::new();
            match &request.kind {
                RequestKind::Functions(functions) => {
                    for (k, function) in functions.iter().enumerate() {
                        numbers[k] = function
                            .as_ref()
                            .map(|f| self.function(f, &owner, Some(ARGUMENTS[k]), Dimension::NONE));
                    }
                }
                RequestKind::Force { i, j, rm } => {
                    for marker in [Some(*i), *j, *rm].into_iter().flatten() {
                        self.used[marker.0] = true;
                    }
                    forces = self.between(*i, *j);
                }
                RequestKind::Displacement { i, j, rm }
                | RequestKind::Velocity { i, j, rm }
                | RequestKind::Acceleration { i, j, rm } => {
                    for marker in [Some(*i), *j, *rm].into_iter().flatten() {
                        self.used[marker.0] = true;
                    }
                }
                RequestKind::User(text) => self.diagnostics.push(
                    Diagnostic::warning(
                        Code::UserSubroutine,
                        format!(
                            "{owner} calls a user-written subroutine and is left empty: {text}"
                        ),
                    )
                    .about(owner.object()),
                ),
            }
            self.requests.push(numbers);
            self.request_forces.push(forces);
        }
        for sensor in &self.model.sensors {
            let owner = name("SENSOR", &sensor.header);
            let function = self.function(&sensor.function, &owner, None, Dimension::NONE);
            let evaluate = sensor
                .evaluate
                .as_ref()
                .map(|f| self.function(f, &owner, Some("EVALUATE"), Dimension::NONE));
            self.sensors.push((function, evaluate));
        }
    }

    /// Adds the y values of the SPLINEs that functions and elements read to the parameters. Surfaces and points from a property file are
    /// not parameters.
    pub(super) fn splines(&mut self) {
        let none = (GroupDimensions::Same(Dimension::NONE), f64::NEG_INFINITY);
        let curves = self.programs.curves();
        for (spline, data) in self.model.splines.iter().enumerate() {
            if data.is_surface() || data.is_of_file || !curves.are_of(spline) {
                continue;
            }
            let id = ("SPLINE", Some(data.header.id));
            let slots = self.numbers(id, Some("Y"), &data.y[0], none, Role::Spline(spline));
            self.splines.push(SplineSlots { spline, slots });
        }
    }

    /// Resolves the inputs of all functions to indices in the system.
    pub(super) fn sources(&mut self) {
        let linear = self.linear_arrays();
        for number in 0..self.functions.len() {
            let inputs = self.functions[number]
                .program
                .as_ref()
                .map_or_else(Vec::new, |p| p.inputs.clone());
            let sources = inputs
                .iter()
                .map(|input| self.source(input, &linear))
                .collect();
            self.functions[number].sources = sources;
        }
    }

    fn source(&mut self, input: &Input, linear: &LinearArrays) -> Source {
        match *input {
            Input::Time => Source::Time,
            Input::Mode => Source::Mode,
            Input::Measure(mut measure) => {
                let mut at = 0;
                if measure.kind.counts_turns() {
                    at = self.measured_angles;
                    self.measured_angles += 1;
                }
                let markers = [&mut measure.i, &mut measure.j, &mut measure.k];
                for marker in markers.into_iter().flatten() {
                    *marker = self.placed(*marker);
                }
                Source::Measure(measure, at)
            }
            Input::Rate(mut measure) => {
                for marker in measure.markers.iter_mut().flatten() {
                    *marker = self.placed(*marker);
                }
                Source::Moved(measure)
            }
            Input::Variable(k) => Source::Variable(k),
            Input::Dif(k) => Source::State(k),
            Input::DifRate(k) => match (&self.states[k].rate, self.held_rates.get(&k)) {
                (StateRhs::Held, Some(function)) => Source::StateRate(k, Some(*function)),
                _ => Source::StateRate(k, None),
            },
            Input::ArrayValue { array, element } => match &self.model.arrays[array].kind {
                ArrayKind::Numbers(numbers) => {
                    Source::Constant(numbers.get(element).copied().unwrap_or(0.0))
                }
                ArrayKind::Variables(ids) => {
                    let variable = ids.get(element).and_then(|id| {
                        let mut all = self.model.variables.iter();
                        all.position(|v| v.header.id == *id)
                    });
                    variable.map_or(Source::Constant(0.0), Source::Variable)
                }
                ArrayKind::States(_) => linear
                    .state(self.model.arrays[array].header.id, element)
                    .map_or(Source::Constant(0.0), Source::State),
                ArrayKind::Outputs(_) => linear
                    .output(self.model.arrays[array].header.id, element)
                    .map_or(Source::Constant(0.0), |row| Source::Output(row.clone())),
            },
            Input::SensorValue(k) => Source::Sensor(k),
            Input::Friction { friction, which } => {
                Source::Friction(self.model.frictions[friction].header.id, which)
            }
            Input::Force(ForceMeasure::Between { component, i, j, k }) => {
                for marker in [Some(i), j].into_iter().flatten() {
                    self.used[marker.0] = true;
                }
                let k = k.map(|k| self.placed(k));
                let by = match j {
                    Some(_) => self.between(i, j),
                    None => self.acting_at(i),
                };
                Source::Force(Box::new(Force {
                    by,
                    component,
                    axes: k.map(|m| m.0),
                }))
            }
            Input::Force(ForceMeasure::Element {
                element,
                on_j,
                component,
                rm,
            }) => {
                let rm = rm.map(|rm| self.placed(rm));
                Source::Force(Box::new(Force {
                    by: vec![(self.exerted_by(element), on_j)],
                    component,
                    axes: rm.map(|m| m.0),
                }))
            }
        }
    }

    /// Marks a measured marker as used and returns the marker. A floating marker is replaced by the I marker of its force, with which it
    /// coincides.
    fn placed(&mut self, marker: MarkerIx) -> MarkerIx {
        let marker = self.floating.get(&marker.0).copied().unwrap_or(marker.0);
        self.used[marker] = true;
        MarkerIx(marker)
    }

    /// Returns the elements and constraints that act directly between two markers. The flag returned with each of them is true if marker
    /// `i` is its J marker. Without `j`, returns only the action-only elements at `i`, as for FORCE of REQUEST and INFO.
    fn between(&self, i: MarkerIx, j: Option<MarkerIx>) -> Vec<(Exerted, bool)> {
        let Some(j) = j else {
            let alone = |e: &Element| e.i == i.0 && e.reaction.is_none();
            let elements = self.elements.iter().enumerate();
            return elements
                .filter(|(_, e)| alone(e))
                .map(|(k, _)| (Exerted::Element(k), false))
                .collect();
        };
        let ends = self.ends();
        ends.filter_map(|(who, ends)| match ends {
            (a, Some(b)) if a == i.0 && b == j.0 => Some((who, false)),
            (a, Some(b)) if a == j.0 && b == i.0 => Some((who, true)),
            // An action-only force uses its J only for the direction.
            _ => None,
        })
        .chain(self.elements.iter().enumerate().filter_map(|(k, e)| {
            let alone = e.reaction.is_none() && e.i == i.0 && e.j == j.0;
            alone.then_some((Exerted::Element(k), false))
        }))
        .collect()
    }

    /// Returns all sources of a force at a marker, as for FX(i) of the C++ solver (`cfunc_fx`). The flag of each source is true if the
    /// marker is its J marker.
    fn acting_at(&self, i: MarkerIx) -> Vec<(Exerted, bool)> {
        self.ends()
            .filter_map(|(who, ends)| match ends {
                (a, _) if a == i.0 => Some((who, false)),
                (_, Some(b)) if b == i.0 => Some((who, true)),
                _ => None,
            })
            .collect()
    }

    /// Returns every element and constraint that exerts a force, with the markers at which it acts. The first is the marker of the action.
    /// The second is the marker of the reaction, unless the force is action-only.
    fn ends(&self) -> impl Iterator<Item = (Exerted, (usize, Option<usize>))> {
        let elements = self.elements.iter().enumerate();
        let elements = elements.map(|(k, e)| (Exerted::Element(k), (e.i, e.reaction.map(|_| e.j))));
        let joints = self.joints.iter().enumerate();
        let joints = joints.filter_map(|(k, joint)| match joint.terms.as_slice() {
            [term] => Some((Exerted::Joint(k, 0), (term.i, Some(term.j)))),
            _ => None,
        });
        let multis = self.multis.iter().enumerate().flat_map(|(k, multi)| {
            let j = Some(multi.j);
            let markers = multi.i.iter().enumerate();
            markers.map(move |(at, i)| (Exerted::Multi(k, at), (*i, j)))
        });
        elements.chain(joints).chain(multis)
    }

    fn exerted_by(&self, element: MeasuredElement) -> Exerted {
        let model = self.model;
        let bushings = model.bushings.len();
        let springs = bushings + model.springdampers.len();
        let pairs = springs + model.pair_forces.len();
        let sforces = pairs + model.sforces.len();
        match element {
            MeasuredElement::Bushing(k) => Exerted::Element(k),
            MeasuredElement::SpringDamper(k) => Exerted::Element(bushings + k),
            MeasuredElement::PairForce(k) => Exerted::Element(springs + k),
            MeasuredElement::Sforce(k) => Exerted::Element(pairs + k),
            MeasuredElement::VectorForce(k) => Exerted::Element(sforces + k),
            MeasuredElement::Nforce { nforce, at } => {
                let which = model.nforces[nforce].i.iter().position(|m| *m == at);
                Exerted::Multi(nforce, which.unwrap_or(0))
            }
            MeasuredElement::Joint(k) => Exerted::Joint(k, 0),
            MeasuredElement::Primitive(k) => Exerted::Joint(model.joints.len() + k, 0),
            MeasuredElement::Motion(k) => Exerted::Joint(
                model.joints.len()
                    + model.primitives.len()
                    + model.couplers.len()
                    + model.gears.len()
                    + k,
                0,
            ),
        }
    }

    fn linear_arrays(&self) -> LinearArrays {
        let mut out = LinearArrays::default();
        let mut first = self.model.diffs.len();
        for l in &self.model.linear_states {
            out.states.push((l.x, first, l.a.len()));
            // The outputs of an inactive statement are zero.
            if let Some(y) = l.y.filter(|_| l.header.active) {
                let inputs = self.array_variables(l.u);
                // C or D may be absent.
                for row in 0..l.c.len().max(l.d.len()) {
                    let c = l.c.get(row).map_or(&[][..], Vec::as_slice);
                    let d = l.d.get(row).map_or(&[][..], Vec::as_slice);
                    let by_state = c.iter().enumerate().map(|(k, c)| (first + k, *c)).collect();
                    let by_variable = d
                        .iter()
                        .zip(&inputs)
                        .filter_map(|(d, v)| v.map(|v| (v, *d)))
                        .collect();
                    out.outputs.push(((y, row), (by_state, by_variable)));
                }
            }
            first += l.a.len();
        }
        out
    }

    /// Returns the indices of the variables in a U array; `None` for an undefined VARIABLE.
    pub(super) fn array_variables(&self, id: u32) -> Vec<Option<usize>> {
        let mut arrays = self.model.arrays.iter();
        match arrays.find(|a| a.header.id == id).map(|a| &a.kind) {
            Some(ArrayKind::Variables(ids)) => ids
                .iter()
                .map(|id| {
                    let mut all = self.model.variables.iter();
                    all.position(|v| v.header.id == *id)
                })
                .collect(),
            _ => Vec::new(),
        }
    }
}

/// Indices of the states and outputs of LSE and TFSISO statements.
#[derive(Default)]
pub(super) struct LinearArrays {
    /// Array id, index of the first state, number of states.
    states: Vec<(u32, usize, usize)>,
    outputs: Vec<((u32, usize), LinearRow)>,
}

impl LinearArrays {
    fn state(&self, array: u32, element: usize) -> Option<usize> {
        let found = self.states.iter().find(|s| s.0 == array)?;
        (element < found.2).then_some(found.1 + element)
    }

    fn output(&self, array: u32, element: usize) -> Option<&LinearRow> {
        let found = self.outputs.iter().find(|o| o.0 == (array, element))?;
        Some(&found.1)
    }
}
