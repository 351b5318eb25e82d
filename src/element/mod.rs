//! Force laws: one file per element.
//!
//! A new law is one entry in the grammar, whose `law` line names it and its arguments; one file here, whose `LAWS` hold it; and its
//! `mod` line and place in `FILES` below.
//!
//! A law sees only the relative motion of its marker pair and its own parameters; it returns a wrench on I with exact
//! derivatives. Reaction on J, chain rule to part coordinates and geometric stiffness are written once, in `system`.

mod beam;
mod bushing;
mod damping;
mod deflection;
mod degenerate;
mod field;
mod friction;
mod law;
mod line;
mod nforce;
mod registry;
mod scalar_force;
mod slip;
mod springdamper;

pub use beam::Beam;
pub use bushing::Bushing;
pub use damping::Damping;
pub use degenerate::Degenerate;
pub use field::Field;
pub use friction::{Coefficient, FrictionLaw};
pub use law::{Law, Wrench};
pub use nforce::{MultiPoint, MultiWrench};
pub use registry::{LawEntry, law, laws};
pub use scalar_force::ScalarForce;
pub use slip::Slip;
pub use springdamper::{RotationalSpring, TranslationalSpring};

/// The laws of every file.
const FILES: &[&[LawEntry]] = &[
    beam::LAWS,
    bushing::LAWS,
    field::LAWS,
    scalar_force::LAWS,
    springdamper::LAWS,
];
