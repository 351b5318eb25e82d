//! From a model to equations: compile, theta, state, assembly.
//!
//! [`System`] is the frozen structure, [`Parameters`] every number that may change between runs, [`State`] what a solve changes.
//! Knows no iteration and no factorisation.

mod assemble;
mod carried;
mod catalogue;
mod chain;
mod compile;
mod compiled_function;
mod condition;
mod configuration;
mod contribution;
mod creeping;
mod dependence;
mod derivative;
mod driven;
mod force_measure;
mod forces;
mod friction;
mod friction_measure;
mod function;
mod inertia;
mod linear_variables;
mod load;
mod multi;
mod name;
mod narrow_order;
mod no_value;
mod parameters;
mod quantity;
mod reactions;
mod reading;
mod redundancy;
mod request;
mod row_products;
mod rows;
mod scratch;
mod state;
mod structure;
mod surface;
mod update;

pub use catalogue::{Catalogue, Slot};
pub use chain::Twist;
pub(crate) use compile::name as name_of;
pub(crate) use configuration::Configuration;
pub use creeping::Grasp;
pub(crate) use creeping::SlidingWith;
pub use load::Load;
pub(crate) use name::EquationName;
pub use name::Name;
pub(crate) use no_value::{NoValue, Reason};
pub use parameters::Parameters;
pub use quantity::Quantity;
pub use reading::Reading;
pub(crate) use row_products::RowProducts;
pub(crate) use rows::Rows;
pub use scratch::Scratch;
pub(crate) use state::{Driven, Equilibrium, Grip};
pub use state::{Rates, State};
pub use structure::System;
pub(crate) use structure::{ConstraintIx, ElementIx};
