use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

use super::carried::Carried;
use super::compiled_function::{CompiledFunction, Exerted, Source};
use super::surface::Friction;
use super::{Catalogue, EquationName, Name, Parameters, State};
use crate::constraint::{Constraint, PairConstraint};
use crate::element::{Damping, Law, MultiPoint};
use crate::mechanics::{Mat3, Mat6, Vec3};
use crate::model::{EquilibriumSettings, PartIx};
use admire_syntax::diagnostic::Diagnostic;

/// Index of a force element of a [`System`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct ElementIx(pub usize);

/// Index of a constraint of a [`System`].
#[derive(Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Debug)]
pub struct ConstraintIx(pub usize);

/// A part or point mass.
#[derive(Clone, Debug)]
pub(crate) struct Body {
    pub name: Name,
    /// First unknown.
    pub first: usize,
    /// 0 for ground, 3 for a point mass, 6 for a part.
    pub freedoms: usize,
    /// Slot of MASS.
    pub mass: usize,
    pub cm: Option<usize>,
    /// What statics moves it by, part axes: its centre of mass, without one the mean of the markers that joints and forces act at. So
    /// nothing depends on where the part's frame is.
    pub centre: Vec3,
    /// Inertia matrix about the origin of the CM marker, in its axes.
    pub inertia: Mat3,
    pub start: Start,
}

/// How a body begins to move, as its statement has it.
#[derive(Clone, Debug)]
pub(crate) struct Start {
    /// VX, VY, VZ of the centre of mass, along the axes of a marker; ground axes if none is given.
    pub linear: [Option<f64>; 3],
    pub linear_axes: Option<usize>,
    /// WX, WY, WZ, along the axes of a marker; those of the part if none is given.
    pub angular: [Option<f64>; 3],
    pub angular_axes: Option<usize>,
    /// EXACT: x, y, z, psi, theta, phi.
    pub exact: [bool; 6],
}

