//! Constraints: one file per joint or primitive.
//!
//! A constraint depends only on the relative motion of its marker pair. It returns residuals, their Jacobian, and the derivative of the
//! reaction wrench for given multipliers. `system` applies the chain rule to the part coordinates. `system` also forms the sums over
//! several marker pairs (COUPLER, GEAR), whose terms are [`RelativeCoordinate`]s.

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

pub(crate) use convel::Convel;
pub(crate) use drive::Drive;
pub(crate) use equations::Constraint;
pub(crate) use equations::Equations;
pub(crate) use gear::GearedJoint;
pub(crate) use gear::gear_terms;
pub(crate) use locks::Locks;
pub(crate) use measure::RelativeCoordinate;
pub(crate) use pair_constraint::PairConstraint;
pub(crate) use rack_pinion::RackPinion;
pub(crate) use registry::ConstraintEntry;
pub(crate) use registry::constraint;
pub(crate) use screw::Screw;
