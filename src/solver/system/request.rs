//! Values of REQUESTs and SENSORs in a configuration.

use super::compiled_function::Source;
use super::{Configuration, NoValue, System};
use crate::mechanics::{Pose, Vec3, Vec6, psi_theta_phi};
use crate::model::{MarkerIx, Request, RequestKind};

impl Configuration<'_> {
    /// Returns the eight components of request `index` of the model. [`Configuration::evaluate`] must have been called.
    ///
    /// Components by kind of request, resolved in RM axes:
    /// - DISPLACEMENT: distance, x, y, z, zero, PSI, THETA, PHI.
    /// - FORCE: magnitude, x, y, z of the force on I, then magnitude, x, y, z of the torque about the I origin.
    /// - VELOCITY, ACCELERATION: magnitude, x, y, z of the difference between I and J, then magnitude, x, y, z for the rotation; zero in
    ///   statics.
    ///
    /// Components without a function are zero.
    ///
    /// # Errors
    /// Returns [`NoValue`] if a function, or an element that it reads, is undefined in this configuration.
    pub fn read_request(&mut self, request: &Request, index: usize) -> Result<[f64; 8], NoValue> {
        let pose = |here: &Self, marker: Option<MarkerIx>| {
            marker.map_or_else(Pose::identity, |m| here.scratch.markers[m.0])
        };
        match &request.kind {
            RequestKind::Displacement { i, j, rm } => {
                let (i, j) = (pose(self, Some(*i)), pose(self, *j));
                let d = pose(self, *rm).R.transpose() * (i.p - j.p);
                let [psi, theta, phi] = psi_theta_phi(&(j.R.transpose() * i.R));
                Ok([d.norm(), d.x, d.y, d.z, 0.0, psi, theta, phi])
            }
            RequestKind::Velocity { i, j, rm } => Ok(self.rates((*i, *j, *rm), false)),
            RequestKind::Acceleration { i, j, rm } => Ok(self.rates((*i, *j, *rm), true)),
            RequestKind::User(_) => Ok([0.0; 8]),
            RequestKind::Force { i, rm, .. } => {
                let mut w = Vec6::zeros();
                for condition in &self.system.conditions {
                    if condition.i == Some(i.0) {
                        // ADAMS adds the reaction of a GCON at its I marker, for any J marker (grammar/NOTES.md).
                        let (F, T) = self.read_condition(condition.name.id, *i);
                        w += Vec6::new(F.x, F.y, F.z, T.x, T.y, T.z);
                    }
                }
                for &(who, on_j) in &self.system.request_forces[index] {
                    w += self.exerted(who, on_j)?;
                }
                let R = pose(self, *rm).R.transpose();
                let f = R * Vec3::new(w[0], w[1], w[2]);
                let t = R * Vec3::new(w[3], w[4], w[5]);
                Ok([f.norm(), f.x, f.y, f.z, t.norm(), t.x, t.y, t.z])
            }
            RequestKind::Functions(_) => {
                let mut out = [0.0; 8];
                for (value, function) in out.iter_mut().zip(&self.system.requests[index]) {
                    if let Some(function) = function {
                        *value = self.value_of(*function)?;
                    }
                }
                Ok(out)
            }
        }
    }

    /// Returns the difference between the velocities or accelerations of I and J, seen from ground. The first four values are the magnitude and
    /// x, y, z along the axes of RM; the last four are the magnitude and x, y, z of the rotation.
    fn rates(
        &self,
        (i, j, rm): (MarkerIx, Option<MarkerIx>, Option<MarkerIx>),
        second: bool,
    ) -> [f64; 8] {
        let frame = |marker: Option<MarkerIx>| self.moving_frame(marker.map(|m| m.0));
        let (i, j, R) = (frame(Some(i)), frame(j), frame(rm).pose.R.transpose());
        let (v, w) = if second {
            (i.a - j.a, i.b - j.b)
        } else {
            (i.v - j.v, i.w - j.w)
        };
        let (v, w) = (R * v, R * w);
        [v.norm(), v.x, v.y, v.z, w.norm(), w.x, w.y, w.z]
    }

    /// Returns value and gradient of one function of request `index` of the model. The gradient is a list of (unknown, derivative). Returns
    /// `None` if the request has no such function. [`Configuration::evaluate`] must have been called.
    ///
    /// # Errors
    /// Returns [`NoValue`] if the function is undefined in this configuration.
    pub fn read_function(
        &mut self,
        index: usize,
        component: usize,
    ) -> Result<Option<(f64, &[(usize, f64)])>, NoValue> {
        let Some(function) = self.system.requests[index]
            .get(component)
            .copied()
            .flatten()
        else {
            return Ok(None);
        };
        let value = self.value_of(function)?;
        let range = self.scratch.functions[function].first..self.scratch.functions[function].last;
        Ok(Some((value, &self.scratch.gradient[range])))
    }

    /// Returns the value of FUNCTION of sensor `index` of the model. [`Configuration::evaluate`] must have been called.
    ///
    /// # Errors
    /// Returns [`NoValue`] if the function is undefined in this configuration.
    pub fn read_sensor(&mut self, index: usize) -> Result<f64, NoValue> {
        self.value_of(self.system.sensors[index].0)
    }

    /// Returns the value of EVALUATE of sensor `index` of the model, which SENVAL returns after the sensor has triggered. Returns `None` if the
    /// sensor has no EVALUATE.
    ///
    /// # Errors
    /// Returns [`NoValue`] if the function is undefined in this configuration.
    pub fn read_sensor_evaluate(&mut self, index: usize) -> Result<Option<f64>, NoValue> {
        let Some(function) = self.system.sensors[index].1 else {
            return Ok(None);
        };
        self.value_of(function).map(Some)
    }
}

impl System {
    /// Returns whether the FUNCTION of sensor `index` of the model reads accelerations or forces, directly or through variables.
    pub fn sensor_reads_balance(&self, index: usize) -> bool {
        let mut seen = vec![false; self.functions.len()];
        let mut open = vec![self.sensors[index].0];
        while let Some(function) = open.pop() {
            if std::mem::replace(&mut seen[function], true) {
                continue;
            }
            for source in &self.functions[function].sources {
                match source {
                    Source::Force(_) | Source::Friction(..) => return true,
                    Source::Moved(measure) if measure.kind.is_second() => return true,
                    Source::Variable(k) => open.push(self.variables[*k].function),
                    Source::Output((_, by_variable)) => {
                        open.extend(by_variable.iter().map(|(k, _)| self.variables[*k].function));
                    }
                    _ => {}
                }
            }
        }
        false
    }
}
