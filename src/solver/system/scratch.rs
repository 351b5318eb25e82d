use super::System;
use super::contribution::{Contribution, FunctionValue};
use super::surface::SLOTS;
use crate::constraint::Equations;
use crate::element::{MultiWrench, Wrench};
use crate::function::Seen;
use crate::mechanics::{Pose, RelativeMotion, Vec3};

/// What GCONs need for the differences of their gradients.
#[derive(Clone, Debug)]
pub(crate) struct Beside {
    pub state: super::State,
    pub scratch: Scratch,
    pub step: Vec<f64>,
}

/// A number that a function changes with, as a column of its gradient: the whole function if it is none of its literals.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seed {
    pub function: usize,
    pub literal: Option<usize>,
    pub column: usize,
}

/// Memory of one assembly, used again and again.
#[derive(Clone, Debug, Default)]
pub struct Scratch {
    /// Pose of every used marker in ground.
    pub(crate) markers: Vec<Pose>,
    /// From the reference point of its part to the marker, in ground axes.
    pub(crate) arms: Vec<Vec3>,
    pub(crate) wrench: Wrench,
    pub(crate) contribution: Contribution,
    pub(crate) equations: Equations,
    pub(crate) multi: MultiWrench,
    pub(crate) motions: Vec<RelativeMotion>,
    pub(crate) program: crate::function::Scratch,
    pub(crate) inputs: Vec<f64>,
    pub(crate) by_input: Vec<f64>,
    pub(crate) by_literal: Vec<f64>,
    /// Ends of the gradients of the inputs.
    pub(crate) spans: Vec<usize>,
    /// A configuration close by, for differences.
    pub(crate) beside: Option<Box<Beside>>,
    pub(crate) functions: Vec<FunctionValue>,
    /// How often functions were evaluated anew, and in which of these times each of those that are none of the equations was.
    pub(crate) looks: u64,
    pub(crate) looked: Vec<u64>,
    /// How many functions had no value and count as zero; an error where there is no number.
    pub(crate) lacking: Option<usize>,
    /// Further columns of gradients, behind those of the unknowns.
    pub(crate) seeds: Vec<Seed>,
    /// What was seen of each switch where the state is held on pieces.
    pub(crate) seen: Vec<Seen>,
    /// Displacement, its rate and second rate of the MOTIONs that prescribe a rate.
    pub(crate) driven: Vec<[f64; 3]>,
    /// (unknown, derivative) of all functions, one after the other.
    pub(crate) gradient: Vec<(usize, f64)>,
    /// The largest force and torque met: what round-off is measured by.
    pub(crate) largest: f64,
}

impl Scratch {
    /// Memory of the right size.
    pub fn new(system: &System) -> Self {
        Self {
            markers: vec![Pose::identity(); system.owners.len()],
            arms: vec![Vec3::zeros(); system.owners.len()],
            functions: vec![
                FunctionValue::default();
                system.functions.len() + SLOTS * system.frictions.len()
            ],
            looked: vec![u64::MAX; system.functions.len()],
            seen: vec![Seen::NOTHING; system.switches.len()],
            ..Self::default()
        }
    }
}
