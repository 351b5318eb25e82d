//! What each hypothesis would gain, by projection: all from one matrix product, without any refit.

use std::cmp::Ordering;
use std::ops::Range;

use nalgebra::{Cholesky, DMatrix, DVector};

use super::candidate_effect::{CandidateEffect, EffectParameter, Sensitivity};
use super::causes;
use super::diagnosis_problem::DiagnosisProblem;
use super::fit::FittedModel;
use super::operating_points::OperatingPoints;
use super::visited::distinct;
use admire_identify::tolerance::{
    Coefficient, CrossProducts, Posterior, RowsByVarianceClass, VarianceComponents, transposed,
};

/// From each scan so many places may be weighed with sizes of their own.
const WEIGHED: usize = 7;
/// Forms of one cause at one place that are looked at; laws of different shape are all fitted.
pub(super) const FORMS: usize = 3;

/// Every hypothesis at a fit, with what each does to the turned rows.
pub(super) struct Catalogue {
    /// Hypotheses that are not in the fit.
    pub hypotheses: Vec<CandidateEffect>,
    /// Columns of each among `further`: of its numbers that have an effect to first order; none of a slab.
    ranges: Vec<Range<usize>>,
    /// Effects on reading minus prediction per unit of the prior.
    further: CrossProducts,
}

/// What a hypothesis promises.
#[derive(Clone, Debug)]
pub(super) struct Promise {
    /// Which, in the catalogue.
    pub at: usize,
    /// Logarithm of evidence and prior with it, of all that is in the model.
    pub ln_posterior: f64,
}

/// What some cause promises, and the sizes at which that is most.
pub(super) type AtSizes = (Promise, VarianceComponents);

pub(super) fn by_promise(a: &AtSizes, b: &AtSizes) -> Ordering {
    b.0.ln_posterior.total_cmp(&a.0.ln_posterior)
}

impl Catalogue {
    /// At a fit.
    pub(super) fn new(subject: &DiagnosisProblem<'_>, fitted: &FittedModel) -> Self {
        let survey = OperatingPoints::new(subject, fitted);
        let hypotheses = causes::candidates(&survey, fitted);
        let seen: Vec<&EffectParameter> = hypotheses.iter().flat_map(seen).collect();
        let mut responses = survey.responses(&seen);
        let turned = |range: Range<usize>| fitted.whitening.apply(&responses.columns(range.len()));
        let residual = fitted.whitened_residual();
        let by_class = RowsByVarianceClass::new(&fitted.whitening, &fitted.whitened_jacobian());
        let mut next = 0;
        let range = |h: &CandidateEffect| {
            let from = next;
            next += self::seen(h).count();
            from..next
        };
        let ranges: Vec<Range<usize>> = hypotheses.iter().map(range).collect();
        let further = CrossProducts::new(&fitted.whitening, &by_class, &residual, &ranges, turned);
        Self {
            hypotheses,
            ranges,
            further,
        }
    }

    /// The causes at the places that promise most at one of these sizes.
    pub(super) fn promised(
        &self,
        base: &FittedModel,
        sizes: [&VarianceComponents; 2],
    ) -> Vec<AtSizes> {
        let mut union: Vec<AtSizes> = Vec::new();
        for sizes in sizes {
            let mut places: Vec<&CandidateEffect> = Vec::new();
            let mut is_full = false;
            for promise in self.scan(base, sizes) {
                let at = promise.at;
                if let Some((known, at)) = union.iter_mut().find(|(known, _)| known.at == at)
                    && known.ln_posterior < promise.ln_posterior
                {
                    (*known, *at) = (promise.clone(), sizes.clone());
                }
                let h = &self.hypotheses[at];
                let forms = places.iter().filter(|other| other.same_term(h)).count();
                // Forms of one place differ little, but for laws that are known in kind only.
                let most = if h.is_poorly_linearised() { FORMS } else { 1 };
                let is_elsewhere = !places.iter().any(|other| other.same_site(h));
                is_full |= is_elsewhere && distinct(&places) == WEIGHED;
                if is_full || forms >= most.max(if h.is_slab() { FORMS } else { 1 }) {
                    continue;
                }
                places.push(h);
                if !union.iter().any(|(known, _)| known.at == at) {
                    union.push((promise, sizes.clone()));
                }
            }
        }
        union
    }

