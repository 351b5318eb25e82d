//! What is left after all causes, as an extra force at one place that is a smooth function of one coordinate.
//!
//! At each place a force that differs from case to case is added to the linear model of the fit: a Gaussian process over the place's own
//! deflection, over a load, or over the order of the cases, with a squared exponential covariance. Over its own deflection the constant
//! and the straight line are taken off: they are the preload and the stiffness. The place, coordinate, length and size of greatest
//! evidence are shown. Fitted without the cases held out it predicts them, with the band of the process.
//!
//! [`unnamed`] makes it a hypothesis that a search holds against several causes of the catalogue: one effect that the catalogue lacks
//! looks like many of those it has. Source: Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), chapters 2 and 5.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::cause::Cause;
use super::diagnosis_problem::{Data, DiagnosisProblem};
use super::fit::FittedModel;
use super::folds::{compared, unseen};
use super::gaussian_process::{LAWS, Law, Reach};
use super::hypothesis::{EffectParameter, Hypothesis, LEFT_BY_LAW, Sensitivity, component};
use super::predictive::PredictiveDistribution;
use super::survey::Survey;
use admire_identify::tolerance::{Posterior, VarianceComponents, transposed};
use admire_solver::mechanics::Vec6;
use admire_solver::model::{Header, JointKind, MarkerIx, Model};
use admire_study::orientation::chi_square_p_value;

/// A first guess moves no stiffness by more than this factor of e.
const FAR: f64 = 0.8;
/// A place stands out from so many nats on, the number of places tried taken off.
const STANDS_OUT: f64 = 5.0;
/// What the force is a function of.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Over {
    /// The deflection at the place itself.
    Deflection,
    /// A load of the study.
    Load,
    /// The order of the cases.
    Order,
}

/// The force in one case.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct RemainderPoint {
    /// Label of the case.
    pub case: String,
    /// Value of the coordinate in the deck's units, angles in radians; the position in the order counts from one.
    pub coordinate: f64,
    /// Force or torque on the I marker along the component, in the deck's units.
    pub force: f64,
    /// Its standard error.
    pub std_error: f64,
}

/// An extra force that takes up what no cause explains.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Remainder {
    /// `BUSHING/2.K.1`: along that component of the bushing; `JOINT/3`: along or about the free axis of the joint.
    pub address: String,
    /// What it is a function of.
    pub over: Over,
    /// The load, if it is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub load: Option<String>,
    /// Part of the chi-square beyond its degrees of freedom that it takes up, 0 to 1.
    pub share: f64,
    /// By how many nats the evidence rises.
    pub nats: f64,
    /// The next best address, and how many nats it is behind.
    pub next: Option<(String, f64)>,
    /// One for each case, in the order of the coordinate.
    pub points: Vec<RemainderPoint>,
    /// What such a force says of the cases held out; `None` where there are none, or the others speak for no force.
    pub held_out: Option<Predicted>,
}

/// Cases that neither the model nor the force has seen.
#[derive(Clone, PartialEq, Debug, Serialize)]
pub struct Predicted {
    /// Where the force is by the other cases alone.
    pub address: String,
    /// Rms of what is compared (as in `hold_out`) without the force, and with it.
    pub rms_before: f64,
    /// With it.
    pub rms_after: f64,
    /// Part of the readings, turned to independent ones, within their 95 percent bands.
    pub within95: f64,
    /// How many there are.
    pub readings: usize,
    /// Whether all agree with the prediction and its covariance.
    pub p_value: f64,
}

/// A component of an element at which a force may be missing.
struct Place {
    address: String,
    pair: (MarkerIx, MarkerIx),
    axis: usize,
    deflection: Vec<f64>,
    /// A usual force.
    force: f64,
}

/// A covariance over one coordinate and how well it does.
struct Process {
    over: Over,
    load: Option<String>,
    coordinate: Vec<f64>,
    law: Law,
}

/// The place, coordinate and law that do best.
struct Best {
    address: String,
    place: Place,
    process: Process,
    next: Option<(String, f64)>,
    /// How a force in each single case moves all rows,
    effect: DMatrix<f64>,
    /// by how much the unknowns of the fit then give way,
    taken_up: DMatrix<f64>,
    /// and how all rows move with that.
    response: DMatrix<f64>,
    /// What the readings say of the unknowns of the fit without the force, at the sizes of tolerances that were taken.
    posterior: Posterior,
    /// How many places and coordinates there were.
    tried: usize,
}

