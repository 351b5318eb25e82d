//! What a rig may do besides: hold loads not exactly, measure from a frame that does not stay, yield under the loads. Where the readings
//! ask for these errors, the search is made again with them among the tolerances.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::diagnosis_problem::DiagnosisProblem;
use super::fit::FittedModel;
use super::frame::{by_frame, motions, varying};
use admire_identify::tolerance::{
    EffectGroup, Posterior, ScalePrior, VarianceComponents, applied_loads, transposed,
};
use admire_solver::mechanics::Vec3;
use admire_solver::mechanics::eigen::symmetric_eigen;
use admire_study::PriorSetting;

/// They have to make the readings more probable by so many nats.
pub(super) const ASKED: f64 = 5.0;
/// They may stand in the place of a force of an unknown law that makes the readings more probable by so many nats: it needs fewer numbers,
/// but nothing at an element changes at random from case to case.
pub(super) const SHORT: f64 = 50.0;

/// A search of causes gives way to one with them where they promise so many nats, and so many times what the best cause promises: no single
/// cause explains what they do to all cases.
const FOREMOST: (f64, f64) = (20.0, 2.0);

/// Sizes at which the evidence is looked at, between their bounds.
const SIZES: usize = 40;

/// Loads in single cases are looked at where they are no more than so many, places of the frame likewise.
const CASE_ERRORS: usize = 400;
/// A mount is looked at under so many loads at most.
const LOADS: usize = 12;

/// What a rig may do besides.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum RigErrors {
    /// Each load has an error of its own in each case.
    Loads,
    /// The measuring frame is set up anew in each case, or goes on from case to case.
    Frame,
    /// The measuring frame sits elsewhere than the deck's, the same in all cases.
    Alignment,
    /// What the axle is mounted on yields to the loads.
    Mount,
}

impl RigErrors {
    /// All of them.
    pub(super) const ALL: [Self; 4] = [Self::Loads, Self::Frame, Self::Alignment, Self::Mount];

    /// The groups of tolerances that hold them and that a study lacks, with their usual sizes; none where they cannot be looked for.
    pub(super) fn open(self, subject: &DiagnosisProblem<'_>) -> Vec<(EffectGroup, ScalePrior)> {
        let problem = &subject.problem;
        let cases = problem.programme.cases.len();
        let millimetre = subject.millimetre();
        let mut groups = match self {
            Self::Loads => {
                let count = cases * applied_loads(problem.model, problem.programme).len();
                let is_open = problem.tolerances.load_repeatability == PriorSetting::Estimate;
                if !is_open || count == 0 || count > CASE_ERRORS {
                    return Vec::new();
                }
                ScalePrior::of_load_errors().to_vec()
            }
            Self::Frame if subject.compares_marks() => {
                let mut groups = ScalePrior::of_frames(millimetre).to_vec();
                let is_few = 6 * cases <= CASE_ERRORS;
                groups.retain(|(group, _)| is_few || *group == EffectGroup::FrameDrifts);
                groups
            }
            Self::Alignment if subject.compares_marks() => {
                let stated = problem.tolerances.alignment;
                if stated != PriorSetting::Estimate {
                    return Vec::new();
                }
                ScalePrior::of_alignment(stated, millimetre)
                    .into_iter()
                    .collect()
            }
            Self::Mount if subject.compares_marks() => {
                let count = varying(problem.programme).len();
                let is_open = problem.tolerances.mount == PriorSetting::Estimate;
                if !is_open || count == 0 || count > LOADS {
                    return Vec::new();
                }
                ScalePrior::of_a_mount(millimetre).to_vec()
            }
            Self::Frame | Self::Alignment | Self::Mount => Vec::new(),
        };
        groups.retain(|(group, _)| subject.sizes.group(*group).is_none());
        groups
    }

    /// True for what is the same in all cases, or follows the loads: a cause of the axle may stand in its place.
    pub(super) const fn is_steady(self) -> bool {
        matches!(self, Self::Alignment | Self::Mount)
    }

