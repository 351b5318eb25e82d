//! How well numbers are known, by doing it again: fits of readings drawn anew, and draws from the posterior itself.
//!
//! Both work on the unknowns with all tolerances marginalised ([`Marginal`](admire_identify::global::Marginal)) and run in the
//! harness of the sweeps: numbers from a counter, a journal, a table. So threads and interruptions change no bit.
//!
//! Bootstrap: readings are the predictions of the fit plus its whitened residuals, drawn with replacement. Residuals are drawn, not load
//! cases: the cases of a rig are designed, each loads something no other does, and all of them share the same tolerances. Whitened by
//! noise and tolerances the residuals are exchangeable, which draws the tolerances anew as well. They are those of their kind of
//! reading, over the root of one less their leverage, less their mean (Davison and Hinkley 1997, section 6.2). Priors count as readings
//! and are drawn too.
//!
//! Posterior: Hamiltonian Monte Carlo (Neal 2011) in the coordinates of the fit's covariance.

mod bootstrap;
mod chains;
mod estimate;
mod posterior;
mod repeat;
mod spread;

pub use repeat::Kind;
pub use repeat::LEAST_DRAWS;
pub use repeat::LEAST_REPLICATES;
pub use repeat::MOST;
pub use repeat::Made;
pub use repeat::Repeats;
pub use repeat::repeat;
