//! First-order effects of candidates on all residual rows, computed from the linearised equilibrium (tangent) of each case. No equilibrium
//! is solved again.

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVectorView};
use rayon::prelude::*;

use super::candidate_effect::{EffectParameter, Sensitivity};
use super::operating_points::OperatingPoints;
use admire_identify::global::{
    CaseChanges, CasePrediction, Direction, NuisanceLayout, Observations, StateSensitivities,
    channel_changes,
};
use admire_solver::mechanics::Vec6;
use admire_solver::model::MarkerIx;
use admire_solver::statics::Tangents;
use admire_solver::system::{Parameters, Scratch, Slot, State};
use admire_study::Channel;
use admire_syntax::Address;

/// Responses of all load cases to a list of parameters. They are converted to columns over the residual rows in batches small enough for the
/// processor's cache.
pub(super) struct Responses<'a> {
    observations: Observations<'a>,
    /// Predictions of all cases. For each batch, `by_unknown` of every prediction is replaced by the batch's part of `changes`.
    prediction: Vec<CasePrediction>,
    /// Changes of poses and channels in each case, per unit of each parameter whose effect requires the solver.
    changes: Vec<CaseChanges>,
    /// Number of columns of `changes` that are already converted.
    done: usize,
    /// Parameters that are not yet converted to columns.
    numbers: &'a [&'a EffectParameter],
}

impl Responses<'_> {
    /// Returns the effects of the next `count` parameters on every residual row, one column per parameter, per unit of its prior standard
    /// deviation. An effect is the change of prediction minus reading, in units of the declared noise. A parameter without an effect of its
    /// own gets a column of zeros.
    pub(super) fn columns(&mut self, count: usize) -> DMatrix<f64> {
        let (numbers, rest) = self.numbers.split_at(count);
        self.numbers = rest;
        let asked: Vec<usize> = (0..count).filter(|k| needs_solver(numbers[*k])).collect();
        let mut prediction = Vec::with_capacity(self.prediction.len());
        let range = self.done..self.done + asked.len();
        self.done = range.end;
        for (case, changes) in self.prediction.drain(..).zip(&self.changes) {
            let by_unknown = changes.range(range.clone());
            prediction.push(Some(CasePrediction { by_unknown, ..case }));
        }
        let x = vec![0.0; asked.len()];
        let mut out = DMatrix::zeros(self.observations.rows.len(), count);
        let layout = NuisanceLayout::default();
        let evaluated = self
            .observations
            .evaluate(&prediction, &layout, &x, x.len());
        if let Some(evaluated) = evaluated {
            for (from, &to) in evaluated.jacobian.column_iter().zip(&asked) {
                let sd = numbers[to].sd;
                for (to, from) in out.column_mut(to).iter_mut().zip(from.iter()) {
                    *to = from * sd;
                }
            }
        }
        self.prediction.extend(prediction.into_iter().flatten());
        for (k, number) in numbers.iter().enumerate() {
            if let Sensitivity::Rows(rows) = &number.column {
                for (row, value) in rows {
                    out[(*row, k)] += value * number.sd;
                }
            }
        }
        out
    }
}

/// Returns true for a parameter whose effect requires the solver.
fn needs_solver(number: &EffectParameter) -> bool {
    !matches!(number.column, Sensitivity::Rows(_) | Sensitivity::None)
}

impl<'a> OperatingPoints<'a> {
    /// Returns the effects of these parameters on every residual row; see [`Responses::columns`].
    pub(super) fn columns(&self, numbers: &[&EffectParameter]) -> DMatrix<f64> {
        self.responses(numbers).columns(numbers.len())
    }

