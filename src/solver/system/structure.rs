use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::carried::Carried;
use super::compiled_function::{CompiledFunction, Exerted, Source};
use super::surface::JointFriction;
use super::{Catalogue, EquationName, Name, Parameters, State};
use crate::constraint::{Constraint, PairConstraint};
use crate::element::{Damping, ElementLaw, MultiPoint};
use crate::mechanics::{Mat3, Mat6, Vec3};
use crate::model::{EquilibriumSettings, PartIx};
use admire_syntax::diagnostic::Diagnostic;

/// Index of a force element in a [`System`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct ElementIx(pub usize);

/// Index of a constraint in a [`System`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct ConstraintIx(pub usize);

/// Body of the system: a part or a point mass.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub name: Name,
    /// Index of the body's first unknown.
    pub first: usize,
    /// Number of degrees of freedom: 0 for ground, 3 for a point mass, 6 for a part.
    pub freedoms: usize,
    /// Index of MASS in theta.
    pub mass: usize,
    /// CM marker, if given.
    pub cm: Option<usize>,
    /// Reference point of the part in statics, in part axes.
    ///
    /// It is the centre of mass or, without a CM marker, the mean of the markers at which joints and forces act. The solution is therefore
    /// independent of the position of the part's frame.
    pub centre: Vec3,
    /// Inertia matrix about the origin of the CM marker, in the axes of the CM marker.
    pub inertia: Mat3,
    pub start: Start,
}

/// Initial velocity of a body, as given by its statement.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    /// VX, VY, VZ: velocity of the centre of mass along the axes of `linear_axes`.
    pub linear: [Option<f64>; 3],
    /// Marker that gives the axes of the linear velocity; ground axes if absent.
    pub linear_axes: Option<usize>,
    /// WX, WY, WZ: angular velocity along the axes of `angular_axes`.
    pub angular: [Option<f64>; 3],
    /// Marker that gives the axes of the angular velocity; part axes if absent.
    pub angular_axes: Option<usize>,
    /// EXACT: whether x, y, z, psi, theta, phi are kept by the assembly.
    pub exact: [bool; 6],
}

/// Definition of the force that an element exerts.
#[derive(Debug)]
pub(crate) enum Action {
    /// Force law between the two markers, with the source of the law's parameters.
    Law(ElementLaw, ParameterSource),
    /// Functions of the force and torque components, in the axes of the frame marker.
    Vector([Option<usize>; 6]),
}

/// Force element: a wrench on marker I, given in the axes of marker `frame`. The opposite wrench acts at the I origin on the part
/// `reaction`.
#[derive(Debug)]
pub(crate) struct Element {
    pub name: Name,
    pub i: usize,
    /// J or JFLOAT marker.
    pub j: usize,
    /// Marker whose axes resolve the wrench: J, or RM for a vector force. `None` means ground axes.
    pub frame: Option<usize>,
    /// Part on which the reaction acts; `None` for ACTIONONLY.
    pub reaction: Option<usize>,
    pub action: Action,
    /// Damping, which depends on the velocity of I relative to J.
    pub damping: Option<Damping>,
    /// Index into `State::pair_angles`.
    pub pair: usize,
    pub active: bool,
}

/// NFORCE: a force between n I markers and one J marker.
#[derive(Debug)]
pub(crate) struct NForce {
    pub name: Name,
    pub i: Vec<usize>,
    pub j: usize,
    /// Range of the parameters in theta.
    pub theta: Range<usize>,
    /// Indices into `State::pair_angles`, one per I marker.
    pub pairs: Vec<usize>,
    /// Blocks of the damping matrix, row by row. Each block is the derivative of wrench a with respect to the velocity of marker b, in J
    /// axes. Empty without damping.
    pub damping: Vec<Mat6>,
    pub active: bool,
}

impl NForce {
    pub(super) fn law(&self) -> MultiPoint {
        MultiPoint {
            markers: self.i.len(),
        }
    }
}

/// Term of a constraint: a set of scalar equations between two markers, multiplied by a scale.
#[derive(Debug)]
pub(crate) struct Term {
    pub i: usize,
    pub j: usize,
    pub law: PairConstraint,
    pub scale: f64,
    pub pair: usize,
}