/// What a force element does.
#[derive(Debug)]
pub(crate) enum Action {
    /// A force law of the pair, and where its parameters come from.
    Law(&'static dyn Law, Drive),
    /// Functions for force and torque components in the axes of the frame marker.
    Vector([Option<usize>; 6]),
}

/// A force element: a wrench on marker I, given in the axes of marker `frame`, with the opposite wrench at the I origin on the
/// part `reaction`.
#[derive(Debug)]
pub(crate) struct Element {
    pub name: Name,
    pub i: usize,
    /// J or JFLOAT.
    pub j: usize,
    /// The marker whose axes the wrench is given in: J, or RM of a vector force; `None` means ground axes.
    pub frame: Option<usize>,
    /// Part that takes the opposite wrench; `None` for ACTIONONLY.
    pub reaction: Option<usize>,
    pub action: Action,
    /// What it adds by the velocity of I in J.
    pub damping: Option<Damping>,
    /// Index into the angle references.
    pub pair: usize,
    pub active: bool,
}

/// NFORCE: a force between n markers and one.
#[derive(Debug)]
pub(crate) struct NForce {
    pub name: Name,
    pub i: Vec<usize>,
    pub j: usize,
    pub theta: Range<usize>,
    /// Angle references, one per I marker.
    pub pairs: Vec<usize>,
    /// Blocks of the damping matrix, row by row: wrench a by the velocity of marker b, J axes. Empty if there is none.
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

/// One summand of a constraint: a set of scalar equations between two markers.
#[derive(Debug)]
pub(crate) struct Term {
    pub i: usize,
    pub j: usize,
    pub law: PairConstraint,
    pub scale: f64,
    pub pair: usize,
}

/// Where the parameters of a force law or a constraint come from.
#[derive(Clone, Debug)]
pub(crate) enum Drive {
    /// Numbers of theta.
    Theta(Range<usize>),
    /// One parameter: the value of a function.
    Function(usize),
    /// A fixed number.
    Held(f64),
    /// A velocity or acceleration motion: in statics held where it is.
    Rate(RateDrive),
}

/// A MOTION that prescribes a rate.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RateDrive {
    /// The prescribed function: of time alone.
    pub function: usize,
    /// False for a velocity, true for an acceleration.
    pub second: bool,
    /// Index into [`State::driven`].
    pub index: usize,
    /// ICDISP; where the parts are if absent.
    pub start: Option<f64>,
    /// ICVEL.
    pub start_rate: f64,
}

/// JOINT, JPRIM, MOTION, COUPLER, GEAR: the scaled sum of its terms is zero.
#[derive(Debug)]
pub(crate) struct Joint {
    pub name: Name,
    pub terms: Vec<Term>,
    pub drive: Drive,
    /// What the sum is held at (GEAR).
    pub offset: f64,
    /// First scalar equation.
    pub first: usize,
    pub count: usize,
    pub active: bool,
}

impl Joint {
    /// How many terms, from the first on, act between the same two markers: what a COUPLER or GEAR does at its first joint. A cylindrical
    /// joint in a GEAR has two terms, what it turns and what it shifts.
    pub(crate) fn at_first(&self) -> usize {
        let ends = |term: &Term| (term.i, term.j);
        let first = self.terms.first().map(ends);
        let same = |term: &&Term| Some(ends(term)) == first;
        self.terms.iter().take_while(same).count()
    }
}

/// GCON: a function is zero.
#[derive(Debug)]
pub(crate) struct GconEquation {
    pub name: Name,
    /// I: where the reaction is reported.
    pub i: Option<usize>,
    pub function: usize,
    pub equation: usize,
    pub active: bool,
}

/// VARIABLE: the value of a function.
#[derive(Debug)]
pub struct VariableEquation {
    pub name: Name,
    pub function: usize,
    pub active: bool,
    /// Its unknown, value minus function being zero, if the function reads the VARIABLE itself.
    pub unknown: Option<usize>,
}

/// DIFF or a row of linear states: at rest.
#[derive(Clone, Debug)]
pub(crate) enum Rate {
    /// The function is zero.
    Function(usize),
    /// The state keeps its value: STATIC_HOLD, where it is not an unknown, or DYNAMIC_HOLD, or switched off.
    Held,
    /// Row of A x + B u = 0: (state, coefficient), (variable, coefficient).
    Linear(Vec<(usize, f64)>, Vec<(usize, f64)>),
}

/// One dynamic state.
#[derive(Debug)]
pub(crate) struct StateEquation {
    pub name: Name,
    pub rate: Rate,
    /// Its unknown in statics; none if held.
    pub unknown: Option<usize>,
    /// Its unknown in motion.
    pub moving_unknown: usize,
    /// What its rate is in motion, also where statics holds it.
    pub moving: Rate,
    /// The function is zero with the rate inside of it.
    pub implicit: bool,
    /// False if its statement is switched off: the state is zero then.
    pub active: bool,
}

/// The frozen structure of one model: what is connected to what, and where each unknown and each number stands.
///
/// Unknowns, in this order: of every part a translation of its reference point (ground axes) and a rotation vector (ground axes,
/// `R <- exp(dphi) R`), of every point mass a translation; one multiplier per scalar constraint equation; values of VARIABLEs that read
/// themselves; dynamic states that are not held. Equations have the same order: force and torque about the part's reference point (ground axes), constraints,
/// `v - e`, rates. The reference point is [`System::reference_point`].
#[derive(Debug)]
pub struct System {
    pub(crate) bodies: Vec<Body>,
    /// Part of each marker.
    pub(crate) owners: Vec<usize>,
    /// Which markers move with others.
    pub(crate) carried: Arc<Carried>,
    /// Of each floating marker the I marker of its force, which it is always at.
    pub(crate) floating: BTreeMap<usize, usize>,
    /// Names of the markers.
    pub(crate) markers: Vec<Name>,
    /// Markers whose place in ground is needed.
    pub(crate) used: Vec<usize>,
    pub(crate) elements: Vec<Element>,
    pub(crate) multis: Vec<NForce>,
    pub(crate) joints: Vec<Joint>,
    pub(crate) frictions: Vec<Friction>,
    pub(crate) conditions: Vec<GconEquation>,
    /// VARIABLEs: algebraic unknowns.
    pub variables: Vec<VariableEquation>,
    pub(crate) states: Vec<StateEquation>,
    /// F1 to F8 of each REQUEST of the model.
    pub(crate) requests: Vec<[Option<usize>; 8]>,
    /// FORCE requests.
    pub(crate) request_forces: Vec<Vec<(Exerted, bool)>>,
    /// FUNCTION and EVALUATE of each SENSOR of the model.
    pub(crate) sensors: Vec<(usize, Option<usize>)>,
    pub(crate) functions: Vec<CompiledFunction>,
    /// Functions of the equations, each after those it reads: what forces, constraints, rates of states, SENSORs and unknown VARIABLEs need.
    /// All others are evaluated where they are shown.
    pub(crate) order: Vec<usize>,
    /// Those of them that MOTIONs and GCONs need.
    pub(crate) order_of_constraints: Vec<usize>,
    /// Whether MOTIONs or GCONs read states or unknown VARIABLEs: these are then all of [`Self::order`].
    pub(crate) data_constrain: bool,
    /// Whether a function is among [`Self::order`].
    pub(crate) in_equations: Vec<bool>,
    /// The place of every function in an order in which each comes after those it reads.
    pub(crate) ranks: Vec<usize>,
    /// The VARIABLEs that are unknowns, in the order of these.
    pub(crate) implicit: Vec<usize>,
    /// First of three slots of gravity.
    pub(crate) gravity: usize,
    pub(crate) ucf: f64,
    /// Metres in a unit of length.
    pub(crate) metre: f64,
    pub(crate) catalogue: Catalogue,
    pub(crate) parameters: Parameters,
    pub(crate) initial: State,
    pub(crate) settings: EquilibriumSettings,
    /// First multiplier.
    pub(crate) first_equation: usize,
    pub(crate) equations: usize,
    pub(crate) first_variable: usize,
    pub(crate) unknowns: usize,
    /// The unknowns of a motion: the states that statics holds come last.
    pub(crate) moving_unknowns: usize,
    /// What a motion cannot take into account though statics can.
    pub(crate) not_in_motion: Vec<Diagnostic>,
    /// The joint of each constraint equation.
    pub(crate) joint_of: Vec<Option<usize>>,
    /// Of each constraint equation whether it holds velocities: `f(q, V, t) = 0`, linear in V, which no place satisfies or violates.
    pub(crate) is_nonholonomic: Vec<bool>,
    /// The mean mass and length that motions are measured by.
    pub(crate) reference_mass: f64,
    /// How far a radian reaches: the mean distance of markers from the centre of their part.
    pub length: f64,
    /// The size of the mechanism as the dataset has it: the largest distance of two markers, within a factor of two.
    pub(crate) extent: f64,
    /// Times at which functions of the time are not smooth, increasing.
    pub(crate) breaks: Vec<f64>,
    /// What [`State::pieces`] holds a motion on.
    pub(crate) switches: Vec<Switch>,
}

/// A function of several pieces within the one of a statement.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Switch {
    /// Which of the functions of the system.
    pub function: usize,
    /// The time alone chooses its piece.
    pub of_time: bool,
    /// Its value may jump where it changes.
    pub jumps: bool,
}

