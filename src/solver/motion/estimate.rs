//! Error estimate of a step by the embedded formula of Radau IIA.

use super::integrator::Integrator;
use super::newton::{StageValues, Stages};
use super::tableau::E;
use crate::system::State;

impl Integrator<'_> {
    /// Returns the estimated error of the step as a multiple of the tolerance. An estimate above one is filtered a second time in three cases:
    /// the integration was restarted, the step is a repetition, or the step follows a rejection (`again`).
    ///
    /// # Errors
    /// Returns a message if an element has no value.
    pub(super) fn error(&mut self, h: f64, again: bool) -> Result<f64, String> {
        let system = self.system;
        let n = system.first_equation;
        let sum =
            |all: &Stages, k: usize| (E[0] * all[0][k] + E[1] * all[1][k] + E[2] * all[2][k]) / h;
        let mut v = Vec::new();
        let mut a = Vec::new();
        system.velocity_vector(&self.state, &mut v);
        system.gathered(&self.state.accelerations, &mut a);
        let unknowns = &self.unknowns;
        let r1: Vec<f64> = (0..n).map(|k| -(v[k] + sum(&unknowns.z, k))).collect();
        for (k, a) in a.iter_mut().enumerate() {
            *a += sum(&unknowns.w, k);
        }
        let mut rates = vec![0.0; system.moving_unknowns];
        for (k, equation) in system.states.iter().enumerate() {
            let at = equation.moving_unknown;
            rates[at] = self.state.state_rates[k] + sum(&unknowns.z, at);
        }
        let g = self.equations.inertia_of(system, &a, &rates);
        let first = self.equations.filtered(system, &self.state, h, r1, g);
        let found = self.measured(&first.z, &first.w, false);
        let start = self.anew || self.within || again;
        if found.size < 1.0 || !start {
            self.worst = format!("the largest error is that of {}", self.report_error(found));
            return Ok(found.size.max(1e-10));
        }
        // The second filter uses the residual at the state that results from adding the first estimate.
        let mut beside = State::empty();
        let unknowns = &self.unknowns;
        let mut z = first.z;
        z[n..system.first_variable].fill(0.0);
        self.equations.stage_state(
            system,
            &self.state,
            &StageValues {
                time: self.state.time,
                z: &z,
                w: &first.w,
                acceleration: &|k| -sum(&unknowns.w, k),
                state_rate: &|k| -sum(&unknowns.z, k),
            },
            &mut beside,
        );
        let mut g = vec![0.0; system.moving_unknowns];
        system
            .residual(
                self.parameters,
                &beside,
                &mut self.equations.scratch,
                &mut g,
            )
            .map_err(|reason| reason.to_string())?;
        let r1: Vec<f64> = (0..n)
            .map(|k| -(v[k] + first.w[k] + sum(&unknowns.z, k)))
            .collect();
        let second = self.equations.filtered(system, &self.state, h, r1, g);
        let found = self.measured(&second.z, &second.w, false);
        self.worst = format!("the largest error is that of {}", self.report_error(found));
        Ok(found.size.max(1e-10))
    }
}