    /// Returns the effects of unit forces at sites, and the compliances of the sites. A site is a pair of markers and a component along the axes
    /// of J. There is one matrix of effects per site, over the residual rows; its column `l` holds the effect of a force in case `l` only. The
    /// compliance of a site in a case is the change of its displacement by a unit force there.
    pub(super) fn unit_force_effects(
        &self,
        sites: &[((MarkerIx, MarkerIx), usize)],
    ) -> (Vec<DMatrix<f64>>, Vec<Vec<f64>>) {
        let cases = self.cases();
        // If every row belongs to one case, a force in all cases at once gives the effects of the forces in all single cases.
        let channels = &self.measurement.channels;
        let is_split = channels.iter().all(Channel::is_of_single_cases);
        let acting = |(pair, axis): &((MarkerIx, MarkerIx), usize),
                      is_on: &dyn Fn(usize) -> bool| {
            let force = |case| f64::from(u8::from(is_on(case)));
            let wrench = (0..cases).map(|case| Vec6::ith(*axis, force(case)));
            EffectParameter::linear("force", 1.0, Sensitivity::Wrench(*pair, wrench.collect()))
        };
        let in_one = |site| (0..cases).map(move |own| acting(site, &|case| case == own));
        let numbers: Vec<EffectParameter> = if is_split {
            sites.iter().map(|site| acting(site, &|_| true)).collect()
        } else {
            sites.iter().flat_map(in_one).collect()
        };
        let columns = self.columns(&numbers.iter().collect::<Vec<_>>());
        let split = |column: DVectorView<'_, f64>| {
            let mut out = DMatrix::zeros(column.len(), cases);
            for (k, (row, value)) in self.rows().iter().zip(column.iter()).enumerate() {
                out[(k, row.case())] = *value;
            }
            out
        };
        let effects: Vec<DMatrix<f64>> = if is_split {
            columns.column_iter().map(split).collect()
        } else {
            let of_site = |k: usize| columns.columns(k * cases, cases).into_owned();
            (0..sites.len()).map(of_site).collect()
        };
        let system = &self.fitted.deck.prepared.system;
        let mut known = Tangents::new(system);
        if let (Some(theta), Some(state)) = (self.fitted.thetas.first(), self.fitted.states.first())
        {
            let _ = known.at(system, theta, state);
        }
        let of_case = |scratch: &mut Scratch, case: usize| -> Vec<f64> {
            let (theta, state) = (&self.fitted.thetas[case], &self.fitted.states[case]);
            let mut tangents = known.clone();
            let Ok(tangent) = tangents.at(system, theta, state) else {
                return vec![0.0; sites.len()];
            };
            let one = |(pair, axis): &((MarkerIx, MarkerIx), usize)| {
                let wrench = Vec6::ith(*axis, 1.0);
                // The column of a unit force holds the derivatives of the displacement, by the principle of virtual work.
                let by_pose = system.unit_wrench_column(theta, state, scratch, *pair, &wrench);
                let mut change = by_pose.clone();
                tangent.respond(&mut change);
                by_pose.iter().zip(&change).map(|(a, b)| a * b).sum()
            };
            sites.iter().map(one).collect()
        };
        let by_case: Vec<Vec<f64>> = (0..cases)
            .into_par_iter()
            .map_init(|| Scratch::new(system), of_case)
            .collect();
        let compliance = (0..sites.len()).map(|k| by_case.iter().map(|case| case[k]).collect());
        (effects, compliance.collect())
    }

    /// Computes the responses of all cases to these parameters.
    pub(super) fn responses<'b>(&self, numbers: &'b [&'b EffectParameter]) -> Responses<'b>
    where
        'a: 'b,
    {
        let system = &self.fitted.deck.prepared.system;
        let catalogue = system.catalogue();
        let slot = |address: &Address| catalogue.slot(address);
        let asked: Vec<usize> = (0..numbers.len())
            .filter(|k| needs_solver(numbers[*k]))
            .collect();
        let direction = |k: &usize| {
            let mut direction = Direction::default();
            match &numbers[*k].column {
                Sensitivity::Always(pairs) => direction
                    .always
                    .extend(pairs.iter().filter_map(|(a, f)| Some((slot(a)?, *f)))),
                Sensitivity::PerCase(pairs) => direction.per_case.extend(
                    pairs
                        .iter()
                        .filter_map(|(a, f)| Some((slot(a)?, f.clone()))),
                ),
                Sensitivity::Wrench(..) | Sensitivity::Rows(_) | Sensitivity::None => {}
            }
            direction
        };
        let directions: Vec<Direction> = asked.iter().map(direction).collect();
        let cases: Vec<usize> = (0..self.cases()).collect();
        let observations = Observations::new(self.measurement, self.subject.problem.model, &cases);
        // All cases use the elimination order of the first case, so that results do not depend on the thread.
        let mut known = Tangents::new(system);
        if let (Some(theta), Some(state)) = (self.fitted.thetas.first(), self.fitted.states.first())
        {
            let _ = known.at(system, theta, state);
        }
        let found: Vec<_> = cases
            .par_iter()
            .map_init(
                || Scratch::new(system),
                |scratch, &case| {
                    let at = (&self.fitted.thetas[case], &self.fitted.states[case]);
                    let tools = (&mut *scratch, known.clone());
                    let found = self.changes(case, at, tools, (&asked, &directions), numbers);
                    let channels = self.fitted.deck.prepared.channels;
                    let observed = &observations.observed;
                    let [changes, free] =
                        found.map(|of| observed.changes(system, at.1, &of.0, &of.1));
                    let here = CasePrediction {
                        poses: at.1.poses.clone(),
                        channels: channels
                            .values(system, at.0, at.1, scratch)
                            .unwrap_or_default(),
                        by_unknown: CaseChanges::default(),
                        free,
                    };
                    (here, changes)
                },
            )
            .collect();
        let (prediction, changes) = found.into_iter().unzip();
        Responses {
            observations,
            prediction,
            changes,
            done: 0,
            numbers,
        }
    }

    /// Returns two pairs of matrices for one case: changes of the system's unknowns, and changes of the channels, one column per direction.
    /// The first pair is for the directions of the parameters, the second for the zero-stiffness motions.
    fn changes(
        &self,
        case: usize,
        (theta, state): (&Parameters, &State),
        (scratch, mut tangents): (&mut Scratch, Tangents),
        (asked, directions): (&[usize], &[Direction]),
        numbers: &[&EffectParameter],
    ) -> [(DMatrix<f64>, DMatrix<f64>); 2] {
        let system = &self.fitted.deck.prepared.system;
        let n = system.unknowns();
        let channels = self.fitted.deck.prepared.channels;
        let nothing = |count: usize| {
            let measured = self.measurement.channels.len();
            (DMatrix::zeros(n, count), DMatrix::zeros(measured, count))
        };
        let Ok(tangent) = tangents.at(system, theta, state) else {
            return [nothing(asked.len()), nothing(0)];
        };
        let motions = tangent.free_motions(system);
        let held = vec![Direction::default(); motions.len()];
        let motions = DMatrix::from_iterator(n, motions.len(), motions.into_iter().flatten());
        let along = StateSensitivities {
            directions: &held,
            responses: &motions,
        };
        let free = match channel_changes(channels, system, theta, case, state, scratch, along) {
            Ok(changed) => (motions, changed),
            Err(_) => nothing(0),
        };
        let mut by_slot = vec![0.0; n];
        let (mut known, mut columns) = (BTreeMap::<Slot, usize>::new(), Vec::<f64>::new());
        // Responses to unit forces along the components of a marker pair. All wrenches between the two markers share them.
        let mut units: BTreeMap<(usize, usize, usize), Vec<f64>> = BTreeMap::new();
        let mut responses = DMatrix::zeros(n, asked.len());
        let mut open: Vec<usize> = Vec::new();
        for (at, (k, direction)) in asked.iter().zip(directions).enumerate() {
            let mut dg = responses.column_mut(at);
            if let Sensitivity::Wrench(pair, wrenches) = &numbers[*k].column {
                for (axis, size) in wrenches[case].iter().enumerate() {
                    if *size == 0.0 {
                        continue;
                    }
                    let unit = units.entry((pair.0.0, pair.1.0, axis)).or_insert_with(|| {
                        let wrench = admire_solver::mechanics::Vec6::ith(axis, 1.0);
                        let mut dg =
                            system.unit_wrench_column(theta, state, scratch, *pair, &wrench);
                        tangent.respond(&mut dg);
                        dg
                    });
                    for (sum, value) in dg.iter_mut().zip(unit.iter()) {
                        *sum += size * value;
                    }
                }
                continue;
            }
            for (slot, weight) in direction.in_case(case).filter(|(_, weight)| *weight != 0.0) {
                let from = *known.entry(slot).or_insert_with(|| {
                    let done = system.residual_by_slot(theta, state, scratch, slot, &mut by_slot);
                    if done.is_err() {
                        by_slot.fill(0.0);
                    }
                    columns.extend_from_slice(&by_slot);
                    columns.len() - n
                });
                for (sum, value) in dg.iter_mut().zip(&columns[from..]) {
                    *sum += weight * value;
                }
            }
            open.push(at);
        }
        let mut changes = responses.select_columns(&open);
        tangent.respond_to_all(changes.as_mut_slice());
        for (at, response) in open.into_iter().zip(changes.column_iter()) {
            responses.set_column(at, &response);
        }
        let along = StateSensitivities {
            directions,
            responses: &responses,
        };
        match channel_changes(channels, system, theta, case, state, scratch, along) {
            Ok(changed) => [(responses, changed), free],
            Err(_) => [nothing(asked.len()), free],
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base_fit::tests::{axle_problem, shipped_axle};
    use crate::candidate_effect::{CandidateEffect, Term};
    use crate::causes::{self, bushing_coupling, dry_friction};
    use crate::diagnosis_problem::{Data, DiagnosisProblem};
    use crate::elastic_element::bushing_stiffness;
    use crate::fit::{FittedModel, fit, with_zero_guesses};
    use crate::site::Sites;

    /// Compares the first-order columns of the last effect of a fit with the Jacobian columns of the fit. The deck of the fit contains that
    /// effect.
    fn compare(subject: &DiagnosisProblem<'_>, fitted: &FittedModel) {
        let at = fitted.effects.len() - 1;
        let own = &fitted.effects[at];
        let survey = OperatingPoints::new(subject, fitted);
        let here = match own.term {
            Term::Asymmetry => own.clone(),
            _ => bushing_coupling::growth(&survey, own).expect("it is deflected"),
        };
        let columns = survey.columns(&here.numbers.iter().collect::<Vec<_>>());
        for (k, column) in columns.column_iter().enumerate() {
            let scale = here.numbers[k].sd / own.numbers[k].sd;
            let exact = fitted.jacobian.column(fitted.parameter_index[at][k]) * scale;
            let off = (&exact - column).norm() / exact.norm();
            // The Jacobian of the fit was computed before its last Gauss-Newton step.
            assert!(off < 1e-3, "{own} {}: {off:e}", own.numbers[k].name);
        }
    }

    /// Checks that the first-order effect of a further term equals the derivative with respect to its parameters in the extended deck.
    #[test]
    fn a_further_part_does_what_its_numbers_in_the_deck_do() {
        let loaded = shipped_axle();
        let problem = loaded.problem();
        let (subject, none) = axle_problem(&problem);
        let with = |base: &FittedModel, h: &CandidateEffect| {
            let mut chosen = with_zero_guesses(base);
            chosen.push((h.clone(), vec![0.05; h.numbers.len()]));
            fit(&subject, &chosen, Some((base, &base.x)), Data::All)
        };
        let survey = OperatingPoints::new(&subject, &none);
        let candidates = causes::candidates(&survey, &none);
        let growing = candidates.iter().filter(|h| h.joint_with.is_some());
        // Each candidate requires a fit. A fit fails if an iterate has no equilibrium.
        let fitted = growing.step_by(5).filter_map(|h| with(&none, h));
        let compared = fitted.map(|fitted| compare(&subject, &fitted)).count();
        assert!(compared > 4, "{compared}");
        let sites = Sites::new(&survey);
        let frictions = dry_friction::scanned(&survey, &sites);
        let friction = frictions.iter().find(|(h, _)| h.address == "BUSHING/2.K.1");
        let (friction, _) = friction.expect("a site");
        let fitted = with(&none, friction).expect("it can be solved");
        let parts = dry_friction::by_direction(&OperatingPoints::new(&subject, &fitted));
        assert_eq!(parts.len(), 1);
        let fitted = with(&fitted, &parts[0]).expect("it can be solved");
        compare(&subject, &fitted);
    }

    /// Checks that a force in all cases at once gives the same effects as one force in each case. Other elements also hold the part, so the
    /// compliance of a site is smaller than the compliance of its bushing alone.
    #[test]
    fn unit_forces_act_case_by_case() {
        let loaded = shipped_axle();
        let problem = loaded.problem();
        let (subject, none) = axle_problem(&problem);
        let survey = OperatingPoints::new(&subject, &none);
        let sites = crate::site::Sites::new(&survey);
        assert!(sites.all.len() > 10);
        let cases = survey.cases();
        for (site, effect) in sites.all.iter().zip(&sites.effects).step_by(5) {
            let one = |own: usize| {
                let force = |case| Vec6::ith(site.axis, f64::from(u8::from(case == own)));
                let wrench = Sensitivity::Wrench(site.pair, (0..cases).map(force).collect());
                EffectParameter::linear("force", 1.0, wrench)
            };
            let each: Vec<EffectParameter> = (0..cases).map(one).collect();
            let expected = survey.columns(&each.iter().collect::<Vec<_>>());
            let apart = (effect - &expected).amax();
            assert!(
                apart < 1e-12 * expected.amax(),
                "{}: {apart:e}",
                site.address
            );
        }
        for (k, bushing) in survey.model.bushings.iter().enumerate() {
            let stiffness = bushing_stiffness(&survey, k);
            let own = format!("BUSHING/{}.", bushing.header.id);
            let here = sites.all.iter().zip(&sites.compliance);
            for (site, compliance) in here.filter(|(site, _)| site.address.starts_with(&own)) {
                let alone = 1.0 / stiffness[site.axis];
                // The geometric stiffness of the loads adds up to a tenth.
                let is_within = |c: &f64| *c > 0.0 && *c < 1.15 * alone;
                assert!(
                    compliance.iter().all(is_within),
                    "{} {alone:e} {compliance:?}",
                    site.address
                );
            }
        }
    }
}
