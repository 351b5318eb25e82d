//! From a model to equations: compile, theta, state, assembly.
//!
//! [`System`] is the frozen structure, [`Parameters`] every number that may change between runs, [`State`] what a solve changes.
//! Knows no iteration and no factorisation.

mod assemble;
mod catalogue;
mod chain;
mod compile;
mod condition;
mod configuration;
mod contribution;
mod creeping;
mod derivative;
mod driven;
mod force_measure;
mod forces;
mod friction;
mod friction_measure;
mod function;
mod inertia;
mod load;
mod multi;
mod parameters;
mod quantity;
mod reactions;
mod reading;
mod redundancy;
mod request;
mod rows;
mod scratch;
mod state;
mod structure;
mod update;

pub use assemble::{NoValue, Reason};
pub use catalogue::{Catalogue, Slot, SlotInfo};
pub use configuration::Configuration;
pub use contribution::Twist;
pub use creeping::{Grasp, SlidingWith};
pub use friction::{FrictionReading, Grip};
pub use load::Load;
pub use parameters::Parameters;
pub use quantity::Quantity;
pub use reading::Reading;
pub(crate) use rows::Rows;
pub use scratch::Scratch;
pub use state::{Driven, Equilibrium, Rates, State};
pub use structure::{ConstraintIx, ElementIx, Name, System};
