//! Model discrepancy that remains after all causes, described as an extra force at one site. The force is a smooth function of one
//! coordinate.
//!
//! At each site, a force that differs from case to case is added to the linear model of the fit. The force is a Gaussian process with
//! squared exponential covariance over one coordinate: the deflection at the site, a load, or the order of the cases. Over the deflection,
//! the constant and the straight line are projected out, because they are equivalent to a preload and a stiffness. The combination of site,
//! coordinate, length scale and standard deviation with the largest evidence is reported. A process fitted without the held-out cases
//! predicts them with a band of uncertainty.
//!
//! [`gp_terms`] makes the force a candidate, which a search compares with several causes of the catalogue. One effect outside the catalogue
//! looks like many effects within it. Source: Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), chapters 2 and 5.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::candidate_effect::{CandidateEffect, EffectParameter, Sensitivity, Term};
use super::cause::Cause;
use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::fit::FittedModel;
use super::gaussian_process::{GRID_SIZE, GpPosterior, Reach};
use super::hold_out_test::{compared, unseen};
use super::operating_points::OperatingPoints;
use super::predictive::PredictiveDistribution;
use super::site::{Site, SiteModel, Sites};
use crate::settings::GP_SITE_NATS;
use admire_identify::settings::NORMAL_QUANTILE_975;
use admire_identify::tolerance::{Posterior, VarianceComponents};
use admire_solver::model::{Header, MarkerIx, Model};
use admire_study::orientation::chi_square_p_value;

/// Coordinate on which the extra force depends.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Over {
    /// Deflection at the site of the force.
    Deflection,
    /// One of the study's loads.
    Load,
    /// Position of the case in the order of application.
    Order,
}

/// Extra force in one load case.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct RemainderPoint {
    /// Label of the case.
    pub case: String,
    /// Value of the coordinate in the deck's units, angles in radians. For the order of the cases, the position counted from one.
    pub coordinate: f64,
    /// Force or torque on the I marker along the component, in the deck's units.
    pub force: f64,
    /// Standard error of the force.
    pub std_error: f64,
}

/// Extra force that explains part of the structure remaining in the residuals.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Remainder {
    /// Address of the component. At `BUSHING/2.K.1`, the force acts along that component of the bushing. At `JOINT/3`, it acts along the
    /// free axis of the joint, or as a torque about it.
    pub address: String,
    /// Coordinate on which the force depends.
    pub over: Over,
    /// Name of the load, if the force depends on a load.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load: Option<String>,
    /// Fraction of the excess of chi-square over its degrees of freedom that the force explains, from 0 to 1.
    pub share: f64,
    /// Gain in log evidence by the force, in nats.
    pub nats: f64,
    /// Address of the second-best site, and its deficit in log evidence against the best site, in nats.
    pub next: Option<(String, f64)>,
    /// Force in each case, sorted by the coordinate.
    pub points: Vec<RemainderPoint>,
    /// Prediction of the held-out cases with an extra force found without them. `None` without held-out cases, or if the other cases support
    /// no force.
    pub held_out: Option<Predicted>,
}

/// Prediction of the held-out cases, which were used neither for the model nor for the extra force.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Predicted {
    /// Address of the force that was found from the other cases alone.
    pub address: String,
    /// Rms prediction error without the force. Its unit is stated in the field `of` of `hold_out` in `diagnosis.json`.
    pub rms_before: f64,
    /// Rms prediction error with the force. Its unit is stated in the field `of` of `hold_out` in `diagnosis.json`.
    pub rms_after: f64,
    /// Fraction of the decorrelated readings that lie within their 95 percent bands.
    pub within95: f64,
    /// Number of decorrelated readings.
    pub readings: usize,
    /// P-value of all held-out readings under the prediction and its covariance.
    pub p_value: f64,
}

/// Gaussian process over one coordinate, with its posterior.
struct Process {
    over: Over,
    load: Option<String>,
    coordinate: Vec<f64>,
    law: GpPosterior,
}

/// Site, coordinate and process with the largest evidence.
struct Best {
    address: String,
    place: Site,
    process: Process,
    next: Option<(String, f64)>,
    /// Effects on all rows of a unit force in each single case, one column per case.
    effect: DMatrix<f64>,
    /// Effect of the force on all rows after the fit's unknowns have adapted to the force.
    response: DMatrix<f64>,
    /// Posterior of the fit without the force, at the variance components in use.
    posterior: Posterior,
    /// Number of combinations of site and coordinate that were tried.
    tried: usize,
}

