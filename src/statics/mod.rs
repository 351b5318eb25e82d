//! Static equilibrium and its sensitivities.
//!
//! Newton's method on the force balance with Lagrange multipliers. Knows no files and no commands.

mod causes;
mod continuation;
mod freedoms;
mod krylov;
mod lu;
mod matrix;
mod measures;
mod newton;
mod ordering;
#[cfg(test)]
mod orders;
mod path;
mod pivoting;
mod rank;
mod report;
mod sensitivity;
mod settings;
mod stability;
mod tangent;

pub use freedoms::Freedoms;
pub use newton::{Solver, solve};
pub use report::{Continuation, FreeMotion, Iteration, Report, SolveError, history_table};
pub use sensitivity::Sensitivity;
pub use settings::Settings;
pub use stability::{smallest_eigenvalue, stiffness_range};
pub use tangent::{Tangent, point_change};