impl System {
    /// How many unknowns and equations there are.
    pub fn unknowns(&self) -> usize {
        self.unknowns
    }

    /// Index of the first multiplier: how many freedoms the parts have.
    pub fn equations_start(&self) -> usize {
        self.first_equation
    }

    /// What the equations of motion leave out; a motion without it would not be the model's.
    pub fn not_in_motion(&self) -> &[Diagnostic] {
        &self.not_in_motion
    }

    /// Which dynamic states are switched on.
    pub fn active_states(&self) -> Vec<bool> {
        self.states.iter().map(|state| state.active).collect()
    }

    /// The unknown of a dynamic state, if it is one.
    pub(crate) fn state_unknown(&self, state: usize, moving: bool) -> Option<usize> {
        let equation = &self.states[state];
        if moving {
            Some(equation.moving_unknown)
        } else {
            equation.unknown
        }
    }

    /// True if VARIABLEs or dynamic states are unknowns besides poses and multipliers.
    pub fn has_data_unknowns(&self) -> bool {
        self.first_variable < self.unknowns
    }

    /// The numbers of the dataset.
    pub fn parameters(&self) -> Parameters {
        self.parameters.clone()
    }

    /// The configuration of the dataset.
    pub fn state(&self) -> State {
        self.initial.clone()
    }

    /// EQUILIBRIUM as the dataset has it.
    pub fn settings(&self) -> &EquilibriumSettings {
        &self.settings
    }

    /// Which number of the dataset is which number of theta.
    pub fn catalogue(&self) -> &Catalogue {
        &self.catalogue
    }

