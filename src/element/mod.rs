//! Force laws: one file per element.
//!
//! A law sees only the relative motion of its marker pair and its own parameters; it returns a wrench on I with exact
//! derivatives. Reaction on J, chain rule to part coordinates and geometric stiffness are written once, in `system`.

mod degenerate;
mod law;

pub use degenerate::Degenerate;
pub use law::{Law, Wrench};
