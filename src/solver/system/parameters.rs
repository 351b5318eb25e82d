use std::ops::Range;
use std::sync::Arc;

use super::Slot;
use super::carried::{Carried, Moved};
use crate::function::Curves;
use crate::mechanics::{Mat3, Pose, Vec3, euler313, exp, psi_theta_phi};

/// Number of parameters per marker at the start of theta: three of QP and three of REULER.
pub(crate) const PER_MARKER: usize = 6;

/// Parameter vector theta: every parameter that can be identified or edited between runs without recompilation.
///
/// Angles are in radians, and all other parameters are in the dataset's units. Parameters have the meaning they have in the statements. For
/// example, QP and REULER of a marker with RM are in the frame of RM. The marker frames are updated with the parameters. A change of QP
/// moves a marker without rotating it; the points that define its axes move along.
#[derive(Clone, PartialEq, Debug)]
pub struct Parameters {
    theta: Vec<f64>,
    /// Pose of each marker on its part.
    markers: Vec<Pose>,
    /// Rotation of each marker that is defined by ZP and XP points; REULER cannot change it. `None` for other markers.
    by_points: Vec<Option<Mat3>>,
    carried: Arc<Carried>,
    /// Curves of the SPLINEs, with the y values that `theta` contains.
    curves: Arc<Curves>,
    splines: Arc<[SplineSlots]>,
}

/// Slots of the y values of a SPLINE.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct SplineSlots {
    /// Index of the SPLINE in the model.
    pub spline: usize,
    /// Slots in theta, one per point.
    pub slots: Range<usize>,
}

impl Parameters {
    pub(crate) fn new(
        theta: Vec<f64>,
        by_points: Vec<Option<Mat3>>,
        carried: Arc<Carried>,
        (curves, splines): (Curves, Vec<SplineSlots>),
    ) -> Self {
        let mut new = Self {
            theta,
            markers: vec![Pose::identity(); by_points.len()],
            by_points,
            carried,
            curves: Arc::new(curves),
            splines: splines.into(),
        };
        for marker in 0..new.markers.len() {
            if !new.carried.is_carried(marker) {
                new.refresh(marker);
            }
        }
        new
    }

    /// Returns the value of a parameter. The parameter that replaces a whole function is NaN while the function itself is used.
    pub fn get(&self, slot: Slot) -> f64 {
        self.theta[slot.0]
    }

    /// Sets a parameter and updates the marker frames or the curves that depend on it.
    pub fn set(&mut self, slot: Slot, value: f64) {
        self.theta[slot.0] = value;
        let marker = slot.0 / PER_MARKER;
        if marker < self.markers.len() {
            self.refresh(marker);
            return;
        }
        let after = self.splines.partition_point(|of| of.slots.end <= slot.0);
        if let Some(of) = self.splines.get(after)
            && of.slots.contains(&slot.0)
        {
            let (spline, knot) = (of.spline, slot.0 - of.slots.start);
            Arc::make_mut(&mut self.curves).set(spline, knot, value);
        }
    }

    /// Returns the curves of the SPLINEs.
    pub(crate) fn curves(&self) -> &Curves {
        &self.curves
    }

    /// Returns all parameters.
    pub(crate) fn theta(&self) -> &[f64] {
        &self.theta
    }

    /// Rotates a marker on its part by `angle` radians about an axis fixed to the marker.
    pub fn turn(&mut self, marker: crate::model::MarkerIx, axis: &Vec3, angle: f64) {
        let R = self.stated(marker.0).R * exp(&(axis * angle));
        if let Some(by_points) = &mut self.by_points[marker.0] {
            *by_points = R;
        } else {
            let first = marker.0 * PER_MARKER + 3;
            self.theta[first..first + 3].copy_from_slice(&psi_theta_phi(&R));
        }
        self.refresh(marker.0);
    }

    /// Returns the axes of a marker defined by points ZP and XP, in the frame in which the points are given. Returns `None` for markers
    /// defined otherwise.
    pub fn axes_by_points(&self, marker: crate::model::MarkerIx) -> Option<Mat3> {
        self.by_points[marker.0]
    }