    /// Unknowns of a part: translation of its reference point, then rotation vector, in ground axes. Empty for ground.
    pub fn part_unknowns(&self, part: PartIx) -> Range<usize> {
        let body = &self.bodies[part.0];
        body.first..body.first + body.freedoms
    }

    /// The reference point of a part, part axes: its centre in statics, its origin in motion, whose velocities results hold.
    pub fn local_reference(&self, state: &State, part: usize) -> Vec3 {
        if state.moves() {
            Vec3::zeros()
        } else {
            self.bodies[part].centre
        }
    }

    /// From the origin of a part to its reference point, ground axes.
    pub fn reference_arm(&self, state: &State, part: usize) -> Vec3 {
        state.poses[part].R * self.local_reference(state, part)
    }

    /// The point that the translation of a part moves and its torques are about, in ground: its centre of mass in statics (without one
    /// the mean of the markers that joints and forces act at), its origin in motion.
    pub fn reference_point(&self, state: &State, part: PartIx) -> Vec3 {
        state.poses[part.0].p + self.reference_arm(state, part.0)
    }

    /// True if a MOTION that is switched on drives parts.
    pub fn is_driven(&self) -> bool {
        let drives = |joint: &Joint| matches!(joint.drive, Drive::Function(_) | Drive::Rate(_));
        self.joints
            .iter()
            .any(|joint| joint.active && drives(joint))
    }

    /// The name of a part.
    pub fn part_name(&self, part: PartIx) -> &Name {
        &self.bodies[part.0].name
    }

    /// A force element by keyword and id.
    pub fn element(&self, kind: &str, id: u32) -> Option<ElementIx> {
        self.elements
            .iter()
            .position(|e| e.name.kind == kind && e.name.id == id)
            .map(ElementIx)
    }

    /// A constraint by keyword and id.
    pub fn constraint(&self, kind: &str, id: u32) -> Option<ConstraintIx> {
        self.joints
            .iter()
            .position(|c| c.name.kind == kind && c.name.id == id)
            .map(ConstraintIx)
    }

    /// All force elements.
    pub fn elements(&self) -> impl Iterator<Item = (ElementIx, &Name)> {
        self.elements
            .iter()
            .enumerate()
            .map(|(k, e)| (ElementIx(k), &e.name))
    }

    /// All constraints that act between markers.
    pub fn constraints(&self) -> impl Iterator<Item = (ConstraintIx, &Name)> {
        self.joints
            .iter()
            .enumerate()
            .map(|(k, c)| (ConstraintIx(k), &c.name))
    }

    /// What an equation balances, for messages: `PART/4 'KNUCKLE' force along x`, `JOINT/4 Zi.Xj`.
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

    /// False for an equation of a constraint that is switched off.
    pub fn equation_is_active(&self, equation: usize) -> bool {
        // Joints stand in the order of their equations, conditions too; each equation is one of either.
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

    /// True for an equation that is switched on and not redundant.
    pub(crate) fn takes_part(&self, state: &State, equation: usize) -> bool {
        state.redundant.get(equation) != Some(&true) && self.equation_is_active(equation)
    }

    /// True for an equation that takes part and holds places; all others hold velocities or nothing.
    pub(crate) fn holds_places(&self, state: &State, equation: usize) -> bool {
        !self.is_nonholonomic[equation] && self.takes_part(state, equation)
    }

    /// Whether in motion the equation of this state reads its own rate.
    pub(crate) fn state_reads_rate(&self, state: usize) -> bool {
        let Rate::Function(function) = self.states[state].moving else {
            return false;
        };
        let sources = self.functions[function].sources.iter();
        let own = |source: &Source| matches!(source, Source::StateRate(k, _) if *k == state);
        sources.into_iter().any(own)
    }

    /// Degrees of freedom of the parts less the equations that take part: of the velocities, where some hold these.
    pub(crate) fn freedoms_left(&self, state: &State) -> usize {
        let held = (0..self.equations).filter(|&k| self.takes_part(state, k));
        self.first_equation.saturating_sub(held.count())
    }

    /// What an unknown of a part moves, for messages: `PART/4 'KNUCKLE' along x`.
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

    /// `Zi.Xj in JOINT/4`, as ADAMS names an equation (guide/formats.md 6.5).
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
