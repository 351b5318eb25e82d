//! The unknowns of a fit with their priors: stiffnesses, tolerances, numbers of causes, frames and places of marks, and what acts on rows
//! alone.

use super::diagnosis_problem::DiagnosisProblem;
use super::frame::{centroid, motions};
use super::hypothesis::{Hypothesis, Parametrisation, Sensitivity};
use admire_identify::global::{
    Component, FitUnknown, FitUnknowns, FrameMotions, HysteresisState, NuisanceLayout, Prepared,
    Target, fit_unknowns,
};
use admire_identify::tolerance::{Effect, EffectGroup, Size};
use admire_identify::{Problem, tolerance};
use admire_solver::mechanics::Vec3;
use admire_solver::system::{Parameters, Slot};
use admire_syntax::Address;

/// What another fit found.
#[derive(Clone, Copy)]
pub struct Known<'a> {
    /// Its unknowns of the deck.
    pub unknowns: &'a FitUnknowns,
    /// What was in it.
    pub chosen: &'a [Hypothesis],
    /// Where.
    pub places: &'a [Vec<usize>],
    /// Values of all unknowns.
    pub x: &'a [f64],
}

/// What an unknown that acts on rows directly adds to each of them.
pub enum RowColumn {
    /// So much per unit.
    Fixed(Vec<(usize, f64)>),
    /// A factor on the prediction: 1 plus the unknown times this unit. With each row stands its reading in units of its noise.
    Gain(f64, Vec<(usize, f64)>),
}

/// Unknowns of a fit.
pub struct Unknowns {
    /// The deck's numbers as they were.
    pub deck: Parameters,
    /// Stiffnesses, members of the layer in its order, numbers of causes.
    pub list: FitUnknowns,
    /// Unknowns of the measurement.
    pub layout: NuisanceLayout,
    /// Columns that act on rows directly.
    pub rows: Vec<RowColumn>,
    /// Contacts that remember.
    pub memories: Vec<HysteresisState>,
    /// Where each number of each hypothesis is.
    pub places: Vec<Vec<usize>>,
    /// Where the fit starts.
    pub start: Vec<f64>,
    /// Priors of all.
    pub priors: Vec<tolerance::Coefficient>,
}

impl Unknowns {
    /// Stiffnesses and numbers of causes, small errors left out: their places among the unknowns of the deck in ascending order.
    pub(super) fn of_the_model(&self) -> Vec<usize> {
        let of_a_cause = |k: &usize| self.places.iter().flatten().any(|at| at == k);
        let is_own = |k: &usize| self.priors[*k].group.is_none() || of_a_cause(k);
        (0..self.list.len()).filter(is_own).collect()
    }