    /// Returns the pose of a marker on its part.
    pub fn marker(&self, marker: crate::model::MarkerIx) -> &Pose {
        &self.markers[marker.0]
    }

    pub(crate) fn markers(&self) -> &[Pose] {
        &self.markers
    }

    /// Returns the motions, per unit of parameter `k` of a marker, of all frames that depend on it: the marker itself and the markers
    /// defined in its frame.
    pub(crate) fn marker_derivative(&self, marker: usize, k: usize) -> Vec<Moved> {
        let (shift, turn) = self.stated_derivative(marker, k);
        let axes = match self.carried.base(marker) {
            Some((rm, between)) => between.R * self.markers[*rm].R,
            None => Mat3::identity(),
        };
        self.moved_with(marker, axes * shift, axes * turn)
    }

    /// Returns the motions of all frames that depend on a marker, per radian of the marker's rotation about an axis fixed to the marker.
    pub(crate) fn turn_derivative(&self, marker: usize, axis: &Vec3) -> Vec<Moved> {
        self.moved_with(marker, Vec3::zeros(), self.markers[marker].R * axis)
    }

    /// Returns the displacement and the rotation vector of a marker per unit of its parameter `k`, in the axes in which the parameter is
    /// given.
    fn stated_derivative(&self, marker: usize, k: usize) -> (Vec3, Vec3) {
        if k < 3 {
            return (Vec3::ith(k, 1.0), Vec3::zeros());
        }
        if self.by_points[marker].is_some() {
            return (Vec3::zeros(), Vec3::zeros());
        }
        let at = marker * PER_MARKER + 3;
        let (psi, theta) = (self.theta[at], self.theta[at + 1]);
        // R = Rz(psi) Rx(theta) Rz(phi): each angle rotates about an axis that depends on the preceding angles.
        let axis = match k {
            3 => Vec3::z(),
            4 => Vec3::new(libm::cos(psi), libm::sin(psi), 0.0),
            _ => Vec3::new(
                libm::sin(psi) * libm::sin(theta),
                -libm::cos(psi) * libm::sin(theta),
                libm::cos(theta),
            ),
        };
        (Vec3::zeros(), axis)
    }

    /// Returns the motion of a marker on its part, and the resulting motions of the markers defined in its frame.
    fn moved_with(&self, marker: usize, shift: Vec3, turn: Vec3) -> Vec<Moved> {
        let mut moved = vec![Moved {
            marker,
            shift,
            turn,
        }];
        for &marker in self.carried.with(marker) {
            let Some((rm, between)) = self.carried.base(marker) else {
                continue;
            };
            // The RM marker of each marker comes before it in the list.
            let Some(by) = moved.iter().find(|moved| moved.marker == *rm) else {
                continue;
            };
            let arm = self.markers[*rm].R * self.stated(marker).p;
            moved.push(Moved {
                marker,
                shift: between.R * (by.shift + by.turn.cross(&arm)),
                turn: between.R * by.turn,
            });
        }
        moved
    }

    /// Returns the frame of a marker as the statement gives it: on its part, or in the frame of RM.
    fn stated(&self, marker: usize) -> Pose {
        let n = &self.theta[marker * PER_MARKER..(marker + 1) * PER_MARKER];
        Pose {
            p: Vec3::new(n[0], n[1], n[2]),
            R: self.by_points[marker].unwrap_or_else(|| euler313(n[3], n[4], n[5])),
        }
    }

    /// Updates the pose of a marker on its part, and the poses of the markers defined in its frame.
    fn refresh(&mut self, marker: usize) {
        self.place(marker);
        let carried = Arc::clone(&self.carried);
        for &marker in carried.with(marker) {
            self.place(marker);
        }
    }

    fn place(&mut self, marker: usize) {
        let stated = self.stated(marker);
        self.markers[marker] = match self.carried.base(marker) {
            Some((rm, between)) => between.compose(&self.markers[*rm]).compose(&stated),
            None => stated,
        };
    }
}
