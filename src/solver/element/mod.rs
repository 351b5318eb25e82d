//! Force laws: one file per element.
//!
//! A new law needs three additions. The first is an entry in the grammar whose `law` line gives its name and arguments. The others are one
//! file here with a `LAWS` constant, and a `mod` line with an entry in `FILES` below.
//!
//! A law depends only on the relative motion of its marker pair and on its own parameters. It returns a wrench on I with exact derivatives.
//! `system` computes the reaction on J, the chain rule to the part coordinates and the geometric stiffness once for all laws.

mod beam;
mod bushing;
mod car_bushing;
mod damping;
mod deflection;
mod degenerate;
mod element_law;
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
pub(crate) use car_bushing::{CarBushing, CarNumbers};
pub(crate) use damping::Damping;
pub(crate) use degenerate::Degenerate;
pub(crate) use element_law::ElementLaw;
pub(crate) use friction::Coefficient;
pub(crate) use friction::FrictionLaw;
pub(crate) use law::Law;
pub(crate) use law::Wrench;
pub(crate) use nforce::{MultiPoint, MultiWrench};
pub(crate) use registry::LawEntry;
pub(crate) use registry::law;
pub(crate) use scalar_force::ScalarForce;
pub use slip::Slip;

/// Law tables of all element files.
const FILES: &[&[LawEntry]] = &[
    beam::LAWS,
    bushing::LAWS,
    field::LAWS,
    scalar_force::LAWS,
    springdamper::LAWS,
];
