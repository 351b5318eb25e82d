//! Forces of elements as inputs of functions: components with gradients with respect to the unknowns.

use super::compiled_function::{Exerted, Force};
use super::forces::DerivativeRequest;
use super::{Configuration, NoValue};
use crate::mechanics::{Mat3, Vec3, Vec6};

/// Ratio of a torque to the force times the length scale of the model. Below this ratio, the torque is round-off and has no direction.
const NO_DIRECTION: f64 = 1e-13;

impl Configuration<'_> {
    /// Computes the wrench of an element or constraint into `scratch.contribution`. Returns false for a constraint term that does not
    /// exist.
    pub(super) fn contribute(
        &mut self,
        who: Exerted,
        ask: DerivativeRequest,
    ) -> Result<bool, NoValue> {
        match who {
            Exerted::Element(k) => self.element(k, ask)?,
            Exerted::Joint(k, term) => {
                if term >= self.system.joints[k].terms.len() {
                    return Ok(false);
                }
                let tangent = ask == DerivativeRequest::Tangent;
                self.term(k, term, tangent);
                if tangent {
                    self.set_reaction_stiffness();
                }
            }
            Exerted::Multi(k, at) => {
                let multi = &self.system.multis[k];
                self.evaluate_multi(multi)?;
                self.multi(multi, at, ask == DerivativeRequest::Tangent);
            }
        }
        Ok(true)
    }

    /// Returns the value of a measured force and appends its gradient to the scratch.
    pub(super) fn measure_force(&mut self, force: &Force) -> Result<f64, NoValue> {
        let mut w = Vec6::zeros();
        for &(who, on_j) in &force.by {
            w += self.exerted(who, on_j)?;
        }
        let index = force.component as usize;
        let torque = index >= 4;
        let half = if torque {
            Vec3::new(w[3], w[4], w[5])
        } else {
            Vec3::new(w[0], w[1], w[2])
        };
        let magnitude = index.is_multiple_of(4);
        // Value = e . half, where e is the direction of the force itself for a magnitude.
        let R = force
            .axes
            .map_or_else(Mat3::identity, |m| self.scratch.markers[m].R);
        let e: Vec3 = if magnitude {
            // A zero force, or a torque that is round-off, has no direction; its magnitude gets zero slope.
            let reach = if torque { self.system.length } else { 1.0 };
            let size = w.fixed_rows::<3>(0).norm() * reach;
            half.try_normalize(NO_DIRECTION * size)
                .unwrap_or_else(Vec3::zeros)
        } else {
            R.column(index % 4 - 1).into_owned()
        };
        let weight = if torque {
            Vec6::new(0.0, 0.0, 0.0, e.x, e.y, e.z)
        } else {
            Vec6::new(e.x, e.y, e.z, 0.0, 0.0, 0.0)
        };
        for &(who, on_j) in &force.by {
            self.push_force(who, on_j, &weight)?;
        }
        if let (false, Some(axes)) = (magnitude, force.axes) {
            // de = dphi x e, hence de . F = dphi . (e x F).
            let by = e.cross(&half);
            let by = Vec6::new(0.0, 0.0, 0.0, by.x, by.y, by.z);
            self.push_motion(axes, &by);
        }
        Ok(e.dot(&half))
    }

    /// Returns (force, torque) in ground axes on I at the I origin, or on J at the J origin.
    pub(super) fn exerted(&mut self, who: Exerted, on_j: bool) -> Result<Vec6, NoValue> {
        let reading = self.read(who)?;
        let (f, t) = if on_j {
            (reading.force_on_j, reading.torque_on_j)
        } else {
            (reading.force, reading.torque)
        };
        Ok(Vec6::new(f.x, f.y, f.z, t.x, t.y, t.z))
    }

    /// Appends the gradient of `weight . (force, torque)` for one element or constraint.
    pub(super) fn push_force(
        &mut self,
        who: Exerted,
        on_j: bool,
        weight: &Vec6,
    ) -> Result<(), NoValue> {
        if !self.contribute(who, DerivativeRequest::Tangent)? {
            return Ok(());
        }
        let mut weight = *weight;
        if on_j {
            let wrench = &self.scratch.contribution;
            let (i, j, F) = (wrench.i, wrench.j, wrench.F);
            let d = self.scratch.markers[i].p - self.scratch.markers[j].p;
            // The forces on J are -F and -T - d x F: convert the weights to F and T on I, and add the change of d.
            let (a, b) = (
                Vec3::new(weight[0], weight[1], weight[2]),
                Vec3::new(weight[3], weight[4], weight[5]),
            );
            // b . (d x F) = F . (b x d) = d . (F x b)
            let on_force = -a - b.cross(&d);
            weight = Vec6::new(on_force.x, on_force.y, on_force.z, -b.x, -b.y, -b.z);
            // A floating marker moves with I.
            if !self.system.floating.contains_key(&j) {
                let by_d = -F.cross(&b);
                let by = Vec6::new(by_d.x, by_d.y, by_d.z, 0.0, 0.0, 0.0);
                self.push_motion(i, &by);
                self.push_motion(j, &-by);
            }
        }
        let scratch = &mut *self.scratch;
        scratch
            .contribution
            .pullback(&weight, &scratch.functions, &mut scratch.gradient);
        Ok(())
    }
}
