//! From the model to the frozen structure.
//!
//! Knows no equilibrium. What cannot be solved is said, with what leaving it out means; nothing is silently dropped.

mod constraints;
mod forces;

use super::catalogue::{Catalogue, Group, Quantity, Role};
use super::function::CompiledFunction;
use super::structure::{
    Algebraic, Body, Condition, Element, Joint, Name, Rate, StateEquation, System,
};
use super::{Parameters, State};
use crate::diagnostic::{Checked, Code, Diagnostic};
use crate::mechanics::{Mat3, Pose, Vec3};
use crate::model::{Function, Header, Model, Orientation, PartKind};
use crate::units::Dimension;

const ACCELERATION: Dimension = Dimension::new(0, 0, 1, -2, 0);

impl System {
    /// Compiles a model. Diagnostics tell what is not solved; with an error among them the answer would not be the model's.
    pub fn compile(model: &Model) -> Checked<Self> {
        let mut compiler = Compiler::new(model);
        compiler.markers();
        compiler.parts();
        compiler.forces();
        compiler.constraints();
        compiler.data();
        compiler.finish()
    }
}

struct Compiler<'a> {
    model: &'a Model,
    diagnostics: Vec<Diagnostic>,
    catalogue: Catalogue,
    theta: Vec<f64>,
    bodies: Vec<Body>,
    used: Vec<bool>,
    elements: Vec<Element>,
    joints: Vec<Joint>,
    conditions: Vec<Condition>,
    variables: Vec<Algebraic>,
    states: Vec<StateEquation>,
    functions: Vec<CompiledFunction>,
    gravity: usize,
    pairs: usize,
    equations: usize,
}

pub(crate) fn name(kind: &'static str, header: &Header) -> Name {
    Name {
        kind,
        id: header.id,
        view: header.name.clone(),
    }
}

impl<'a> Compiler<'a> {
    fn new(model: &'a Model) -> Self {
        Self {
            model,
            diagnostics: Vec::new(),
            catalogue: Catalogue::default(),
            theta: Vec::new(),
            bodies: Vec::new(),
            used: vec![false; model.markers.len()],
            elements: Vec::new(),
            joints: Vec::new(),
            conditions: Vec::new(),
            variables: Vec::new(),
            states: Vec::new(),
            functions: Vec::new(),
            gravity: 0,
            pairs: 0,
            equations: 0,
        }
    }

