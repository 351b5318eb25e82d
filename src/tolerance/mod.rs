//! What every real axle and every real rig has beside the causes one looks for: noise and tolerances.
//!
//! [`Noise`] says how exact the readings are, from the readings alone. [`Layer`] holds the small errors of all hardpoints, loads, axes
//! and marks as numbers of the deck with Gaussian priors, whose sizes [`Group`] describes. [`Whitening`] brings readings to independent
//! rows; [`Linear`] holds the linearised problem as Gram matrices, one `Share` per class of rows; [`Further`] holds the products of
//! columns that it does not have yet with its own; [`Linear::evidence`] gives the evidence, the posterior and the
//! gradient by the sizes, and [`Linear::sized`] the sizes that the readings ask for. Knows neither fits nor causes.
//!
//! To use it at a fit: take the Jacobian of all rows by the unknowns and by the members of a [`Layer`], [`Whitening::apply`] it to
//! residual and Jacobian, build a [`Linear`] with one [`Unknown`] per column, and ask [`Linear::sized`]. Its `Posterior::covariance`
//! holds the intervals with tolerances marginalised; [`Posterior::without`] the part of a variance that is not due to them.

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

pub(crate) use columns::ByClass;
pub(crate) use factor::Factor;
pub(crate) use further::Further;
pub(crate) use group::Sizes;
pub(crate) use group::{Group, Scale, Size};
pub(crate) use layer::{Effect, Layer, LayerOf};
pub(crate) use layer::{acts_at, scattering};
pub(crate) use linear::{Linear, Posterior, Unknown};
pub(crate) use misplaced::Misplaced;
pub(crate) use noise::Noise;
pub(crate) use point::Point;
pub(crate) use product::transposed;
pub(crate) use reached::Reached;
pub(crate) use sorted::spread;
pub(crate) use tails::Tails;
pub(crate) use whitening::{MarkBlock, Whitening};