/// Returns the extra force with the largest evidence in the residuals of a fit, at the given variance components. Returns `None` if no site
/// stands out.
pub(super) fn remainder(
    subject: &DiagnosisProblem<'_>,
    fitted: &FittedModel,
    sizes: &VarianceComponents,
) -> Option<Remainder> {
    let Best {
        address,
        process,
        next,
        posterior,
        ..
    } = most_spoken_for(subject, fitted, &sites_of(subject, fitted), sizes, None)?;
    let cases = &subject.problem.programme.cases;
    let mut points: Vec<RemainderPoint> = (0..cases.len())
        .map(|k| RemainderPoint {
            case: cases[k].label.clone(),
            coordinate: process.coordinate[k],
            force: process.law.mean[k],
            std_error: process.law.covariance[(k, k)].max(0.0).sqrt(),
        })
        .collect();
    points.sort_by(|a, b| a.coordinate.total_cmp(&b.coordinate));
    let excess = posterior.chi_square - (posterior.count - posterior.effective);
    Some(Remainder {
        address,
        over: process.over,
        load: process.load,
        share: (process.law.taken / excess.max(process.law.taken)).clamp(0.0, 1.0),
        nats: process.law.nats,
        next,
        points,
        held_out: None,
    })
}

/// Returns the sites of a fit.
pub(super) fn sites_of(subject: &DiagnosisProblem<'_>, fitted: &FittedModel) -> Sites {
    Sites::new(&OperatingPoints::new(subject, fitted))
}

/// Predicts the held-out cases by a fit without them, plus the extra force found in the residuals of that fit. Let `f` and `V` be the mean
/// and the covariance of the force, `R` the response of the rows to the force, `J` the Jacobian of the fit, and `C` the covariance of its
/// unknowns. The force changes the prediction by `R f`; the covariance of the prediction is `J C J' + R V R'` plus noise. Returns `None` if
/// nothing is held out, or if no site stands out.
pub(super) fn predicted(
    subject: &DiagnosisProblem<'_>,
    fitted: &FittedModel,
    sizes: &VarianceComponents,
) -> Option<Predicted> {
    let found = most_spoken_for(subject, fitted, &sites_of(subject, fitted), sizes, None)?;
    let before = &fitted.residual + &fitted.jacobian * &found.posterior.step;
    let after = &before + &found.response * &found.process.law.mean;
    let rows = compared(subject);
    let (_, unit) = subject.compared();
    let rms = |misfit: &DVector<f64>| {
        let squares: f64 = rows.iter().map(|k| (misfit[*k] * unit).powi(2)).sum();
        (squares / rows.len() as f64).sqrt()
    };
    let whitening = subject.whitening(Data::All);
    let weights = whitening.weights(&sizes.ln);
    let held_out = unseen(subject);
    let turned: Vec<usize> = (0..subject.rows.len())
        .filter(|k| weights[*k] > 0.0 && held_out.binary_search(k).is_ok())
        .collect();
    if rows.is_empty() || turned.is_empty() {
        return None;
    }
    let weighed = |columns: &DMatrix<f64>| {
        let mut out = whitening.apply(columns);
        for (mut row, weight) in out.row_iter_mut().zip(weights.iter()) {
            row *= *weight;
        }
        out.select_rows(&turned)
    };
    let (J, R) = (weighed(&fitted.jacobian), weighed(&found.response));
    let r = whitening.apply_vector(&after).component_mul(&weights);
    let r = r.select_rows(&turned);
    let n = turned.len();
    let foreseen = PredictiveDistribution::new(J, &found.posterior.covariance);
    let foreseen = foreseen.with(&R, &found.process.law.covariance);
    let within =
        (0..n).filter(|k| r[*k].abs() < NORMAL_QUANTILE_975 * foreseen.variance(*k).sqrt());
    let within95 = within.count() as f64 / n as f64;
    let chi_square = foreseen.chi_square(&r)?;
    Some(Predicted {
        address: found.address,
        rms_before: rms(&before),
        rms_after: rms(&after),
        within95,
        readings: n,
        p_value: chi_square_p_value(chi_square, n),
    })
}

/// Force of unknown law, as a candidate in a search.
pub(super) struct GpTerm {
    /// Candidate with one parameter per column of `root`, in units of the priors. Its effects on the rows are linearised at the end of a
    /// fit.
    pub hypothesis: CandidateEffect,
    place: Site,
    root: DMatrix<f64>,
}

