//! Compilation of the model to the fixed structure [`System`].
//!
//! The module contains no solution method. Every statement that cannot be solved is reported together with the effect of leaving it out;
//! nothing is dropped silently.

mod car_bushing;
mod centres;
mod conditions;
mod constraints;
mod forces;
mod friction;
mod functions;
mod motion;
mod order;

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use self::centres::{centres, sizes};
use self::motion::{not_in_motion, reference_mass};

use super::carried::Carried;
use super::catalogue::{Catalogue, Group, GroupDimensions, Role};
use super::compiled_function::{CompiledFunction, Exerted};
use super::parameters::SplineSlots;
use super::structure::{
    Body, ConstraintEquation, Element, GconEquation, NForce, Start, StateEquation, StateRhs,
    System, VariableEquation,
};
use super::surface::JointFriction;
use super::{Driven, Name, Parameters, Scratch, State, StictionState};
use crate::function::Reference;
use crate::mechanics::{Mat3, Pose, Vec3};
use crate::model::{
    ArrayKind, Function, Header, Model, Orientation, Part, PartKind, effect_of, may_be_ignored,
};
use admire_syntax::diagnostic::{Checked, Code, Diagnostic};
use admire_syntax::grammar;
use admire_syntax::grammar::ArgumentDef;
use admire_syntax::units::Dimension;

/// Returns the help text of the diagnostic for an unsolved statement.
fn way_out(kind: &str, real: &str) -> String {
    let property = match kind {
        "GFORCE" | "SFORCE" | "VFORCE" | "VTORQUE" => {
            "; if it only reads an Adams/Car property file, `admire fix --replace-user` replaces it by its curves"
        }
        _ => "",
    };
    let leave = if may_be_ignored(kind) {
        format!(
            "; `mdi` leaves it out with ADMIRE_IGNORE={kind}, `admire solve` with --ignore {kind}"
        )
    } else {
        String::new()
    };
    format!("{real}{property}{leave}")
}

impl System {
    /// Compiles a model. The diagnostics report unsolved statements. If any of them is an error, a solution would not represent the model.
    pub fn compile(model: &Model) -> Checked<Self> {
        let mut compiler = SystemCompiler::new(model);
        compiler.markers();
        compiler.parts();
        compiler.forces();
        compiler.constraints();
        compiler.joint_frictions();
        compiler.data();
        compiler.readings();
        compiler.splines();
        compiler.left_out();
        compiler.report_car_bushings();
        compiler.finish()
    }
}

struct SystemCompiler<'a> {
    model: &'a Model,
    diagnostics: Vec<Diagnostic>,
    catalogue: Catalogue,
    theta: Vec<f64>,
    bodies: Vec<Body>,
    used: Vec<bool>,
    /// I marker of the force that each floating marker belongs to.
    floating: BTreeMap<usize, usize>,
    elements: Vec<Element>,
    multis: Vec<NForce>,
    joints: Vec<ConstraintEquation>,
    frictions: Vec<JointFriction>,
    conditions: Vec<GconEquation>,
    variables: Vec<VariableEquation>,
    states: Vec<StateEquation>,
    functions: Vec<CompiledFunction>,
    gravity: usize,
    pairs: usize,
    equations: usize,
    programs: crate::function::ExpressionCompiler<'a>,
    measured_angles: usize,
    /// For each DIFF that statics holds constant, the index of its function.
    held_rates: BTreeMap<usize, usize>,
    state_values: Vec<f64>,
    requests: Vec<[Option<usize>; 8]>,
    request_forces: Vec<Vec<(Exerted, bool)>>,
    sensors: Vec<(usize, Option<usize>)>,
    /// Statements that need user-written subroutines.
    users: Vec<Name>,
    /// Initial integration constants of MOTIONs that prescribe a velocity or acceleration.
    driven: Vec<Driven>,
    splines: Vec<SplineSlots>,
    /// Times at which each function is not smooth.
    breaks: Vec<Vec<f64>>,
    /// ARRAYs that belong to a FIELD of Adams/Car.
    car_arrays: BTreeSet<u32>,
}

/// Returns the definition of a statement's argument in the grammar.
fn stated(kind: &str, argument: &str) -> &'static ArgumentDef {
    grammar::statement(kind)
        .and_then(|def| def.argument(argument))
        .expect("a statement and an argument of the grammar")
}

/// Returns the name of an object of the model.
pub fn name(kind: &'static str, header: &Header) -> Name {
    Name {
        kind,
        id: header.id,
        view: header.name.clone(),
    }
}

