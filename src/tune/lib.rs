//! Design to a target: values of numbers in a deck that give the wanted kinematics and compliance, forces in elements, and readings in load
//! cases.
//!
//! [`Tuning`] is a study with a section `[target]`, with all names resolved. [`Tuning::search`] searches for values of the unknowns. It
//! begins at the start of the study and at Sobol points within the bounds. [`Outcome`] states the changed numbers, the goals that are met,
//! the conflicts, and the importance of each unknown.
//!
//! [`Tuning::robust`] computes the share of axles that meet the goals if the axles scatter by the tolerances of the study.
//! [`Tuning::front`] computes the trade-off between two goals.
//!
//! The misses of all goals form a least-squares problem, which the trust-region Gauss-Newton method of `admire-identify` solves within the
//! bounds. The derivatives of positions, angles, wheel loads, forces in elements and readings of load cases are exact. Limits and minimax
//! goals are constraints, handled by the augmented Lagrangian method (method of multipliers).
#![warn(unreachable_pub)]
// The documentation of private modules links to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

mod analysis;
mod answers;
#[cfg(test)]
mod bench;
mod cost;
mod descent;
mod evaluation;
#[cfg(test)]
mod force_bench;
mod found;
mod front;
mod goal;
mod goal_names;
mod goal_reader;
mod load_cases;
mod outcome;
mod problem;
#[cfg(test)]
mod reading_bench;
mod reading_name;
mod robust;
#[cfg(test)]
mod robust_bench;
mod search;
pub mod settings;
#[cfg(test)]
mod speed_bench;
mod tolerance;
mod tune_error;
mod tuning;

pub use analysis::Conflict;
pub use answers::{Answers, CaseAnswer};
pub use evaluation::{Evaluation, Spread};
pub use front::{Front, FrontPoint};
pub use goal::{Goal, GoalKind, Row};
pub use outcome::{GoalOutcome, NumberOutcome, Outcome, RowOutcome, StartOutcome, UnknownOutcome};
pub use problem::Watch;
pub use robust::{DrawnAxles, GoalSpread, Robust, ToleranceShare};
pub use tune_error::TuneError;
pub use tuning::{Refused, Tuning};
