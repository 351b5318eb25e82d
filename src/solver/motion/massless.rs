//! Motions of parts without inertia.
//!
//! Y is a basis of the motions that have no inertia and violate no constraint. The force balances along these motions contain no accelerations:
//! `Y' g(q, V, t) = 0`. Where damping acts, the balances determine the velocities. Elsewhere they determine the positions through the
//! stiffness, and their time derivative determines the velocities: `Y' (K V + g_t) = 0`.

use nalgebra::{DMatrix, DVector};

use super::bordered::plain_weight;
use super::consistent::Consistent;
use super::error::MotionFailure;
use crate::linear::{Levels, Lu};
use crate::mechanics::eigen::singular_values;
use crate::system::{Parameters, State, System};

/// A direction whose scaled damping and stiffness are below this counts as unrestrained.
const NOTHING: f64 = 1e-9;
/// A direction counts as damped if damping makes up more than this share of its restraint over one step.
const DAMPED: f64 = 0.5;
/// Largest number of iterations in [`Consistent::settle_massless`]; a few are usual.
const ITERATIONS: usize = 20;
/// Convergence limit for the change of positions, and for the change of velocities times the time step, in model lengths or radians.
const SETTLED: f64 = 1e-12;

/// Motions without inertia, and the stiffness and damping that restrain them over a time `step`.
struct Massless {
    /// Y: each column is one motion of all parts, scaled so that its largest displacement is one model length or its largest rotation one
    /// radian.
    motions: DMatrix<f64>,
    /// Stiffness along the motions: Y' K Y.
    stiffness: DMatrix<f64>,
    /// Damping along the motions: Y' C Y.
    damping: DMatrix<f64>,
    /// Scale factor of each motion that makes the restraints of all motions comparable; zero for a motion without any restraint.
    scale: DVector<f64>,
    step: f64,
}

impl Massless {
    /// Collects the motions without inertia from the factors of the mass matrix with the constraints. Returns `None` if every motion has
    /// inertia.
    fn of(system: &System, factors: &Lu, levels: &Levels, step: f64) -> Option<Self> {
        let n = system.first_equation;
        let mut columns = Vec::new();
        for m in 0..factors.deficiency() {
            let z = factors.null_vector(m);
            let motion = DVector::from_column_slice(&z[..n]);
            let most = size(system, motion.as_slice());
            if most > 0.0 {
                columns.push(motion / most);
            }
        }
        if columns.is_empty() {
            return None;
        }
        let motions = DMatrix::from_columns(&columns);
        let [by_place, by_rate] = products(&motions, levels);
        let (stiffness, damping) = (motions.tr_mul(&by_place), motions.tr_mul(&by_rate));
        let scale = DVector::from_fn(motions.ncols(), |k, _| {
            let of = |matrix: &DMatrix<f64>| matrix.row(k).amax().max(matrix.column(k).amax());
            let held = step * of(&stiffness) + of(&damping);
            if held > 0.0 { held.sqrt().recip() } else { 0.0 }
        });
        Some(Self {
            motions,
            stiffness,
            damping,
            scale,
            step,
        })
    }

    fn scaled(&self, matrix: &DMatrix<f64>) -> DMatrix<f64> {
        DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| {
            self.scale[i] * matrix[(i, j)] * self.scale[j]
        })
    }

    /// Returns a motion that is unrestrained or whose restraint is not finite. Returns `None` if every motion is restrained.
    fn unrestrained_mode(&self) -> Option<DVector<f64>> {
        let held = self.scaled(&(&self.stiffness * self.step + &self.damping));
        let Some(svd) = singular_values(held, false, true) else {
            return self
                .motions
                .column_iter()
                .next()
                .map(nalgebra::Matrix::into_owned);
        };
        let (at, least) = svd.singular_values.argmin();
        if least > NOTHING {
            return None;
        }
        let mut along = svd.v_t?.row(at).transpose();
        for (k, part) in along.iter_mut().enumerate() {
            // The components of motions without any restraint are not scaled.
            if self.scale[k] > 0.0 {
                *part *= self.scale[k];
            }
        }
        Some(&self.motions * along)
    }

    /// Computes the changes of positions and velocities along Y. `balance` contains the force balances along Y, and `rate` their time
    /// derivatives. Returns `None` if a matrix is singular.
    fn changes(
        &self,
        balance: &DVector<f64>,
        rate: &DVector<f64>,
    ) -> Option<(DVector<f64>, DVector<f64>)> {
        let damping = self.scaled(&self.damping);
        let svd = singular_values(damping.clone(), true, true)?;
        let (U, V) = (svd.u?, svd.v_t?.transpose());
        let order: Vec<usize> = (0..U.ncols()).collect();
        let (damped, held): (Vec<_>, Vec<_>) = order
            .into_iter()
            .partition(|k| svd.singular_values[*k] > DAMPED);
        let stiffness = self.scaled(&self.stiffness);
        let balance = balance.component_mul(&self.scale);
        let rate = rate.component_mul(&self.scale);
        let (U0, V0) = (U.select_columns(&held), V.select_columns(&held));
        let (U1, V1) = (U.select_columns(&damped), V.select_columns(&damped));
        let mut place = DVector::zeros(self.scale.len());
        let mut velocity = DVector::zeros(self.scale.len());
        if !damped.is_empty() {
            let matrix = U1.tr_mul(&damping) * &V1;
            velocity -= &V1 * matrix.lu().solve(&U1.tr_mul(&balance))?;
        }
        if !held.is_empty() {
            let factors = (U0.tr_mul(&stiffness) * &V0).lu();
            place -= &V0 * factors.solve(&U0.tr_mul(&balance))?;
            let rate = rate + &stiffness * &velocity;
            velocity -= &V0 * factors.solve(&U0.tr_mul(&rate))?;
        }
        let along = |x: DVector<f64>| &self.motions * x.component_mul(&self.scale);
        Some((along(place), along(velocity)))
    }
}

