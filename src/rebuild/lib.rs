//! Decks from results files: parts, joints, hardpoints, laws and masses from the poses and forces of static equilibria.
//!
//! [`Record::read`] reads the equilibria of one or several results files of one mechanism. [`mechanism`] finds the connections of the parts:
//!
//! 1. Parts that never move relative to each other form one cluster. Two clusters whose relative motion has a fixed point, line or direction
//!    may share a joint.
//! 2. The forces on one part balance its weight in every state. Signed sums of forces that are constant are therefore the balances of parts.
//!    The moments determine the part of each balance.
//! 3. The moments of all parts determine the points at which forces act, and the mass centres. Joints, angles of bushings and the requests
//!    of Adams/Car determine the same points; if there are several sources, they are compared.
//! 4. Forces over deflections determine the laws of bushings and springs.
//!
//! The results do not determine inertias, damping, and laws beyond the deflections of the states. These get default values, which are listed.
#![warn(unreachable_pub)]
// The documentation of private modules links to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Matrices keep their capital letters.

mod assignment;
mod balance;
mod bushing;
mod connection;
mod constant;
mod deck;
mod deck_text;
mod held;
mod joint;
mod law;
mod least_squares;
mod linear_law;
mod mechanism;
mod moments;
mod names;
mod rebuilt;
mod record;
mod relation;
mod repeat_states;
mod report;
mod requests;
mod settings;
mod spring;
mod study;

pub use bushing::Motion;
pub use connection::Connection;
pub use deck::{Deck, Drive, deck};
pub use joint::Joint;
pub use law::{AxisLaw, Law};
pub use mechanism::{Mass, Mechanism, Member, Role, mechanism};
pub use rebuilt::{Rebuilt, rebuild};
pub use record::{Body, Element, FloatingMarker, Record, Run};
pub use relation::Relation;
pub use repeat_states::{Repeat, repeat};
pub use spring::Spring;

use admire_syntax::units::Units;

/// Returns the mass that has a weight under standard gravity, both in the units of a deck.
pub(crate) fn mass(weight: f64, units: &Units) -> f64 {
    weight * units.ucf / gravity(units)
}

/// Returns standard gravity in the units of a deck.
pub(crate) fn gravity(units: &Units) -> f64 {
    settings::GRAVITY_M_PER_S2 * units.time.si * units.time.si / units.length.si
}
