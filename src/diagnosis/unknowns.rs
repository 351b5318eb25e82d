//! Unknowns of a fit with their priors: stiffnesses, random effects, parameters of causes, frame poses, positions of marks, and effects that
//! act directly on residual rows.

use super::candidate_effect::{CandidateEffect, Parametrisation, Sensitivity};
use super::diagnosis_problem::DiagnosisProblem;
use super::frame::{centroid, motions};
use crate::priors::COMPLIANCE_LN_SD;
use crate::settings::{ABSENT_COMPLIANCE, HELD_UNKNOWN_SD};
use admire_identify::global::{
    Component, FitUnknown, FitUnknowns, FrameMotions, HysteresisState, NuisanceLayout, Prepared,
    UnknownTarget, fit_unknowns,
};
use admire_identify::tolerance::{Effect, EffectGroup, ScalePrior};
use admire_identify::{Problem, tolerance};
use admire_solver::mechanics::Vec3;
use admire_solver::system::{Parameters, Slot};
use admire_study::Channel;
use admire_syntax::Address;

/// Unknowns of an earlier fit, from which a new fit starts.
#[derive(Clone, Copy)]
pub struct Known<'a> {
    /// Unknowns of the deck in the earlier fit.
    pub unknowns: &'a FitUnknowns,
    /// Effects in the earlier fit.
    pub chosen: &'a [CandidateEffect],
    /// Index of each parameter of each effect among the unknowns of the earlier fit.
    pub places: &'a [Vec<usize>],
    /// Values of all unknowns of the earlier fit.
    pub x: &'a [f64],
}

/// Effect of an unknown that acts directly on residual rows, without the deck.
pub enum RowColumn {
    /// Fixed changes of rows per unit of the unknown. Each pair holds a row index and the change.
    Fixed(Vec<(usize, f64)>),
    /// Gain error: the predictions are multiplied by 1 plus the product of the unknown and the first field. Each pair holds a row index and
    /// the reading in units of its noise.
    Gain(f64, Vec<(usize, f64)>),
}

/// Index of an unknown while the unknowns are collected. Effects that act directly on rows get their final index last, because they are the
/// last unknowns.
#[derive(Clone, Copy)]
enum ParameterPosition {
    /// Index among all unknowns.
    Deck(usize),
    /// Index among the effects that act directly on rows.
    Row(usize),
}

/// Unknowns of a fit, with their start values and priors.
pub struct Unknowns {
    /// Parameters of the deck before the fit.
    pub deck: Parameters,
    /// Unknowns of the deck: stiffnesses, then random effects in their order, then parameters of causes.
    pub list: FitUnknowns,
    /// Unknowns of the measurement: poses of the measuring frame and positions of marks.
    pub layout: NuisanceLayout,
    /// Effects that act directly on residual rows.
    pub rows: Vec<RowColumn>,
    /// History variables of laws with memory.
    pub memories: Vec<HysteresisState>,
    /// Index of each parameter of each effect among all unknowns.
    pub places: Vec<Vec<usize>>,
    /// Start values of all unknowns.
    pub start: Vec<f64>,
    /// Priors of all unknowns.
    pub priors: Vec<tolerance::Coefficient>,
}

impl Unknowns {
    /// Returns the indices of stiffnesses and parameters of causes among the unknowns of the deck, in ascending order. Plain random effects
    /// are left out.
    pub(super) fn of_the_model(&self) -> Vec<usize> {
        let of_a_cause = |k: &usize| self.places.iter().flatten().any(|at| at == k);
        let is_own = |k: &usize| self.priors[*k].group.is_none() || of_a_cause(k);
        (0..self.list.len()).filter(is_own).collect()
    }

