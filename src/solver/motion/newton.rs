//! The equations of one time step: three stages, and the linear systems of their Newton iteration.
//!
//! z is an eigenvalue of B / h, and the residuals are those of the transformed stages. `g` is the residual that the system assembles. Its
//! derivatives are K with respect to positions, C with respect to velocities and N with respect to accelerations:
//!
//! ```text
//! r1 = (B d)/h - Th(d) (V - D G' mu),     r3 = Phi,     r4 = G V + Phi_t
//! G D G' dmu = z r3 - r4 - G r1,          e = r1 + D G' dmu
//! (K + z C + z^2 N) dd + ... = -g - (C + z N) e,    G dd = -r3,    dW = z dd + e
//! ```
//!
//! The linear system with K, C and N is solved for z^2 dd, so that the entries of its matrix stay bounded as the step size goes to zero.

use nalgebra::Complex;

use super::bordered::plain_weight;
use super::linearisation::{Correction, Linearisation};
use super::tableau::{ALPHA_BETA, C, GAMMA, Tableau};
use crate::linear::{Lu, Triple};
use crate::mechanics::{Mat3, Vec3, turning_rate};
use crate::system::{NoValue, Parameters, PartRates, RowProducts, Scratch, State, System};

/// Returns two eigenvalues of B / h: the real eigenvalue, and one of the complex pair.
fn eigenvalues(h: f64) -> Triple {
    Triple::new(GAMMA / h, ALPHA_BETA / h)
}

/// Three vectors, one per stage of a step.
pub(super) type Stages = [Vec<f64>; 3];

pub(super) fn stages(n: usize) -> Stages {
    std::array::from_fn(|_| vec![0.0; n])
}

/// Step of the integrator.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step<'a> {
    /// State at the start.
    pub start: &'a State,
    /// Step size.
    pub h: f64,
}

/// Stage of a step, relative to its start.
pub(super) struct StageValues<'a> {
    /// Time of the stage.
    pub time: f64,
    /// Changes of all unknowns since the start of the step.
    pub z: &'a [f64],
    /// Changes of the velocities since the start of the step.
    pub w: &'a [f64],
    /// Function that returns the time derivative of the velocity with a given index.
    pub acceleration: &'a dyn Fn(usize) -> f64,
    /// Function that returns the time derivative of a dynamic state, given the index of the state among the unknowns.
    pub state_rate: &'a dyn Fn(usize) -> f64,
}

/// Unknowns of the three stages. `z` contains the changes of all unknowns since the start of the step (displacements and rotation vectors of
/// the parts, multipliers, variables, states). `w` contains the changes of the velocities, and `mu` the multipliers of the velocity
/// constraints.
#[derive(Clone, Debug)]
pub(super) struct Unknowns {
    pub z: Stages,
    pub w: Stages,
    pub mu: Stages,
}

impl Unknowns {
    pub(crate) fn new(system: &System) -> Self {
        Self {
            z: stages(system.moving_unknowns),
            w: stages(system.first_equation),
            mu: stages(system.equations),
        }
    }
}

impl Unknowns {
    fn all(&self) -> impl Iterator<Item = &Vec<f64>> {
        self.z.iter().chain(&self.w).chain(&self.mu)
    }

    fn all_mut(&mut self) -> impl Iterator<Item = &mut Vec<f64>> {
        self.z.iter_mut().chain(&mut self.w).chain(&mut self.mu)
    }

    /// Adds `factor` times `other`.
    pub(crate) fn add(&mut self, factor: f64, other: &Self) {
        for (to, from) in self.all_mut().zip(other.all()) {
            for (x, dx) in to.iter_mut().zip(from) {
                *x += factor * dx;
            }
        }
    }

    pub(crate) fn scale(&mut self, factor: f64) {
        for x in self.all_mut().flatten() {
            *x *= factor;
        }
    }