impl<'a> SystemCompiler<'a> {
    fn new(model: &'a Model) -> Self {
        Self {
            model,
            diagnostics: Vec::new(),
            catalogue: Catalogue::default(),
            theta: Vec::new(),
            bodies: Vec::new(),
            used: vec![false; model.markers.len()],
            floating: BTreeMap::new(),
            elements: Vec::new(),
            multis: Vec::new(),
            joints: Vec::new(),
            frictions: Vec::new(),
            conditions: Vec::new(),
            variables: Vec::new(),
            states: Vec::new(),
            functions: Vec::new(),
            gravity: 0,
            pairs: 0,
            equations: 0,
            programs: crate::function::ExpressionCompiler::new(model),
            measured_angles: 1,
            held_rates: BTreeMap::new(),
            state_values: Vec::new(),
            requests: Vec::new(),
            request_forces: Vec::new(),
            sensors: Vec::new(),
            users: Vec::new(),
            driven: Vec::new(),
            splines: Vec::new(),
            breaks: Vec::new(),
            car_arrays: BTreeSet::new(),
        }
    }

    /// Appends parameters to theta and returns their range.
    fn numbers(
        &mut self,
        (kind, id): (&'static str, Option<u32>),
        argument: Option<&'static str>,
        values: &[f64],
        (quantity, minimum): (GroupDimensions, f64),
        role: Role,
    ) -> std::ops::Range<usize> {
        self.theta.extend_from_slice(values);
        let indexed = values.len() > 1 || matches!(role, Role::Literals(_));
        self.catalogue.push(Group {
            kind,
            id,
            argument,
            first: 0,
            count: values.len(),
            indexed,
            quantity,
            minimum,
            role,
        })
    }

    /// Appends the values of an argument of the grammar to theta and returns their range.
    fn argument(
        &mut self,
        of: (&'static str, Option<u32>),
        argument: &'static ArgumentDef,
        values: &[f64],
        role: Role,
    ) -> std::ops::Range<usize> {
        let bounds = (GroupDimensions::of_argument(argument), argument.minimum());
        self.numbers(of, Some(argument.name), values, bounds, role)
    }

    fn markers(&mut self) {
        let (position, angle) = (stated("MARKER", "QP"), stated("MARKER", "REULER"));
        // The six parameters of each marker come first in theta, so that a slot identifies its marker.
        for (k, marker) in self.model.markers.iter().enumerate() {
            let of = ("MARKER", Some(marker.header.id));
            let (qp, orientation) = match &marker.relative {
                Some(relative) => (relative.qp, relative.orientation),
                None => (marker.qp, marker.orientation),
            };
            self.argument(of, position, &[qp.x, qp.y, qp.z], Role::Marker(k));
            let angles = match orientation {
                Orientation::Reuler(angles) => angles,
                Orientation::Points => [0.0; 3],
            };
            self.argument(of, angle, &angles, Role::Marker(k));
        }
    }

    fn parts(&mut self) {
        let gravity = self.model.gravity;
        self.gravity = self.theta.len();
        for (k, argument) in ["IGRAV", "JGRAV", "KGRAV"].into_iter().enumerate() {
            let argument = stated("ACCGRAV", argument);
            self.argument(("ACCGRAV", None), argument, &[gravity[k]], Role::Gravity);
        }
        let mass = [stated("PART", "MASS"), stated("POINT_MASS", "MASS")];
        let mut first = 0;
        for (k, part) in self.model.parts.iter().enumerate() {
            let (kind, freedoms) = match part.kind {
                PartKind::Ground => ("PART", 0),
                PartKind::Rigid => ("PART", 6),
                PartKind::PointMass => ("POINT_MASS", 3),
                PartKind::External => ("FLEX_BODY", 0),
            };
            let mass = if part.kind == PartKind::External {
                // External bodies are reported with the unsolved statements.
                self.theta.len()
            } else {
                let mass = mass[usize::from(part.kind == PartKind::PointMass)];
                let of = (kind, Some(part.header.id));
                self.argument(of, mass, &[part.mass], Role::Mass(k)).start
            };
            let [xx, yy, zz, xy, xz, yz] = part.ip;
            let cm = part.cm.map(|m| m.0);
            if let Some(cm) = cm {
                self.used[cm] = true;
            }
            let start = self.start(part);
            self.bodies.push(Body {
                name: name(kind, &part.header),
                first,
                freedoms,
                mass,
                cm,
                centre: Vec3::zeros(),
                inertia: Mat3::new(xx, -xy, -xz, -xy, yy, -yz, -xz, -yz, zz),
                start,
            });
            first += freedoms;
        }
    }

    fn start(&mut self, part: &Part) -> Start {
        let start = part.start;
        for marker in [start.linear_axes, start.angular_axes]
            .into_iter()
            .flatten()
        {
            self.used[marker.0] = true;
        }
        Start {
            linear: start.linear,
            linear_axes: start.linear_axes.map(|m| m.0),
            angular: start.angular,
            angular_axes: start.angular_axes.or(part.cm).map(|m| m.0),
            exact: part.exact,
        }
    }

    /// Reserves reference angles for a pair of markers and returns their index.
    fn pair(&mut self, i: usize, j: usize) -> usize {
        self.used[i] = true;
        self.used[j] = true;
        self.pairs += 1;
        self.pairs - 1
    }

    fn part_of(&self, marker: usize) -> usize {
        self.model.markers[marker].part.0
    }

    fn data(&mut self) {
        for v in &self.model.variables {
            let of = name("VARIABLE", &v.header);
            let function = self.function(&v.function, &of, None, Dimension::NONE);
            self.variables.push(VariableEquation {
                name: of,
                function,
                active: v.header.active,
                unknown: None,
            });
        }
        for (k, d) in self.model.diffs.iter().enumerate() {
            let of = name("DIFF", &d.header);
            let function = self.function(&d.function, &of, None, Dimension::NONE);
            let active = d.header.active;
            if active && d.static_hold {
                self.held_rates.insert(k, function);
            }
            let rate = |held: bool| {
                if held || !active {
                    StateRhs::Held
                } else {
                    StateRhs::Function(function)
                }
            };
            self.states.push(StateEquation {
                name: of,
                rate: rate(d.static_hold),
                unknown: None,
                moving: rate(d.dynamic_hold),
                moving_unknown: 0,
                implicit: d.implicit && active && !d.dynamic_hold,
                active,
            });
            self.state_values.push(if active { d.ic } else { 0.0 });
        }
        for l in &self.model.linear_states {
            let of = name(l.kind, &l.header);
            let inputs = self.array_variables(l.u);
            let first = self.states.len();
            let mut arrays = self.model.arrays.iter();
            let initial = l.ic.and_then(|id| {
                let array = arrays.find(|a| a.header.id == id)?;
                match &array.kind {
                    ArrayKind::Numbers(numbers) => Some(&numbers[..]),
                    _ => None,
                }
            });
            for (row, a) in l.a.iter().enumerate() {
                let b = l.b.get(row).map_or(&[][..], Vec::as_slice);
                let linear = StateRhs::Linear(
                    a.iter().enumerate().map(|(k, a)| (first + k, *a)).collect(),
                    b.iter()
                        .zip(&inputs)
                        .filter_map(|(b, v)| v.map(|v| (v, *b)))
                        .collect(),
                );
                let active = l.header.active;
                let rate = |held: bool| {
                    if held || !active {
                        StateRhs::Held
                    } else {
                        linear.clone()
                    }
                };
                self.states.push(StateEquation {
                    name: of.clone(),
                    rate: rate(l.static_hold),
                    unknown: None,
                    moving: rate(false),
                    moving_unknown: 0,
                    implicit: false,
                    active,
                });
                let ic = initial.and_then(|ic| ic.get(row)).copied();
                self.state_values.push(ic.filter(|_| active).unwrap_or(0.0));
            }
        }
    }

    /// Reports a fault of a statement with a function, unless the statement is inactive.
    fn complain_of(&mut self, owner: &Name, diagnostic: Diagnostic) {
        if !self.model.is_off(owner.kind, owner.id) {
            self.diagnostics.push(diagnostic);
        }
    }

    /// Reports statements that are not solved. Omits inactive statements and statements that only write or draw.
    fn left_out(&mut self) {
        for u in self.model.unsolved.iter().filter(|u| u.header.active) {
            let Some(effect) = effect_of(u.kind) else {
                continue;
            };
            let owner = name(u.kind, &u.header);
            if u.code == Code::UserSubroutine {
                self.users.push(owner.clone());
            }
            let message = format!("{owner} is not solved: {}; {effect}", u.why);
            let diagnostic = Diagnostic::error(u.code, message).about(owner.object());
            let help = way_out(u.kind, "real ADAMS solves it");
            self.diagnostics.push(diagnostic.help(help));
        }
        let users = &self.users;
        if users.len() > 1 {
            let names: Vec<String> = users.iter().map(ToString::to_string).collect();
            let message = format!(
                "{} statements need user-written subroutines: {}",
                users.len(),
                names.join(", ")
            );
            self.diagnostics.push(
                Diagnostic::error(Code::UserSubroutine, message)
                    .help("use the command backend, which runs real ADAMS with the library of these subroutines"),
            );
        }
    }

    fn finish(mut self) -> Checked<System> {
        self.sources();
        let model = self.model;
        let freedoms: usize = self.bodies.iter().map(|b| b.freedoms).sum();
        let first_variable = freedoms + self.equations;
        let order = self.order(first_variable);
        let (switches, breaks) = self.watched(&order);
        let of_velocities = self.of_velocities();
        let mut in_equations = vec![false; self.functions.len()];
        for &function in &order.equations {
            in_equations[function] = true;
        }
        let poses: Vec<Pose> = model
            .parts
            .iter()
            .map(|part| match part.kind {
                PartKind::Ground => Pose::identity(),
                PartKind::PointMass => Pose {
                    R: Mat3::identity(),
                    ..part.pose
                },
                _ => part.pose,
            })
            .collect();
        let by_points = model
            .markers
            .iter()
            .map(|m| match &m.relative {
                Some(m) => (m.orientation == Orientation::Points).then_some(m.R),
                None => (m.orientation == Orientation::Points).then_some(m.R),
            })
            .collect();
        let carried = Arc::new(Carried::of(model));
        let parameters = Parameters::new(
            self.theta,
            by_points,
            Arc::clone(&carried),
            (self.programs.curves(), self.splines),
        );
        let mut unknowns = first_variable + order.implicit.len();
        let mut states = self.states;
        for state in &mut states {
            if !matches!(state.rate, StateRhs::Held) {
                state.unknown = Some(unknowns);
                unknowns += 1;
            }
        }
        let mut joint_of = vec![None; self.equations];
        for (number, joint) in self.joints.iter().enumerate() {
            joint_of[joint.first..joint.first + joint.count].fill(Some(number));
        }
        let mut moving_unknowns = unknowns;
        for state in &mut states {
            state.moving_unknown = state.unknown.unwrap_or_else(|| {
                moving_unknowns += 1;
                moving_unknowns - 1
            });
        }
        let owners: Vec<usize> = model.markers.iter().map(|m| m.part.0).collect();
        let used: Vec<usize> = (0..owners.len()).filter(|&m| self.used[m]).collect();
        centres(
            &mut self.bodies,
            &self.elements,
            &self.joints,
            &self.multis,
            &owners,
            &parameters,
        );
        let (length, extent) = sizes(&used, &owners, &parameters, &poses, &self.bodies);
        let initial = State {
            time: 0.0,
            mode: 5,
            poses,
            multipliers: vec![0.0; self.equations],
            variables: model.variables.iter().map(|v| v.ic).collect(),
            states: self.state_values,
            redundant: Vec::new(),
            pair_angles: vec![Vec3::zeros(); self.pairs],
            measure_angles: vec![Reference::NONE; self.measured_angles.max(1)],
            velocities: Vec::new(),
            accelerations: Vec::new(),
            state_rates: Vec::new(),
            driven: self.driven,
            grips: vec![StictionState::none(); self.frictions.len()],
            sensors: vec![0.0; model.sensors.len()],
            pieces: Vec::new(),
        };
        let system = System {
            markers: model
                .markers
                .iter()
                .map(|m| name("MARKER", &m.header))
                .collect(),
            owners,
            carried,
            floating: self.floating,
            used,
            order: order.equations,
            order_of_constraints: order.constraints,
            data_constrain: order.data_constrain,
            in_equations,
            ranks: order.ranks,
            implicit: order.implicit,
            bodies: self.bodies,
            elements: self.elements,
            multis: self.multis,
            joints: self.joints,
            frictions: self.frictions,
            conditions: self.conditions,
            variables: self.variables,
            states,
            requests: self.requests,
            request_forces: self.request_forces,
            sensors: self.sensors,
            functions: self.functions,
            gravity: self.gravity,
            ucf: model.units.ucf,
            metre: model.units.length.si,
            catalogue: self.catalogue,
            parameters,
            initial,
            settings: model.equilibrium.clone(),
            first_equation: freedoms,
            equations: self.equations,
            first_variable,
            unknowns,
            moving_unknowns,
            not_in_motion: Vec::new(),
            joint_of,
            is_nonholonomic: of_velocities,
            reference_mass: reference_mass(model),
            length,
            extent,
            breaks,
            switches,
        };
        let mut system = system;
        system.not_in_motion = not_in_motion(&system);
        // This sets the references for counting full turns: an angle near 180 degrees may pass 180 degrees on the way to the first
        // equilibrium.
        let mut initial = system.initial.clone();
        system.accept(&system.parameters, &mut initial, &mut Scratch::new(&system));
        system.initial = initial;
        Checked {
            value: system,
            diagnostics: self.diagnostics,
        }
    }
}
