//! Decks out of results files: parts, joints, hardpoints, laws and masses from the poses and forces of static equilibria.
//!
//! [`Record::read`] reads the equilibria of one or several results files of one mechanism. [`mechanism`] finds what connects the parts:
//!
//! 1. Parts that never move against each other form one cluster. Two clusters whose relative motion has a fixed point, line or direction
//!    may share a joint.
//! 2. The forces on one part add up to its weight in every state. Signed sums of forces that stay constant are therefore the balances of
//!    parts; their moments tell of which part.
//! 3. The moments of all parts give the points at which forces act, and the mass centres. Joints, angles of bushings and the requests of
//!    Adams/Car give the same points; what several of them tell is compared.
//! 4. Forces against deflections give the laws of bushings and springs.
//!
//! What the results do not tell (inertias, damping, laws beyond the visited deflections) gets a plain default and is listed.
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
