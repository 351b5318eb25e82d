//! Forces of elements as functions see them: components with gradients by the unknowns.

use super::assemble::{NoValue, halves};
use super::chain::{moved_columns, turn};
use super::structure::{Action, Drive};
use super::{Parameters, Scratch, State, System};
use crate::function::ForceComponent;
use crate::mechanics::{Mat3, Mat6, Vec3, Vec6, skew};

/// Magnitudes below this beside their terms are round-off.
const NO_DIRECTION: f64 = 1e-13;

/// What exerts a force.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(crate) enum Exerted {
    Element(usize),
    Joint(usize),
    /// An NFORCE at one of its markers.
    Multi(usize, usize),
}

/// A component of the sum of some forces.
#[derive(Clone, PartialEq, Debug)]
pub(crate) struct Force {
    /// Who, and whether the force on J (at the J origin) is meant.
    pub by: Vec<(Exerted, bool)>,
    pub component: ForceComponent,
    /// Axes that resolve it; ground if absent.
    pub axes: Option<usize>,
}

/// A measured force; its gradient is appended to the scratch.
pub(crate) struct ForceMeasured {
    pub value: f64,
}

impl System {
    pub(crate) fn measure_force(
        &self,
        force: &Force,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        with_gradient: bool,
    ) -> Result<ForceMeasured, NoValue> {
        let mut w = Vec6::zeros();
        for &(who, on_j) in &force.by {
            w += self.exerted(who, on_j, parameters, state, scratch)?;
        }
        let index = force.component as usize;
        let torque = index >= 4;
        let half = if torque {
            Vec3::new(w[3], w[4], w[5])
        } else {
            Vec3::new(w[0], w[1], w[2])
        };
        let magnitude = index.is_multiple_of(4);
        // Value = e . half; for a magnitude e is the direction of the force itself.
        let R = force
            .axes
            .map_or_else(Mat3::identity, |m| scratch.markers[m].R);
        let e: Vec3 = if magnitude {
            // What is round-off beside the forces has no direction, and its magnitude no slope.
            let size = w.fixed_rows::<3>(0).norm() * if torque { self.length } else { 1.0 };
            half.try_normalize(NO_DIRECTION * size)
                .unwrap_or_else(Vec3::zeros)
        } else {
            R.column(index % 4 - 1).into_owned()
        };
        if with_gradient {
            let weight = if torque {
                Vec6::new(0.0, 0.0, 0.0, e.x, e.y, e.z)
            } else {
                Vec6::new(e.x, e.y, e.z, 0.0, 0.0, 0.0)
            };
            for &(who, on_j) in &force.by {
                self.push_force(who, on_j, &weight, parameters, state, scratch)?;
            }
            if let (false, Some(axes)) = (magnitude, force.axes) {
                // de = dphi x e, hence de . F = dphi . (e x F).
                let by = e.cross(&half);
                let by = Vec6::new(0.0, 0.0, 0.0, by.x, by.y, by.z);
                self.push_motion(scratch, axes, &by);
            }
        }
        Ok(ForceMeasured {
            value: e.dot(&half),
        })
    }