    /// By how many nats they would make the readings more probable beside a fit, in its linear model: with its sizes of tolerances or with
    /// usual ones, where other tolerances may have taken these errors up.
    pub(super) fn promised(self, subject: &DiagnosisProblem<'_>, fitted: &FittedModel) -> f64 {
        if self.open(subject).is_empty() {
            return 0.0;
        }
        let whitened = Whitened::of(fitted);
        let promised = self.promised_beyond(0.0, (subject, fitted), &whitened);
        promised.unwrap_or(0.0)
    }

    /// The same with the whitened model of the fit at hand. `None` where it is no more than `least`, and that is seen at once: nothing
    /// promises more than all that is left over.
    fn promised_beyond(
        self,
        least: f64,
        (subject, fitted): (&DiagnosisProblem<'_>, &FittedModel),
        whitened: &[Whitened],
    ) -> Option<f64> {
        let groups = self.open(subject);
        let &(group, size) = groups.first()?;
        let is_enough = |at: &&Whitened| at.behind + 0.5 * at.residual.norm_squared() > least;
        let whitened: Vec<&Whitened> = whitened.iter().filter(is_enough).collect();
        if whitened.is_empty() {
            return None;
        }
        let columns = match group {
            EffectGroup::LoadRepeatability => of_loads(subject, fitted),
            EffectGroup::FrameShifts => of_frames(subject),
            _ => of_motions(&subject.with_groups(groups), group),
        };
        if columns.values.ncols() == 0 {
            return None;
        }
        let turned = fitted.whitening.apply(&columns.values);
        let of = |at: &&Whitened| at.behind + at.gained(&turned, &columns.blocks, size);
        Some(whitened.iter().map(of).fold(0.0, f64::max))
    }

    /// By how many nats they make the readings of a fit that has them more probable, the priors of their sizes left out. `subject` is the
    /// study without them.
    pub(super) fn carried(self, subject: &DiagnosisProblem<'_>, fitted: &FittedModel) -> f64 {
        let mut without = fitted.sizes.clone();
        let mut of_priors = 0.0;
        for (group, _) in self.open(subject) {
            if let Some(at) = without.group(group) {
                let size = without.groups[at].1;
                let least = size.bounds.0;
                of_priors += size.ln_prior(without.ln[at]) - size.ln_prior(least);
                without.ln[at] = least;
            }
        }
        let reached = fitted.linear.solve(&without, 0.0);
        reached.map_or(0.0, |reached| {
            fitted.posterior.ln_z - reached.ln_z - of_priors
        })
    }
}

/// What errors of the rig promise beside fits that were looked at.
#[derive(Debug, Default)]
pub struct Promises(Vec<(RigErrors, Arc<FittedModel>, f64)>);

impl Promises {
    /// As [`RigErrors::promised`].
    pub(super) fn of(
        &self,
        errors: RigErrors,
        subject: &DiagnosisProblem<'_>,
        fitted: &Arc<FittedModel>,
    ) -> f64 {
        let same =
            |(of, beside, _): &&(RigErrors, _, _)| *of == errors && Arc::ptr_eq(beside, fitted);
        match self.0.iter().find(same) {
            Some((.., promised)) => *promised,
            None => errors.promised(subject, fitted),
        }
    }

