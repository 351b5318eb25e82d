//! Equations of a model: compilation, parameters (theta), state and assembly.
//!
//! [`System`] is the fixed structure, [`Parameters`] holds every parameter that may change between runs, and [`State`] holds the values
//! that a solver changes. The module contains no iteration and no factorisation.

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
pub use compile::name as name_of;
pub use configuration::Configuration;
pub use creeping::SlidingWith;
pub use creeping::StickSlipState;
pub use load::Load;
pub use name::EquationName;
pub use name::Name;
pub use no_value::NoValue;
pub(crate) use no_value::NoValueReason;
pub use parameters::Parameters;
pub use quantity::Quantity;
pub use reading::Reading;
pub(crate) use row_products::RowProducts;
pub(crate) use rows::Rows;
pub use scratch::Scratch;
pub use state::Driven;
pub use state::Equilibrium;
pub use state::StictionState;
pub use state::{PartRates, State};
pub use structure::ConstraintIx;
pub use structure::ElementIx;
pub use structure::System;