    /// Gives numbers a place in theta.
    fn numbers(
        &mut self,
        (kind, id): (&'static str, Option<u32>),
        argument: Option<&'static str>,
        values: &[f64],
        (quantity, minimum): (Quantity, f64),
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

    fn markers(&mut self) {
        // Six numbers per marker stand first, so that a slot tells its marker.
        for (k, marker) in self.model.markers.iter().enumerate() {
            let of = ("MARKER", Some(marker.header.id));
            let qp = [marker.qp.x, marker.qp.y, marker.qp.z];
            let length = (Quantity::Same(Dimension::LENGTH), f64::NEG_INFINITY);
            self.numbers(of, Some("QP"), &qp, length, Role::Marker(k));
            let angles = match marker.orientation {
                Orientation::Reuler(angles) => angles,
                Orientation::Points => [0.0; 3],
            };
            let angle = (Quantity::Same(Dimension::ANGLE), f64::NEG_INFINITY);
            self.numbers(of, Some("REULER"), &angles, angle, Role::Marker(k));
        }
    }

    fn parts(&mut self) {
        let gravity = self.model.gravity;
        self.gravity = self.theta.len();
        for (k, argument) in ["IGRAV", "JGRAV", "KGRAV"].into_iter().enumerate() {
            let acceleration = (Quantity::Same(ACCELERATION), f64::NEG_INFINITY);
            self.numbers(
                ("ACCGRAV", None),
                Some(argument),
                &[gravity[k]],
                acceleration,
                Role::Gravity,
            );
        }
        let mut first = 0;
        for (k, part) in self.model.parts.iter().enumerate() {
            let (kind, freedoms) = match part.kind {
                PartKind::Ground => ("PART", 0),
                PartKind::Rigid => ("PART", 6),
                PartKind::PointMass => ("POINT_MASS", 3),
                PartKind::External => ("FLEX_BODY", 0),
            };
            let mass = if part.kind == PartKind::External {
                self.diagnostics.push(Diagnostic::error(
                    Code::NotSolvedNatively,
                    format!(
                        "flexible body {} is solved by real ADAMS only",
                        part.header.name
                    ),
                ));
                self.theta.len()
            } else {
                let mass = (Quantity::Same(Dimension::MASS), 0.0);
                self.numbers(
                    (kind, Some(part.header.id)),
                    Some("MASS"),
                    &[part.mass],
                    mass,
                    Role::Mass(k),
                )
                .start
            };
            let [xx, yy, zz, xy, xz, yz] = part.ip;
            let cm = part.cm.map(|m| m.0);
            if let Some(cm) = cm {
                self.used[cm] = true;
            }
            self.bodies.push(Body {
                name: name(kind, &part.header),
                first,
                freedoms,
                mass,
                cm,
                inertia: Mat3::new(xx, -xy, -xz, -xy, yy, -yz, -xz, -yz, zz),
            });
            first += freedoms;
        }
    }

    /// A place for the angles of a pair of markers.
    fn pair(&mut self, i: usize, j: usize) -> usize {
        self.used[i] = true;
        self.used[j] = true;
        self.pairs += 1;
        self.pairs - 1
    }

    fn part_of(&self, marker: usize) -> usize {
        self.model.markers[marker].part.0
    }

    /// Compiles a function; gives its index.
    fn function(
        &mut self,
        function: &Function,
        owner: &Name,
        argument: Option<&'static str>,
        dimension: Dimension,
    ) -> usize {
        let at = self.functions.len();
        let id = (owner.kind, Some(owner.id));
        let any = f64::NEG_INFINITY;
        let mut sign = 1.0;
        let literals: Vec<f64> = match function {
            Function::Expression(expression) => {
                if let crate::syntax::expression::Node::Negate(_) = expression.root {
                    sign = -1.0;
                }
                expression.literals.iter().map(|n| n.value).collect()
            }
            Function::User(_) => {
                self.diagnostics.push(Diagnostic::error(
                    Code::UserSubroutine,
                    format!("{owner} calls a user-written subroutine"),
                ));
                vec![0.0]
            }
        };
        let none = (Quantity::Same(Dimension::NONE), any);
        let word = Some(argument.unwrap_or("FUNCTION"));
        let first = self
            .numbers(id, word, &literals, none, Role::Literals(at))
            .start;
        let whole = (Quantity::Same(dimension), any);
        let replacement = self
            .numbers(id, argument, &[f64::NAN], whole, Role::Override(at))
            .start;
        self.functions.push(CompiledFunction {
            owner: owner.clone(),
            literals: first,
            replacement,
            sign,
        });
        at
    }

    fn data(&mut self) {
        let model = self.model;
        for v in &model.variables {
            let of = name("VARIABLE", &v.header);
            let function = self.function(&v.function, &of, None, Dimension::NONE);
            self.variables.push(Algebraic {
                name: of,
                function,
                active: v.header.active,
            });
        }
    }

    fn finish(self) -> Checked<System> {
        let model = self.model;
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
            .map(|m| (m.orientation == Orientation::Points).then_some(m.R))
            .collect();
        let parameters = Parameters::new(self.theta, by_points);
        let freedoms: usize = self.bodies.iter().map(|b| b.freedoms).sum();
        let first_variable = freedoms + self.equations;
        let mut unknowns = first_variable + self.variables.len();
        let mut states = self.states;
        for state in &mut states {
            if !matches!(state.rate, Rate::Held) {
                state.unknown = Some(unknowns);
                unknowns += 1;
            }
        }
        let owners: Vec<usize> = model.markers.iter().map(|m| m.part.0).collect();
        let used: Vec<usize> = (0..owners.len()).filter(|&m| self.used[m]).collect();
        let length = size(&used, &owners, &parameters, &poses);
        let initial = State {
            time: 0.0,
            mode: 5,
            poses,
            multipliers: vec![0.0; self.equations],
            variables: model.variables.iter().map(|v| v.ic).collect(),
            states: vec![0.0; states.len()],
            redundant: Vec::new(),
            pair_angles: vec![Vec3::zeros(); self.pairs],
            measure_angles: Vec::new(),
        };
        let system = System {
            markers: model
                .markers
                .iter()
                .map(|m| name("MARKER", &m.header))
                .collect(),
            owners,
            used,
            order: (0..self.functions.len()).collect(),
            bodies: self.bodies,
            elements: self.elements,
            joints: self.joints,
            conditions: self.conditions,
            variables: self.variables,
            states,
            outputs: Vec::new(),
            functions: self.functions,
            gravity: self.gravity,
            ucf: model.units.ucf,
            catalogue: self.catalogue,
            parameters,
            initial,
            settings: model.equilibrium.clone(),
            first_equation: freedoms,
            equations: self.equations,
            first_variable,
            unknowns,
            length,
        };
        Checked {
            value: system,
            diagnostics: self.diagnostics,
        }
    }
}

/// The mean distance of used markers from the origin of their part: how far a radian reaches.
fn size(used: &[usize], owners: &[usize], parameters: &Parameters, poses: &[Pose]) -> f64 {
    let mut sum = 0.0;
    let mut count = 0;
    for &marker in used {
        let arm = (poses[owners[marker]].R * parameters.markers()[marker].p).norm();
        if arm > 0.0 && owners[marker] != 0 {
            sum += arm;
            count += 1;
        }
    }
    if count == 0 {
        1.0
    } else {
        sum / f64::from(count)
    }
}
