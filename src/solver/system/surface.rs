//! Friction surfaces of joints, as defined by FRICTION.

use super::Name;
use crate::element::FrictionLaw;
use crate::mechanics::Vec6;

/// Number of entries reserved for each friction in `Scratch::functions`. These entries follow the entries of the functions.
pub(crate) const SLOTS: usize = 3;
/// Sliding direction of a joint's surfaces.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Slide {
    /// Translation along zj.
    AlongZ,
    /// Rotation about an axis of I.
    AboutI(usize),
    /// Rotation about an axis of J.
    AboutJ(usize),
}

/// Normal load of the friction surfaces as a weighted sum of components of the joint reaction.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Pressing {
    /// Constant preload force.
    pub preload: f64,
    /// Factor of the force perpendicular to the axis.
    pub across: f64,
    /// Factor of the force along the axis.
    pub along: f64,
    /// Factor of the moment perpendicular to the axis.
    pub bending: f64,
    /// Factor of the moment about the axis.
    pub torsion: f64,
    /// Whether the magnitude of the total force counts, regardless of its direction, as in a ball joint.
    pub ball: bool,
    /// Overlap by which the perpendicular moment is divided: initial value, and derivative with respect to the joint displacement.
    pub overlap: Option<(f64, f64)>,
}

/// Friction of one joint or, for a joint with two yokes, of one yoke.
#[derive(Debug)]
pub(crate) struct JointFriction {
    pub name: Name,
    /// Index of the joint in the system.
    pub joint: usize,
    pub i: usize,
    pub j: usize,
    pub pair: usize,
    /// Sliding directions, one to three. Their forces are resolved in the axes of one marker.
    pub slides: Vec<Slide>,
    /// Radius of the surface, the lever arm for rotations.
    pub radius: f64,
    pub law: FrictionLaw,
    /// Whether EFFECT includes stiction. Only then can the surfaces creep.
    pub sticks: bool,
    /// Whether EFFECT includes sliding.
    pub slips: bool,
    /// Friction law in statics, if the friction acts there.
    pub at_rest: Option<FrictionLaw>,
    pub pressing: Pressing,
    /// Torque preload, FRICTION_TORQUE_PRELOAD.
    pub torque_preload: f64,
    pub active: bool,
}

impl JointFriction {
    pub(crate) fn lever(&self, slide: Slide) -> f64 {
        if slide == Slide::AlongZ {
            1.0
        } else {
            self.radius
        }
    }

    /// Returns the marker whose axes resolve the friction wrench.
    pub(crate) fn frame(&self) -> usize {
        match self.slides.first() {
            Some(Slide::AboutI(_)) => self.i,
            _ => self.j,
        }
    }

    /// Returns the wrench of a unit generalised force in a sliding direction, in the axes of [`Self::frame`].
    pub(crate) fn unit(slide: Slide) -> Vec6 {
        Vec6::ith(
            match slide {
                Slide::AlongZ => 2,
                Slide::AboutI(axis) | Slide::AboutJ(axis) => 3 + axis,
            },
            1.0,
        )
    }
}
