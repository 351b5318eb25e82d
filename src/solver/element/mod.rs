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

pub(crate) use beam::Beam;
pub(crate) use damping::Damping;
pub(crate) use degenerate::Degenerate;
pub(crate) use friction::Coefficient;
pub(crate) use friction::FrictionLaw;
pub(crate) use law::Law;
pub(crate) use law::Wrench;
pub(crate) use nforce::{MultiPoint, MultiWrench};
pub(crate) use registry::LawEntry;
pub(crate) use registry::law;
pub(crate) use scalar_force::ScalarForce;
pub use slip::Slip;

/// The laws of every file.
const FILES: &[&[LawEntry]] = &[
    beam::LAWS,
    bushing::LAWS,
    field::LAWS,
    scalar_force::LAWS,
    springdamper::LAWS,
];