    /// Collects the unknowns of the deck extended by the `chosen` effects. Each effect comes with guesses of its parameters, in units of the
    /// priors. Values of the earlier fit `known` replace the guesses. Returns `None` if the deck lacks a parameter of an effect.
    pub fn new(
        subject: &DiagnosisProblem<'_>,
        problem: &Problem<'_>,
        prepared: &Prepared,
        chosen: &[(CandidateEffect, Vec<f64>)],
        known: Option<Known<'_>>,
    ) -> Option<Self> {
        let system = &prepared.system;
        let slot = |address: &Address| system.catalogue().slot(address);
        let mut list = fit_unknowns(problem, system, None).list().to_vec();
        list.retain(|unknown| !matches!(unknown.target, UnknownTarget::Offset(_)));
        let mut priors: Vec<tolerance::Coefficient> = list
            .iter()
            .map(|unknown| own(unknown.mean, unknown.sd))
            .collect();
        let stiffnesses = list.len();
        // A reading of several cases, such as a gradient, couples the errors of these cases.
        let channels = &problem.measurement.channels;
        let is_apart = channels.iter().all(Channel::is_of_single_cases);
        for member in &subject.layer.members {
            let meaning = match &member.effect {
                Effect::Always(pairs) => {
                    UnknownTarget::Number(slots(pairs, &slot).unwrap_or_default())
                }
                Effect::PerCase(pairs) => {
                    UnknownTarget::PerCase(per_case(pairs, 1.0, &slot).unwrap_or_default())
                }
                Effect::Turn(markers) => UnknownTarget::Turn(markers.clone()),
                Effect::Offset { bushing, axis } => {
                    let id = problem.model.bushings[*bushing].header.id;
                    let of = |word| Address::of_argument("BUSHING", id, word, Some(axis + 1));
                    UnknownTarget::Offset(Component {
                        stiffness: slot(&of("K"))?,
                        preload: Some(slot(&of("FORCE"))?),
                    })
                }
            };
            list.push(FitUnknown {
                addresses: Vec::new(),
                target: meaning,
                start: 0.0,
                mean: 0.0,
                sd: 1.0,
                bounds: None,
            });
            let prior = tolerance::Coefficient::member(member.group);
            priors.push(prior.in_case(member.effect.only_case().filter(|_| is_apart)));
        }
        let members = list.len();
        // Values from another fit apply where available: stiffnesses and random effects have the same order in every fit.
        let mut start: Vec<f64> = match known {
            Some(known) => known.x[..members].to_vec(),
            None => list.iter().map(|unknown| unknown.start).collect(),
        };
        let mut rows: Vec<RowColumn> = Vec::new();
        let mut row_starts = Vec::new();
        let (mut memories, mut places) = (Vec::new(), Vec::new());
        for (hypothesis, guesses) in chosen {
            let before = known.and_then(|known| {
                let at = known.chosen.iter().position(|h| h.same_form(hypothesis))?;
                Some(
                    known.places[at]
                        .iter()
                        .map(|k| known.x[*k])
                        .collect::<Vec<_>>(),
                )
            });
            if let Some(plan) = &hypothesis.memory {
                memories.push(HysteresisState {
                    anchor: slot(&plan.anchor)?,
                    carries: plan.carries,
                    by: slot(&plan.by)?,
                    channel: problem.measurement.channels.len() + memories.len(),
                });
            }
            let mut place = Vec::new();
            for (k, number) in hypothesis.numbers.iter().enumerate() {
                let (mut mean, mut sd) = (number.mean / number.sd, 1.0);
                let mut guess = before
                    .as_ref()
                    .map_or(guesses[k] + mean, |before| before[k]);
                let meaning = match (&number.unknown, &number.column) {
                    (Parametrisation::Member(member), _) => {
                        let at = stiffnesses + member;
                        priors[at].sd = libm::hypot(priors[at].sd, number.sd);
                        if before.is_none() && guesses[k] != 0.0 {
                            start[at] = guesses[k] * number.sd;
                        }
                        place.push(ParameterPosition::Deck(at));
                        continue;
                    }
                    (Parametrisation::Linear, Sensitivity::Rows(column)) => {
                        let column = column.iter().map(|(at, v)| (*at, v * number.sd));
                        place.push(ParameterPosition::Row(rows.len()));
                        rows.push(RowColumn::Fixed(column.collect()));
                        row_starts.push(guess);
                        continue;
                    }
                    (Parametrisation::Gain(readings), _) => {
                        place.push(ParameterPosition::Row(rows.len()));
                        rows.push(RowColumn::Gain(number.sd, readings.clone()));
                        row_starts.push(guess);
                        continue;
                    }
                    (Parametrisation::Linear, Sensitivity::Always(pairs))
                    | (Parametrisation::Extended(pairs), _) => {
                        let scaled: Vec<_> = pairs
                            .iter()
                            .map(|(address, factor)| (address.clone(), factor * number.sd))
                            .collect();
                        UnknownTarget::Number(slots(&scaled, &slot)?)
                    }
                    (Parametrisation::Linear, Sensitivity::PerCase(pairs)) => {
                        UnknownTarget::PerCase(per_case(pairs, number.sd, &slot)?)
                    }
                    // A wrench is not a parameter of the deck.
                    (Parametrisation::Linear, Sensitivity::Wrench(..) | Sensitivity::None) => {
                        return None;
                    }
                    (Parametrisation::Compliance(addresses), _) => {
                        if before.is_none() {
                            guess = -libm::log(guess.max(ABSENT_COMPLIANCE) * number.sd);
                        }
                        (mean, sd) = (-libm::log(number.sd), COMPLIANCE_LN_SD);
                        UnknownTarget::Stiffness(components(addresses, &slot)?)
                    }
                    (Parametrisation::Rate { address, usual }, _) => {
                        if before.is_none() {
                            guess = libm::log(*usual) + guess * number.sd;
                        }
                        (mean, sd) = (libm::log(*usual), number.sd);
                        UnknownTarget::Stiffness(components(std::slice::from_ref(address), &slot)?)
                    }
                    (Parametrisation::Offset { stiffness, preload }, _) => {
                        if before.is_none() {
                            guess *= number.sd;
                        }
                        sd = number.sd;
                        UnknownTarget::Offset(Component {
                            stiffness: slot(stiffness)?,
                            preload: Some(slot(preload)?),
                        })
                    }
                    (
                        Parametrisation::SlipLength {
                            address,
                            start,
                            usual,
                        },
                        _,
                    ) => {
                        if before.is_none() {
                            guess = libm::log(*start);
                        }
                        (mean, sd) = (libm::log(*usual), number.sd);
                        UnknownTarget::Stiffness(components(std::slice::from_ref(address), &slot)?)
                    }
                };
                place.push(ParameterPosition::Deck(list.len()));
                start.push(guess);
                priors.push(own(mean, sd));
                list.push(FitUnknown {
                    addresses: Vec::new(),
                    target: meaning,
                    start: guess,
                    mean,
                    sd,
                    bounds: None,
                });
            }
            places.push(place);
        }
        let list = FitUnknowns::new(list);
        let (layout, groups) = measurement_unknowns(subject, list.len());
        let first_mark = list.len();
        start.extend(
            (0..layout.sd.len())
                .map(|k| known.map_or(0.0, |known| known.x[known.unknowns.len() + k])),
        );
        priors.extend(groups.into_iter().map(|(group, case)| {
            let prior = tolerance::Coefficient::member(group);
            prior.in_case(case)
        }));
        let first_row = first_mark + layout.sd.len();
        let index = |place: ParameterPosition| match place {
            ParameterPosition::Deck(at) => at,
            ParameterPosition::Row(row) => first_row + row,
        };
        let places = places
            .into_iter()
            .map(|place: Vec<ParameterPosition>| place.into_iter().map(index).collect())
            .collect();
        start.extend(row_starts);
        priors.extend(rows.iter().map(|_| own(0.0, 1.0)));
        Some(Self {
            deck: system.parameters(),
            list,
            layout,
            rows,
            memories,
            places,
            start,
            priors,
        })
    }