impl GpTerm {
    /// Returns the candidate with its effects linearised at another fit.
    pub(super) fn at(
        &self,
        subject: &DiagnosisProblem<'_>,
        fitted: &FittedModel,
    ) -> CandidateEffect {
        let survey = OperatingPoints::new(subject, fitted);
        let site = (self.place.pair, self.place.axis);
        let (effects, _) = survey.unit_force_effects(&[site]);
        CandidateEffect {
            numbers: numbers(&effects[0], &self.root),
            ..self.hypothesis.clone()
        }
    }
}

/// Returns up to two forces of unknown law as candidates. One has the largest evidence at the fit's own variance components, which may have
/// absorbed part of the effect. The other has the largest evidence at variance components limited to their prior medians. The prior probability
/// of an unmodelled force is divided among all sites, coordinates, length scales and standard deviations tried.
pub(super) fn gp_terms(
    subject: &DiagnosisProblem<'_>,
    fitted: &FittedModel,
    sites: &Sites,
) -> Vec<GpTerm> {
    let usual = fitted.sizes.at(fitted.sizes.capped_above_median(0.0));
    let each = [&usual, &fitted.sizes].into_iter();
    let found = each.filter_map(|sizes| most_spoken_for(subject, fitted, sites, sizes, None));
    let mut out: Vec<GpTerm> = Vec::new();
    let priors = subject.problem.priors;
    let odds = libm::log(priors.class_probability * priors.unmodelled_force_odds);
    for mut unnamed in found.map(as_hypothesis) {
        unnamed.hypothesis.ln_prior += odds;
        if !out
            .iter()
            .any(|other| other.hypothesis.same_form(&unnamed.hypothesis))
        {
            out.push(unnamed);
        }
    }
    out
}

/// Returns the misfits of the force laws in a fit, each as a further term of its cause. Only laws known in kind but not in shape have a
/// misfit: friction may differ from a slider, and rubber from a polynomial.
pub(super) fn left_by_laws(
    subject: &DiagnosisProblem<'_>,
    fitted: &FittedModel,
    sites: &Sites,
) -> Vec<GpTerm> {
    let chosen = &fitted.effects;
    let is_closed = |h: &CandidateEffect| {
        let mut parts = chosen.iter().filter(|other| other.same_site(h));
        parts.any(CandidateEffect::is_left_by_law)
    };
    let usual = fitted.sizes.at(fitted.sizes.capped_above_median(0.0));
    let priors = subject.problem.priors;
    let left = |h: &CandidateEffect| {
        let best = most_spoken_for(subject, fitted, sites, &usual, Some(&h.address))?;
        let mut left = as_hypothesis(best);
        left.hypothesis.cause = h.cause;
        left.hypothesis.side = h.side;
        left.hypothesis.term = Term::LawMisfit;
        left.hypothesis.ln_prior += libm::log(priors.law_misfit);
        Some(left)
    };
    let open = CandidateEffect::causes(chosen).filter(|h| h.cause.has_rough_law() && !is_closed(h));
    open.filter_map(left).collect()
}

/// Returns true if the site of a cause is the elastic element or joint where `force` acts, or one of its markers.
pub(super) fn is_at_element_of(
    model: &Model,
    h: &CandidateEffect,
    force: &CandidateEffect,
) -> bool {
    let element = |address: &str| {
        let end = address.find(['.', '<']).unwrap_or(address.len());
        address[..end].to_string()
    };
    let own = element(&force.address);
    let named = |kind: &str, header: &Header| own == format!("{kind}/{}", header.id);
    let bushing = model.bushings.iter().find(|b| named("BUSHING", &b.header));
    let mut fields = model.pair_forces.iter();
    let field = fields.find(|f| named(f.def.name, &f.header));
    let joint = model.joints.iter().find(|j| named("JOINT", &j.header));
    let ends = bushing.map(|b| (b.i, b.j));
    let ends = ends.or(field.map(|f| (f.i, f.j)));
    let ends = ends.or(joint.map(|j| (j.i, j.j)));
    let marker = |at: MarkerIx| format!("MARKER/{}", model.markers[at.0].header.id);
    let ends: Vec<String> = ends.map_or_else(Vec::new, |(i, j)| vec![marker(i), marker(j)]);
    let mut places = h.members.iter().chain([&h.address]);
    places.any(|place| element(place) == own || ends.contains(&element(place)))
}

