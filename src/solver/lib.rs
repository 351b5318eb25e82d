//! The multibody solver: from a dataset to equations, equilibria and motions.
//!
//! The modules build on each other in this order:
//! - [`mechanics`]: poses, rotations and relative motion.
//! - [`linear`]: sparse matrices and their LU factors.
//! - [`model`]: the typed, named objects of a dataset.
//! - [`function`]: compiled FUNCTION expressions.
//! - [`element`]: the force laws, one file each.
//! - [`constraint`]: the joints and primitives, one file each.
//! - [`system`]: [`system::System`] is the fixed structure of a model. [`system::Parameters`] holds every parameter that may change between
//!   runs. [`system::State`] holds everything that a solution changes.
//! - [`statics`]: [`statics::Solver`] finds equilibria and their exact sensitivities.
//! - [`motion`]: initial conditions, kinematic analysis, integration over time and small motions about a state.
//!
//! The crate is independent of commands, results files and measurements.
#![warn(unreachable_pub)]
// Documentation of private modules links to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

pub mod constraint;
pub mod element;
pub mod function;
pub mod linear;
pub mod mechanics;
pub mod model;
pub mod motion;
pub mod statics;
pub mod system;
