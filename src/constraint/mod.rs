//! Constraints: one file per joint or primitive.
//!
//! A constraint sees only the relative motion of its marker pair. It returns residuals, their Jacobian, and the derivative of
//! the reaction wrench along given multipliers. The chain rule is in `system`.

mod equations;
pub mod joint;
mod locks;
pub mod primitive;

pub use equations::{Constraint, Equations};
pub use locks::Locks;