/// Returns one parameter per column of `root`. A column is a pattern of forces, with one force per case; the parameter scales this pattern.
/// `effect` holds the effects of unit forces on the rows. The parameter times its `unit` is the rms force over all cases, for the report.
fn numbers(effect: &DMatrix<f64>, root: &DMatrix<f64>) -> Vec<EffectParameter> {
    let columns = effect * root;
    let number = |(k, column): (usize, nalgebra::DVectorView<'_, f64>)| {
        let rows = column.iter().copied().enumerate();
        let moved = rows.filter(|(_, value)| *value != 0.0).collect();
        EffectParameter {
            unit: root.column(k).norm() / (root.nrows() as f64).sqrt(),
            ..EffectParameter::linear(format!("f{}", k + 1), 1.0, Sensitivity::Rows(moved))
        }
    };
    columns.column_iter().enumerate().map(number).collect()
}

fn as_hypothesis(found: Best) -> GpTerm {
    let form = match found.process.over {
        Over::Deflection => "over deflection",
        Over::Load => "over a load",
        Over::Order => "over the order",
    };
    let root = found.process.law.root;
    let mut hypothesis = CandidateEffect::plain(
        Cause::UnmodelledForce,
        found.address,
        form,
        numbers(&found.effect, &root),
    );
    let laws = found.tried * GRID_SIZE;
    hypothesis.ln_prior = -libm::log(laws as f64);
    GpTerm {
        hypothesis,
        place: found.place,
        root,
    }
}

/// Finds the extra force with the largest evidence. If `only` names a site, the force is a misfit of the law at that site; otherwise all
/// sites are searched.
fn most_spoken_for(
    subject: &DiagnosisProblem<'_>,
    fitted: &FittedModel,
    sites: &Sites,
    sizes: &VarianceComponents,
    only: Option<&str>,
) -> Option<Best> {
    let reach = if only.is_some() {
        Reach::Short
    } else {
        Reach::Smooth
    };
    let size = only.map_or(1.0, |_| subject.problem.priors.law_misfit_size);
    let posterior = fitted.linear.posterior(sizes)?;
    let whitened = fitted.whitened_at(sizes, &posterior);
    let is_tried =
        |site: &Site| site.force > 0.0 && only.is_none_or(|address| site.address == address);
    let mut tried = 0_usize;
    let mut absorbed: BTreeMap<usize, DMatrix<f64>> = BTreeMap::new();
    let mut found: Vec<(usize, Process)> = Vec::new();
    for (at, place) in sites.all.iter().enumerate().filter(|(_, s)| is_tried(s)) {
        let model = SiteModel::new(fitted, &sites.effects[at], sizes, &posterior, &whitened);
        absorbed.insert(at, model.absorbed);
        for (over, load, coordinate) in coordinates(subject, place) {
            if only.is_some() && over == Over::Load {
                continue;
            }
            tried += 1;
            let is_stiffness_apart = over == Over::Deflection;
            let Some(law) = GpPosterior::best(
                &coordinate,
                &model.information,
                &model.gradient,
                size * place.force,
                reach,
                is_stiffness_apart,
            ) else {
                continue;
            };
            found.push((
                at,
                Process {
                    over,
                    load,
                    coordinate,
                    law,
                },
            ));
        }
    }
    let by_nats =
        |a: &(usize, Process), b: &(usize, Process)| b.1.law.nats.total_cmp(&a.1.law.nats);
    found.sort_by(by_nats);
    if found.first()?.1.law.nats < GP_SITE_NATS + libm::log(tried as f64) {
        return None;
    }
    let (at, process) = found.swap_remove(0);
    let address = sites.all[at].address.clone();
    found.sort_by(by_nats);
    let next = found
        .iter()
        .find(|(other, _)| sites.all[*other].address != address)
        .map(|(other, behind)| {
            let nats = process.law.nats - behind.law.nats;
            (sites.all[*other].address.clone(), nats)
        });
    let taken_up = absorbed.remove(&at)?;
    let effect = &sites.effects[at];
    Some(Best {
        place: sites.all[at].clone(),
        response: effect - &fitted.jacobian * &taken_up,
        effect: effect.clone(),
        posterior,
        tried,
        address,
        process,
        next,
    })
}

/// Returns the coordinates on which the force at a site may depend. Each entry holds the kind, the name of the load if any, and one value
/// per case.
fn coordinates(
    subject: &DiagnosisProblem<'_>,
    place: &Site,
) -> Vec<(Over, Option<String>, Vec<f64>)> {
    let programme = subject.problem.programme;
    let order = (1..=programme.cases.len()).map(|k| k as f64).collect();
    let mut out = vec![
        (Over::Deflection, None, place.displacement.clone()),
        (Over::Order, None, order),
    ];
    for (k, load) in programme.loads.iter().enumerate() {
        let values = programme.cases.iter().map(|case| case.values[k]).collect();
        out.push((Over::Load, Some(load.name.clone()), values));
    }
    out
}
