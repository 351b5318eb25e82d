//! Compiled FUNCTIONs with the resolved indices of their inputs.

use super::Name;
use crate::function::{ForceComponent, Measure, Program, RateMeasure};

/// Source of a wrench.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Exerted {
    Element(usize),
    /// Constraint, by one of its terms.
    Joint(usize, usize),
    /// NFORCE at one of its markers.
    Multi(usize, usize),
}

/// Component of the sum of several forces.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Force {
    /// Sources of the force, each with a flag that selects the force on J (at the J origin).
    pub by: Vec<(Exerted, bool)>,
    pub component: ForceComponent,
    /// Marker whose axes resolve the force; ground if absent.
    pub axes: Option<usize>,
}

/// Linear combination: (state, coefficient) and (variable, coefficient).
pub(crate) type LinearRow = (Vec<(usize, f64)>, Vec<(usize, f64)>);

/// Input of a program, with its indices resolved.
#[derive(Clone, Debug)]
pub(crate) enum Source {
    Time,
    Mode,
    /// Geometric measure, with the index of its reference angle in `State::measure_angles`.
    Measure(Measure, usize),
    /// Velocity or acceleration; zero in statics.
    Moved(RateMeasure),
    /// VARIABLE. If it is not an unknown, the value of its function is used.
    Variable(usize),
    State(usize),
    /// Rate of a state. In statics it is the value of the given function if the state is held constant, and zero otherwise.
    StateRate(usize, Option<usize>),
    Output(LinearRow),
    Constant(f64),
    Sensor(usize),
    Force(Box<Force>),
    /// Quantity of the FRICTION with this id.
    Friction(u32, usize),
}

/// FUNCTION of the model, ready for evaluation.
#[derive(Clone, Debug)]
pub(crate) struct CompiledFunction {
    /// Statement of the function.
    pub owner: Name,
    /// Compiled program. `None` for user subroutines, which the built-in solver cannot run and takes as zero.
    pub program: Option<Program>,
    /// Sources of the inputs of the program, in their order.
    pub sources: Vec<Source>,
    /// Slots of its literals in theta.
    pub literals: std::ops::Range<usize>,
    /// Slot of the constant that replaces the function. NaN means that the function itself is used.
    pub replacement: usize,
    /// Range of its switches (IMPACT, BISTOP, IF, ...) among the switches of the system.
    pub switches: std::ops::Range<usize>,
}
