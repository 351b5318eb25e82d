//! Gauss-Newton iteration of a fit, with variance components of maximum evidence.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::early_stopping::{EarlyStopping, is_still};
use super::progress::Progress;
use super::settings::NEGLIGIBLE_GAIN_NATS;
use super::unknowns::{RowColumn, Unknowns};
use admire_identify::global::gauss_newton::{LeastSquares, homotopy_start};
use admire_identify::global::{Evaluation, FitUnknowns, NativePredictor, Observations, Predictor};
use admire_identify::tolerance::{
    LinearModel, Posterior, RowsByVarianceClass, Solution, VarianceComponents, Whitening,
};

/// Largest change of the logarithm of a stiffness: in the first step of a fit, and in later steps.
const REACH: [f64; 2] = [0.8, 1.2];
/// Number of steps at the start of a fit in which the variance components are fixed, unless they are free.
const HELD: usize = 5;
/// Predicted gain in nats below which the variance components are no longer fixed.
const NEAR: f64 = 30.0;
/// Decrease of the objective below which a step counts as small.
const LITTLE: f64 = 0.2;
/// Number of successive small steps after which a fit ends.
const SLOW: usize = 3;
/// Maximum number of trial steps from one point.
const TRIALS: usize = 8;
/// Damping after the first trial step that increases the objective.
const FIRST: f64 = 0.3;
/// Factor by which the damping grows after each further such step.
const HARDER: f64 = 6.0;
/// Divisor by which the damping falls after an accepted step.
const EASE: f64 = 6.0;
/// Damping below which an accepted step ends the damping.
const EASED: f64 = 0.3;
/// Predicted gain in nats above which a step that increases the objective is first shortened, not damped. This applies to fits with causes.
const WORTH: f64 = 10.0;
/// Smallest fraction of a step to which it is shortened.
const SHORTEST: f64 = 0.1;
/// Ratio of the actual to the predicted decrease below which derivatives with respect to random effects are computed again.
const FAITHFUL: f64 = 0.5;
/// Relative difference up to which two predicted gains count as equal.
const ALIKE: f64 = 0.1;
/// Decrease of the objective in nats during which reused derivatives with respect to random effects count as exact. The decrease is counted
/// from a point at which they predicted the same gain as exact derivatives.
const TRUSTED: f64 = 10.0;
/// Predicted gain in nats below which a fit ends if a full step increases the objective. The increase is then due to kinks of the objective, where
/// sliders begin to stick or slip. A step along a kink needs a larger predicted gain.
const KINKS: f64 = 0.5;
/// Maximum number of steps along kinks that are tried before shorter steps.
const ALONG: usize = 2;

/// Derivatives of the residual with respect to all unknowns.
struct Derivatives {
    jacobian: DMatrix<f64>,
    /// Whitened Jacobian.
    turned: DMatrix<f64>,
    /// Whitened Jacobian, split by variance class.
    by_class: RowsByVarianceClass,
}

/// Linearisation of a fit at some values of the unknowns.
pub(super) struct Point {
    /// Values of the unknowns.
    pub x: Vec<f64>,
    /// Prediction minus reading of all rows, in units of the declared noise.
    pub residual: DVector<f64>,
    /// Linear model at this point.
    pub linear: LinearModel,
    /// Derivatives at this point, or at a nearby point. In the second case, `own` replaces some of the columns.
    derivatives: Arc<Derivatives>,
    /// Indices of columns computed at this point, with these columns of the Jacobian and of the whitened Jacobian.
    own: Option<(Vec<usize>, [DMatrix<f64>; 2])>,
    /// False if the derivatives with respect to random effects are those of a nearby point.
    is_exact: bool,
}

impl Point {
    /// Returns the Gram matrix of the change of the whitened columns `places` from this point to `there`. Rows are multiplied by `weights`.
    fn bend(&self, there: &Self, places: &[usize], weights: &DVector<f64>) -> DMatrix<f64> {
        let turned = |point: &Self| match &point.own {
            Some((known, own)) if known == places => own[1].clone(),
            _ => point.derivatives.turned.select_columns(places),
        };
        let mut change = turned(there) - turned(self);
        for (mut row, weight) in change.row_iter_mut().zip(weights.iter()) {
            row *= *weight;
        }
        change.tr_mul(&change)
    }

