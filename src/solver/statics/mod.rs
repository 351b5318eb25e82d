//! Static equilibrium and its sensitivities.
//!
//! The equilibrium is found by Newton's method on the force balances with Lagrange multipliers. The module is independent of files and
//! commands.

mod balance;
mod causes;
mod continuation;
mod direction;
mod first_solution;
mod freedoms;
mod krylov;
mod measures;
mod minimum_norm;
mod multipliers;
mod newton;
#[cfg(test)]
mod orders;
mod path;
mod probe;
mod rank;
mod report;
mod sensitivity;
mod settings;
mod settle;
mod stability;
mod tangent;

pub use balance::{Balance, Left};
pub use direction::Direction;
pub use freedoms::FreedomCount;
pub use newton::{Solver, solve};
pub use probe::{FORCE_COMPONENTS, Probe, Probes};
pub(crate) use report::Iteration;
pub use report::{Continuation, Far, FreeMotion, Report, SolveError, history_table};
pub use sensitivity::Sensitivity;
pub use settings::StaticSettings;
pub use settle::StabilisedEquilibrium;
pub use stability::{Softest, smallest_eigenvalue};
pub use tangent::Tangent;
pub use tangent::Tangents;
pub use tangent::displace;
pub use tangent::point_change;
pub use tangent::twist;