/// Source of the parameters of a force law or a constraint.
#[derive(Clone, Debug)]
pub(crate) enum ParameterSource {
    /// Range of parameters in theta.
    Theta(Range<usize>),
    /// Value of a function as the only parameter.
    Function(usize),
    /// Constant value as the only parameter.
    Constant(f64),
    /// MOTION that prescribes a velocity or acceleration. Its displacement is held constant in statics.
    Rate(RateDrive),
}

/// MOTION that prescribes a velocity or an acceleration.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RateDrive {
    /// Prescribed function, which depends on time alone.
    pub function: usize,
    /// Whether the function is an acceleration (true) or a velocity (false).
    pub second: bool,
    /// Index into [`State::driven`].
    pub index: usize,
    /// Initial displacement ICDISP. If absent, the motion starts at the displacement of the parts at that time.
    pub start: Option<f64>,
    /// Initial velocity, ICVEL.
    pub start_rate: f64,
}

/// Constraint of a JOINT, JPRIM, MOTION, COUPLER or GEAR: the sum of its terms, each multiplied by its scale, equals `offset`.
#[derive(Debug)]
pub(crate) struct ConstraintEquation {
    pub name: Name,
    pub terms: Vec<Term>,
    pub drive: ParameterSource,
    /// Constant that the sum must equal; nonzero only for GEAR.
    pub offset: f64,
    /// Index of the first scalar equation.
    pub first: usize,
    pub count: usize,
    pub active: bool,
}

impl ConstraintEquation {
    /// Returns the number of leading terms that act between the same two markers. For a COUPLER or GEAR, these are the terms at its first
    /// joint. A cylindrical joint in a GEAR has two terms, rotation and translation.
    pub(crate) fn at_first(&self) -> usize {
        let ends = |term: &Term| (term.i, term.j);
        let first = self.terms.first().map(ends);
        let same = |term: &&Term| Some(ends(term)) == first;
        self.terms.iter().take_while(same).count()
    }
}

/// GCON: constrains a function to zero.
#[derive(Debug)]
pub(crate) struct GconEquation {
    pub name: Name,
    /// I marker, at which the reaction is reported.
    pub i: Option<usize>,
    pub function: usize,
    pub equation: usize,
    pub active: bool,
}

/// VARIABLE statement: a variable that equals the value of a function.
#[derive(Debug)]
pub struct VariableEquation {
    pub name: Name,
    pub function: usize,
    pub active: bool,
    /// Index of the unknown, if the function depends on the VARIABLE itself. The equation is then `value - function = 0`.
    pub unknown: Option<usize>,
}

/// Right-hand side of a DIFF or of a row of linear states.
#[derive(Clone, Debug)]
pub(crate) enum StateRhs {
    /// Value of a function.
    Function(usize),
    /// Zero: the state is constant. Used for STATIC_HOLD (in statics the state is then not an unknown), DYNAMIC_HOLD and inactive
    /// statements.
    Held,
    /// Row of A x + B u: pairs (state, coefficient), and pairs (variable, coefficient).
    Linear(Vec<(usize, f64)>, Vec<(usize, f64)>),
}

/// Equation of one dynamic state.
#[derive(Debug)]
pub(crate) struct StateEquation {
    pub name: Name,
    /// Right-hand side in statics, which is zero at equilibrium.
    pub rate: StateRhs,
    /// Index of the state's unknown in statics; `None` if the state is held constant.
    pub unknown: Option<usize>,
    /// Index of the state's unknown in motion.
    pub moving_unknown: usize,
    /// Right-hand side in motion; also set for a state that statics holds constant.
    pub moving: StateRhs,
    /// Whether the equation is implicit: the function contains the rate and equals zero.
    pub implicit: bool,
    /// Whether the statement is active. The state of an inactive statement is zero.
    pub active: bool,
}

