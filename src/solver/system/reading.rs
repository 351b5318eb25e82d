//! Forces and reactions of elements and constraints in a configuration.

use super::NoValue;
use super::compiled_function::Exerted;
use super::forces::DerivativeRequest;
use super::{Configuration, ConstraintIx, ElementIx};
use crate::mechanics::{RelativeMotion, Vec3, Vec6};
use crate::model::MarkerIx;

/// Force and relative motion of one element or constraint.
#[derive(Clone, PartialEq, Debug)]
pub struct Reading {
    /// I marker.
    pub i: MarkerIx,
    /// J or JFLOAT marker.
    pub j: MarkerIx,
    /// Motion of I relative to J.
    pub motion: RelativeMotion,
    /// Wrench (force, torque) on I at the I origin, in J axes (in RM axes for vector forces).
    pub wrench_j: Vec6,
    /// Force on I, ground axes.
    pub force: Vec3,
    /// Torque on I about the I origin, ground axes.
    pub torque: Vec3,
    /// Force on J, ground axes; zero for ACTIONONLY.
    pub force_on_j: Vec3,
    /// Torque on J about the J origin, ground axes: `-T - d x F` with d from J to I.
    pub torque_on_j: Vec3,
}

impl Reading {
    /// Returns the deflections of an elastic element: three translations along the axes of J, then three projected angles in radians.
    pub fn deflections(&self) -> [f64; 6] {
        let (p, a) = (self.motion.p_ij_j, self.motion.angles);
        [p.x, p.y, p.z, a.x, a.y, a.z]
    }
}

impl Configuration<'_> {
    /// Returns the wrench of a force element; all zero if the element is inactive. [`Configuration::evaluate`] must have been called.
    ///
    /// # Errors
    /// Returns [`NoValue`] if the element is undefined in this configuration.
    pub fn read_element(&mut self, element: ElementIx) -> Result<Reading, NoValue> {
        self.read(Exerted::Element(element.0))
    }

    /// Returns the reaction of a constraint on its I marker; for COUPLER and GEAR, the reaction at the first joint.
    /// [`Configuration::evaluate`] must have been called.
    pub fn read_constraint(&mut self, constraint: ConstraintIx) -> Reading {
        let terms = self.system.joints[constraint.0].at_first().max(1);
        let mut all = (0..terms).map(|at| {
            self.read(Exerted::Joint(constraint.0, at))
                .expect("constraints have a value everywhere")
        });
        let mut out = all.next().expect("at least one");
        for more in all {
            out.wrench_j += more.wrench_j;
            out.force += more.force;
            out.torque += more.torque;
            out.force_on_j += more.force_on_j;
            out.torque_on_j += more.torque_on_j;
        }
        out
    }

    /// Returns the wrenches of an NFORCE at each of its I markers. [`Configuration::evaluate`] must have been called.
    ///
    /// # Errors
    /// Returns [`NoValue`] if the NFORCE is undefined in this configuration.
    pub fn read_nforce(&mut self, id: u32) -> Result<Vec<Reading>, NoValue> {
        let mut multis = self.system.multis.iter();
        let Some(number) = multis.position(|multi| multi.name.id == id) else {
            return Ok(Vec::new());
        };
        (0..self.system.multis[number].i.len())
            .map(|at| self.read(Exerted::Multi(number, at)))
            .collect()
    }

    /// Returns the wrench of an element, of a constraint term, or of an NFORCE at one of its markers.
    pub(super) fn read(&mut self, who: Exerted) -> Result<Reading, NoValue> {
        if !self.contribute(who, DerivativeRequest::Value)? {
            self.scratch.contribution = super::contribution::Contribution::default();
        }
        Ok(self.contributed())
    }

    /// Returns the wrench in `scratch.contribution` as a [`Reading`].
    pub(super) fn contributed(&self) -> Reading {
        let wrench = &self.scratch.contribution;
        let (i, j) = (wrench.i, wrench.j);
        let on_j = if wrench.b.is_some() { 1.0 } else { 0.0 };
        let d = self.scratch.markers[i].p - self.scratch.markers[j].p;
        Reading {
            i: MarkerIx(i),
            j: MarkerIx(j),
            motion: self.motion(i, j, wrench.pair, true),
            wrench_j: wrench.w,
            force: wrench.F,
            torque: wrench.T,
            force_on_j: -on_j * wrench.F,
            torque_on_j: -on_j * (wrench.T + d.cross(&wrench.F)),
        }
    }
}
