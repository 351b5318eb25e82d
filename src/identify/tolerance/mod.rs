//! Error model of a measured axle: measurement noise, manufacturing tolerances and rig tolerances. It contains no hypotheses about faults.
//!
//! - [`MarkNoise`] estimates the noise of the marks (measured points on parts) from the readings alone.
//! - [`RandomEffects`] lists the small errors of hardpoints, loads, axes and springs as changes of the deck with Gaussian priors.
//! - [`EffectGroup`] names the groups of these errors; [`VarianceComponents`] holds the standard deviation of each group.
//! - [`Whitening`] transforms the readings to independent rows.
//! - [`LinearModel`] holds the linearised problem as Gram matrices, one `ClassGram` for each class of rows with equal variance.
//! - [`CrossProducts`] holds the products of candidate columns, which may be appended, with the columns of a [`LinearModel`].
//! - [`LinearModel::evidence`] returns the evidence and its gradient with respect to the log standard deviations.
//! - [`LinearModel::maximise_evidence`] returns the standard deviations of maximum evidence. [`LinearModel::posterior`] returns the posterior
//!   of the unknowns at given standard deviations.
//!
//! To apply the error model to a fit, first compute the Jacobian of all rows with respect to the unknowns and the [`RandomEffects`]. Transform
//! residual and Jacobian with [`Whitening::apply`]. Build a [`LinearModel`] with one [`Coefficient`] per column. Call
//! [`LinearModel::maximise_evidence`], then [`LinearModel::posterior`]. `Posterior::covariance` gives the intervals with tolerances
//! marginalised. [`Posterior::without`] gives the variances that would remain if the tolerances were known exactly.

mod class;
mod class_gram;
mod columns;
mod covariance_root;
mod cross_products;
mod effect_products;
mod factor;
mod free;
mod group;
mod linear;
mod maximise_evidence;
mod misplaced;
mod noise;
mod part_marks;
mod point;
mod product;
mod random_effects;
mod rigidity_screen;
mod solution;
mod tails;
mod whitening;

pub use columns::RowsByVarianceClass;
pub use covariance_root::covariance_root;
pub use cross_products::CrossProducts;
pub use effect_products::EffectProducts;
pub use factor::Factor;
pub use group::EffectGroup;
pub use group::NoiseScale;
pub use group::ScalePrior;
pub use group::VarianceComponents;
pub use linear::Coefficient;
pub use linear::LinearModel;
pub use linear::Posterior;
pub use misplaced::Misplaced;
pub use noise::MarkNoise;
pub use point::{ConnectionPoint, points};
pub use product::transposed;
pub use random_effects::Effect;
pub use random_effects::LayerOf;
pub use random_effects::RandomEffects;
pub use random_effects::acts_at;
pub use random_effects::applied_loads;
pub use random_effects::shift;
pub use rigidity_screen::mad_sigma;
pub use solution::Solution;
pub use tails::Tails;
pub use whitening::MarkBlock;
pub use whitening::Whitening;