    /// Fixes unknowns of the study at the given coordinates, by replacing their priors with very narrow ones. `held` lists the index and the
    /// coordinate of each.
    pub(super) fn hold(&mut self, held: &[(usize, f64)]) {
        for (k, x) in held {
            self.start[*k] = *x;
            self.priors[*k] = own(*x, HELD_UNKNOWN_SD);
        }
    }

    /// Returns true if the model contains any cause.
    pub(super) fn has_causes(&self) -> bool {
        !self.places.is_empty()
    }

    /// Returns true if unknown `k` is the logarithm of a stiffness or of another positive parameter.
    pub(super) fn is_logarithm(&self, k: usize) -> bool {
        matches!(self.list.list()[k].target, UnknownTarget::Stiffness(_))
    }
}

const fn own(mean: f64, sd: f64) -> tolerance::Coefficient {
    tolerance::Coefficient {
        mean,
        sd,
        group: None,
        case: None,
    }
}

/// Returns the unknowns of the measurement: shifts and rotations of the measuring frame in each case, positions of marks on parts, and motions
/// of the frame through the cases. Each unknown comes with its tolerance group, and with its case if it is confined to one. Groups that the
/// study switches off are left out.
fn measurement_unknowns(
    subject: &DiagnosisProblem<'_>,
    first: usize,
) -> (NuisanceLayout, Vec<(EffectGroup, Option<usize>)>) {
    let mut layout = NuisanceLayout::default();
    let mut groups = Vec::new();
    let measurement = subject.problem.measurement;
    let mut count = 0;
    for part in &measurement.parts {
        layout.first_mark.push(count);
        count += part.marks.len();
    }
    if subject.has_frames() && count > 0 {
        layout.frames = Some(first);
        let of_a_case = [[EffectGroup::FrameShifts; 3], [EffectGroup::FrameTurns; 3]];
        for case in 0..measurement.cases.len() {
            let each = of_a_case.as_flattened().iter();
            groups.extend(each.map(|group| (*group, Some(case))));
        }
    }
    if subject.sizes.group(EffectGroup::Marks).is_some() && count > 0 {
        layout.marks = Some(first + groups.len());
        groups.extend(std::iter::repeat_n((EffectGroup::Marks, None), 3 * count));
    }
    let through = motions(subject, &[]);
    if !through.is_empty() && count > 0 {
        let marks = measurement.cases.iter().flat_map(|case| &case.marks);
        let places: Vec<Vec3> = marks.map(|mark| mark.x).collect();
        let first = first + groups.len();
        groups.extend(through.iter().flat_map(|(group, _)| [(*group, None); 6]));
        layout.motions = Some(FrameMotions {
            first,
            centre: centroid(&places),
            turn: ScalePrior::turn_by_shift(subject.millimetre()),
            factors: through.into_iter().map(|(_, factors)| factors).collect(),
        });
    }
    layout.sd = vec![1.0; groups.len()];
    (layout, groups)
}

fn slots(
    pairs: &[(Address, f64)],
    slot: &dyn Fn(&Address) -> Option<Slot>,
) -> Option<Vec<(Slot, f64)>> {
    pairs.iter().map(|(a, f)| Some((slot(a)?, *f))).collect()
}

fn per_case(
    pairs: &[(Address, Vec<f64>)],
    scale: f64,
    slot: &dyn Fn(&Address) -> Option<Slot>,
) -> Option<Vec<(Slot, Vec<f64>)>> {
    let of = |(address, factors): &(Address, Vec<f64>)| {
        let factors = factors.iter().map(|f| f * scale).collect();
        Some((slot(address)?, factors))
    };
    pairs.iter().map(of).collect()
}

fn components(
    addresses: &[Address],
    slot: &dyn Fn(&Address) -> Option<Slot>,
) -> Option<Vec<Component>> {
    let of = |address: &Address| {
        Some(Component {
            stiffness: slot(address)?,
            preload: None,
        })
    };
    addresses.iter().map(of).collect()
}
