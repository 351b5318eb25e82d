//! Force laws: one file per element.
//!
//! A law sees only the relative motion of its marker pair and its own parameters; it returns a wrench on I with exact
//! derivatives. Reaction on J, chain rule to part coordinates and geometric stiffness are written once, in `system`.

mod beam;
mod bushing;
mod deflection;
mod degenerate;
mod elasto_slip;
mod field;
mod force_law;
mod law;
mod line;
mod nforce;
mod parameter;
mod registry;
mod scalar_force;
mod springdamper;

pub use beam::Beam;
pub use bushing::Bushing;
pub use degenerate::Degenerate;
pub use elasto_slip::{ElastoSlip, Slip};
pub use field::Field;
pub use force_law::ForceLaw;
pub use law::{Law, Wrench};
pub use nforce::{MultiPoint, MultiWrench};
pub use parameter::ParameterGroup;
pub use registry::{LAWS, LawEntry};
pub use scalar_force::ScalarForce;
pub use springdamper::{RotationalSpring, TranslationalSpring};
