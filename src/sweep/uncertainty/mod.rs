//! Uncertainty of identified numbers by repetition: bootstrap fits of resampled readings, and draws from the posterior.
//!
//! Both work on the unknowns with all tolerances marginalised ([`Marginal`](admire_identify::global::Marginal)). They use the engine of the
//! sweeps: counter-based random numbers, a journal, a table. Threads and interruptions therefore change no bit.
//!
//! Bootstrap: readings are the predictions of the fit plus its whitened residuals, drawn with replacement. Residuals are drawn rather than
//! load cases, because the cases of a rig are designed: each has its own loads, and all share the same tolerances. Residuals whitened by
//! noise and tolerances are exchangeable, so that drawing them draws the tolerances, too. Each residual is drawn from its kind of reading,
//! divided by the root of one minus its leverage, and centred (Davison and Hinkley 1997, section 6.2). Priors count as readings and are
//! drawn, too.
//!
//! Posterior: Hamiltonian Monte Carlo (Neal 2011) in coordinates whitened by the fit's covariance.

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
pub use repeat::RepeatOutput;
pub use repeat::Repeats;
pub use repeat::repeat;
