//! Sparse linear algebra: a matrix that is assembled repeatedly, its LU factors and their elimination order.
//!
//! The module is independent of equations and units.

mod additions;
mod dependent;
mod entries;
mod factors;
mod form;
mod lanes;
mod levels;
mod lu;
mod matrix;
mod occupied;
mod ordering;
mod pattern;
mod pivoting;
mod postorder;
mod recorded;
mod scalar;
mod sink;
mod step;
mod triple;
mod upper;

pub(crate) use dependent::dependent_columns;
pub(crate) use entries::Entries;
pub(crate) use levels::Levels;
pub(crate) use lu::Lu;
pub(crate) use matrix::Matrix;
pub(crate) use occupied::Occupied;
pub(crate) use ordering::by_groups;
#[cfg(test)]
pub(crate) use ordering::minimum_degree;
pub(crate) use scalar::Scalar;
pub(crate) use sink::NoMatrix;
pub use sink::Sink;
pub(crate) use triple::Triple;