/// Fixed structure of one model: its topology, and the indices of the unknowns and parameters.
///
/// The unknowns are ordered as follows:
/// - for each part, a translation of its reference point and a rotation vector (ground axes, `R <- exp(dphi) R`); for each point mass, a
///   translation;
/// - one multiplier for each scalar constraint equation;
/// - values of VARIABLEs that depend on themselves;
/// - dynamic states that are not held constant.
///
/// The equations have the same order: force and torque about the part's reference point (ground axes), constraints, `v - e`, rates of
/// states. The reference point is [`System::reference_point`].
#[derive(Debug)]
pub struct System {
    pub(crate) bodies: Vec<Body>,
    /// Index of the part that carries each marker.
    pub(crate) owners: Vec<usize>,
    /// Markers that move with other markers (RM).
    pub(crate) carried: Arc<Carried>,
    /// For each floating marker, the I marker of the force it belongs to. The two markers always coincide.
    pub(crate) floating: BTreeMap<usize, usize>,
    /// Names of the markers.
    pub(crate) markers: Vec<Name>,
    /// Markers whose pose in ground is needed.
    pub(crate) used: Vec<usize>,
    pub(crate) elements: Vec<Element>,
    pub(crate) multis: Vec<NForce>,
    pub(crate) joints: Vec<ConstraintEquation>,
    pub(crate) frictions: Vec<JointFriction>,
    pub(crate) conditions: Vec<GconEquation>,
    /// Equations of the VARIABLEs.
    pub variables: Vec<VariableEquation>,
    pub(crate) states: Vec<StateEquation>,
    /// Functions F1 to F8 of each REQUEST of the model.
    pub(crate) requests: Vec<[Option<usize>; 8]>,
    /// For each FORCE request, the elements that act between its markers. The flag of each element is true if the I marker of the request
    /// is the element's J marker.
    pub(crate) request_forces: Vec<Vec<(Exerted, bool)>>,
    /// FUNCTION and EVALUATE of each SENSOR of the model.
    pub(crate) sensors: Vec<(usize, Option<usize>)>,
    pub(crate) functions: Vec<CompiledFunction>,
    /// Functions that the equations need, each after the functions it reads. The equations include forces, constraints, rates of states,
    /// SENSORs and unknown VARIABLEs. All other functions are evaluated only when their value is reported.
    pub(crate) order: Vec<usize>,
    /// Functions among [`Self::order`] that MOTIONs and GCONs need.
    pub(crate) order_of_constraints: Vec<usize>,
    /// Whether MOTIONs or GCONs read states or unknown VARIABLEs. `order_of_constraints` then equals [`Self::order`].
    pub(crate) data_constrain: bool,
    /// Whether each function is in [`Self::order`].
    pub(crate) in_equations: Vec<bool>,
    /// Rank of every function in an order in which each function comes after the functions it reads.
    pub(crate) ranks: Vec<usize>,
    /// VARIABLEs that are unknowns, in the order of their unknowns.
    pub(crate) implicit: Vec<usize>,
    /// Index in theta of the first of the three gravity components.
    pub(crate) gravity: usize,
    pub(crate) ucf: f64,
    /// Length unit of the model, in metres.
    pub(crate) metre: f64,
    pub(crate) catalogue: Catalogue,
    pub(crate) parameters: Parameters,
    pub(crate) initial: State,
    pub(crate) settings: EquilibriumSettings,
    /// Index of the first multiplier among the unknowns, and of the first constraint equation among the equations.
    pub(crate) first_equation: usize,
    pub(crate) equations: usize,
    pub(crate) first_variable: usize,
    pub(crate) unknowns: usize,
    /// Number of unknowns in motion. The states that statics holds constant come last.
    pub(crate) moving_unknowns: usize,
    /// Diagnostics of statements that statics can solve but motion cannot.
    pub(crate) not_in_motion: Vec<Diagnostic>,
    /// Index in `joints` of the constraint to which each scalar constraint equation belongs; `None` for a GCON.
    pub(crate) joint_of: Vec<Option<usize>>,
    /// Whether each constraint equation is nonholonomic: `f(q, V, t) = 0`, linear in the velocities V. Such an equation does not constrain
    /// the positions alone.
    pub(crate) is_nonholonomic: Vec<bool>,
    /// Mass scale of the equations of motion: the median mass of the bodies.
    pub(crate) reference_mass: f64,
    /// Length scale that converts radians to lengths: the mean distance of markers from the centres of their parts.
    pub length: f64,
    /// Size of the mechanism in the dataset: the largest distance between two markers, accurate within a factor of two.
    pub(crate) extent: f64,
    /// Times at which functions of time are not smooth, in increasing order.
    pub(crate) breaks: Vec<f64>,
    /// Piecewise functions, to which the entries of [`State::pieces`] refer.
    pub(crate) switches: Vec<Switch>,
}

/// Piecewise function within the FUNCTION of a statement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Switch {
    /// Index of the function in the system.
    pub function: usize,
    /// Whether the piece depends on time alone.
    pub of_time: bool,
    /// Whether the value of the function may jump when the piece changes.
    pub jumps: bool,
}

