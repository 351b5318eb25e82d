//! Identification: estimation of deck parameters, mainly bushing stiffnesses, from measurements on a test rig.
//!
//! [`LoadedStudy`] is a study together with its model. [`Problem`] collects the inputs of an identification, among them the parameters to
//! identify. [`Fit`] is the result as written to `identification.json`.
//!
//! Three methods share these types. [`regression`] is the iteration of the paper by Meissonnier et al. (see guide page `paper`). [`direct`] is
//! a solution without equilibrium iterations. [`global`] is a least-squares fit of all readings.
//!
//! [`tolerance`] is the error model: noise of the readings, tolerances of axle and rig, and the evidence for their sizes. Marks are measured
//! points on a part. Effects that are missing from a model are treated in `admire-diagnosis`.
#![warn(unreachable_pub)]
// The documentation of private modules links to private items.
#![allow(rustdoc::private_intra_doc_links)]
#![allow(non_snake_case)] // Rotation matrices keep their capital letters: R_ji.

mod bounded;
mod deck_unknown;
pub mod direct;
mod evaluation;
mod fit;
mod free_motions;
pub mod global;
mod goodness;
pub mod lack_of_fit;
mod loaded;
mod mirror;
mod noise;
pub mod priors;
mod problem;
pub mod regression;
mod repeated;
pub mod settings;
pub mod slips;
mod smooth_points;
mod stated_unknowns;
pub mod tolerance;
mod unknowns;

pub use deck_unknown::{DeckUnknown, SetNumber, resolved, written_numbers};
pub use evaluation::{ReadingMisfit, compare};
pub use evaluation::{marker_pose, written};
pub use fit::{
    CurveHeldOut, Fit, HeldOut, Marks, NOT_CONVERGED, NoiseFound, NumberFit, OffsetFit,
    ParameterFit, Status, ToleranceFound, UnidentifiableDirection, WheelFit, Written,
};
pub use free_motions::meet_marks;
pub use free_motions::meet_marks_of_all;
pub use goodness::{FitTest, FitVerdict, ReadingsLeft};
pub use lack_of_fit::{ChiSquare, LackOfFitAspect, LackOfFitTest};
pub use loaded::LoadedStudy;
pub use mirror::Mirror;
pub use noise::estimate_noise;
pub use problem::IdentifyError;
pub use problem::{Problem, Progress};
pub use repeated::{BootstrapMade, PosteriorMade, Repeated};
pub use unknowns::{Assignment, Place, Unknown, unknowns};
