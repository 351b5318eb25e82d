//! The unknowns of an extended fit: those of the deck, of the measurement, and those that only act on rows.

use super::extended::Warm;
use super::hypothesis::{Column, Hypothesis, Turn, Unknown};
use super::subject::Subject;
use crate::identify::Problem;
use crate::identify::global::gauss_newton::Prior;
use crate::identify::global::{
    Component, FitUnknown, FitUnknowns, Meaning, Memory, NuisanceLayout, Prepared, fit_unknowns,
};
use crate::syntax::Address;
use crate::system::{Parameters, Slot};

/// Columns that act on rows directly.
pub(super) type RowColumn = Vec<(usize, f64)>;

/// Unknowns of an extended fit: those of the deck, of the measurement, and those that only act on rows.
pub(super) struct Setup {
    pub(super) deck: Parameters,
    pub(super) unknowns: FitUnknowns,
    pub(super) layout: NuisanceLayout,
    pub(super) rows: Vec<RowColumn>,
    pub(super) turns: Vec<(usize, Turn, [[Slot; 3]; 2])>,
    pub(super) memories: Vec<Memory>,
    pub(super) places: Vec<Vec<usize>>,
    pub(super) start: Vec<f64>,
    pub(super) priors: Vec<Prior>,
    pub(super) scale: Vec<f64>,
}

