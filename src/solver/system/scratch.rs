use super::System;
use super::contribution::{Contribution, FunctionValue};
use super::surface::SLOTS;
use crate::constraint::Equations;
use crate::element::{MultiWrench, Wrench};
use crate::function::SwitchState;
use crate::mechanics::{Pose, RelativeMotion, Vec3};

/// Working memory for finite differences of GCON gradients.
#[derive(Clone, Debug)]
pub(crate) struct NeighbourState {
    pub state: super::State,
    pub scratch: Scratch,
    pub step: Vec<f64>,
}

/// Number of a function with respect to which a derivative is taken.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum FunctionNumber {
    /// Value of the function itself.
    Value,
    /// Literal of the expression.
    Literal(usize),
    /// y value of a SPLINE: index of the SPLINE in the model, index of the point.
    Knot(usize, usize),
}

/// Additional gradient column of a function: the derivative with respect to one of its numbers (see [`FunctionNumber`]).
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seed {
    pub function: usize,
    pub number: FunctionNumber,
    pub column: usize,
}

/// Working memory of an assembly, reused between assemblies.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// Pose of every used marker in ground.
    pub(crate) markers: Vec<Pose>,
    /// Vector from the reference point of the marker's part to each marker, in ground axes.
    pub(crate) arms: Vec<Vec3>,
    pub(crate) wrench: Wrench,
    pub(crate) contribution: Contribution,
    pub(crate) equations: Equations,
    pub(crate) multi: MultiWrench,
    pub(crate) motions: Vec<RelativeMotion>,
    pub(crate) program: crate::function::EvaluationMemory,
    pub(crate) inputs: Vec<f64>,
    pub(crate) by_input: Vec<f64>,
    pub(crate) by_literal: Vec<f64>,
    /// For each input of a function, the end index of its gradient in `gradient`.
    pub(crate) spans: Vec<usize>,
    /// Neighbouring configuration for finite differences.
    pub(crate) beside: Option<Box<NeighbourState>>,
    pub(crate) functions: Vec<FunctionValue>,
    /// Counter of the calls that evaluate the functions.
    pub(crate) looks: u64,
    /// For each function outside the equations, the value of `looks` at its last evaluation.
    pub(crate) looked: Vec<u64>,
    /// Number of undefined functions that were replaced by zero so far. `None` means that an undefined function is an error.
    pub(crate) lacking: Option<usize>,
    /// Additional gradient columns, which follow the columns of the unknowns.
    pub(crate) seeds: Vec<Seed>,
    /// Observed state of each switch while the functions are held on pieces.
    pub(crate) seen: Vec<SwitchState>,
    /// Displacement, velocity and acceleration of each MOTION that prescribes a velocity or acceleration.
    pub(crate) driven: Vec<[f64; 3]>,
    /// Gradients of all functions as (unknown, derivative), one after the other.
    pub(crate) gradient: Vec<(usize, f64)>,
    /// Largest force or torque encountered, used as the reference for round-off.
    pub(crate) largest: f64,
}

impl Scratch {
    /// Allocates the memory for a system.
    pub fn new(system: &System) -> Self {
        Self {
            markers: vec![Pose::identity(); system.owners.len()],
            arms: vec![Vec3::zeros(); system.owners.len()],
            functions: vec![
                FunctionValue::default();
                system.functions.len() + SLOTS * system.frictions.len()
            ],
            looked: vec![u64::MAX; system.functions.len()],
            seen: vec![SwitchState::NOTHING; system.switches.len()],
            ..Self::default()
        }
    }
}