impl System {
    /// Returns the number of unknowns, which equals the number of equations.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Returns the index of the first multiplier, which equals the number of degrees of freedom of the parts.
    pub fn equations_start(&self) -> usize {
        self.first_equation
    }

    /// Returns diagnostics of statements that the equations of motion do not include. If there are any, a dynamic simulation would not
    /// represent the model.
    pub fn not_in_motion(&self) -> &[Diagnostic] {
        &self.not_in_motion
    }

    /// Returns for each dynamic state whether it is active.
    pub fn active_states(&self) -> Vec<bool> {
        self.states.iter().map(|state| state.active).collect()
    }

    /// Returns the index of the unknown of a dynamic state, or `None` if the state is held constant.
    pub(crate) fn state_unknown(&self, state: usize, moving: bool) -> Option<usize> {
        let equation = &self.states[state];
        if moving {
            Some(equation.moving_unknown)
        } else {
            equation.unknown
        }
    }

    /// Returns whether VARIABLEs or dynamic states are unknowns, in addition to poses and multipliers.
    pub fn has_data_unknowns(&self) -> bool {
        self.first_variable < self.unknowns
    }

    /// Returns the parameters with their values from the dataset.
    pub fn parameters(&self) -> Parameters {
        self.parameters.clone()
    }

    /// Returns the initial state, as given by the dataset.
    pub fn state(&self) -> State {
        self.initial.clone()
    }

    /// Returns the settings of EQUILIBRIUM.
    pub fn settings(&self) -> &EquilibriumSettings {
        &self.settings
    }

    /// Returns the catalogue, which maps addresses in the dataset to parameters in theta.
    pub fn catalogue(&self) -> &Catalogue {
        &self.catalogue
    }

    /// Returns the indices of the unknowns of a part: translation of its reference point, then rotation vector, in ground axes. The range
    /// is empty for ground.
    pub fn part_unknowns(&self, part: PartIx) -> Range<usize> {
        let body = &self.bodies[part.0];
        body.first..body.first + body.freedoms
    }

    /// Returns the reference point of a part in part axes. In statics, it is the centre. In motion, it is the origin, because results
    /// report the velocity of the origin.
    pub fn local_reference(&self, state: &State, part: usize) -> Vec3 {
        if state.moves() {
            Vec3::zeros()
        } else {
            self.bodies[part].centre
        }
    }

    /// Returns the vector from the origin of a part to its reference point, in ground axes.
    pub fn reference_arm(&self, state: &State, part: usize) -> Vec3 {
        state.poses[part].R * self.local_reference(state, part)
    }

    /// Returns the reference point of a part in ground, to which its translation and its torque balance refer.
    ///
    /// In statics, it is the centre of mass or, without a CM marker, the mean of the markers at which joints and forces act. In motion, it
    /// is the origin of the part.
    pub fn reference_point(&self, state: &State, part: PartIx) -> Vec3 {
        state.poses[part.0].p + self.reference_arm(state, part.0)
    }

    /// Returns whether any active MOTION exists.
    pub fn is_driven(&self) -> bool {
        let drives = |joint: &ConstraintEquation| {
            matches!(
                joint.drive,
                ParameterSource::Function(_) | ParameterSource::Rate(_)
            )
        };
        self.joints
            .iter()
            .any(|joint| joint.active && drives(joint))
    }

    /// Returns the name of a part.
    pub fn part_name(&self, part: PartIx) -> &Name {
        &self.bodies[part.0].name
    }

    /// Returns the index of the force element with this keyword and id.
    pub fn element(&self, kind: &str, id: u32) -> Option<ElementIx> {
        self.elements
            .iter()
            .position(|e| e.name.kind == kind && e.name.id == id)
            .map(ElementIx)
    }

    /// Returns the index of the constraint with this keyword and id.
    pub fn constraint(&self, kind: &str, id: u32) -> Option<ConstraintIx> {
        self.joints
            .iter()
            .position(|c| c.name.kind == kind && c.name.id == id)
            .map(ConstraintIx)
    }

    /// Returns the indices and names of all force elements.
    pub fn elements(&self) -> impl Iterator<Item = (ElementIx, &Name)> {
        self.elements
            .iter()
            .enumerate()
            .map(|(k, e)| (ElementIx(k), &e.name))
    }

