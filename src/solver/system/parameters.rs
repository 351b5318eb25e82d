use std::sync::Arc;

use super::Slot;
use super::carried::{Carried, Moved};
use crate::mechanics::{Mat3, Pose, Vec3, euler313, exp, psi_theta_phi};

/// Numbers per marker at the front of theta: QP and REULER.
pub(crate) const PER_MARKER: usize = 6;

/// Theta: every number that can be identified or edited between runs without compiling anew.
///
/// Angles in radians, everything else in the dataset's units, as the statements have them: QP and REULER of a marker with RM are in the
/// frame of RM. Marker frames are kept up to date with the numbers. QP moves a marker without turning it: points that give its axes
/// move along.
#[derive(Clone, PartialEq, Debug)]
pub struct Parameters {
    theta: Vec<f64>,
    /// Pose of each marker on its part.
    markers: Vec<Pose>,
    /// Rotation from ZP, XP points, which REULER cannot change.
    by_points: Vec<Option<Mat3>>,
    carried: Arc<Carried>,
}

impl Parameters {
    pub(crate) fn new(
        theta: Vec<f64>,
        by_points: Vec<Option<Mat3>>,
        carried: Arc<Carried>,
    ) -> Self {
        let mut new = Self {
            theta,
            markers: vec![Pose::identity(); by_points.len()],
            by_points,
            carried,
        };
        for marker in 0..new.markers.len() {
            if !new.carried.is_carried(marker) {
                new.refresh(marker);
            }
        }
        new
    }

    /// The number in a slot. The slot of a whole function is NaN as long as the function itself is in force.
    pub fn get(&self, slot: Slot) -> f64 {
        self.theta[slot.0]
    }

    /// Changes a number.
    pub fn set(&mut self, slot: Slot, value: f64) {
        self.theta[slot.0] = value;
        let marker = slot.0 / PER_MARKER;
        if marker < self.markers.len() {
            self.refresh(marker);
        }
    }

    /// All numbers.
    pub(crate) fn theta(&self) -> &[f64] {
        &self.theta
    }

    /// Turns a marker on its part by `angle` radians about an axis of its own.
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

    /// Axes of a marker whose points ZP and XP give them, in the frame that these are given in.
    pub fn axes_by_points(&self, marker: crate::model::MarkerIx) -> Option<Mat3> {
        self.by_points[marker.0]
    }

    /// Where a marker is on its part.
    pub fn marker(&self, marker: crate::model::MarkerIx) -> &Pose {
        &self.markers[marker.0]
    }

    pub(crate) fn markers(&self) -> &[Pose] {
        &self.markers
    }

    /// The frames that move by a unit of one of a marker's six numbers: its own, and those that are given in it.
    pub(crate) fn marker_derivative(&self, marker: usize, k: usize) -> Vec<Moved> {
        let (shift, turn) = self.stated_derivative(marker, k);
        let axes = match self.carried.base(marker) {
            Some((rm, between)) => between.R * self.markers[*rm].R,
            None => Mat3::identity(),
        };
        self.moved_with(marker, axes * shift, axes * turn)
    }

    /// The frames that move by a radian of a turn of a marker about an axis of its own.
    pub(crate) fn turn_derivative(&self, marker: usize, axis: &Vec3) -> Vec<Moved> {
        self.moved_with(marker, Vec3::zeros(), self.markers[marker].R * axis)
    }

    /// Displacement and rotation vector by a number, in the axes that the number is given in.
    fn stated_derivative(&self, marker: usize, k: usize) -> (Vec3, Vec3) {
        if k < 3 {
            return (Vec3::ith(k, 1.0), Vec3::zeros());
        }
        if self.by_points[marker].is_some() {
            return (Vec3::zeros(), Vec3::zeros());
        }
        let at = marker * PER_MARKER + 3;
        let (psi, theta) = (self.theta[at], self.theta[at + 1]);
        // R = Rz(psi) Rx(theta) Rz(phi): each angle turns about an axis that the ones before it have placed.
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

    /// A marker that moves on its part, and with it those that are given in its frame.
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
            // Their frame comes before them in the list.
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

    /// The frame of a marker as it is stated: on its part, or in the frame of RM.
    fn stated(&self, marker: usize) -> Pose {
        let n = &self.theta[marker * PER_MARKER..(marker + 1) * PER_MARKER];
        Pose {
            p: Vec3::new(n[0], n[1], n[2]),
            R: self.by_points[marker].unwrap_or_else(|| euler313(n[3], n[4], n[5])),
        }
    }

    /// Places a marker on its part, and those that are given in its frame on theirs.
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
