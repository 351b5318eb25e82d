//! What every real axle and every real rig has beside the causes one looks for: noise and tolerances.
//!
//! [`MarkNoise`] says how exact the readings are, from the readings alone. [`RandomEffects`] holds the small errors of all hardpoints,
//! loads, axes and marks as numbers of the deck with Gaussian priors, whose sizes [`EffectGroup`] describes. [`Whitening`] brings readings
//! to independent rows; [`LinearModel`] holds the linearised problem as Gram matrices, one `ClassGram` per class of rows;
//! [`CrossProducts`] holds the products of columns that it does not have yet with its own. [`LinearModel::evidence`] gives the evidence,
//! the posterior and the gradient by the sizes, and [`LinearModel::maximise_evidence`] the sizes of maximum evidence. It contains neither
//! fits nor causes.
//!
//! To use it at a fit: take the Jacobian of all rows by the unknowns and by the effects of [`RandomEffects`], [`Whitening::apply`] it to
//! residual and Jacobian, build a [`LinearModel`] with one [`Coefficient`] per column, and ask [`LinearModel::maximise_evidence`]. Its
//! `Posterior::covariance` holds the intervals with tolerances marginalised; [`Posterior::without`] the part of a variance that is not due
//! to them.

mod class;
mod columns;
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
