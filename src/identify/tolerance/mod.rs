//! Error model of a measured axle: measurement noise and manufacturing or rig tolerances, without any fault hypothesis.
//!
//! - [`MarkNoise`] estimates the noise of the mark readings from the readings alone.
//! - [`RandomEffects`] lists the small errors of hardpoints, loads, axes and marks as numbers of the deck with Gaussian priors.
//! - [`EffectGroup`] names the groups of these errors; [`VarianceComponents`] holds the standard deviation of each group.
//! - [`Whitening`] transforms the readings to independent rows.
//! - [`LinearModel`] holds the linearised problem as Gram matrices, one `ClassGram` per variance class of rows.
//! - [`CrossProducts`] holds the products of candidate columns with the columns of a [`LinearModel`].
//! - [`LinearModel::evidence`] returns the evidence and its gradient with respect to the log standard deviations.
//! - [`LinearModel::maximise_evidence`] returns the standard deviations of maximum evidence, [`LinearModel::posterior`] the posterior at
//!   given ones.
//!
//! To apply the error model to a fit, compute the Jacobian of all rows with respect to the unknowns and the [`RandomEffects`].
//! [`Whitening::apply`] transforms residual and Jacobian. Build a [`LinearModel`] with one [`Coefficient`] per column and call
//! [`LinearModel::maximise_evidence`], then [`LinearModel::posterior`]. `Posterior::covariance` gives the intervals with tolerances
//! marginalised. [`Posterior::without`] gives the variances that would remain if the tolerances were known exactly.

mod class;
mod columns;
mod covariance_root;
mod factor;
mod free;
mod further;
mod group;
mod layer;
mod linear;
mod misplaced;
mod noise;
mod part_marks;
mod point;
mod product;
mod reached;
mod share;
mod sizes;
mod sorted;
mod tails;
mod whitening;

pub use columns::RowsByVarianceClass;
pub use covariance_root::covariance_root;
pub use factor::Factor;
pub use further::CrossProducts;
pub use group::EffectGroup;
pub use group::NoiseScale;
pub use group::Size;
pub use group::VarianceComponents;
pub use layer::Effect;
pub use layer::LayerOf;
pub use layer::RandomEffects;
pub use layer::acts_at;
pub use layer::scattering;
pub use linear::Coefficient;
pub use linear::LinearModel;
pub use linear::Posterior;
pub use misplaced::Misplaced;
pub use noise::MarkNoise;
pub use point::Point;
pub use product::transposed;
pub use reached::Solution;
pub use sorted::mad_sigma;
pub use tails::Tails;
pub use whitening::MarkBlock;
pub use whitening::Whitening;