    /// Returns the indices and names of all constraints that act between markers.
    pub fn constraints(&self) -> impl Iterator<Item = (ConstraintIx, &Name)> {
        self.joints
            .iter()
            .enumerate()
            .map(|(k, c)| (ConstraintIx(k), &c.name))
    }

    /// Returns the name of an equation for messages: `PART/4 'KNUCKLE' force along x`, `JOINT/4 Zi.Xj`.
    pub fn equation_name(&self, equation: usize) -> String {
        const BALANCE: [&str; 6] = [
            "force along x",
            "force along y",
            "force along z",
            "torque about x",
            "torque about y",
            "torque about z",
        ];
        if equation < self.first_equation {
            let k = self
                .bodies
                .partition_point(|b| b.first + b.freedoms <= equation);
            let body = &self.bodies[k];
            return format!("{} {}", body.name, BALANCE[equation - body.first]);
        }
        if equation < self.first_variable {
            let name = self.constraint_equation_name(equation - self.first_equation);
            return name.to_string();
        }
        if let Some(&variable) = self.implicit.get(equation - self.first_variable) {
            return self.variables[variable].name.to_string();
        }
        self.states
            .iter()
            .find(|s| s.unknown == Some(equation) || s.moving_unknown == equation)
            .map_or_else(String::new, |s| s.name.to_string())
    }

    /// Returns whether a constraint equation is active: false if its constraint is inactive.
    pub fn equation_is_active(&self, equation: usize) -> bool {
        // Each equation belongs to a joint or to a GCON.
        let at = self.joint_of.get(equation).copied().flatten();
        match at {
            Some(joint) => self.joints[joint].active,
            None => self
                .conditions
                .iter()
                .find(|c| c.equation == equation)
                .is_none_or(|c| c.active),
        }
    }

    /// Returns whether a constraint equation is active and not redundant.
    pub(crate) fn is_effective(&self, state: &State, equation: usize) -> bool {
        state.redundant.get(equation) != Some(&true) && self.equation_is_active(equation)
    }

    /// Returns whether a constraint equation is active, not redundant, and holonomic (constrains positions).
    pub(crate) fn is_effective_holonomic(&self, state: &State, equation: usize) -> bool {
        !self.is_nonholonomic[equation] && self.is_effective(state, equation)
    }

    /// Returns whether the equation of a dynamic state reads the state's own rate in motion.
    pub(crate) fn state_reads_rate(&self, state: usize) -> bool {
        let StateRhs::Function(function) = self.states[state].moving else {
            return false;
        };
        let sources = self.functions[function].sources.iter();
        let own = |source: &Source| matches!(source, Source::StateRate(k, _) if *k == state);
        sources.into_iter().any(own)
    }

    /// Returns the degrees of freedom of the parts minus the number of active, non-redundant constraint equations. Nonholonomic equations
    /// count too, so the result is the number of free velocities.
    pub(crate) fn freedoms_left(&self, state: &State) -> usize {
        let held = (0..self.equations).filter(|&k| self.is_effective(state, k));
        self.first_equation.saturating_sub(held.count())
    }

    /// Returns the name of an unknown for messages: `PART/4 'KNUCKLE' along x`.
    pub(crate) fn freedom_name(&self, unknown: usize) -> String {
        const FREEDOMS: [&str; 6] = [
            "along x", "along y", "along z", "about x", "about y", "about z",
        ];
        if unknown >= self.first_equation {
            return self.equation_name(unknown);
        }
        let k = self
            .bodies
            .partition_point(|b| b.first + b.freedoms <= unknown);
        let body = &self.bodies[k];
        format!("{} {}", body.name, FREEDOMS[unknown - body.first])
    }

    /// Returns the name of a constraint equation as ADAMS writes it: `Zi.Xj in JOINT/4` (guide/formats.md 6.5).
    pub fn constraint_equation_name(&self, equation: usize) -> EquationName {
        for joint in &self.joints {
            if (joint.first..joint.first + joint.count).contains(&equation) {
                let what = match joint.terms.as_slice() {
                    [term] => Some(term.law.equation_name(equation - joint.first)),
                    _ => None,
                };
                let object = joint.name.clone();
                return EquationName { what, object };
            }
        }
        let condition = self.conditions.iter().find(|c| c.equation == equation);
        EquationName {
            what: None,
            object: condition
                .expect("every constraint equation is of a joint or a GCON")
                .name
                .clone(),
        }
    }
}
