//! The multibody solver: from a dataset to equations, equilibria and motions.
//!
//! From the bottom up: [`mechanics`] has poses, rotations and relative motion; [`linear`] sparse matrices and their LU factors; [`model`] the
//! typed, named objects of a dataset; [`function`] compiled FUNCTION expressions; [`element`] the force laws, one file each; [`constraint`] the
//! joints and primitives, one file each. [`system::System`] is the frozen structure of a model, [`system::Parameters`] every number that may
//! change between runs, [`system::State`] what a solution changes. [`statics::Solver`] finds equilibria with exact sensitivities, [`motion`]
//! integrates over time. Knows no commands, no results files and no measurements.
#![warn(unreachable_pub)]
// Modules that are private link to what is private with them.
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
