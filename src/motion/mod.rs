//! Motion over time: initial conditions, kinematics, integration.
//!
//! Radau IIA of three stages on the stabilised index-2 form of the equations of motion, in a rotation chart per step. Knows no files and no
//! commands.

mod assembly;
mod bordered;
mod consistent;
mod coupled;
mod dense;
mod error;
mod gripping;
mod integrator;
mod kinematic;
mod linearised;
mod modes;
mod newton;
mod settings;
mod sizes;
mod state_matrices;
mod tableau;
#[cfg(test)]
mod tests;

pub use assembly::{Kept, assemble};
pub use consistent::Consistent;
pub use error::{MotionError, Reason};
pub use integrator::{Integrator, Statistics};
pub use kinematic::{advance, check_determined};
pub use modes::{Mode, modes};
pub use settings::Settings;
pub use state_matrices::{StateMatrices, state_matrices};
