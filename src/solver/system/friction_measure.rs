//! Quantities of a FRICTION as inputs of functions, with gradients with respect to the unknowns.
//!
//! The quantities have the order of the components of the function FRICTION, and vectors are in the axes of the J marker of the JOINT
//! (func_friction; grammar/NOTES.md). The order is: force and torque on I, coefficients of translation and rotation, stiction coefficient,
//! surface velocities, creeps, weight of the velocity term.

use super::Configuration;
use super::NoValue;
use super::forces::DerivativeRequest;
use super::friction::{Sliding, coefficients};
use super::surface::{JointFriction, Slide};
use crate::mechanics::{Vec3, Vec6};

/// Quantity that the function FRICTION returns.
#[derive(Clone, Copy, PartialEq, Eq)]
enum FrictionComponent {
    /// Force or torque on I along an axis of J.
    Wrench { axis: usize, torque: bool },
    /// Component along an axis of J of a vector that is summed over the sliding directions. `turning` selects the rotational directions.
    Along {
        of: Vector,
        axis: usize,
        turning: bool,
    },
    /// Stiction coefficient mu_1.
    Stiction,
    /// Weight beta of the velocity term.
    Share,
}

/// Quantity with one component per sliding direction.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Vector {
    Coefficient,
    Velocity,
    Creep,
}

impl FrictionComponent {
    fn of(which: usize) -> Self {
        let along = |of, at: usize| Self::Along {
            of,
            axis: at % 3,
            turning: at >= 3,
        };
        match which {
            0..6 => Self::Wrench {
                axis: which % 3,
                torque: which >= 3,
            },
            6..12 => along(Vector::Coefficient, which - 6),
            12 => Self::Stiction,
            13..19 => along(Vector::Velocity, which - 13),
            19..25 => along(Vector::Creep, which - 19),
            _ => Self::Share,
        }
    }
}

impl Configuration<'_> {
    /// Returns a quantity of the FRICTION with this id, summed over its yokes. Appends the gradient of the quantity, always with the same
    /// sparsity pattern. The quantity is zero in statics.
    ///
    /// The stiction coefficient and the velocity weight have no gradient.
    pub(super) fn measure_friction(&mut self, id: u32, which: usize) -> Result<f64, NoValue> {
        let system = self.system;
        if !self.moving() || self.state.grips.len() != system.frictions.len() {
            return Ok(0.0);
        }
        let mut value = 0.0;
        for (number, friction) in system.frictions.iter().enumerate() {
            if friction.name.id != id {
                continue;
            }
            let before = self.scratch.gradient.len();
            let on = f64::from(u8::from(friction.active));
            let (found, first) = match FrictionComponent::of(which) {
                FrictionComponent::Wrench { axis, torque } => {
                    self.friction_wrench(number, friction, (axis, torque))?
                }
                FrictionComponent::Along { of, axis, turning } => {
                    let sliding = self.sliding(number, true)?;
                    let first = self.scratch.gradient.len();
                    let found = self.friction_along(friction, &sliding, (of, axis, turning));
                    (found, first)
                }
                FrictionComponent::Stiction | FrictionComponent::Share => {
                    let sliding = self.sliding(number, false)?;
                    let (mu, _) = coefficients(&friction.law, &sliding);
                    let found = match FrictionComponent::of(which) {
                        FrictionComponent::Stiction => mu.mu_1,
                        _ => mu.beta,
                    };
                    (found, self.scratch.gradient.len())
                }
            };
            value += on * found;
            let gradient = &mut self.scratch.gradient;
            for (_, by) in &mut gradient[first..] {
                *by *= on;
            }
            gradient.drain(before..first);
        }
        Ok(value)
    }

    /// Returns a component of the friction wrench on I in J axes, and the start index of its gradient.
    fn friction_wrench(
        &mut self,
        number: usize,
        friction: &JointFriction,
        (axis, torque): (usize, bool),
    ) -> Result<(f64, usize), NoValue> {
        self.friction(number, DerivativeRequest::Tangent)?;
        let first = self.scratch.gradient.len();
        let e: Vec3 = self.scratch.markers[friction.j].R.column(axis).into();
        let (half, weight) = if torque {
            let weight = Vec6::new(0.0, 0.0, 0.0, e.x, e.y, e.z);
            (self.scratch.contribution.T, weight)
        } else {
            let weight = Vec6::new(e.x, e.y, e.z, 0.0, 0.0, 0.0);
            (self.scratch.contribution.F, weight)
        };
        let scratch = &mut *self.scratch;
        scratch
            .contribution
            .pullback(&weight, &scratch.functions, &mut scratch.gradient);
        // The axis rotates with J: de = dphi x e.
        let by = e.cross(&half);
        self.push_motion(friction.j, &Vec6::new(0.0, 0.0, 0.0, by.x, by.y, by.z));
        Ok((e.dot(&half), first))
    }

    /// Returns a component of a vector that is the sum of contributions along the sliding directions, and appends its gradient.
    fn friction_along(
        &mut self,
        friction: &JointFriction,
        sliding: &Sliding,
        (of, axis, turning): (Vector, usize, bool),
    ) -> f64 {
        let (mu, _) = coefficients(&friction.law, sliding);
        let parts = match of {
            Vector::Coefficient => mu.value,
            Vector::Velocity => sliding.v,
            Vector::Creep => sliding.c,
        };
        let e: Vec3 = self.scratch.markers[friction.j].R.column(axis).into();
        let mut value = 0.0;
        for (k, &slide) in friction.slides.iter().enumerate() {
            if turning != (slide != Slide::AlongZ) {
                continue;
            }
            let (marker, column) = match slide {
                Slide::AlongZ => (friction.j, 2),
                Slide::AboutI(column) => (friction.i, column),
                Slide::AboutJ(column) => (friction.j, column),
            };
            let a: Vec3 = self.scratch.markers[marker].R.column(column).into();
            let share = e.dot(&a);
            value += parts[k] * share;
            let scratch = &mut *self.scratch;
            for m in 0..friction.slides.len() {
                let same = f64::from(u8::from(m == k));
                let (by_v, by_c) = match of {
                    Vector::Coefficient => (mu.by_velocity[(k, m)], mu.by_creep[(k, m)]),
                    Vector::Velocity => (same, 0.0),
                    Vector::Creep => (0.0, same),
                };
                for ((from, to), by) in [(sliding.v_spans[m], by_v), (sliding.c_spans[m], by_c)] {
                    for at in from..to {
                        let (unknown, derivative) = scratch.gradient[at];
                        scratch.gradient.push((unknown, share * by * derivative));
                    }
                }
            }
            // d(e . a) = dphi_J . (e x a) + dphi_a . (a x e)
            let by = e.cross(&a) * parts[k];
            let by = Vec6::new(0.0, 0.0, 0.0, by.x, by.y, by.z);
            self.push_motion(friction.j, &by);
            self.push_motion(marker, &-by);
        }
        value
    }
}