    /// Returns the scalar product with `other`, where each component of both is multiplied by its weight.
    pub(crate) fn product(&self, other: &Self, weights: &Self) -> f64 {
        let mut sum = 0.0;
        for ((a, b), w) in self.all().zip(other.all()).zip(weights.all()) {
            let terms = a.iter().zip(b).zip(w);
            sum += terms.map(|((a, b), w)| (a * w) * (b * w)).sum::<f64>();
        }
        sum
    }
}

/// Residuals of the stages: `r1` of the rates of displacements, `g` of force balances, constraints and states, `r4` of the velocity
/// constraints.
#[derive(Clone, Debug)]
pub(super) struct Residuals {
    r1: Stages,
    g: Stages,
    r4: Stages,
}

impl Residuals {
    /// Returns `r1`, `g` and `r4` of one stage.
    pub(crate) fn at(&self, stage: usize) -> (&[f64], &[f64], &[f64]) {
        (&self.r1[stage], &self.g[stage], &self.r4[stage])
    }

    /// Iterates over the residuals of one stage, in the order `g`, `r1`, `r4`.
    pub(crate) fn of(&self, stage: usize) -> impl Iterator<Item = f64> + '_ {
        let parts = [&self.g[stage], &self.r1[stage], &self.r4[stage]];
        parts.into_iter().flatten().copied()
    }
}

/// Equations of a step, with the matrices of its Newton iteration and their factors.
#[derive(Debug)]
pub(super) struct StepMatrices {
    pub tableau: Tableau,
    pub(super) linear: Linearisation,
    products: RowProducts,
    pub(super) factors: Lu<Triple>,
    values: Vec<Triple>,
    pub scratch: Scratch,
    pub(super) stage: State,
    pub(super) residuals: Residuals,
    /// Residuals of the transformed stages. The solution replaces them by corrections.
    transformed: Correction<Triple>,
    pub evaluations: usize,
    pub jacobians: usize,
    pub factorisations: usize,
}

impl StepMatrices {
    pub(crate) fn new(system: &System) -> Self {
        let n = system.moving_unknowns;
        Self {
            tableau: Tableau::new(),
            linear: Linearisation::new(system),
            products: RowProducts::new(system),
            factors: Lu::for_steps(n),
            values: Vec::new(),
            scratch: Scratch::new(system),
            stage: system.state(),
            residuals: Residuals {
                r1: stages(system.first_equation),
                g: stages(n),
                r4: stages(system.equations),
            },
            transformed: Correction::default(),
            evaluations: 0,
            jacobians: 0,
            factorisations: 0,
        }
    }

    /// Assembles the derivatives at a state and factors the projection onto the constraints.
    pub(crate) fn linearise(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &State,
    ) -> Result<(), NoValue> {
        let (scratch, g) = (&mut self.scratch, &mut self.residuals.g[0]);
        self.linear.take(system, parameters, state, scratch, g)?;
        self.jacobians += 1;
        Ok(())
    }

    /// Assembles the derivatives at the stage whose state [`Self::place_stage`] computed last.
    pub(crate) fn linearise_stage(
        &mut self,
        system: &System,
        parameters: &Parameters,
        linear: &mut Linearisation,
    ) -> Result<(), NoValue> {
        let (stage, scratch) = (&self.stage, &mut self.scratch);
        linear.take(system, parameters, stage, scratch, &mut self.residuals.g[0])?;
        self.jacobians += 1;
        Ok(())
    }

    /// Assembles the derivatives at the predicted second stage of a step. This stage is closer to all stages than the start of the step is.
    pub(crate) fn linearise_within(
        &mut self,
        system: &System,
        parameters: &Parameters,
        step: Step<'_>,
        unknowns: &Unknowns,
    ) -> Result<(), NoValue> {
        let Step { start, h } = step;
        self.place_stage(system, start, h, 1, unknowns);
        let stage = std::mem::replace(&mut self.stage, State::empty());
        let done = self.linearise(system, parameters, &stage);
        self.stage = stage;
        done
    }