    /// Of a deck extended by `chosen`, whose guesses are in units of their priors.
    pub fn new(
        (subject, problem): (&DiagnosisProblem<'_>, &Problem<'_>),
        prepared: &Prepared,
        chosen: &[(Hypothesis, Vec<f64>)],
        known: Option<Known<'_>>,
    ) -> Option<Self> {
        let system = &prepared.system;
        let slot = |address: &Address| system.catalogue().slot(address);
        let mut list = fit_unknowns(problem, system, None).list().to_vec();
        list.retain(|unknown| !matches!(unknown.target, Target::Offset(_)));
        let mut priors: Vec<tolerance::Coefficient> = list
            .iter()
            .map(|unknown| own(unknown.mean, unknown.sd))
            .collect();
        let stiffnesses = list.len();
        for member in &subject.layer.members {
            let meaning = match &member.effect {
                Effect::Always(pairs) => Target::Number(slots(pairs, &slot).unwrap_or_default()),
                Effect::PerCase(pairs) => {
                    Target::PerCase(per_case(pairs, 1.0, &slot).unwrap_or_default())
                }
                Effect::Turn(markers) => Target::Turn(markers.clone()),
                Effect::Offset { bushing, axis } => {
                    let id = problem.model.bushings[*bushing].header.id;
                    let of = |word| super::hypothesis::number("BUSHING", id, word, Some(axis + 1));
                    Target::Offset(Component {
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
            });
            priors.push(tolerance::Coefficient::member(member.group));
        }
        let members = list.len();
        // What another fit says of the same unknown: stiffnesses and members are the same everywhere.
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
                        place.push(at);
                        continue;
                    }
                    (Parametrisation::Linear, Sensitivity::Rows(column)) => {
                        let column = column.iter().map(|(at, v)| (*at, v * number.sd));
                        place.push(usize::MAX - rows.len());
                        rows.push(RowColumn::Fixed(column.collect()));
                        row_starts.push(guess);
                        continue;
                    }
                    (Parametrisation::Gain(readings), _) => {
                        place.push(usize::MAX - rows.len());
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
                        Target::Number(slots(&scaled, &slot)?)
                    }
                    (Parametrisation::Linear, Sensitivity::PerCase(pairs)) => {
                        Target::PerCase(per_case(pairs, number.sd, &slot)?)
                    }
                    // A wrench is no number of a deck.
                    (Parametrisation::Linear, Sensitivity::Wrench(..) | Sensitivity::None) => {
                        return None;
                    }
                    (Parametrisation::Compliance(addresses), _) => {
                        if before.is_none() {
                            guess = -libm::log(guess.max(1e-3) * number.sd);
                        }
                        (mean, sd) = (-libm::log(number.sd), 2.0);
                        Target::Stiffness(components(addresses, &slot)?)
                    }
                    (Parametrisation::Rate { address, usual }, _) => {
                        if before.is_none() {
                            guess = libm::log(*usual);
                        }
                        (mean, sd) = (libm::log(*usual), number.sd);
                        Target::Stiffness(components(std::slice::from_ref(address), &slot)?)
                    }
                    (Parametrisation::Offset { stiffness, preload }, _) => {
                        if before.is_none() {
                            guess *= number.sd;
                        }
                        sd = number.sd;
                        Target::Offset(Component {
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
                        Target::Stiffness(components(std::slice::from_ref(address), &slot)?)
                    }
                };
                place.push(list.len());
                start.push(guess);
                priors.push(own(mean, sd));
                list.push(FitUnknown {
                    addresses: Vec::new(),
                    target: meaning,
                    start: guess,
                    mean,
                    sd,
                });
            }
            places.push(place);
        }
        let list = FitUnknowns::new(list);
        let (layout, groups) = of_the_measurement(subject, list.len());
        let first_mark = list.len();
        start.extend(
            (0..layout.sd.len())
                .map(|k| known.map_or(0.0, |known| known.x[known.unknowns.len() + k])),
        );
        priors.extend(groups.into_iter().map(tolerance::Coefficient::member));
        let first_row = first_mark + layout.sd.len();
        for at in places
            .iter_mut()
            .flatten()
            .filter(|at| **at > usize::MAX / 2)
        {
            *at = first_row + (usize::MAX - *at);
        }
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

    /// True of a model with causes.
    pub(super) fn has_causes(&self) -> bool {
        !self.places.is_empty()
    }

    /// True for the logarithm of a stiffness.
    pub(super) fn is_logarithm(&self, k: usize) -> bool {
        matches!(self.list.list()[k].target, Target::Stiffness(_))
    }
}

const fn own(mean: f64, sd: f64) -> tolerance::Coefficient {
    tolerance::Coefficient {
        mean,
        sd,
        group: None,
    }
}

/// Shifts and turns of the frame where they are looked for, and places of marks on their parts, unless the user says they are exact;
/// with the group of each.
fn of_the_measurement(
    subject: &DiagnosisProblem<'_>,
    first: usize,
) -> (NuisanceLayout, Vec<EffectGroup>) {
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
        for _ in &measurement.cases {
            groups.extend(of_a_case.as_flattened());
        }
    }
    if subject.sizes.group(EffectGroup::Marks).is_some() && count > 0 {
        layout.marks = Some(first + groups.len());
        groups.extend(std::iter::repeat_n(EffectGroup::Marks, 3 * count));
    }
    let through = motions(subject, &[]);
    if !through.is_empty() && count > 0 {
        let marks = measurement.cases.iter().flat_map(|case| &case.marks);
        let places: Vec<Vec3> = marks.map(|mark| mark.x).collect();
        let first = first + groups.len();
        groups.extend(through.iter().flat_map(|(group, _)| [*group; 6]));
        layout.motions = Some(FrameMotions {
            first,
            centre: centroid(&places),
            turn: Size::turn_by_shift(subject.millimetre()),
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