impl Setup {
    pub(super) fn new(
        (subject, problem): (&Subject<'_>, &Problem<'_>),
        prepared: &Prepared,
        chosen: &[(Hypothesis, Vec<f64>)],
        warm: Option<Warm<'_>>,
    ) -> Option<Self> {
        let at_warm = warm.map(|warm| warm.x());
        let warm = warm.map(|warm| warm.fitted);
        let system = &prepared.system;
        let mut list = fit_unknowns(problem, system, None).list().to_vec();
        list.retain(|unknown| match unknown.meaning {
            Meaning::Offset(component) => {
                let id = system.catalogue().info(component.stiffness).address.id;
                !subject.offsets_in_question.iter().any(|of| Some(*of) == id)
            }
            _ => true,
        });
        // What another fit says of the same unknown, whatever else was in it.
        let same = |a: &FitUnknown, b: &FitUnknown| {
            a.addresses == b.addresses
                && std::mem::discriminant(&a.meaning) == std::mem::discriminant(&b.meaning)
        };
        let of_warm = |unknown: &FitUnknown| {
            let (warm, x) = warm.zip(at_warm.as_ref())?;
            let list = warm.unknowns.list();
            let at = list.iter().position(|other| same(other, unknown))?;
            Some(x[at])
        };
        let mut start: Vec<f64> = list
            .iter()
            .map(|unknown| of_warm(unknown).unwrap_or(unknown.start))
            .collect();
        let slot = |address: &Address| system.catalogue().slot(address);
        let (mut rows, mut turns, mut memories) = (Vec::new(), Vec::new(), Vec::new());
        let (mut row_starts, mut places) = (Vec::new(), Vec::new());
        for (hypothesis, guesses) in chosen {
            let known = warm.zip(at_warm.as_ref()).and_then(|(warm, x)| {
                let at = warm.chosen.iter().position(|h| h.same(hypothesis))?;
                Some(warm.places[at].iter().map(|k| x[*k]).collect::<Vec<_>>())
            });
            if let Some(plan) = &hypothesis.memory {
                memories.push(Memory {
                    anchor: slot(&plan.anchor)?,
                    length: slot(&plan.length)?,
                    channel: problem.measurement.channels.len() + memories.len(),
                });
            }
            let mut place = Vec::new();
            for (k, number) in hypothesis.numbers.iter().enumerate() {
                let (mut mean, mut sd) = (number.mean / number.sd, 1.0);
                let mut guess = known.as_ref().map_or(guesses[k] + mean, |known| known[k]);
                let scaled = |pairs: &[(Address, f64)]| {
                    let scale = |(address, factor): &(Address, f64)| {
                        Some((slot(address)?, factor * number.sd))
                    };
                    pairs.iter().map(scale).collect::<Option<Vec<_>>>()
                };
                let meaning = match (&number.unknown, &number.column) {
                    (Unknown::Linear, Column::Rows(column)) => {
                        let column = column.iter().map(|(at, v)| (*at, v * number.sd));
                        place.push(usize::MAX - rows.len());
                        rows.push(column.collect::<RowColumn>());
                        row_starts.push(guess);
                        continue;
                    }
                    (Unknown::Linear, Column::Always(pairs)) | (Unknown::Extended(pairs), _) => {
                        let scaled = scaled(pairs)?;
                        // What the study drives is set anew in every case; the error comes on top each time.
                        let driven = |address: &Address| {
                            let loads = &problem.programme.loads;
                            loads.iter().any(|load| load.target == *address)
                        };
                        if pairs.iter().any(|(address, _)| driven(address)) {
                            let cases = problem.programme.cases.len();
                            let every = |(slot, factor)| (slot, vec![factor; cases]);
                            Meaning::PerCase(scaled.into_iter().map(every).collect())
                        } else {
                            Meaning::Number(scaled)
                        }
                    }
                    (Unknown::Linear, Column::PerCase(pairs)) => {
                        let mut factors = Vec::new();
                        for (address, values) in pairs {
                            let values = values.iter().map(|v| v * number.sd).collect();
                            factors.push((slot(address)?, values));
                        }
                        Meaning::PerCase(factors)
                    }
                    // A wrench is no number of a deck.
                    (Unknown::Linear, Column::Wrench(..)) => return None,
                    (Unknown::Compliance(addresses), _) => {
                        let components = addresses
                            .iter()
                            .map(|address| {
                                Some(Component {
                                    stiffness: slot(address)?,
                                    preload: None,
                                })
                            })
                            .collect::<Option<Vec<_>>>()?;
                        if known.is_none() {
                            guess = -(guess.max(1e-3) * number.sd).ln();
                        }
                        (mean, sd) = (-number.sd.ln(), 2.0);
                        Meaning::Stiffness(components)
                    }
                    (Unknown::Turn(turn), _) => {
                        let of = |k: usize| {
                            let word = |i| {
                                super::hypothesis::number(
                                    "MARKER",
                                    turn.markers[k].1,
                                    "REULER",
                                    Some(i),
                                )
                            };
                            Some([slot(&word(1))?, slot(&word(2))?, slot(&word(3))?])
                        };
                        turns.push((list.len(), turn.clone(), [of(0)?, of(1)?]));
                        Meaning::Number(Vec::new())
                    }
                    (Unknown::Offset { stiffness, preload }, _) => {
                        let meaning = Meaning::Offset(Component {
                            stiffness: slot(stiffness)?,
                            preload: Some(slot(preload)?),
                        });
                        // It may have been a nuisance so far.
                        let unknown = FitUnknown {
                            addresses: vec![stiffness.clone()],
                            meaning,
                            start: 0.0,
                            mean: 0.0,
                            sd: number.sd,
                        };
                        place.push(list.len());
                        start.push(of_warm(&unknown).unwrap_or(guess * number.sd));
                        list.push(unknown);
                        continue;
                    }
                    (
                        Unknown::SlipLength {
                            address,
                            start,
                            usual,
                        },
                        _,
                    ) => {
                        if known.is_none() {
                            guess = start.ln();
                        }
                        (mean, sd) = (usual.ln(), number.sd);
                        Meaning::Stiffness(vec![Component {
                            stiffness: slot(address)?,
                            preload: None,
                        }])
                    }
                };
                place.push(list.len());
                start.push(guess);
                list.push(FitUnknown {
                    addresses: Vec::new(),
                    meaning,
                    start: guess,
                    mean,
                    sd,
                });
            }
            places.push(place);
        }
        let unknowns = FitUnknowns::new(list);
        let frame = problem.settings.frame_sd;
        let frame = (frame.length, frame.angle_deg.to_radians());
        let layout = NuisanceLayout::new(problem.measurement, unknowns.len(), frame);
        match warm.zip(at_warm.as_ref()) {
            Some((warm, x)) => {
                let first = warm.unknowns.len();
                start.extend_from_slice(&x[first..first + layout.sd.len()]);
            }
            None => start.resize(unknowns.len() + layout.sd.len(), 0.0),
        }
        let first_row = start.len();
        for at in places
            .iter_mut()
            .flatten()
            .filter(|at| **at > usize::MAX / 2)
        {
            *at = first_row + (usize::MAX - *at);
        }
        start.extend(row_starts);
        let prior = |mean, sd| Prior { mean, sd };
        let mut priors: Vec<Prior> = unknowns
            .list()
            .iter()
            .map(|u| prior(u.mean, u.sd))
            .collect();
        priors.extend(layout.sd.iter().map(|sd| prior(0.0, *sd)));
        priors.extend(rows.iter().map(|_| prior(0.0, 1.0)));
        let scale = priors.iter().map(|p| p.sd.min(1.0)).collect();
        Some(Self {
            deck: system.parameters(),
            unknowns,
            layout,
            rows,
            turns,
            memories,
            places,
            start,
            priors,
            scale,
        })
    }
}