    /// Factors the real and the complex matrix for step size `h`.
    pub(crate) fn factor(&mut self, system: &System, h: f64) {
        let matrix = self.linear.matrix(system, &mut self.values, eigenvalues(h));
        self.factors.factor_entries(&matrix);
        self.factorisations += 1;
    }

    /// Computes the corrections of the unknowns from the residuals of the stages.
    pub(crate) fn correct(
        &mut self,
        system: &System,
        start: &State,
        h: f64,
        change: &mut Unknowns,
    ) {
        let T = self.tableau.T;
        let U = self.tableau.T_inverse;
        let of = &mut self.transformed;
        let Residuals { r1, g, r4 } = &self.residuals;
        for (from, to) in [(g, &mut of.z), (r1, &mut of.w), (r4, &mut of.mu)] {
            let stages = from[0].iter().zip(&from[1]).zip(&from[2]);
            to.clear();
            to.extend(stages.map(|((a, b), c)| {
                let [alone, re, im] = U.map(|row| row[0] * a + row[1] * b + row[2] * c);
                Triple::new(alone, Complex::new(re, im))
            }));
        }
        let factors = &self.factors;
        (self.linear).solve(system, start, eigenvalues(h), of, factors);
        for (to, from) in [
            (&mut change.z, &of.z),
            (&mut change.w, &of.w),
            (&mut change.mu, &of.mu),
        ] {
            for (k, Triple { alone, pair }) in from.iter().enumerate() {
                for (to, row) in to.iter_mut().zip(&T) {
                    to[k] = row[0] * alone + row[1] * pair.re + row[2] * pair.im;
                }
            }
        }
    }

    /// Computes the state of a stage, with accelerations and rates of states, and writes it to `stage`. `z` and `w` are the changes since
    /// `start`.
    pub(crate) fn stage_state(
        &self,
        system: &System,
        start: &State,
        at: &StageValues<'_>,
        stage: &mut State,
    ) {
        stage.clone_from(start);
        stage.time = at.time;
        system.advance(stage, at.z);
        for (part, body) in system.bodies.iter().enumerate() {
            let mut acceleration = PartRates::zero();
            for k in 0..body.freedoms {
                let (dw, a) = (at.w[body.first + k], (at.acceleration)(body.first + k));
                if k < 3 {
                    stage.velocities[part].linear[k] += dw;
                    acceleration.linear[k] = a;
                } else {
                    stage.velocities[part].angular[k - 3] += dw;
                    acceleration.angular[k - 3] = a;
                }
            }
            stage.accelerations[part] = acceleration;
        }
        for (k, equation) in system.states.iter().enumerate() {
            stage.state_rates[k] = (at.state_rate)(equation.moving_unknown);
        }
    }

    /// Computes the state of stage `i` and stores it in the `stage` field.
    pub(super) fn place_stage(
        &mut self,
        system: &System,
        start: &State,
        h: f64,
        i: usize,
        unknowns: &Unknowns,
    ) {
        let B = self.tableau.B[i];
        let rate_of =
            |all: &Stages, k: usize| (B[0] * all[0][k] + B[1] * all[1][k] + B[2] * all[2][k]) / h;
        let mut stage = std::mem::replace(&mut self.stage, State::empty());
        self.stage_state(
            system,
            start,
            &StageValues {
                time: start.time + C[i] * h,
                z: &unknowns.z[i],
                w: &unknowns.w[i],
                acceleration: &|k| rate_of(&unknowns.w, k),
                state_rate: &|k| rate_of(&unknowns.z, k),
            },
            &mut stage,
        );
        self.stage = stage;
    }

