//! What elements and constraints do in a configuration.

use super::assemble::{NoValue, halves};
use super::structure::{Action, Joint};
use super::{ConstraintIx, ElementIx, Parameters, Scratch, State, System};
use crate::mechanics::{Mat3, RelativeMotion, Vec3, Vec6};
use crate::model::MarkerIx;

/// What one element or constraint does.
#[derive(Clone, PartialEq, Debug)]
pub struct Reading {
    /// I marker.
    pub i: MarkerIx,
    /// J or JFLOAT marker.
    pub j: MarkerIx,
    /// Motion of I as J sees it.
    pub motion: RelativeMotion,
    /// (force, torque) on I at the I origin, in the axes of J (of RM for vector forces).
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

impl System {
    /// Makes `scratch` hold the marker poses and function values of a configuration, for the readings below.
    ///
    /// # Errors
    /// [`NoValue`] if an element that a function measures is undefined in this configuration.
    pub fn look(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Result<(), NoValue> {
        self.place_markers(parameters, state, scratch);
        self.evaluate_functions(parameters, state, scratch)
    }

    /// What a force element does; after [`System::look`]. All zero if it is deactivated.
    ///
    /// # Errors
    /// [`NoValue`] if it is undefined in this configuration.
    pub fn read_element(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        element: ElementIx,
    ) -> Result<Reading, NoValue> {
        let element = &self.elements[element.0];
        let (mut w, mut R) = (Vec6::zeros(), Mat3::identity());
        if element.active {
            match &element.action {
                Action::Law(..) => {
                    Self::evaluate_law(element, parameters, state, scratch, false)?;
                    w = scratch.wrench.value;
                    R = scratch.markers[element.j].R;
                }
                Action::Vector(components) => {
                    for k in 0..6 {
                        w[k] = components[k].map_or(0.0, |f| scratch.functions[f].value);
                    }
                    R = element.frame.map_or(R, |m| scratch.markers[m].R);
                }
            }
        }
        let on_j = if element.reaction.is_some() { 1.0 } else { 0.0 };
        let pair = (element.i, element.j, element.pair);
        Ok(Self::reading(state, scratch, pair, (&w, &R), on_j))
    }

    /// The reaction of a constraint on its I marker; after [`System::look`]. For COUPLER and GEAR that of the first joint.
    pub fn read_constraint(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        constraint: ConstraintIx,
    ) -> Reading {
        let joint = &self.joints[constraint.0];
        if joint.terms.is_empty() {
            let w = (&Vec6::zeros(), &Mat3::identity());
            return Self::reading(state, scratch, (0, 0, 0), w, 0.0);
        }
        self.read_term(joint, 0, parameters, state, scratch)
    }

    /// The reaction of one term of a constraint on its I marker.
    pub(crate) fn read_term(
        &self,
        joint: &Joint,
        number: usize,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Reading {
        let term = &joint.terms[number];
        let mut w = Vec6::zeros();
        if joint.active {
            let out = Self::removed(joint, state);
            let lambda = Self::evaluate_term(joint, number, out, parameters, state, scratch);
            for k in 0..joint.count {
                w -= scratch.equations.jacobian[k] * lambda[k];
            }
        }
        let R = scratch.markers[term.j].R;
        Self::reading(state, scratch, (term.i, term.j, term.pair), (&w, &R), 1.0)
    }

    fn reading(
        state: &State,
        scratch: &Scratch,
        (i, j, pair): (usize, usize, usize),
        (w, R): (&Vec6, &Mat3),
        on_j: f64,
    ) -> Reading {
        let (force, torque) = halves(R, w);
        let d = scratch.markers[i].p - scratch.markers[j].p;
        Reading {
            i: MarkerIx(i),
            j: MarkerIx(j),
            motion: Self::motion(scratch, state, (i, j, pair), true),
            wrench_j: *w,
            force,
            torque,
            force_on_j: -on_j * force,
            torque_on_j: -on_j * (torque + d.cross(&force)),
        }
    }
}