    /// What all of them promise at these sizes, best first.
    pub(super) fn scan(&self, fitted: &FittedModel, sizes: &VarianceComponents) -> Vec<Promise> {
        let Some(posterior) = fitted.linear.posterior(sizes) else {
            return Vec::new();
        };
        let (effects, g) = self.effects(sizes, &posterior);
        let of = |(at, h): (usize, &CandidateEffect)| {
            let gain = if h.is_slab() {
                slab(fitted, &posterior, sizes, h)?
            } else {
                let range = self.ranges[at].clone();
                let (from, count) = (range.start, range.len());
                let g = g.rows(from, count).into_owned();
                projected(&effects.information(at, &range), &g, one_sided(h)?)?
            };
            let prior = h.ln_prior_given(&fitted.effects) + fitted.ln_prior();
            let ln_posterior = gain + posterior.ln_z + prior;
            let promise = Promise { at, ln_posterior };
            ln_posterior.is_finite().then_some(promise)
        };
        let mut out: Vec<Promise> = self.hypotheses.iter().enumerate().filter_map(of).collect();
        out.sort_by(|a, b| b.ln_posterior.total_cmp(&a.ln_posterior));
        out
    }

    /// For each hypothesis what the readings say of each of its numbers alone, the others being as in a sound model: the information in
    /// units of the number's prior, all that is fitted marginalised. Of hypotheses that are no slabs.
    pub(super) fn information(
        &self,
        fitted: &FittedModel,
        sizes: &VarianceComponents,
    ) -> Vec<Vec<f64>> {
        let Some(posterior) = fitted.linear.posterior(sizes) else {
            return vec![Vec::new(); self.hypotheses.len()];
        };
        let (effects, _) = self.effects(sizes, &posterior);
        let of = |(at, (h, range)): (usize, (&CandidateEffect, &Range<usize>))| {
            let own = effects.information(at, range).diagonal();
            spread(h, own.iter().copied())
        };
        let hypotheses = self.hypotheses.iter().zip(&self.ranges);
        hypotheses.enumerate().map(of).collect()
    }

    /// Effects at these sizes, and what each column would explain where the linear model is best.
    fn effects(
        &self,
        sizes: &VarianceComponents,
        posterior: &Posterior,
    ) -> (Effects<'_>, DVector<f64>) {
        let (cross, g) = self.further.at(&sizes.ln, &posterior.step);
        let effects = Effects {
            // A covariance is symmetric.
            through: transposed(&posterior.covariance, &cross),
            further: &self.further,
            ln: sizes.ln.clone(),
            cross,
        };
        (effects, g)
    }

    /// A hypothesis with sizes of its own in the linear model: evidence and prior, and guesses of its numbers in units of their priors.
    pub(super) fn weigh(
        &self,
        fitted: &FittedModel,
        at: usize,
        start: &VarianceComponents,
    ) -> Option<Weighed> {
        let h = &self.hypotheses[at];
        let linear = if h.is_slab() {
            let mut linear = (*fitted.linear).clone();
            let first = first_member(fitted);
            for (member, sd) in h.slab() {
                let unknown = &mut linear.unknowns[first + member];
                unknown.sd = libm::hypot(unknown.sd, sd);
            }
            linear
        } else {
            let own = Coefficient {
                mean: 0.0,
                sd: 1.0,
                group: None,
                case: None,
            };
            fitted
                .linear
                .with(&self.further, at, self.ranges[at].len(), own)
        };
        let sizes = linear.maximise_evidence(start);
        let posterior = linear.posterior(&sizes)?;
        let guesses: Vec<f64> = if h.is_slab() {
            let first = first_member(fitted);
            h.slab()
                .iter()
                .map(|(member, sd)| {
                    (fitted.x[first + member] + posterior.step[first + member]) / sd
                })
                .collect()
        } else {
            let own = posterior.step.iter().skip(fitted.x.len());
            spread(h, own.copied())
        };
        if h.one_sided && guesses[0] <= 0.0 {
            return None;
        }
        let x = fitted
            .x
            .iter()
            .zip(posterior.step.iter())
            .zip(&fitted.priors)
            .map(|((x, step), prior)| {
                // A linear step from where a cause was swallowed overshoots.
                let most = if prior.group.is_none() {
                    0.8
                } else {
                    f64::INFINITY
                };
                x + step.clamp(-most, most)
            })
            .collect();
        Some(Weighed {
            ln_posterior: posterior.ln_z + h.ln_prior_given(&fitted.effects) + fitted.ln_prior(),
            guesses,
            x,
            sizes,
        })
    }
}

/// Numbers of a hypothesis that do something to the rows to first order; none of a slab, whose members are in the fit.
fn seen(h: &CandidateEffect) -> impl Iterator<Item = &EffectParameter> {
    let numbers = if h.is_slab() { &[][..] } else { &h.numbers };
    numbers
        .iter()
        .filter(|number| number.column != Sensitivity::None)
}