    /// Returns the values of the unknowns, the residual, its Jacobian, and the linear model.
    pub(super) fn into_parts(self) -> (Vec<f64>, DVector<f64>, DMatrix<f64>, LinearModel) {
        let mut jacobian = match Arc::try_unwrap(self.derivatives) {
            Ok(own) => own.jacobian,
            Err(shared) => shared.jacobian.clone(),
        };
        if let Some((places, [own, _])) = self.own {
            for (k, place) in places.into_iter().enumerate() {
                jacobian.set_column(place, &own.column(k));
            }
        }
        (self.x, self.residual, jacobian, self.linear)
    }
}

/// Result of a fit.
pub(super) struct Settled {
    /// Final point.
    pub point: Point,
    /// Final variance components.
    pub sizes: VarianceComponents,
    /// Posterior of the linear model at the final point.
    pub posterior: Posterior,
}

impl Settled {
    /// Returns the log evidence at the final point, without the gain predicted for a further step.
    pub(super) fn reached(&self) -> f64 {
        self.posterior.ln_z - self.posterior.gain
    }

    fn end(point: Point, sizes: VarianceComponents) -> Option<Self> {
        Some(Self {
            posterior: point.linear.posterior(&sizes)?,
            point,
            sizes,
        })
    }
}

/// Residuals of a fit as a function of its unknowns.
pub(super) struct Sweep<'a> {
    /// Unknowns of the fit.
    pub unknowns: &'a Unknowns,
    /// Readings.
    pub observations: Observations<'a>,
    /// Predictor of the readings.
    pub predictor: NativePredictor<'a>,
    /// Whitening transformation.
    pub whitening: &'a Whitening,
    /// Number of stiffnesses, which are the first unknowns.
    pub stiffnesses: usize,
    /// Indices of the deck's unknowns other than plain random effects, in ascending order.
    pub of_the_model: Vec<usize>,
    /// Effects that act directly on rows, per unit, at the last evaluation. Each holds pairs of row index and change.
    pub on_rows: Vec<Vec<(usize, f64)>>,
    /// Progress of the diagnosis, with the request to stop it.
    pub progress: &'a Progress,
}

