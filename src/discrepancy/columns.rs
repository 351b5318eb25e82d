//! First-order effects of hypotheses on all rows, from the sensitivities at hand.

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::hypothesis::{Column, Hypothesis, Number};
use super::survey::Survey;
use crate::identify::global::{
    CaseChange, CasePrediction, Direction, NuisanceLayout, Observations,
};
use crate::model::PartIx;
use crate::statics::Tangent;
use crate::syntax::Address;
use crate::system::{Parameters, Scratch, Slot, State, System};

/// Where the column of a number is.
#[derive(Clone, PartialEq, Debug)]
pub enum ColumnOf {
    /// A column of [`Columns::solved`].
    Solved(usize),
    /// Some rows only.
    Rows(Vec<(usize, f64)>),
}

/// First-order effects of numbers on all rows.
#[derive(Clone, PartialEq, Debug)]
pub struct Columns {
    /// Those the solver has answered.
    pub solved: DMatrix<f64>,
    /// One per number, in order.
    pub of: Vec<ColumnOf>,
}

impl Survey<'_> {
    /// Effect of every number of these hypotheses on every row, per unit of its prior standard deviation.
    pub fn columns(&self, hypotheses: &[Hypothesis]) -> Columns {
        let numbers: Vec<_> = hypotheses.iter().flat_map(|h| &h.numbers).collect();
        let system = &self.fitted.deck.prepared.system;
        let catalogue = system.catalogue();
        let slot = |address: &Address| catalogue.slot(address);
        // Only what the solver has to answer.
        let asked: Vec<usize> = (0..numbers.len())
            .filter(|k| !matches!(numbers[*k].column, Column::Rows(_)))
            .collect();
        let directions: Vec<Direction> = asked
            .iter()
            .map(|k| {
                let mut direction = Direction::default();
                match &numbers[*k].column {
                    Column::Always(pairs) => direction
                        .always
                        .extend(pairs.iter().filter_map(|(a, f)| Some((slot(a)?, *f)))),
                    Column::PerCase(pairs) => direction.per_case.extend(
                        pairs
                            .iter()
                            .filter_map(|(a, f)| Some((slot(a)?, f.clone()))),
                    ),
                    Column::Wrench(..) | Column::Rows(_) => {}
                }
                direction
            })
            .collect();
        let cases: Vec<usize> = (0..self.cases()).collect();
        let observations = Observations::new(self.measurement, self.subject.problem.model, &cases);
        let prediction: Vec<_> = cases
            .par_iter()
            .map_init(
                || Scratch::new(system),
                |scratch, &case| {
                    let at = (&self.fitted.thetas[case], &self.fitted.states[case]);
                    let changes = self.changes(case, at, scratch, (&asked, &directions), &numbers);
                    let channels = self.fitted.deck.prepared.channels;
                    Some(CasePrediction {
                        poses: at.1.poses.clone(),
                        channels: channels
                            .values(system, at.0, at.1, scratch)
                            .unwrap_or_default(),
                        by_unknown: changes
                            .into_iter()
                            .map(|six| share(system, &observations, six))
                            .collect(),
                    })
                },
            )
            .collect();
        let x = vec![0.0; asked.len()];
        let evaluated = observations.evaluate(&prediction, &NuisanceLayout::default(), &x, true);
        let mut solved = match evaluated {
            Some(evaluated) => evaluated.jacobian,
            None => DMatrix::zeros(self.subject.rows.len(), asked.len()),
        };
        for (mut column, &of) in solved.column_iter_mut().zip(&asked) {
            column *= numbers[of].sd;
        }
        if let Some(background) = &self.fitted.background {
            background.whiten_columns(&mut solved);
        }
        let mut next = 0;
        let of = |number: &&Number| {
            if let Column::Rows(rows) = &number.column {
                let scaled = rows.iter().map(|(row, v)| (*row, v * number.sd));
                return ColumnOf::Rows(scaled.collect());
            }
            next += 1;
            ColumnOf::Solved(next - 1)
        };
        Columns {
            of: numbers.iter().map(of).collect(),
            solved,
        }
    }

    /// How the system's unknowns and the channels of a case change along each direction.
    fn changes(
        &self,
        case: usize,
        (theta, state): (&Parameters, &State),
        scratch: &mut Scratch,
        (asked, directions): (&[usize], &[Direction]),
        numbers: &[&Number],
    ) -> Vec<(Vec<f64>, Vec<f64>)> {
        let system = &self.fitted.deck.prepared.system;
        let n = system.unknowns();
        let zero = || vec![(vec![0.0; n], vec![0.0; self.measurement.channels.len()]); asked.len()];
        let Ok(mut tangent) = Tangent::new(system, theta, state) else {
            return zero();
        };
        let mut by_slot = vec![0.0; n];
        let mut known: std::collections::BTreeMap<Slot, Vec<f64>> =
            std::collections::BTreeMap::new();
        let mut responses = Vec::with_capacity(asked.len());
        for (k, direction) in asked.iter().zip(directions) {
            let mut dg = vec![0.0; n];
            if let Column::Wrench(pair, wrenches) = &numbers[*k].column {
                dg = system.unit_wrench_column(theta, state, scratch, *pair, &wrenches[case]);
            }
            for (slot, weight) in direction.in_case(case).filter(|(_, weight)| *weight != 0.0) {
                let column = known.entry(slot).or_insert_with(|| {
                    let done = system.residual_by_slot(theta, state, scratch, slot, &mut by_slot);
                    if done.is_err() {
                        by_slot.fill(0.0);
                    }
                    by_slot.clone()
                });
                for (sum, value) in dg.iter_mut().zip(column.iter()) {
                    *sum += weight * value;
                }
            }
            tangent.respond(&mut dg);
            responses.push(dg);
        }
        let channels = self.fitted.deck.prepared.channels;
        let along = (directions, responses.as_slice());
        let Ok(changed) = channels.changes(system, (theta, case), state, scratch, along) else {
            return zero();
        };
        responses.into_iter().zip(changed).collect()
    }
}

/// The observed parts' share of a change.
fn share(
    system: &System,
    observations: &Observations<'_>,
    (dx, channels): (Vec<f64>, Vec<f64>),
) -> CaseChange {
    let six = |part: &PartIx| {
        let mut six = [0.0; 6];
        for (to, from) in six.iter_mut().zip(&dx[system.part_unknowns(*part)]) {
            *to = *from;
        }
        six
    };
    CaseChange {
        parts: observations.observed.parts.iter().map(six).collect(),
        channels,
    }
}