/// The place, coordinate and law that the residuals of a fit speak for most, tolerances being of such sizes; `None` where none stands
/// out.
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
    } = most_spoken_for(subject, fitted, sizes, None)?;
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

/// Predicts the cases held out by a fit that has not seen them and the extra force that its own residuals speak for. With `f` and `V`
/// mean and covariance of the force, `R` the response of the rows and `C` the covariance of the unknowns, the rows are off by
/// `R f` with `J C J' + R V R'` and their noise. `None` where nothing is held out, or no place stands out.
pub(super) fn predicted(
    subject: &DiagnosisProblem<'_>,
    fitted: &FittedModel,
    sizes: &VarianceComponents,
) -> Option<Predicted> {
    let found = most_spoken_for(subject, fitted, sizes, None)?;
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
    let within = (0..n).filter(|k| r[*k].abs() < 1.96 * foreseen.variance(*k).sqrt());
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

/// A force of a law that no cause has, as a search takes it in.
pub(super) struct Unnamed {
    /// It, as numbers in units of their priors; what they do is linear where a fit ended.
    pub hypothesis: Hypothesis,
    /// First guesses of its numbers,
    pub guesses: Vec<f64>,
    /// and of the unknowns of the fit.
    pub x: Vec<f64>,
    /// By how many nats the linear model expects the evidence to rise, prior left out.
    pub nats: f64,
    place: Place,
    root: DMatrix<f64>,
}

impl Unnamed {
    /// The same law linearised at another fit.
    pub(super) fn at(&self, subject: &DiagnosisProblem<'_>, fitted: &FittedModel) -> Hypothesis {
        let survey = Survey::new(subject, fitted);
        Hypothesis {
            numbers: numbers(&effect(&survey, &self.place), &self.root),
            ..self.hypothesis.clone()
        }
    }
}

/// Such forces as hypotheses: the one that stands out at a fit's own sizes of tolerances, and the one that does with sizes that are
/// usual, for its own may have swallowed the effect. The prior is that of a class of causes, spread over all places, coordinates, lengths
/// and sizes that were tried.
pub(super) fn unnamed(subject: &DiagnosisProblem<'_>, fitted: &FittedModel) -> Vec<Unnamed> {
    let usual = fitted.sizes.at(fitted.sizes.shrunk_to_median(0.0));
    let each = [&usual, &fitted.sizes].into_iter();
    let found = each.filter_map(|sizes| most_spoken_for(subject, fitted, sizes, None));
    let mut out: Vec<Unnamed> = Vec::new();
    for unnamed in found.map(|best| as_hypothesis(subject, fitted, best)) {
        if !out
            .iter()
            .any(|other| other.hypothesis.same_form(&unnamed.hypothesis))
        {
            out.push(unnamed);
        }
    }
    out
}

/// What the laws of causes in a fit leave at their own places, each as a further part of its cause. Only laws that are known in kind
/// only leave anything: friction that is not a slider, rubber that is not a polynomial.
pub(super) fn left_by_laws(subject: &DiagnosisProblem<'_>, fitted: &FittedModel) -> Vec<Unnamed> {
    let chosen = &fitted.effects;
    let is_closed = |h: &Hypothesis| {
        let mut parts = chosen.iter().filter(|other| other.same_site(h));
        parts.any(Hypothesis::is_left_by_law)
    };
    let usual = fitted.sizes.at(fitted.sizes.shrunk_to_median(0.0));
    let priors = subject.problem.priors;
    let left = |h: &Hypothesis| {
        let best = most_spoken_for(subject, fitted, &usual, Some(&h.address))?;
        let mut left = as_hypothesis(subject, fitted, best);
        left.hypothesis.cause = h.cause;
        left.hypothesis.side = h.side;
        left.hypothesis.part = LEFT_BY_LAW;
        left.hypothesis.ln_prior += libm::log(priors.law_misfit / priors.class_probability);
        Some(left)
    };
    let open = Hypothesis::causes(chosen).filter(|h| h.cause.has_rough_law() && !is_closed(h));
    open.filter_map(left).collect()
}

/// True if a cause is at the bushing or joint at which a force acts, or at a marker of it.
pub(super) fn is_at_element_of(model: &Model, h: &Hypothesis, force: &Hypothesis) -> bool {
    let element = |address: &str| {
        let end = address.find(['.', '<']).unwrap_or(address.len());
        address[..end].to_string()
    };
    let own = element(&force.address);
    let named = |kind: &str, header: &Header| own == format!("{kind}/{}", header.id);
    let bushing = model.bushings.iter().find(|b| named("BUSHING", &b.header));
    let joint = model.joints.iter().find(|j| named("JOINT", &j.header));
    let ends = bushing.map(|b| (b.i, b.j)).or(joint.map(|j| (j.i, j.j)));
    let marker = |at: MarkerIx| format!("MARKER/{}", model.markers[at.0].header.id);
    let ends: Vec<String> = ends.map_or_else(Vec::new, |(i, j)| vec![marker(i), marker(j)]);
    let mut places = h.members.iter().chain([&h.address]);
    places.any(|place| element(place) == own || ends.contains(&element(place)))
}

/// One for each column of what a force does, per unit of its weight; told as a force whose mean square is that over all cases.
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

fn as_hypothesis(subject: &DiagnosisProblem<'_>, fitted: &FittedModel, found: Best) -> Unnamed {
    let form = match found.process.over {
        Over::Deflection => "over deflection",
        Over::Load => "over a load",
        Over::Order => "over the order",
    };
    let Law {
        root,
        weights,
        mean,
        nats,
        ..
    } = found.process.law;
    let mut hypothesis = Hypothesis::plain(
        Cause::UnmodelledForce,
        found.address,
        form,
        numbers(&found.effect, &root),
    );
    let laws = found.tried * LAWS;
    hypothesis.ln_prior = libm::log(subject.problem.priors.class_probability / laws as f64);
    let step = &found.posterior.step - &found.taken_up * mean;
    let x = fitted.x.iter().zip(step.iter()).zip(&fitted.priors);
    let moved = x.map(|((x, step), prior)| match prior.group {
        None => x + step.clamp(-FAR, FAR),
        Some(_) => x + step,
    });
    Unnamed {
        hypothesis,
        guesses: weights.iter().copied().collect(),
        x: moved.collect(),
        nats,
        place: found.place,
        root,
    }
}

/// At all places, or at one where the law of a cause leaves it.
fn most_spoken_for(
    subject: &DiagnosisProblem<'_>,
    fitted: &FittedModel,
    sizes: &VarianceComponents,
    only: Option<&str>,
) -> Option<Best> {
    let survey = Survey::new(subject, fitted);
    let mut places = places(&survey);
    let reach = if let Some(address) = only {
        places.retain(|place| place.address == address);
        for place in &mut places {
            place.force *= survey.priors().law_misfit_size;
        }
        Reach::Short
    } else {
        Reach::Smooth
    };
    let weights = fitted.whitening.weights(&sizes.ln);
    let posterior = fitted.linear.posterior(sizes)?;
    let (residual, jacobian) = fitted.whitened_at(sizes, &posterior);
    let (mut tried, mut responses) = (0_usize, Vec::new());
    let mut found: Vec<(usize, Process)> = Vec::new();
    for (at, place) in places.iter().enumerate() {
        let plain = effect(&survey, place);
        let mut effect = fitted.whitening.apply(&plain);
        for (mut row, weight) in effect.row_iter_mut().zip(weights.iter()) {
            row *= *weight;
        }
        let cross = transposed(&jacobian, &effect);
        let taken_up = transposed(&posterior.covariance, &cross);
        let information = transposed(&effect, &effect) - transposed(&cross, &taken_up);
        let gradient = effect.tr_mul(&residual);
        responses.push((plain, taken_up));
        for (over, load, coordinate) in coordinates(subject, place) {
            if only.is_some() && over == Over::Load {
                continue;
            }
            tried += 1;
            let is_stiffness_apart = over == Over::Deflection;
            let read = (&information, &gradient);
            let kind = (reach, is_stiffness_apart);
            let Some(law) = Law::best(&coordinate, kind, read, place.force) else {
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
    if found.first()?.1.law.nats < STANDS_OUT + libm::log(tried as f64) {
        return None;
    }
    let (at, process) = found.swap_remove(0);
    let address = places[at].address.clone();
    found.sort_by(by_nats);
    let next = found
        .iter()
        .find(|(other, _)| places[*other].address != address)
        .map(|(other, behind)| {
            let nats = process.law.nats - behind.law.nats;
            (places[*other].address.clone(), nats)
        });
    let (effect, taken_up) = responses.swap_remove(at);
    Some(Best {
        place: places.swap_remove(at),
        response: &effect - &fitted.jacobian * &taken_up,
        effect,
        taken_up,
        posterior,
        tried,
        address,
        process,
        next,
    })
}

/// Components of bushings that move, and free motions of joints.
fn places(survey: &Survey<'_>) -> Vec<Place> {
    let mut out = Vec::new();
    let mut put = |address: String, pair, axis: usize, deflection: Vec<f64>, force: f64| {
        let low = deflection.iter().copied().fold(f64::INFINITY, f64::min);
        let high = deflection.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        if high - low > 1e-9 && force > 0.0 {
            out.push(Place {
                address,
                pair,
                axis,
                deflection,
                force,
            });
        }
    };
    let mut largest = 0.0_f64;
    for (k, bushing) in survey.model.bushings.iter().enumerate() {
        if !bushing.header.active {
            continue;
        }
        let deflections = survey.bushing_deflections(k);
        let stiffness = survey.stiffnesses(k);
        for axis in 0..6 {
            let u: Vec<f64> = deflections.iter().map(|d| d[axis]).collect();
            let most = u.iter().fold(0.0_f64, |m, u| m.max(u.abs()));
            let force = stiffness[axis] * most;
            if axis < 3 {
                largest = largest.max(force);
            }
            let address = format!("BUSHING/{}.{}", bushing.header.id, component(axis));
            put(address, (bushing.i, bushing.j), axis, u, force);
        }
    }
    let lever = 100.0 * survey.millimetre();
    for joint in survey.model.joints.iter().filter(|j| j.header.active) {
        let axes: &[usize] = match joint.kind {
            JointKind::Translational | JointKind::Cylindrical => &[2],
            JointKind::Revolute => &[5],
            _ => continue,
        };
        let readings = survey.constraint("JOINT", joint.header.id);
        for &axis in axes {
            let of = |r: &admire_solver::system::Reading| match axis {
                0..3 => r.motion.p_ij_j[axis],
                _ => r.motion.angles[axis - 3],
            };
            let u: Vec<f64> = readings.iter().map(of).collect();
            let force = if axis < 3 { largest } else { largest * lever };
            let address = format!("JOINT/{}", joint.header.id);
            put(address, (joint.i, joint.j), axis, u, force);
        }
    }
    out
}

/// What the force may be a function of at a place.
fn coordinates(
    subject: &DiagnosisProblem<'_>,
    place: &Place,
) -> Vec<(Over, Option<String>, Vec<f64>)> {
    let programme = subject.problem.programme;
    let order = (1..=programme.cases.len()).map(|k| k as f64).collect();
    let mut out = vec![
        (Over::Deflection, None, place.deflection.clone()),
        (Over::Order, None, order),
    ];
    for (k, load) in programme.loads.iter().enumerate() {
        let values = programme.cases.iter().map(|case| case.values[k]).collect();
        out.push((Over::Load, Some(load.name.clone()), values));
    }
    out
}

/// How a unit force in each single case moves all rows: one column for each case.
fn effect(survey: &Survey<'_>, place: &Place) -> DMatrix<f64> {
    let cases = survey.cases();
    let number = |case: usize| {
        let unit = |k: usize| {
            if k == case {
                Vec6::ith(place.axis, 1.0)
            } else {
                Vec6::zeros()
            }
        };
        EffectParameter::linear(
            "force",
            1.0,
            Sensitivity::Wrench(place.pair, (0..cases).map(unit).collect()),
        )
    };
    let numbers: Vec<EffectParameter> = (0..cases).map(number).collect();
    survey.columns(&numbers.iter().collect::<Vec<_>>())
}
