//! Uncertainty of identified parameters by repetition: bootstrap fits to resampled readings, and draws from the posterior.
//!
//! Both methods work on the unknowns with all tolerances marginalised ([`Marginal`](admire_identify::global::Marginal)). They use the
//! engine of the sweeps: counter-based random numbers, a journal, a table. Thus neither the number of threads nor an interruption changes a
//! bit of the results.
//!
//! Bootstrap: the readings of a replicate are the predictions of the fit plus whitened residuals, drawn with replacement. Residuals are
//! drawn rather than load cases, because the load cases of a rig are designed: each has its own loads, and all share the same tolerances.
//! Residuals whitened by noise and tolerances are exchangeable. Drawing them therefore also draws the tolerances. Each residual is drawn
//! from the pool for its kind of reading. The residuals in a pool are divided by the square root of one minus the leverage, and centred
//! (Davison and Hinkley 1997, section 6.2). Priors count as readings and are drawn, too.
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
