//! Compiled FUNCTIONs with the resolved indices of their inputs.

use super::Name;
use crate::function::{ForceComponent, Measure, Program, RateMeasure};

/// Object that exerts a wrench.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Exerted {
    Element(usize),
    /// Term of a constraint: index of the constraint, index of the term.
    Joint(usize, usize),
    /// NFORCE at one of its I markers: index of the NFORCE, index of the marker.
    Multi(usize, usize),
}

/// Component of a measured force, which is the sum of several forces.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Force {
    /// Objects that exert the force, each with a flag that selects the force on J (at the J origin).
    pub by: Vec<(Exerted, bool)>,
    pub component: ForceComponent,
    /// Marker whose axes resolve the force; ground if absent.
    pub axes: Option<usize>,
}

/// Linear combination of states and variables: pairs (state, coefficient), and pairs (variable, coefficient).
pub(crate) type LinearRow = (Vec<(usize, f64)>, Vec<(usize, f64)>);

/// Input of a program, with its indices resolved.
#[derive(Clone, Debug)]
pub(crate) enum Source {
    Time,
    Mode,
    /// Geometric measure, with the index of its reference angle in `State::measure_angles`.
    Measure(Measure, usize),
    /// Velocity or acceleration of markers; zero in statics.
    Moved(RateMeasure),
    /// VARIABLE. If the VARIABLE is not an unknown, the value of its function is used.
    Variable(usize),
    State(usize),
    /// Rate of a state (first index). In statics, the rate of a state that is held constant is the value of the function with the second index. All
    /// other rates are zero in statics.
    StateRate(usize, Option<usize>),
    Output(LinearRow),
    Constant(f64),
    Sensor(usize),
    Force(Box<Force>),
    /// Quantity of a FRICTION: id of the FRICTION, index of the quantity.
    Friction(u32, usize),
}

/// FUNCTION of the model, ready for evaluation.
#[derive(Clone, Debug)]
pub(crate) struct CompiledFunction {
    /// Statement that contains the function.
    pub owner: Name,
    /// Compiled program. `None` for user subroutines, which the built-in solver cannot run and takes as zero.
    pub program: Option<Program>,
    /// Sources of the program's inputs, in the order of the inputs.
    pub sources: Vec<Source>,
    /// Slots of the function's literals in theta.
    pub literals: std::ops::Range<usize>,
    /// Slot of the constant that replaces the function. NaN means that the function itself is used.
    pub replacement: usize,
    /// Range of the function's switches (IMPACT, BISTOP, IF, ...) among the switches of the system.
    pub switches: std::ops::Range<usize>,
}
