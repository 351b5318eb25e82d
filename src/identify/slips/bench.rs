//! Test bench for slips: a study is compiled once, and changes of its input are tried by short fits.

use std::cell::Cell;
use std::collections::BTreeMap;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::candidate::{Change, Family};
use crate::global::gauss_newton::{Ending, LeastSquares, Tolerances, minimise};
use crate::global::{
    Component, FitUnknown, FitUnknowns, GlobalProblem, Observations, Prepared, UnknownTarget,
    fit_unknowns, global_problem,
};
use crate::settings::{FLAT_PRIOR_SD, SLIP_DECREMENT_NATS, SLIP_MIN_SIGMA};
use crate::tolerance::{Effect, LayerOf, RandomEffects, VarianceComponents};
use crate::unknowns::bushing_number;
use crate::{LoadedStudy, Problem};
use admire_syntax::Address;

/// A study and its compiled deck, on which changes of the input are tried.
pub(super) struct Bench {
    study: LoadedStudy,
    prepared: Prepared,
    /// Number of equilibria solved so far.
    solved: Cell<usize>,
}

/// Final state of a short fit.
#[derive(Clone, Debug)]
pub(super) struct Trial {
    /// Values of all unknowns.
    pub x: Vec<f64>,
    /// Objective: half the sum of the squared residuals and the prior terms.
    pub objective: f64,
    /// True if the fit converged to a minimum.
    pub is_minimum: bool,
}

/// Residuals of a study at given unknowns, and their derivatives.
struct Rows {
    residual: DVector<f64>,
    /// Derivatives with respect to each unknown, multiplied by its prior standard deviation.
    columns: DMatrix<f64>,
    /// Derivatives with respect to the additional unknowns whose prior has zero width, one column per unknown.
    further: DMatrix<f64>,
}

impl Rows {
    /// Computes `C^-1 rows`. Here `C = I + columns columns'` is the covariance of the residuals with all unknowns marginalised.
    fn beyond(&self, rows: &DVector<f64>) -> Option<DVector<f64>> {
        let count = self.columns.ncols();
        let information =
            self.columns.transpose() * &self.columns + DMatrix::identity(count, count);
        let along = Cholesky::new(information)?.solve(&self.columns.tr_mul(rows));
        Some(rows - &self.columns * along)
    }
}

/// Returns an additional unknown with starting value and prior mean zero.
const fn unknown(meaning: UnknownTarget, sd: f64) -> FitUnknown {
    FitUnknown {
        addresses: Vec::new(),
        target: meaning,
        start: 0.0,
        mean: 0.0,
        sd,
        bounds: None,
    }
}

impl Bench {
    /// Compiles a study; returns `None` if the built-in solver cannot solve it.
    pub(super) fn new(study: LoadedStudy) -> Option<Self> {
        let prepared = Prepared::new(&study.problem()).ok()?;
        Some(Self {
            study,
            prepared,
            solved: Cell::new(0),
        })
    }