impl Sweep<'_> {
    /// Computes residuals and all derivatives at `x`. Returns `None` if a case has no equilibrium.
    pub(super) fn at(&mut self, x: Vec<f64>) -> Option<Point> {
        let evaluation = self.evaluate(&x, None)?;
        Some(self.linearised(x, evaluation, true))
    }

    /// Computes residuals at `x`, and derivatives with respect to the parameters of the model. All other columns are copied from the Jacobian
    /// `known` of another fit, whose deck has `theirs` unknowns; they differ little. Returns `None` if a case has no equilibrium.
    pub(super) fn beside(
        &mut self,
        x: Vec<f64>,
        (known, theirs): (&DMatrix<f64>, usize),
    ) -> Option<Point> {
        let (count, nuisances) = (self.unknowns.list.len(), self.unknowns.layout.sd.len());
        let own = self.of_the_model.clone();
        let mut evaluation = self.evaluate(&x, Some(&own))?;
        let mut jacobian = DMatrix::zeros(known.nrows(), x.len());
        for (k, place) in own.iter().enumerate() {
            jacobian.set_column(*place, &evaluation.jacobian.column(k));
        }
        let errors = (0..count).filter(|k| own.binary_search(k).is_err());
        let from = errors.map(|k| (k, k));
        let from = from.chain((0..nuisances).map(|k| (count + k, theirs + k)));
        for (own, other) in from {
            jacobian.set_column(own, &known.column(other));
        }
        self.set_rows(&mut jacobian);
        evaluation.jacobian = jacobian;
        Some(self.linearised(x, evaluation, false))
    }

    fn linearised(&self, x: Vec<f64>, evaluation: Evaluation, is_exact: bool) -> Point {
        let turned = self.whitening.apply(&evaluation.jacobian);
        let by_class = RowsByVarianceClass::new(self.whitening, &turned);
        let linear = LinearModel::new(
            self.whitening,
            &by_class,
            &self.whitening.apply_vector(&-&evaluation.residual),
            self.unknowns.priors.clone(),
            DVector::from_column_slice(&x),
        );
        let jacobian = evaluation.jacobian;
        Point {
            x,
            residual: evaluation.residual,
            linear,
            derivatives: Arc::new(Derivatives {
                jacobian,
                turned,
                by_class,
            }),
            own: None,
            is_exact,
        }
    }

    /// Computes residuals at `x`, and derivatives with respect to the parameters of the model. All other columns are those of the nearby `point`.
    /// Returns `None` if a case has no equilibrium.
    fn near(&mut self, x: Vec<f64>, point: &Point) -> Option<Point> {
        let own = self.of_the_model.clone();
        let evaluation = self.evaluate(&x, Some(&own))?;
        let jacobian = evaluation.jacobian;
        let turned = self.whitening.apply(&jacobian);
        let by_class = RowsByVarianceClass::new(self.whitening, &turned);
        let linear = point.linear.moved(
            self.whitening,
            &point.derivatives.by_class,
            &own,
            &by_class,
            &self.whitening.apply_vector(&-&evaluation.residual),
            DVector::from_column_slice(&x),
        );
        Some(Point {
            x,
            residual: evaluation.residual,
            linear,
            derivatives: Arc::clone(&point.derivatives),
            own: Some((own, [jacobian, turned])),
            is_exact: false,
        })
    }

    /// Solves all cases at `x`. If `columns` lists unknowns of the deck, in ascending order, the Jacobian has only their columns. Otherwise, it has
    /// one column per unknown. Returns `None` if a case has no equilibrium.
    fn evaluate(&mut self, x: &[f64], columns: Option<&[usize]>) -> Option<Evaluation> {
        let own = &self.unknowns.list;
        let count = own.len();
        let numbers = own.numbers(&self.unknowns.deck, &x[..count]);
        let mut directions = own.directions(&numbers.theta, &x[..count]);
        if let Some(columns) = columns {
            let mut at = 0..;
            directions.retain(|_| at.next().is_some_and(|k| columns.binary_search(&k).is_ok()));
        }
        let prediction = self.predictor.predict(&numbers, Some(&directions));
        let layout = &self.unknowns.layout;
        let inner = count + layout.sd.len();
        let rows = &self.unknowns.rows;
        let width = columns.map_or(inner + rows.len(), <[usize]>::len);
        let found = self
            .observations
            .evaluate(&prediction, layout, &x[..inner], width);
        let mut out = found?;
        let at_rows = |column: &RowColumn| match column {
            RowColumn::Fixed(column) => column.clone(),
            RowColumn::Gain(unit, readings) => {
                let predicted = |&(row, reading): &(usize, f64)| (row, reading + out.residual[row]);
                let each = readings.iter().map(predicted);
                each.map(|(row, value)| (row, unit * value)).collect()
            }
        };
        self.on_rows = rows.iter().map(at_rows).collect();
        for (k, column) in rows.iter().enumerate() {
            let RowColumn::Gain(unit, readings) = column else {
                continue;
            };
            let factor = 1.0 + unit * x[inner + k];
            for (row, _) in readings {
                out.jacobian.row_mut(*row).scale_mut(factor);
            }
        }
        for (k, column) in self.on_rows.iter().enumerate() {
            for (row, value) in column {
                out.residual[*row] += value * x[inner + k];
            }
        }
        self.confine(&mut out.jacobian, columns);
        if columns.is_none() {
            self.set_rows(&mut out.jacobian);
        }
        Some(out)
    }

    /// Sets the derivatives with respect to errors of single cases to zero in all other cases. A law with memory carries such an error on to later
    /// cases, but its covariance is computed case by case.
    fn confine(&self, jacobian: &mut DMatrix<f64>, columns: Option<&[usize]>) {
        if self.unknowns.memories.is_empty() {
            return;
        }
        for place in 0..jacobian.ncols() {
            let unknown = columns.map_or(place, |columns| columns[place]);
            let Some(case) = self.unknowns.priors[unknown].case else {
                continue;
            };
            for (value, row) in jacobian
                .column_mut(place)
                .iter_mut()
                .zip(&self.observations.rows)
            {
                if row.case() != case {
                    *value = 0.0;
                }
            }
        }
    }

    /// Fills in the Jacobian columns of effects that act directly on rows, at the last evaluation.
    fn set_rows(&self, jacobian: &mut DMatrix<f64>) {
        let first = jacobian.ncols() - self.on_rows.len();
        for (k, column) in self.on_rows.iter().enumerate() {
            for (row, value) in column {
                jacobian[(*row, first + k)] = *value;
            }
        }
    }

    /// Replaces the stiffnesses in `x` by better start values, see [`homotopy_start`]. All other unknowns keep their values.
    pub(super) fn stiffnesses_alone(&mut self, x: &mut [f64]) {
        let count = self.stiffnesses;
        if count == 0 {
            return;
        }
        let priors = &self.unknowns.priors[..count];
        let scale: Vec<f64> = priors.iter().map(|prior| prior.sd.min(1.0)).collect();
        let start = x[..count].to_vec();
        let mut alone = Alone {
            sweep: self,
            rest: x.to_vec(),
        };
        let held = vec![false; count];
        x[..count].copy_from_slice(&homotopy_start(&mut alone, &start, &scale, &held));
    }

    /// Returns the point after the fraction `part` of the step `reached`. In the full step, logarithms change by `reach` at most. Returns `None` if
    /// a case has no equilibrium there.
    fn stepped(
        &mut self,
        from: &Point,
        reached: &Solution,
        list: &FitUnknowns,
        (reach, part): (f64, f64),
    ) -> Option<Point> {
        let count = list.len();
        let (low, high) = list.limits(&vec![1.0; count], reach);
        let limits = low.into_iter().zip(high).enumerate();
        let limits = limits.filter(|(k, _)| self.unknowns.is_logarithm(*k));
        let limits: Vec<(usize, (f64, f64))> = limits.collect();
        // Without causes, a fit with box-constrained steps was seen to end with less evidence than a fit with clamped steps.
        let step = if self.unknowns.has_causes() {
            reached.box_constrained_step(&limits)
        } else {
            reached.step_clamped(&limits)
        };
        let step = step * part;
        let mut there = list.moved(&from.x, &step.rows(0, count).into_owned());
        let rest = from.x.iter().zip(step.iter()).skip(count);
        there.extend(rest.map(|(x, s)| x + s));
        self.near(there, from)
    }

    /// Fits all unknowns by Gauss-Newton steps, and the variance components by maximum evidence. If `free`, the variance components are optimised in
    /// every step. This is suitable after a fit of the stiffnesses alone, or without a new cause. Derivatives with respect to random effects are
    /// reused from step to step; they are exact at the end, and after a failed step. The fit ends early under the condition of `stopping`. Returns
    /// `None` if a linear model has no finite solution, or if a case loses its equilibrium.
    pub(super) fn settle(
        &mut self,
        start: Point,
        first: &VarianceComponents,
        (steps, stopping): (usize, EarlyStopping),
        free: bool,
    ) -> Option<Settled> {
        let mut sizes = first.clone();
        let mut here = start;
        // Stiffnesses are stepped in coordinates in which the deflections are nearly linear.
        let mut list = self.unknowns.list.clone();
        list.set_load_shares(&self.predictor.shares(&list.springs()).unwrap_or_default());
        let (mut slow, mut damping) = (0, 0.0);
        // Log evidence after each step, without the gain predicted for the next step.
        let mut course: Vec<f64> = Vec::new();
        // Objective where exact derivatives with respect to random effects last predicted the same gain as reused derivatives.
        let mut confirmed: Option<f64> = None;
        for step_number in 0.. {
            if self.progress.is_stopped() {
                return Settled::end(here, sizes);
            }
            // Far from the optimum, the variance components would absorb misfit that later steps remove.
            let mut reached = here.linear.solve(&sizes, 0.0)?;
            if free || step_number >= HELD || reached.gain < NEAR {
                sizes = here.linear.maximise_evidence(&sizes);
                reached = here.linear.solve(&sizes, 0.0)?;
            } else if step_number > 0 && stopping.is_lost(&reached) {
                let own = here.linear.maximise_evidence(&sizes);
                let granted = here.linear.solve(&own, 0.0)?;
                if stopping.is_lost(&granted) {
                    return Settled::end(here, own);
                }
            }
            let objective = here.linear.objective(&sizes);
            // The gain predicted by the linear model counts in favour of the fit.
            let is_beaten = stopping.is_beaten(reached.ln_z, reached.gain);
            let own = reached.ln_z - reached.gain;
            course.push(own);
            let hopeless = (is_beaten && (step_number >= HELD || reached.gain < KINKS))
                || stopping.is_out_of_reach(&course, (HELD, steps));
            let is_over = step_number >= steps || slow == SLOW || is_still(&course);
            if reached.gain < NEGLIGIBLE_GAIN_NATS || is_over || hopeless {
                if here.is_exact || hopeless {
                    return Settled::end(here, sizes);
                }
                here = self.at(here.x)?;
                let exact = here.linear.solve(&sizes, 0.0)?;
                if is_alike(exact.gain, reached.gain) {
                    return Settled::end(here, sizes);
                }
                slow = 0;
                continue;
            }
            let is_sure =
                here.is_exact || confirmed.is_some_and(|at| at - objective < 2.0 * TRUSTED);
            let reach = REACH[step_number.min(1)];
            let mut next = None;
            // If a full step increases the objective, it is first shortened. The directions that damping restrains most are not the most nonlinear.
            let (mut part, mut is_part) = (1.0, false);
            // A slider that begins to slip causes a kink in the objective. Beyond the kink, the linear model is wrong by the change of the Jacobian
            // times the step. With the square of this error added to the objective, a step goes along the kink instead of across it.
            let along = if self.unknowns.memories.is_empty() {
                0
            } else {
                ALONG
            };
            let (mut bend, mut bends): (Option<DMatrix<f64>>, usize) = (None, 0);
            let mut held: Option<Solution> = None;
            self.predictor.checkpoint();
            for trial in 0..TRIALS + along {
                let other;
                let damped = if damping == 0.0 {
                    &reached
                } else {
                    other = here.linear.solve(&sizes, damping)?;
                    &other
                };
                let held_here = held.take();
                let step = held_here.as_ref().unwrap_or(damped);
                let mut further = self.stepped(&here, step, &list, (reach, part));
                let value = |point: &Point| point.linear.objective(&sizes);
                let led = further.as_ref().map(value);
                let mut beyond = None;
                if damping == 0.0
                    && !is_part
                    && held_here.is_none()
                    && let Some(uphill) = further
                        .as_ref()
                        .filter(|f| value(f) > objective + NEGLIGIBLE_GAIN_NATS)
                {
                    // In a curved valley of the objective, a full step ends on the wall, and the next step returns to the floor. Source:
                    // Chamberlain, Powell, Lemarechal and Pedersen, Mathematical Programming Study 16 (1982) 1.
                    let back = uphill.linear.solve(&sizes, 0.0);
                    let back = back.filter(|b| value(uphill) - 2.0 * b.gain < objective);
                    if let Some(back) = back {
                        let returned = self.stepped(uphill, &back, &list, (reach, 1.0));
                        beyond = std::mem::replace(&mut further, returned);
                    }
                }
                let is_down = |point: &Point| value(point) <= objective + NEGLIGIBLE_GAIN_NATS;
                if let Some(further) = further.take_if(|further| is_down(further)) {
                    // If the predicted decrease was much larger, the derivatives have changed.
                    let value = value(&further);
                    let is_less = objective - value < FAITHFUL * 2.0 * reached.gain;
                    let further = if is_less && !is_sure {
                        let near = further.linear.solve(&sizes, 0.0)?.gain;
                        let exact = self.at(further.x)?;
                        let gain = exact.linear.solve(&sizes, 0.0)?.gain;
                        confirmed = is_alike(gain, near).then_some(value);
                        exact
                    } else {
                        further
                    };
                    let small = objective - value < LITTLE;
                    slow = if small { slow + 1 } else { 0 };
                    next = Some(further);
                    // If a step needed more damping than the previous one, the next step keeps this damping.
                    if trial == 0 || held_here.is_some() {
                        damping = if damping < EASED { 0.0 } else { damping / EASE };
                    }
                    break;
                }
                // Without a rollback, the next trial would start from the equilibria of the rejected one.
                self.predictor.rollback();
                if bends < along
                    && reached.gain > KINKS
                    && let Some(beyond) = beyond.or(further)
                {
                    let weights = self.whitening.weights(&sizes.ln);
                    let crossed = here.bend(&beyond, &self.of_the_model, &weights);
                    let all = bend.map_or(crossed.clone(), |known| known + &crossed);
                    let step = damped.with_quadratic_penalty(&self.of_the_model, &all);
                    held = step.filter(|step| step.gain > KINKS);
                    (bend, bends) = (Some(all), bends + 1);
                }
                if held.is_some() {
                    continue;
                }
                if !is_sure {
                    break;
                }
                // With so small a predicted gain, kinks prevent any decrease.
                if reached.gain < KINKS {
                    break;
                }
                if damping == 0.0
                    && !is_part
                    && self.unknowns.has_causes()
                    && reached.gain > WORTH
                    && let Some(led) = led
                {
                    // Minimum of the parabola with the slope at this point and the objective after the full step.
                    let slope = 4.0 * reached.gain;
                    let rise = led - objective + slope;
                    (part, is_part) = ((0.5 * slope / rise).max(SHORTEST), true);
                    continue;
                }
                part = 1.0;
                damping = (damping * HARDER).max(FIRST);
            }
            if let Some(next) = next {
                here = next;
                continue;
            }
            if !here.is_exact {
                here = self.at(here.x)?;
            }
            if is_sure {
                return Settled::end(here, sizes);
            }
            let exact = here.linear.solve(&sizes, 0.0)?;
            confirmed = is_alike(exact.gain, reached.gain).then_some(objective);
            damping = 0.0;
        }
        None
    }
}

