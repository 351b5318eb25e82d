//! Motion over time: initial conditions, kinematic analysis, integration and small motions about a state.
//!
//! The integrator is the three-stage Radau IIA method on the stabilised index-2 form of the equations of motion. Rotations are parametrised by
//! rotation vectors relative to the start of each step. The module is independent of files and commands.

mod anderson;
mod arrival;
mod assembly;
mod bordered;
mod consistent;
mod coordinates;
mod coupled;
mod dense;
mod derivatives;
mod discrete_states;
mod error;
mod error_scales;
mod estimate;
mod event_handling;
mod event_location;
mod exchange;
mod freedoms;
mod integrator;
mod iteration;
mod kinematic;
mod linearisation;
mod linearised;
mod massless;
mod modes;
mod newton;
mod reduced;
mod root;
mod sequence;
mod settings;
mod state_matrices;
mod tableau;
#[cfg(test)]
mod tests;

pub use arrival::has_arrived;
pub use assembly::{Kept, assemble};
pub use consistent::Consistent;
pub use coordinates::Coordinates;
pub use error::MotionError;
pub use error::MotionFailure;
pub use event_location::Watched;
pub use integrator::Integrator;
pub use kinematic::advance;
pub use kinematic::advance_watched;
pub use kinematic::check_determined;
pub use modes::Mode;
pub use modes::modes;
pub use modes::modes_in;
pub use settings::MotionSettings;
pub use state_matrices::state_matrices;