    /// Of the errors in `open` those that promise most beside a fit, where that is far more than `promised`, what the best cause promises.
    pub(super) fn foremost(
        &mut self,
        open: &[RigErrors],
        (subject, fitted): (&DiagnosisProblem<'_>, &Arc<FittedModel>),
        promised: f64,
    ) -> Option<GaveWay> {
        let (least, times) = FOREMOST;
        let asked = least.max(times * promised);
        let mut best: Option<(RigErrors, f64)> = None;
        if open.is_empty() {
            return None;
        }
        let whitened = Whitened::of(fitted);
        for errors in open {
            let Some(own) = errors.promised_beyond(asked, (subject, fitted), &whitened) else {
                continue;
            };
            self.0.push((*errors, Arc::clone(fitted), own));
            if own >= asked && best.is_none_or(|(_, most)| own > most) {
                best = Some((*errors, own));
            }
        }
        best.map(|(errors, _)| GaveWay {
            errors,
            least: fitted.ln_posterior() + asked,
        })
    }
}

/// What a search of causes gave way to before its end.
#[derive(Clone, Copy, Debug)]
pub struct GaveWay {
    /// A search is to be made with these errors.
    pub errors: RigErrors,
    /// The evidence that search has to reach, in nats, prior included; else the one that gave way goes on to its end.
    pub least: f64,
}

/// Derivatives of all rows by errors of the rig.
struct ErrorColumns {
    values: DMatrix<f64>,
    /// Ranges of columns, and the rows in which they have anything.
    blocks: Vec<(Range<usize>, Vec<usize>)>,
}

/// The rows of a case.
fn rows_of(subject: &DiagnosisProblem<'_>, case: usize) -> Vec<usize> {
    let rows = subject.rows.iter().enumerate();
    let own = rows.filter(|(_, row)| row.case() == case);
    own.map(|(at, _)| at).collect()
}

/// By each shift of the frame in each case, and by each turn in parts of its usual size over that of a shift.
fn of_frames(subject: &DiagnosisProblem<'_>) -> ErrorColumns {
    let measurement = subject.problem.measurement;
    let turn = ScalePrior::turn_by_shift(subject.millimetre());
    let mut out = DMatrix::zeros(subject.rows.len(), 6 * measurement.cases.len());
    let mut blocks = Vec::new();
    for (case, read) in measurement.cases.iter().enumerate() {
        let places: Vec<Vec3> = read.marks.iter().map(|mark| mark.x).collect();
        let columns = by_frame(&subject.rows, case, &places, subject.sigma, turn);
        for (k, column) in columns.into_iter().enumerate() {
            for (row, value) in column {
                out[(row, 6 * case + k)] = value;
            }
        }
        blocks.push((6 * case..6 * case + 6, rows_of(subject, case)));
    }
    ErrorColumns {
        values: out,
        blocks,
    }
}

/// By the motions of a group that the frame makes through the cases.
fn of_motions(subject: &DiagnosisProblem<'_>, of: EffectGroup) -> ErrorColumns {
    let mut through = motions(subject, &[]);
    through.retain(|(group, _)| *group == of);
    let own = of_frames(subject).values;
    let mut out = DMatrix::zeros(own.nrows(), 6 * through.len());
    for (at, (_, factors)) in through.iter().enumerate() {
        for (case, factor) in factors.iter().enumerate() {
            let mut six = out.columns_mut(6 * at, 6);
            six += own.columns(6 * case, 6) * *factor;
        }
    }
    ErrorColumns {
        blocks: vec![(0..out.ncols(), (0..out.nrows()).collect())],
        values: out,
    }
}

/// By each load in each case, in units of the load's largest value: those by the gain of the load, row by row. A load that is zero in a case
/// has none there: the fit has no derivative by it.
fn of_loads(subject: &DiagnosisProblem<'_>, fitted: &FittedModel) -> ErrorColumns {
    let problem = &subject.problem;
    let programme = problem.programme;
    let by_gain = |(load, largest): (usize, f64)| {
        let name = programme.loads[load].target.to_string();
        let gain = subject.layer.at(EffectGroup::LoadGains, &name).next()?;
        let column = fitted.jacobian.column(problem.unknowns.len() + gain);
        Some((load, largest, column))
    };
    let loads = applied_loads(problem.model, programme).into_iter();
    let loads: Vec<_> = loads.filter_map(by_gain).collect();
    let mut out: Vec<DVector<f64>> = Vec::new();
    let mut blocks = Vec::new();
    for (case, at) in programme.cases.iter().enumerate() {
        let (first, rows) = (out.len(), rows_of(subject, case));
        for (load, largest, by_gain) in &loads {
            let value = at.values[*load];
            if value == 0.0 {
                continue;
            }
            let mut column = DVector::zeros(subject.rows.len());
            for row in &rows {
                column[*row] = by_gain[*row] * largest / value;
            }
            out.push(column);
        }
        blocks.push((first..out.len(), rows));
    }
    let values = if out.is_empty() {
        DMatrix::zeros(subject.rows.len(), 0)
    } else {
        DMatrix::from_columns(&out)
    };
    ErrorColumns { values, blocks }
}

/// The linear model of a fit, whitened at some sizes of tolerances.
struct Whitened {
    /// Its evidence less that at the fit's own sizes.
    behind: f64,
    /// Of turned rows.
    weights: DVector<f64>,
    /// Whitened reading minus prediction at its maximum,
    residual: DVector<f64>,
    /// and the whitened Jacobian.
    jacobian: DMatrix<f64>,
    /// Of the unknowns.
    covariance: DMatrix<f64>,
}

impl Whitened {
    /// At the sizes of a fit, and at usual ones.
    fn of(fitted: &FittedModel) -> Vec<Self> {
        let modest = fitted.sizes.at(fitted.sizes.capped_above_median(0.0));
        let usual = fitted.linear.posterior(&modest);
        let own = Some((&fitted.sizes, fitted.posterior.clone()));
        let options = own.into_iter().chain(usual.map(|usual| (&modest, usual)));
        let of = |(sizes, posterior): (&VarianceComponents, Posterior)| {
            let (residual, jacobian) = fitted.whitened_at(sizes, &posterior);
            Self {
                behind: posterior.ln_z - fitted.posterior.ln_z,
                weights: fitted.whitening.weights(&sizes.ln),
                residual,
                jacobian,
                covariance: posterior.covariance,
            }
        };
        options.map(of).collect()
    }