    pub(super) fn stage_residuals(
        &mut self,
        system: &System,
        parameters: &Parameters,
        start: &State,
        h: f64,
        unknowns: &Unknowns,
    ) -> Result<(), NoValue> {
        let d_inverse = plain_weight(system);
        for i in 0..3 {
            let B = self.tableau.B[i];
            let rate_of = |all: &Stages, k: usize| {
                (B[0] * all[0][k] + B[1] * all[1][k] + B[2] * all[2][k]) / h
            };
            self.place_stage(system, start, h, i, unknowns);
            let g = &mut self.residuals.g[i];
            let (scratch, products) = (&mut self.scratch, &mut self.products);
            let (stage, mu) = (&self.stage, &unknowns.mu[i]);
            system.residual_and_products(parameters, stage, mu, scratch, g, products)?;
            self.evaluations += 1;
            let r4 = &mut self.residuals.r4[i];
            r4.copy_from_slice(&products.rates);
            // V - D G' mu.
            let (v, pull) = (&products.v, &products.pull);
            let r1 = &mut self.residuals.r1[i];
            for body in &system.bodies {
                let at = |k: usize| {
                    let k = body.first + k;
                    let weight = d_inverse[(k - body.first, k - body.first)];
                    v[k] - pull[k] / weight
                };
                for k in 0..body.freedoms.min(3) {
                    r1[body.first + k] = rate_of(&unknowns.z, body.first + k) - at(k);
                }
                if body.freedoms == 6 {
                    let first = body.first + 3;
                    let z = &unknowns.z[i];
                    let turn = Vec3::new(z[first], z[first + 1], z[first + 2]);
                    let w = turning_rate(&turn) * Vec3::new(at(3), at(4), at(5));
                    for k in 0..3 {
                        r1[first + k] = rate_of(&unknowns.z, first + k) - w[k];
                    }
                }
            }
            for k in 0..system.equations {
                if !system.is_effective_holonomic(start, k) {
                    r4[k] = 0.0;
                }
            }
        }
        Ok(())
    }

    /// Returns the error of a step in positions, velocities and states: `(gamma_0 E - Jac)^-1 (f + E sum e_i Z_i / h)`. In `r1` and `g`, the
    /// negative of the weighted sum replaces the rates.
    pub(crate) fn filtered(
        &mut self,
        system: &System,
        start: &State,
        h: f64,
        r1: Vec<f64>,
        mut g: Vec<f64>,
    ) -> Correction<f64> {
        let constraints = system.first_equation..system.first_variable;
        g[constraints.clone()].fill(0.0);
        let mut r4 = vec![0.0; system.equations];
        if !system.states.is_empty() {
            // In constraint rows that depend on states, the same weighted sums replace the rates of the states.
            let first_state = system.first_state();
            for (row, column, [by_place, ..]) in self.linear.levels.entries() {
                if column >= first_state && constraints.contains(&row) {
                    r4[row - constraints.start] -= by_place * g[column];
                }
            }
        }
        let mut of = Correction::of(g, r1, r4);
        (self.linear).solve(system, start, GAMMA / h, &mut of, &self.factors);
        of
    }

    /// Returns `g` for the error estimate at the start of the step: minus the inertia terms of the accelerations `a` and of the rates of
    /// states.
    pub(crate) fn inertia_of(&self, system: &System, a: &[f64], state_rates: &[f64]) -> Vec<f64> {
        let mut g = vec![0.0; system.moving_unknowns];
        let n = system.first_equation;
        let first_state = system.first_state();
        for (row, column, [by_rate, by_second]) in self.linear.levels.rates() {
            if column < n {
                g[row] -= by_second * a[column];
            } else if column >= first_state {
                g[row] -= by_rate * state_rates[column];
            }
        }
        g
    }
}

/// Returns the matrix [`turning_rate`] of every body for the rotation vectors of a stage. It is the identity for bodies that do not rotate.
pub(super) fn turns(system: &System, z: &[f64]) -> Vec<Mat3> {
    let each = system.bodies.iter().map(|body| {
        if body.freedoms < 6 {
            return Mat3::identity();
        }
        let at = body.first + 3;
        turning_rate(&Vec3::new(z[at], z[at + 1], z[at + 2]))
    });
    each.collect()
}