/// Values of the numbers that are [`seen`], with zeros for the others.
fn spread(h: &CandidateEffect, mut values: impl Iterator<Item = f64>) -> Vec<f64> {
    let of = |number: &EffectParameter| match number.column {
        Sensitivity::None => 0.0,
        _ => values.next().unwrap_or_default(),
    };
    h.numbers.iter().map(of).collect()
}

/// Whether the first number that is seen can only be positive. `None` where that is not the first of all: nothing promises it.
fn one_sided(h: &CandidateEffect) -> Option<bool> {
    let first = h.numbers.first()?;
    (!h.one_sided || first.column != Sensitivity::None).then_some(h.one_sided)
}

/// What the numbers of all hypotheses do to the whitened rows: their columns `E`, `A'E` and `C A'E` with the columns `A` of a fit and
/// its covariance `C`.
struct Effects<'a> {
    further: &'a CrossProducts,
    ln: Vec<f64>,
    cross: DMatrix<f64>,
    through: DMatrix<f64>,
}

impl Effects<'_> {
    /// `E'E - E'A C A'E` of the columns of a hypothesis.
    fn information(&self, hypothesis: usize, range: &Range<usize>) -> DMatrix<f64> {
        let (from, count) = (range.start, range.len());
        let mut out = self.further.own(hypothesis, count, &self.ln);
        out -= self.cross.columns(from, count).transpose() * self.through.columns(from, count);
        out
    }
}

/// A hypothesis in the linear model.
#[derive(Clone, Debug)]
pub(super) struct Weighed {
    /// Logarithm of evidence and prior, of all that is in the model.
    pub ln_posterior: f64,
    /// Its numbers in units of their priors.
    pub guesses: Vec<f64>,
    /// The fit's unknowns with it.
    pub x: Vec<f64>,
    /// Sizes with it.
    pub sizes: VarianceComponents,
}

/// Where members of the layer begin among the unknowns.
pub(super) fn first_member(fitted: &FittedModel) -> usize {
    fitted
        .priors
        .iter()
        .position(|prior| prior.group.is_some())
        .unwrap_or(0)
}

/// `1/2 g' M^-1 g - 1/2 ln det M` with `M = 1 + E'E - E'A C A'E`.
fn projected(information: &DMatrix<f64>, g: &DVector<f64>, one_sided: bool) -> Option<f64> {
    let k = g.len();
    let factor = Cholesky::new(information + DMatrix::identity(k, k))?;
    let estimate = factor.solve(g);
    if one_sided && estimate[0] <= 0.0 {
        return None;
    }
    let log_det: f64 = factor
        .l_dirty()
        .diagonal()
        .iter()
        .map(|d| libm::log(*d))
        .sum::<f64>()
        * 2.0;
    Some(0.5 * g.dot(&estimate) - 0.5 * log_det)
}

/// Logarithm of the evidence when members of a group may be larger than the others, over that when they may not: with their posterior
/// `N(m, C)`, `T` their variances now and then, `D = T0^-1 - T1^-1`,
/// `1/2 ln det T0/T1 - 1/2 ln det(1 - C D) + 1/2 m' D (1 - C D)^-1 m`.
fn slab(
    fitted: &FittedModel,
    posterior: &Posterior,
    sizes: &VarianceComponents,
    h: &CandidateEffect,
) -> Option<f64> {
    let first = first_member(fitted);
    let slab = h.slab();
    let places: Vec<usize> = slab.iter().map(|(member, _)| first + member).collect();
    let k = places.len();
    let C = posterior
        .covariance
        .select_rows(&places)
        .select_columns(&places);
    let m = DVector::from_iterator(
        k,
        places.iter().map(|at| fitted.x[*at] + posterior.step[*at]),
    );
    let mut D = DMatrix::zeros(k, k);
    let mut logs = 0.0;
    for (at, (place, (_, sd))) in places.iter().zip(&slab).enumerate() {
        let before = fitted.priors[*place].prior_sd(sizes).powi(2);
        let after = before + sd * sd;
        D[(at, at)] = 1.0 / before - 1.0 / after;
        logs += 0.5 * libm::log(before / after);
    }
    let rest = DMatrix::identity(k, k) - &C * &D;
    let lu = rest.lu();
    let determinant = lu.determinant();
    let right = lu.solve(&m)?;
    (determinant > 0.0).then(|| logs - 0.5 * libm::log(determinant) + 0.5 * m.dot(&(&D * right)))
}