/// Returns the largest displacement in a motion, in model lengths, or the largest rotation, in radians, whichever is larger.
fn size(system: &System, motion: &[f64]) -> f64 {
    let mut most = 0.0_f64;
    for body in &system.bodies {
        for k in 0..body.freedoms {
            let unit = if k < 3 { system.length } else { 1.0 };
            most = most.max(motion[body.first + k].abs() / unit);
        }
    }
    most
}

/// Returns K Y and C Y, where `levels` contains the derivatives K and C.
fn products(motions: &DMatrix<f64>, levels: &Levels) -> [DMatrix<f64>; 2] {
    let n = motions.nrows();
    let mut out = [0, 1].map(|_| DMatrix::zeros(n, motions.ncols()));
    let inside = levels
        .entries()
        .filter(|(row, column, _)| *row < n && *column < n);
    for (row, column, [k, c, _]) in inside {
        for j in 0..motions.ncols() {
            let y = motions[(column, j)];
            if y != 0.0 {
                out[0][(row, j)] += k * y;
                out[1][(row, j)] += c * y;
            }
        }
    }
    out
}

impl Consistent {
    /// Checks, after the mass matrix was factored, that stiffness or damping restrains every motion without inertia.
    ///
    /// # Errors
    /// Returns [`MotionFailure::MassSingular`] if such a motion is not restrained.
    pub(super) fn check_held(&mut self, system: &System, step: f64) -> Result<(), MotionFailure> {
        let deficiency = self.factors.deficiency();
        if deficiency == 0 || self.held == Some(deficiency) {
            return Ok(());
        }
        let massless = Massless::of(system, &self.factors, &self.levels, step);
        if let Some(motion) = massless.and_then(|massless| massless.unrestrained_mode()) {
            let freedom = system.freedom_name(motion.icamax());
            return Err(MotionFailure::MassSingular { freedom });
        }
        self.held = Some(deficiency);
        Ok(())
    }

    /// Brings motions without inertia into equilibrium. Where damping acts, their velocities change; elsewhere their positions change. All
    /// other motions keep their positions and velocities. The state remains unchanged if the iteration does not converge.
    ///
    /// `step` is the time over which damping is compared with stiffness.
    ///
    /// # Errors
    /// Returns [`MotionFailure`] if an element has no value.
    pub(super) fn settle_massless(
        &mut self,
        system: &System,
        parameters: &Parameters,
        state: &mut State,
        step: f64,
    ) -> Result<(), MotionFailure> {
        if !system.has_massless(parameters, state) {
            return Ok(());
        }
        self.accelerations(system, parameters, state, step)?;
        let mut found = state.clone();
        for _ in 0..ITERATIONS {
            // The levels and factors belong to `found`, because its accelerations were computed last.
            let Some(massless) = Massless::of(system, &self.factors, &self.levels, step) else {
                return Ok(());
            };
            let (scratch, g) = (&mut self.scratch, &mut self.g);
            system.residual(parameters, &found, scratch, g)?;
            let n = system.first_equation;
            let balance = massless
                .motions
                .tr_mul(&DVector::from_column_slice(&self.g[..n]));
            system.velocity_vector(&found, &mut self.v);
            let v = DMatrix::from_column_slice(n, 1, &self.v[..n]);
            let [moved, _] = products(&v, &self.levels);
            let by_time = DVector::from_column_slice(&self.levels.time[..n]) + moved.column(0);
            let rate = massless.motions.tr_mul(&by_time);
            let Some((place, velocity)) = massless.changes(&balance, &rate) else {
                return Ok(());
            };
            let moved = size(system, place.as_slice());
            let faster = size(system, velocity.as_slice());
            if !(moved.is_finite() && faster.is_finite()) {
                return Ok(());
            }
            self.step.fill(0.0);
            self.step[..n].copy_from_slice(place.as_slice());
            system.advance(&mut found, &self.step);
            for (v, change) in self.v.iter_mut().zip(&velocity) {
                *v += change;
            }
            system.scattered(&self.v, &mut found.velocities);
            let plain = plain_weight(system);
            self.positions(system, parameters, &mut found, None)?;
            self.velocities(system, parameters, &mut found, &|_| plain)?;
            self.accelerations(system, parameters, &mut found, step)?;
            if moved <= SETTLED && faster * step <= SETTLED {
                *state = found;
                return Ok(());
            }
        }
        Ok(())
    }
}
