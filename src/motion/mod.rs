//! Motion over time: initial conditions, kinematics, integration.
//!
//! Radau IIA of three stages on the stabilised index-2 form of the equations of motion, in a rotation chart per step. Knows no files and no
//! commands.

mod arrival;
mod assembly;
mod bordered;
mod consistent;
mod coordinates;
mod coupled;
mod dense;
mod derivatives;
mod error;
mod estimate;
mod exchange;
mod freedoms;
mod integrator;
mod iteration;
mod kinematic;
mod linearisation;
mod linearised;
mod massless;
mod mixing;
mod modes;
mod newton;
mod passage;
mod reduced;
mod regimes;
mod root;
mod sequence;
mod settings;
mod settling;
mod sizes;
mod state_matrices;
mod tableau;
#[cfg(test)]
mod tests;

pub(crate) use arrival::has_arrived;
pub use assembly::{Kept, assemble};
pub use consistent::Consistent;
pub(crate) use coordinates::Coordinates;
pub(crate) use error::{MotionError, Reason};
pub use integrator::Integrator;
pub use kinematic::advance;
pub(crate) use kinematic::{advance_watched, check_determined};
pub(crate) use modes::Mode;
pub use modes::modes;
pub(crate) use modes::modes_in;
pub(crate) use passage::Watched;
pub use settings::Settings;
pub(crate) use state_matrices::state_matrices;