    /// (force, torque) in ground axes on I at the I origin, or on J at the J origin.
    pub(crate) fn exerted(
        &self,
        who: Exerted,
        on_j: bool,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Result<Vec6, NoValue> {
        let reading = match who {
            Exerted::Element(k) => {
                self.read_element(parameters, state, scratch, super::ElementIx(k))?
            }
            Exerted::Joint(k) => {
                self.read_constraint(parameters, state, scratch, super::ConstraintIx(k))
            }
            Exerted::Multi(k, at) => self.read_multi((k, at), parameters, state, scratch)?,
        };
        let (f, t) = if on_j {
            (reading.force_on_j, reading.torque_on_j)
        } else {
            (reading.force, reading.torque)
        };
        Ok(Vec6::new(f.x, f.y, f.z, t.x, t.y, t.z))
    }

    /// Appends the gradient of `weight . (force, torque)` of one element or constraint.
    pub(crate) fn push_force(
        &self,
        who: Exerted,
        on_j: bool,
        weight: &Vec6,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Result<(), NoValue> {
        let (i, j) = match who {
            Exerted::Element(k) => (self.elements[k].i, self.elements[k].j),
            Exerted::Joint(k) => match self.joints[k].terms.first() {
                Some(term) => (term.i, term.j),
                None => return Ok(()),
            },
            Exerted::Multi(k, at) => (self.multis[k].i[at], self.multis[k].j),
        };
        let mut weight = *weight;
        let d = scratch.markers[i].p - scratch.markers[j].p;
        if on_j {
            // On J act -F and -T - d x F: the weights of F and T on I, and the change of d.
            let (a, b) = (
                Vec3::new(weight[0], weight[1], weight[2]),
                Vec3::new(weight[3], weight[4], weight[5]),
            );
            let w = self.exerted(who, false, parameters, state, scratch)?;
            let F = Vec3::new(w[0], w[1], w[2]);
            // b . (d x F) = F . (b x d) = d . (F x b)
            let on_force = -a - b.cross(&d);
            weight = Vec6::new(on_force.x, on_force.y, on_force.z, -b.x, -b.y, -b.z);
            let by_d = -F.cross(&b);
            let by = Vec6::new(by_d.x, by_d.y, by_d.z, 0.0, 0.0, 0.0);
            self.push_motion(scratch, i, &by);
            self.push_motion(scratch, j, &-by);
        }
        match who {
            Exerted::Element(k) => self.push_element(k, &weight, parameters, state, scratch),
            Exerted::Joint(k) => {
                self.push_joint(k, &weight, parameters, state, scratch);
                Ok(())
            }
            Exerted::Multi(k, at) => self.push_multi((k, at), &weight, parameters, state, scratch),
        }
    }

    fn push_element(
        &self,
        number: usize,
        weight: &Vec6,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Result<(), NoValue> {
        let element = &self.elements[number];
        let on = if element.active { 1.0 } else { 0.0 };
        match &element.action {
            Action::Law(_, drive) => {
                Self::evaluate_law(element, parameters, state, scratch, false)?;
                let R = scratch.markers[element.j].R;
                let (F, T) = halves(&R, &scratch.wrench.value);
                let D = turn(&R, &scratch.wrench.by_motion);
                let (weight, unit) = (weight * on, scratch.wrench.by_parameter.first().copied());
                let frame = Some(element.j);
                self.push_wrench(
                    (element.i, frame),
                    (&F, &T),
                    Some(&D),
                    &weight,
                    state,
                    scratch,
                );
                if let (Drive::Function(function), Some(unit)) = (drive, unit) {
                    let (uF, uT) = halves(&R, &unit);
                    push_function(scratch, *function, dot(&weight, &uF, &uT));
                }
            }
            Action::Vector(components) => {
                let R = element
                    .frame
                    .map_or_else(Mat3::identity, |m| scratch.markers[m].R);
                let mut w = Vec6::zeros();
                for k in 0..6 {
                    w[k] = components[k].map_or(0.0, |f| scratch.functions[f].value);
                }
                let (F, T) = halves(&R, &w);
                let weight = weight * on;
                self.push_wrench(
                    (element.i, element.frame),
                    (&F, &T),
                    None,
                    &weight,
                    state,
                    scratch,
                );
                for k in 0..6 {
                    if let Some(function) = components[k] {
                        let (uF, uT) = halves(&R, &Vec6::ith(k, 1.0));
                        push_function(scratch, function, dot(&weight, &uF, &uT));
                    }
                }
            }
        }
        Ok(())
    }

    fn push_joint(
        &self,
        number: usize,
        weight: &Vec6,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) {
        let joint = &self.joints[number];
        let term = &joint.terms[0];
        let on = if joint.active { 1.0 } else { 0.0 };
        let weight = weight * on;
        let out = Self::removed(joint, state);
        let lambda = Self::evaluate_term(joint, 0, out, parameters, state, scratch);
        let R = scratch.markers[term.j].R;
        let mut w = Vec6::zeros();
        for k in 0..joint.count {
            let row = scratch.equations.jacobian[k];
            w -= row * lambda[k];
            let (a, b) = halves(&R, &row);
            let by = if out[k] {
                0.0
            } else {
                -term.scale * dot(&weight, &a, &b)
            };
            scratch
                .gradient
                .push((self.first_equation + joint.first + k, by));
        }
        let (F, T) = halves(&R, &w);
        let mut D = Mat6::zeros();
        let curvature = R * scratch.equations.curvature * R.transpose();
        D.fixed_view_mut::<3, 3>(3, 3).copy_from(&-curvature);
        self.push_wrench(
            (term.i, Some(term.j)),
            (&F, &T),
            Some(&D),
            &weight,
            state,
            scratch,
        );
    }

    /// Appends the gradient of `weight . w` by the parts of I and of the frame: `dw = D m + dphi_C x w`.
    fn push_wrench(
        &self,
        (i, frame): (usize, Option<usize>),
        (F, T): (&Vec3, &Vec3),
        D: Option<&Mat6>,
        weight: &Vec6,
        state: &State,
        scratch: &mut Scratch,
    ) {
        let mut push = |part: usize, row: &nalgebra::RowVector6<f64>| {
            let place = self.place(part);
            for k in 0..place.freedoms {
                scratch.gradient.push((place.first + k, row[k]));
            }
        };
        let a = self.owners[i];
        let arm = scratch.markers[i].p;
        let seen = |part: usize| skew(&(arm - state.poses[part].p));
        if let Some(D) = D {
            push(a, &(weight.transpose() * moved_columns(D, &seen(a))));
        }
        if let Some(frame) = frame {
            let c = self.owners[frame];
            let mut N = D.map_or_else(Mat6::zeros, |D| -moved_columns(D, &seen(c)));
            let mut upper = N.fixed_view_mut::<3, 3>(0, 3);
            upper -= skew(F);
            let mut lower = N.fixed_view_mut::<3, 3>(3, 3);
            lower -= skew(T);
            push(c, &(weight.transpose() * N));
        }
    }
}

fn dot(weight: &Vec6, F: &Vec3, T: &Vec3) -> f64 {
    (0..3)
        .map(|k| weight[k] * F[k] + weight[3 + k] * T[k])
        .sum()
}

/// Appends a multiple of the gradient of a function.
fn push_function(scratch: &mut Scratch, function: usize, by: f64) {
    let value = scratch.functions[function];
    for at in value.first..value.last {
        let (unknown, derivative) = scratch.gradient[at];
        scratch.gradient.push((unknown, by * derivative));
    }
}