/// Returns true if two predicted gains in nats are nearly equal.
fn is_alike(a: f64, b: f64) -> bool {
    (a - b).abs() < ALIKE * b + NEGLIGIBLE_GAIN_NATS
}

/// Least-squares problem of the stiffnesses alone. All other unknowns keep the values in `rest`.
struct Alone<'a, 'b> {
    sweep: &'a mut Sweep<'b>,
    rest: Vec<f64>,
}

impl LeastSquares for Alone<'_, '_> {
    fn evaluate(&mut self, x: &[f64], with_jacobian: bool) -> Option<Evaluation> {
        if self.sweep.progress.is_stopped() {
            return None;
        }
        let mut all = self.rest.clone();
        all[..x.len()].copy_from_slice(x);
        let active = if with_jacobian { x.len() } else { 0 };
        let columns: Vec<usize> = (0..active).collect();
        let out = self.sweep.evaluate(&all, Some(&columns))?;
        Some(Evaluation {
            residual: self.sweep.whitening.apply_vector(&out.residual),
            jacobian: self.sweep.whitening.apply(&out.jacobian),
            free: Vec::new(),
        })
    }

    fn checkpoint(&mut self) {
        self.sweep.predictor.checkpoint();
    }

    fn rollback(&mut self) {
        self.sweep.predictor.rollback();
    }

    fn retract(&self, x: &[f64], step: &DVector<f64>) -> Vec<f64> {
        self.sweep.unknowns.list.moved(x, step)
    }

    fn limits(&self, scale: &[f64], reach: f64) -> (Vec<f64>, Vec<f64>) {
        self.sweep.unknowns.list.limits(scale, reach)
    }

    fn bounds(&self, x: &[f64]) -> Option<(Vec<f64>, Vec<f64>)> {
        self.sweep.unknowns.list.bounds(x)
    }
}