    /// Runs `work` on the least-squares problem of the changed study. The unknowns that `further` returns are appended to the unknowns of the
    /// deck.
    fn with<T>(
        &self,
        change: Option<&Change>,
        further: impl FnOnce(&Problem<'_>) -> Vec<FitUnknown>,
        work: impl FnOnce(&mut GlobalProblem<'_>) -> Option<T>,
    ) -> Option<T> {
        let study = &self.study;
        let programme = change.map(|change| change.programme(&study.programme));
        let measurement = change.map(|change| change.measurement(&study.measurement));
        let problem = Problem {
            programme: programme.as_ref().unwrap_or(&study.programme),
            measurement: measurement.as_ref().unwrap_or(&study.measurement),
            ..study.problem()
        };
        let system = &self.prepared.system;
        let cases: Vec<usize> = problem.measurement.fitted_cases().collect();
        let observations = Observations::fitted(problem.measurement, problem.model, &cases);
        let mut list = fit_unknowns(&problem, system, None).list().to_vec();
        list.extend(further(&problem));
        let predictor = self
            .prepared
            .native(&problem, observations.observed.clone())
            .ok()?;
        let mut global = global_problem(
            &problem,
            observations,
            FitUnknowns::new(list),
            Box::new(predictor),
        );
        for (address, value) in change.map_or(&[][..], Change::numbers) {
            let slot = system.catalogue().slot(address)?;
            global.deck.set(slot, *value);
        }
        let done = work(&mut global);
        let solved = self.solved.get() + global.predictor.solver_runs();
        self.solved.set(solved);
        done
    }

    /// Returns the number of equilibria solved so far.
    pub(super) fn solved(&self) -> usize {
        self.solved.get()
    }

    /// Fits the changed study in at most `steps` trial steps, from `start` or from the study's initial values. Returns `None` if a case has no
    /// equilibrium at the start.
    pub(super) fn fit(
        &self,
        change: Option<&Change>,
        start: Option<&[f64]>,
        steps: usize,
    ) -> Option<Trial> {
        self.with(
            change,
            |_| Vec::new(),
            |global| {
                let start = start.map_or_else(|| global.start(), <[f64]>::to_vec);
                if start.is_empty() {
                    let squares = global.evaluate(&start, false)?.residual.norm_squared();
                    return Some(Trial {
                        objective: 0.5 * squares,
                        is_minimum: true,
                        x: start,
                    });
                }
                let (priors, scale, held) = (global.priors(), global.scale(), global.held());
                let tolerances = Tolerances {
                    max_iterations: steps,
                    decrement: SLIP_DECREMENT_NATS,
                    ..Tolerances::default()
                };
                let found = minimise(global, &start, &priors, &scale, &held, tolerances)?;
                Some(Trial {
                    objective: found.objective,
                    is_minimum: found.ending == Ending::Converged,
                    x: found.x,
                })
            },
        )
    }

    /// Returns the unchanged study.
    pub(super) const fn study(&self) -> &LoadedStudy {
        &self.study
    }

    /// Returns the rms of the residuals that remain when unknowns and tolerances absorb as much as possible, in units of the noise. The model
    /// is linearised at `x`, and each tolerance has its largest allowed size.
    pub(super) fn beyond_tolerances(&self, change: Option<&Change>, x: &[f64]) -> Option<f64> {
        let sizes = self.sizes();
        let further = |problem: &Problem<'_>| self.members(problem, &sizes);
        let at = self.explained(change, further, x)?;
        let left = at.residual.dot(&at.beyond(&at.residual)?).max(0.0);
        Some((left / at.residual.len().max(1) as f64).sqrt())
    }

    /// Returns the predicted gain of each family: the fraction of the squared residuals at `x` that a factor near one explains beyond the
    /// unknowns. For families without a factor, the gain is infinite.
    pub(super) fn gains(&self, families: &[Family], x: &[f64]) -> Option<Vec<f64>> {
        let by_factor = |problem: &Problem<'_>| -> Vec<FitUnknown> {
            let effects = families
                .iter()
                .filter_map(|family| family.by_factor.as_ref());
            let meaning = |effect| {
                // An effect on parameters that the solver cannot change has no consequence.
                let none = UnknownTarget::Number(Vec::new());
                self.meaning(problem, effect).unwrap_or(none)
            };
            effects
                .map(|effect| unknown(meaning(effect), 0.0))
                .collect()
        };
        let at = self.explained(None, by_factor, x)?;
        let left = at.beyond(&at.residual)?;
        let all = at.residual.dot(&left).max(f64::MIN_POSITIVE);
        let mut columns = at.further.column_iter();
        let gain = |family: &Family| {
            if family.by_factor.is_none() {
                return Some(f64::INFINITY);
            }
            let column = columns.next()?.into_owned();
            let own = column.dot(&at.beyond(&column)?);
            let gain = column.dot(&left).powi(2) / own / all;
            Some(if gain.is_finite() { gain } else { 0.0 })
        };
        families.iter().map(gain).collect()
    }

    /// Evaluates residuals and derivatives of the changed study at `x`, which holds the unknowns of the deck and then the unknowns of the
    /// measurement. The additional unknowns that `further` returns are zero. Those with zero prior width go to [`Rows::further`].
    fn explained(
        &self,
        change: Option<&Change>,
        further: impl FnOnce(&Problem<'_>) -> Vec<FitUnknown>,
        x: &[f64],
    ) -> Option<Rows> {
        let own = self.with(change, |_| Vec::new(), |global| Some(global.unknowns.len()))?;
        self.with(change, further, |global| {
            let count = global.unknowns.len() - own;
            let mut all = x[..own].to_vec();
            all.extend(std::iter::repeat_n(0.0, count));
            all.extend_from_slice(&x[own..]);
            let found = global.evaluate(&all, true)?;
            let priors = global.priors();
            let apart: Vec<usize> = (own..own + count)
                .filter(|k| priors[*k].sd == 0.0)
                .collect();
            let mut columns = found.jacobian;
            let further = columns.select_columns(&apart);
            for (mut column, prior) in columns.column_iter_mut().zip(&priors) {
                column *= if prior.sd.is_finite() {
                    prior.sd
                } else {
                    FLAT_PRIOR_SD
                };
            }
            Some(Rows {
                residual: found.residual,
                columns,
                further,
            })
        })
    }

    /// Returns the rms variation of the readings over the cases, in units of their noise. This is the residual of a model that does not move.
    pub(super) fn movement(&self) -> f64 {
        let to = &self.study.measurement;
        let mut series: BTreeMap<[usize; 3], Vec<f64>> = BTreeMap::new();
        let mut add = |key: [usize; 3], value: f64, sigma: f64| {
            let values = series.entry(key).or_default();
            values.push(value / sigma.max(SLIP_MIN_SIGMA));
        };
        for case in to.fitted_cases().map(|case| &to.cases[case]) {
            for mark in &case.marks {
                for axis in 0..3 {
                    add([mark.part, mark.mark, axis], mark.x[axis], to.sigma);
                }
            }
            let first = to.parts.len();
            if let (Some(wheel), Some(read)) = (&to.wheel, &case.wheel) {
                for axis in 0..3 {
                    add([first, 0, axis], read.position[axis], wheel.sigma_position);
                }
                add([first, 1, 0], read.camber_deg, wheel.sigma_angle_deg);
                add([first, 1, 1], read.steer_deg, wheel.sigma_angle_deg);
            }
            for (k, channel) in to.channels.iter().enumerate() {
                if let Some(value) = case.channels[k] {
                    add([first + 1, k, 0], value, channel.sigma);
                }
            }
        }
        let count: usize = series.values().map(Vec::len).sum();
        let squares = |values: &Vec<f64>| {
            let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
            values
                .iter()
                .map(|value| (value - mean).powi(2))
                .sum::<f64>()
        };
        (series.values().map(squares).sum::<f64>() / count.max(1) as f64).sqrt()
    }

    fn sizes(&self) -> VarianceComponents {
        let study = &self.study;
        let millimetre = 1e-3 / study.model.units.length.si;
        let frames = study.study.identify.frame_sd;
        let frames = [0, 3].map(|axis| frames.of_axis(axis, &study.model.units));
        VarianceComponents::new(
            &study.study.tolerances,
            study.measurement.sigma_on_parts,
            frames,
            millimetre,
        )
    }

    /// Returns the small errors of axle and rig as unknowns. The prior standard deviation of each is the largest size that its group may have.
    fn members(&self, problem: &Problem<'_>, sizes: &VarianceComponents) -> Vec<FitUnknown> {
        let is_sought = |address: &Address| {
            let mut unknowns = problem.unknowns.iter();
            unknowns.any(|unknown| unknown.sets(address))
        };
        let layer = RandomEffects::of(&LayerOf {
            model: problem.model,
            programme: problem.programme,
            load_errors: false,
            is_sought: &is_sought,
            is_sought_change: &|change| problem.seeks_change(change),
        });
        let members = layer.members.iter();
        members
            .filter_map(|member| {
                let (_, size) = sizes
                    .groups
                    .iter()
                    .find(|(group, _)| *group == member.group)?;
                let meaning = self.meaning(problem, &member.effect)?;
                Some(unknown(meaning, libm::exp(size.bounds.1)))
            })
            .collect()
    }

    fn meaning(&self, problem: &Problem<'_>, effect: &Effect) -> Option<UnknownTarget> {
        let slot = |address: &Address| self.prepared.system.catalogue().slot(address);
        Some(match effect {
            Effect::Always(pairs) => {
                let of = |(address, factor): &(Address, f64)| Some((slot(address)?, *factor));
                UnknownTarget::Number(pairs.iter().map(of).collect::<Option<_>>()?)
            }
            Effect::PerCase(pairs) => {
                let of = |(address, factors): &(Address, Vec<f64>)| {
                    Some((slot(address)?, factors.clone()))
                };
                UnknownTarget::PerCase(pairs.iter().map(of).collect::<Option<_>>()?)
            }
            Effect::Turn(markers) => UnknownTarget::Turn(markers.clone()),
            Effect::Offset { bushing, axis } => {
                let id = problem.model.bushings[*bushing].header.id;
                let of = |words| slot(&bushing_number(id, words, *axis));
                UnknownTarget::Offset(Component {
                    stiffness: of(["K", "KT"])?,
                    preload: Some(of(["FORCE", "TORQUE"])?),
                })
            }
        })
    }
}
