//! Constraints: one file per joint or primitive.
//!
//! A constraint sees only the relative motion of its marker pair. It returns residuals, their Jacobian, and the derivative of
//! the reaction wrench along given multipliers. The chain rule is in `system`, and so are sums over several pairs (COUPLER,
//! GEAR), whose terms are [`Measure`]s.

mod angle;
mod convel;
mod drive;
mod equations;
mod gear;
mod joint;
mod locks;
mod measure;
mod pair_constraint;
mod primitive;
mod rack_pinion;
mod registry;
mod screw;

pub use convel::Convel;
pub use drive::Drive;
pub use equations::{Constraint, Equations};
pub use gear::{GearedJoint, Term, gear_terms};
pub use locks::Locks;
pub use measure::{Measure, Measured};
pub use pair_constraint::PairConstraint;
pub use rack_pinion::RackPinion;
pub use registry::{CONSTRAINTS, ConstraintEntry, constraint};
pub use screw::Screw;