    /// `max ln Z` over the size `s` of further unknowns with columns `U`, of which `turned` holds the turned ones, beside what is known of the
    /// others: with `r` the residual, `b = U'r` and `G = U'U - U'J C J'U`, it is `b'(G + 1/s^2)^-1 b / 2 - ln det(1 + s^2 G) / 2`.
    fn gained(
        &self,
        turned: &DMatrix<f64>,
        blocks: &[(Range<usize>, Vec<usize>)],
        size: ScalePrior,
    ) -> f64 {
        let count = turned.ncols();
        let mut JU = DMatrix::zeros(self.jacobian.ncols(), count);
        let (mut G, mut b) = (DMatrix::zeros(count, count), DVector::zeros(count));
        for (range, rows) in blocks {
            let (first, width) = (range.start, range.len());
            let mut U = turned.columns(first, width).select_rows(rows);
            for (mut values, row) in U.row_iter_mut().zip(rows) {
                values *= self.weights[*row];
            }
            let (J, r) = (
                self.jacobian.select_rows(rows),
                self.residual.select_rows(rows),
            );
            b.rows_mut(first, width).copy_from(&U.tr_mul(&r));
            JU.columns_mut(first, width).copy_from(&transposed(&J, &U));
            G.view_mut((first, first), (width, width))
                .copy_from(&transposed(&U, &U));
        }
        G -= transposed(&JU, &(&self.covariance * &JU));
        let eigen = symmetric_eigen(G);
        let b = eigen.eigenvectors.tr_mul(&b);
        let (low, high) = size.bounds;
        let at = |k: usize| {
            let ln = low + (high - low) * k as f64 / SIZES as f64;
            let s = libm::exp(2.0 * ln);
            let each = eigen.eigenvalues.iter().zip(b.iter());
            let sum: f64 = each
                .map(|(g, b)| {
                    let wider = 1.0 + s * g.max(0.0);
                    0.5 * (s * b * b / wider - libm::log(wider))
                })
                .sum();
            sum + size.ln_prior(ln)
        };
        (0..=SIZES).map(at).fold(f64::NEG_INFINITY, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::super::sought::tests::{of_the_axle, shipped_axle};
    use super::*;

    /// Columns that meet the rows of their case only promise what they do with all rows.
    #[test]
    fn columns_of_single_cases_promise_what_they_do_with_all_rows() {
        let loaded = shipped_axle();
        let problem = loaded.problem();
        let (subject, fitted) = of_the_axle(&problem);
        for (errors, columns) in [
            (RigErrors::Loads, of_loads(&subject, &fitted)),
            (RigErrors::Frame, of_frames(&subject)),
        ] {
            let size = errors.open(&subject)[0].1;
            let turned = fitted.whitening.apply(&columns.values);
            let (rows, count) = turned.shape();
            assert!(columns.blocks.len() > 1 && count > 1);
            let whole = vec![(0..count, (0..rows).collect())];
            for at in Whitened::of(&fitted) {
                let (own, all) = (
                    at.gained(&turned, &columns.blocks, size),
                    at.gained(&turned, &whole, size),
                );
                assert!((own - all).abs() < 1e-9 * (1.0 + all.abs()), "{own} {all}");
            }
        }
    }
}
