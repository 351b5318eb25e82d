//! What a FUNCTION reads, with its indices resolved.

use super::Name;
use crate::function::{ForceComponent, Measure, Program, RateMeasure};

/// What exerts a wrench.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Exerted {
    Element(usize),
    /// A constraint by one of its terms.
    Joint(usize, usize),
    /// An NFORCE at one of its markers.
    Multi(usize, usize),
}

/// A component of the sum of some forces.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Force {
    /// Who, and whether the force on J (at the J origin) is meant.
    pub by: Vec<(Exerted, bool)>,
    pub component: ForceComponent,
    /// Axes that resolve it; ground if absent.
    pub axes: Option<usize>,
}

/// (state, coefficient), (variable, coefficient).
pub(crate) type LinearRow = (Vec<(usize, f64)>, Vec<(usize, f64)>);

/// An input of a program, with its indices resolved.
#[derive(Clone, Debug)]
pub(crate) enum Source {
    Time,
    Mode,
    /// And where its angle of the last equilibrium is kept.
    Measure(Measure, usize),
    /// A velocity or acceleration: zero in statics.
    Moved(RateMeasure),
    /// Where it is no unknown, its function stands in for it.
    Variable(usize),
    State(usize),
    /// Rate of a state: in statics the value of its function if it is held, else zero.
    StateRate(usize, Option<usize>),
    Output(LinearRow),
    Constant(f64),
    Sensor(usize),
    Force(Box<Force>),
    /// A number of the FRICTION with this id.
    Friction(u32, usize),
}

/// A FUNCTION of the model, ready to evaluate.
#[derive(Clone, Debug)]
pub(crate) struct CompiledFunction {
    /// The statement it belongs to.
    pub owner: Name,
    /// `None` for subroutines, which the built-in solver cannot run: zero.
    pub program: Option<Program>,
    /// One per input of the program.
    pub sources: Vec<Source>,
    /// Slots of its literals.
    pub literals: std::ops::Range<usize>,
    /// Slot of the constant that replaces it; NaN there means that the function itself is in force.
    pub replacement: usize,
    /// Its IMPACTs, BISTOPs and IFs among those of the system that a motion is held on pieces of.
    pub switches: std::ops::Range<usize>,
}
