//! Surfaces of joints that rub on each other, as a FRICTION has them.

use super::Name;
use crate::element::FrictionLaw;
use crate::mechanics::Vec6;

/// Places of a friction behind the values of the functions.
pub(crate) const SLOTS: usize = 3;
/// A direction in which the surfaces of a joint slide.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Slide {
    /// Along zj.
    AlongZ,
    /// About an axis of I.
    AboutI(usize),
    /// About an axis of J.
    AboutJ(usize),
}

/// What of a joint's reaction presses the surfaces together.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(crate) struct Pressing {
    /// A force that is always there.
    pub preload: f64,
    /// Factors of the force across the axis, the force along it, the moment across it and the moment about it.
    pub across: f64,
    pub along: f64,
    pub bending: f64,
    pub torsion: f64,
    /// The whole force counts, whatever its direction: a ball.
    pub ball: bool,
    /// The moment across is divided by an overlap: at the start, and its change by the displacement.
    pub overlap: Option<(f64, f64)>,
}

/// FRICTION of one joint, or of one yoke of it.
#[derive(Debug)]
pub(crate) struct Friction {
    pub name: Name,
    /// Index into the joints of the system.
    pub joint: usize,
    pub i: usize,
    pub j: usize,
    pub pair: usize,
    /// One to three directions; what they exert stands in the axes of one marker.
    pub slides: Vec<Slide>,
    /// Of rotations.
    pub radius: f64,
    pub law: FrictionLaw,
    /// EFFECT has stiction: surfaces creep.
    pub sticks: bool,
    /// EFFECT has sliding.
    pub slips: bool,
    /// Its law at rest, where it counts in statics too.
    pub at_rest: Option<FrictionLaw>,
    pub pressing: Pressing,
    /// FRICTION_TORQUE_PRELOAD.
    pub torque_preload: f64,
    pub active: bool,
}

impl Friction {
    pub(crate) fn lever(&self, slide: Slide) -> f64 {
        if slide == Slide::AlongZ {
            1.0
        } else {
            self.radius
        }
    }

    /// The marker whose axes the wrench is given in.
    pub(crate) fn frame(&self) -> usize {
        match self.slides.first() {
            Some(Slide::AboutI(_)) => self.i,
            _ => self.j,
        }
    }

    /// The wrench of a unit generalised force in a direction, axes of the frame.
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
