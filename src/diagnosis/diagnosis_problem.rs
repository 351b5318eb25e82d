use std::sync::{Arc, OnceLock};

use nalgebra::DVector;

use super::progress::Progress;
use crate::settings::{FAR_MARK_SIGMA, FEW_FAR_MARKS};
use admire_identify::Problem;
use admire_identify::global::{NuisanceLayout, Numbers, Observations, Predictor, Prepared, Row};
use admire_identify::settings::{
    HEAVY_TAILS_NATS, HUBER_THRESHOLD_SIGMA, POSSIBLE_HEAVY_TAILS_NATS,
};
use admire_identify::tolerance::{
    EffectGroup, LayerOf, MarkBlock, MarkNoise, NoiseScale, RandomEffects, ScalePrior, Tails,
    VarianceComponents, Whitening, mad_sigma,
};
use admire_solver::mechanics::Vec3;
use admire_study::settings::Loss;
use admire_study::{Measurement, PriorSetting, ToleranceSettings};
use admire_syntax::Address;

/// Study under diagnosis: readings, their noise model, and the random effects of axle and rig.
#[derive(Clone, Debug)]
pub struct DiagnosisProblem<'a> {
    /// Identification problem of the study.
    pub problem: Problem<'a>,
    /// Residual rows of all cases, including the held-out cases.
    pub rows: Vec<Row>,
    /// Declared standard deviation of the mark readings, per coordinate and in the deck's length unit. It is the unit of the residual rows of
    /// marks.
    pub sigma: f64,
    /// Noise of the marks, estimated from the rigidity of the parts. Also lists outliers and misplaced marks.
    pub noise: MarkNoise,
    /// Student-t noise model of the marks. `None` unless the residuals of a fit have heavy tails.
    pub tails: Option<Tails>,
    /// Random effects: small errors of the axle and of the rig.
    pub layer: Arc<RandomEffects>,
    /// Variance components (standard deviations of tolerance groups and noise scales) before any fit.
    pub sizes: VarianceComponents,
    /// Precision of each residual row in the row's own unit. Zero for a row that is not used.
    pub precision: Vec<f64>,
    /// Directions in the space of residual rows that are excluded from the comparison, because zero-stiffness motions act along them.
    free: Arc<Vec<Vec<(usize, f64)>>>,
    blocks: Vec<MarkBlock>,
    single: Vec<(usize, Option<NoiseScale>)>,
    /// Whitening transformations, computed at first use. The first leaves out the held-out cases, the second covers all cases.
    whitenings: [OnceLock<Arc<Whitening>>; 2],
    held_out: Vec<bool>,
    /// True if fits leave out the curves that the study holds out.
    holds_curves: bool,
    progress: Progress,
}

impl<'a> DiagnosisProblem<'a> {
    /// Sets up the diagnosis of a study. Cases flagged in `held_out` are left out of the fits that measure predictive gain.
    pub fn new(problem: &Problem<'a>, held_out: Vec<bool>) -> Self {
        let measurement = problem.measurement;
        let cases: Vec<usize> = (0..held_out.len()).collect();
        let observations = Observations::new(measurement, problem.model, &cases);
        let (rows, sigma) = (observations.rows, observations.sigma);
        let noise = MarkNoise::of(measurement);
        let stated =
            matches!(problem.tolerances.load_repeatability, PriorSetting::Size(s) if s > 0.0);
        let layer = layer_of(problem, stated);
        let millimetre = 1e-3 / problem.model.units.length.si;
        let frame = problem.settings.frame_sd;
        let frames = [0, 3].map(|axis| frame.of_axis(axis, &problem.model.units));
        let mut sizes = VarianceComponents::new(
            problem.tolerances,
            measurement.sigma_on_parts,
            frames,
            millimetre,
        );
        let alignment = problem.tolerances.alignment;
        if alignment != PriorSetting::Estimate
            && !measurement.parts.is_empty()
            && let Some((group, size)) = ScalePrior::of_alignment(alignment, millimetre)
        {
            sizes = sizes.with_group(group, size);
        }
        if noise.estimated.is_none() && !measurement.parts.is_empty() {
            sizes.add_scale(NoiseScale::Marks, !measurement.sigma_estimated);
        }
        if measurement.wheel.is_some() {
            sizes.add_scale(NoiseScale::WheelPosition, true);
            sizes.add_scale(NoiseScale::WheelAngles, true);
        }
        for (k, channel) in measurement.channels.iter().enumerate() {
            sizes.add_scale(NoiseScale::Channel(k), !channel.sigma_estimated);
        }
        let mut new = Self {
            problem: problem.clone(),
            precision: vec![1.0; rows.len()],
            free: Arc::new(free_directions(problem).unwrap_or_default()),
            blocks: Vec::new(),
            single: Vec::new(),
            whitenings: Default::default(),
            tails: None,
            layer: Arc::new(layer),
            progress: Progress::default(),
            rows,
            sigma,
            noise,
            sizes,
            held_out,
            holds_curves: true,
        };
        let seen = |case: usize, reading: usize| measurement.cases[case].marks[reading].x;
        (new.blocks, new.single) = placed(&new.rows, measurement, new.sigma, &seen);
        new.set_row_weights(None);
        new
    }

    /// Returns a copy of this study with additional tolerance groups.
    #[must_use]
    pub fn with_groups(&self, groups: impl IntoIterator<Item = (EffectGroup, ScalePrior)>) -> Self {
        let mut new = self.clone();
        for (group, size) in groups {
            new.sizes = new.sizes.with_group(group, size);
        }
        let has_load_errors = new.sizes.group(EffectGroup::LoadRepeatability).is_some();
        if has_load_errors != self.sizes.group(EffectGroup::LoadRepeatability).is_some() {
            new.layer = Arc::new(layer_of(&new.problem, has_load_errors));
        }
        new.whitenings = Default::default();
        new
    }

    /// Returns true if the pose of the measuring frame is a separate unknown in each case.
    pub fn has_frames(&self) -> bool {
        self.sizes.group(EffectGroup::FrameShifts).is_some()
    }

    /// Sets the precision of all rows. Mark rows get the precision of the estimated noise, and rows of outliers get zero. If `misfit` gives
    /// the residuals of a fit, heavy tails or Huber's loss lower the precision of readings far from the fit.
    pub fn set_row_weights(&mut self, misfit: Option<&DVector<f64>>) {
        let least = if self.noise.has_tails() {
            HEAVY_TAILS_NATS
        } else {
            f64::INFINITY
        };
        self.weigh_by(misfit, least);
    }

    /// Sets the precision of all rows. A Student-t model is used if its log likelihood exceeds that of the Gaussian model by more than
    /// `least` nats.
    fn weigh_by(&mut self, misfit: Option<&DVector<f64>>, least: f64) {
        let relative = self.noise.sigma().map_or(1.0, |sigma| self.sigma / sigma);
        let relative = if relative.is_finite() { relative } else { 1.0 };
        let measurement = self.problem.measurement;
        let dropped = |row: &Row| match *row {
            Row::Mark { case, reading, .. } => {
                let read = &measurement.cases[case].marks[reading];
                self.noise.is_excluded(case, reading, read)
            }
            _ => false,
        };
        let used: Vec<f64> = misfit.map_or_else(Vec::new, |misfit| {
            let marks = |(_, row): &(&f64, &Row)| matches!(row, Row::Mark { .. }) && !dropped(row);
            let pairs = misfit.iter().zip(&self.rows).filter(marks);
            pairs.map(|(r, _)| *r).collect()
        });
        let best = Tails::best(&used).filter(|(_, gain)| *gain > least);
        self.tails = best.map(|(tails, _)| tails);
        let huber = self.problem.settings.loss == Loss::Huber;
        let precision = |(at, row): (usize, &Row)| {
            if dropped(row) {
                return 0.0;
            }
            if !matches!(row, Row::Mark { .. }) {
                let r = misfit.map_or(0.0, |misfit| misfit[at].abs());
                return if huber && r > HUBER_THRESHOLD_SIGMA {
                    HUBER_THRESHOLD_SIGMA / r
                } else {
                    1.0
                };
            }
            let own = relative * relative;
            match (misfit, self.tails) {
                (Some(misfit), Some(tails)) => tails.precision(misfit[at]),
                (Some(misfit), None) if huber => {
                    let r = misfit[at].abs() * relative;
                    own * if r > HUBER_THRESHOLD_SIGMA {
                        HUBER_THRESHOLD_SIGMA / r
                    } else {
                        1.0
                    }
                }
                _ => own,
            }
        };
        self.precision = self.rows.iter().enumerate().map(precision).collect();
        self.whitenings = Default::default();
    }

    /// Flags possible outliers on parts with only three usable marks, from the residuals of a fit. The rigidity of a part alone cannot show
    /// which of three marks is an outlier. Returns true if any mark is flagged.
    pub fn flag_three_mark_outliers(&mut self, misfit: &DVector<f64>) -> bool {
        let marks = self.rows.iter().zip(misfit.iter());
        let marks = marks.filter(|(row, _)| matches!(row, Row::Mark { .. }));
        let usual = mad_sigma(marks.map(|(_, r)| r * self.sigma).collect());
        let off = off(&self.rows, misfit, self.sigma);
        self.noise
            .flag_three_mark_outliers(self.problem.measurement, &off, usual)
    }

    /// Decides whether each flagged mark is an outlier, by the residuals of a fit that left the flagged marks out. Returns true if any marks
    /// were flagged.
    pub fn resolve_flagged(&mut self, misfit: &DVector<f64>) -> bool {
        if self.noise.suspects.is_empty() {
            return false;
        }
        let off = off(&self.rows, misfit, self.sigma);
        self.noise.judge(self.problem.measurement, &off);
        true
    }

    /// Returns a copy with Student-t weights, for a study whose marks are too few to show heavy tails by themselves. `far` states that
    /// isolated far readings are the only remaining structure; weaker evidence for heavy tails is then enough. Returns `None` if heavy tails
    /// are already in use, or if the evidence for them is too weak.
    pub fn with_tails(&self, misfit: &DVector<f64>, far: bool) -> Option<Self> {
        if self.tails.is_some() || !(far || self.noise.may_have_tails()) {
            return None;
        }
        let mut tailed = self.clone();
        tailed.weigh_by(
            Some(misfit),
            if far {
                POSSIBLE_HEAVY_TAILS_NATS
            } else {
                HEAVY_TAILS_NATS
            },
        );
        tailed.tails.is_some().then_some(tailed)
    }

    /// Returns true if some mark coordinates, but fewer than 3 percent, have residuals far from zero. A wrong model spreads its error over
    /// many readings.
    pub fn has_few_far(&self, misfit: &DVector<f64>) -> bool {
        let sigma = self.mark_sigma() / self.sigma;
        let marks = self.rows.iter().zip(&self.precision).zip(misfit.iter());
        let used = marks
            .filter(|((row, precision), _)| matches!(row, Row::Mark { .. }) && **precision > 0.0);
        let (mut all, mut far) = (0.0, 0.0);
        for (_, r) in used {
            all += 1.0;
            if r.abs() > FAR_MARK_SIGMA * sigma {
                far += 1.0;
            }
        }
        far > 0.0 && far < FEW_FAR_MARKS * all
    }

    /// Returns true if the readings reject the declared noise of the marks.
    pub fn declared_noise_rejected(&self) -> bool {
        let tailed = self.tails.is_some() || self.noise.has_tails();
        self.noise.contradicts(tailed)
    }

    /// Returns the factor that scales the mean square of the whitened residuals of these rows to an expected value of one. Student-t weights
    /// lower the mean square of mark rows.
    pub fn variance_factor(&self, rows: impl IntoIterator<Item = usize>) -> f64 {
        let Some(tails) = self.tails else {
            return 1.0;
        };
        let of_marks = (tails.nu + 1.0) / (tails.nu + 3.0);
        let (mut count, mut sum) = (0.0, 0.0);
        for row in rows {
            if self.precision[row] > 0.0 {
                count += 1.0;
                let is_of_marks = matches!(self.rows[row], Row::Mark { .. });
                sum += if is_of_marks { of_marks } else { 1.0 };
            }
        }
        if sum > 0.0 { count / sum } else { 1.0 }
    }

    /// Returns true if the precision of the rows depends on the residuals of a fit.
    pub fn is_reweighed(&self) -> bool {
        self.tails.is_some() || self.problem.settings.loss == Loss::Huber
    }

    /// Returns the whitening transformation for the cases that `data` selects.
    pub fn whitening(&self, data: Data) -> Arc<Whitening> {
        let known = &self.whitenings[usize::from(data == Data::All)];
        let new = || {
            let is_seen = |row: &Row| data == Data::All || !self.is_held_out_row(row);
            let rows = self.rows.iter().zip(&self.precision);
            let seen = rows.map(|(row, precision)| if is_seen(row) { *precision } else { 0.0 });
            let precision: Vec<f64> = seen.collect();
            Arc::new(Whitening::new(
                &self.blocks,
                &self.single,
                &precision,
                &self.sizes,
                &self.free,
            ))
        };
        Arc::clone(known.get_or_init(new))
    }

    /// Returns true if `is_seen` holds for all cases on which the row depends. A row of a summary channel depends on several cases, any
    /// other row on one.
    pub(super) fn sees(&self, row: &Row, is_seen: &dyn Fn(usize) -> bool) -> bool {
        match *row {
            Row::Channel { case, channel } => {
                let summary = &self.problem.measurement.channels[channel].summary;
                match summary {
                    Some(summary) => summary.cases.iter().all(|case| is_seen(*case)),
                    None => is_seen(case),
                }
            }
            _ => is_seen(row.case()),
        }
    }

    /// Returns true if the row is left out of the fits that measure predictive gain, because its case or its curve is held out.
    pub fn is_held_out_row(&self, row: &Row) -> bool {
        let channels = &self.problem.measurement.channels;
        let curve = matches!(*row, Row::Channel { channel, .. } if channels[channel].held_out);
        self.holds_curves && curve || !self.sees(row, &|case| !self.held_out[case])
    }

    /// Returns the whitening transformation of planned readings. Planned mark readings get the mean precision of the existing mark readings.
    /// `rows` refer to `measurement`. `seen` returns the expected position of a mark, given the case and the reading. The directions in
    /// `free` are excluded.
    pub fn whitening_ahead(
        &self,
        rows: &[Row],
        measurement: &Measurement,
        seen: &dyn Fn(usize, usize) -> Vec3,
        free: &[Vec<(usize, f64)>],
    ) -> Whitening {
        let (blocks, single) = placed(rows, measurement, self.sigma, seen);
        let usual = self.usual_precision();
        let of = |row: &Row| match row {
            Row::Mark { .. } => usual,
            _ => 1.0,
        };
        let precision: Vec<f64> = rows.iter().map(of).collect();
        Whitening::new(&blocks, &single, &precision, &self.sizes, free)
    }

    /// Returns the mean precision of the mark rows in use; 1 if there are none.
    pub fn usual_precision(&self) -> f64 {
        let rows = self.rows.iter().zip(&self.precision);
        let used = rows.filter(|(row, p)| matches!(row, Row::Mark { .. }) && **p > 0.0);
        let (count, sum) = used.fold((0, 0.0), |(n, sum), (_, p)| (n + 1, sum + p));
        if count == 0 {
            1.0
        } else {
            sum / f64::from(count)
        }
    }

    /// Returns true if a case is held out from the fits that measure predictive gain.
    pub fn is_held_out(&self, case: usize) -> bool {
        self.held_out[case]
    }

    /// Returns true if any case or curve is held out.
    pub fn holds_out(&self) -> bool {
        let mut curves = self.problem.measurement.channels.iter();
        self.held_out.iter().any(|held| *held)
            || self.holds_curves && curves.any(|channel| channel.held_out)
    }

    /// Returns the length of one millimetre in the deck's length unit.
    pub fn millimetre(&self) -> f64 {
        1e-3 / self.problem.model.units.length.si
    }

    /// Returns the standard deviation of the mark readings that the fits use, per coordinate and in the deck's length unit.
    pub fn mark_sigma(&self) -> f64 {
        self.noise.sigma().unwrap_or(self.sigma)
    }

    /// Returns the tolerance settings of the study.
    pub fn stated(&self) -> &ToleranceSettings {
        self.problem.tolerances
    }

    /// Adds to the number of sweeps. One sweep solves all load cases once.
    pub fn count_sweeps(&self, sweeps: usize) {
        self.progress.spend(sweeps);
    }

    /// Returns the number of sweeps so far.
    pub fn sweeps(&self) -> usize {
        self.progress.sweeps()
    }

    /// Returns true if the budget of sweeps is spent, so that no further round of a search starts.
    pub fn budget_exhausted(&self) -> bool {
        self.progress.is_spent()
    }

    /// Returns the progress counter.
    pub(super) const fn progress(&self) -> &Progress {
        &self.progress
    }

    /// Uses `progress` as the progress counter from now on.
    pub fn with_progress(&mut self, progress: &Progress) {
        self.progress = progress.clone();
    }

    /// Holds out exactly these cases, and no curves.
    pub fn hold_out(&mut self, cases: &[usize]) {
        self.holds_curves = false;
        self.whitenings[0] = OnceLock::new();
        for (case, held) in self.held_out.iter_mut().enumerate() {
            *held = cases.contains(&case);
        }
    }

    /// Returns true if the study has marks. Predictions are then compared on the marks alone.
    pub fn compares_marks(&self) -> bool {
        !self.problem.measurement.parts.is_empty()
    }

    /// Returns the quantity in which predictions are compared, and the factor that converts a residual row to the unit of this quantity. `mark`
    /// means the errors of the marks, in the deck's length unit. `noise` means the errors of all readings, in units of their noise.
    pub fn compared(&self) -> (&'static str, f64) {
        // If only curves are held out, predictions are compared in units of the noise.
        if self.compares_marks() && (self.cases_held_out().next().is_some() || !self.holds_out()) {
            ("mark", self.sigma)
        } else {
            ("noise", 1.0)
        }
    }

    /// Iterates over the cases that are not held out.
    pub fn cases_fitted(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.held_out.len()).filter(|case| !self.held_out[*case])
    }

    /// Iterates over the held-out cases.
    pub fn cases_held_out(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.held_out.len()).filter(|case| self.held_out[*case])
    }
}

/// Returns the directions in the space of residual rows along which zero-stiffness motions act, linearised at the deck's own parameters.
/// Returns `None` without such motions, or if no case has an equilibrium.
fn free_directions(problem: &Problem<'_>) -> Option<Vec<Vec<(usize, f64)>>> {
    if problem.free.is_empty() {
        return None;
    }
    let prepared = Prepared::new(problem).ok()?;
    let cases: Vec<usize> = (0..problem.measurement.cases.len()).collect();
    let observations = Observations::new(problem.measurement, problem.model, &cases);
    let mut predictor = prepared
        .native(problem, observations.observed.clone())
        .ok()?;
    let numbers = Numbers {
        theta: prepared.system.parameters(),
        per_case: Vec::new(),
        x: Vec::new(),
    };
    let mut prediction = predictor.predict(&numbers, None);
    // Zero-stiffness motions hardly depend on the load, so an unsolved case takes the directions of a solved case.
    let known = prediction.iter().flatten().next()?.clone();
    for own in &mut prediction {
        own.get_or_insert_with(|| known.clone());
    }
    let found = observations.evaluate(&prediction, &NuisanceLayout::default(), &[], 0)?;
    Some(found.free)
}

/// Returns the random effects of the study's axle and rig.
fn layer_of(problem: &Problem<'_>, load_errors: bool) -> RandomEffects {
    let is_sought = |address: &Address| {
        let mut unknowns = problem.unknowns.iter();
        unknowns.any(|unknown| unknown.sets(address))
    };
    RandomEffects::of(&LayerOf {
        model: problem.model,
        programme: problem.programme,
        load_errors,
        is_sought: &is_sought,
        is_sought_change: &|change| problem.seeks_change(change),
    })
}

/// Divides the rows into correlated blocks and independent rows. A block holds the marks of one part in one case, with their levers from the
/// mean position.
fn placed(
    rows: &[Row],
    measurement: &Measurement,
    unit: f64,
    seen: &dyn Fn(usize, usize) -> Vec3,
) -> (Vec<MarkBlock>, Vec<(usize, Option<NoiseScale>)>) {
    let mut blocks: Vec<((usize, usize), MarkBlock)> = Vec::new();
    let mut single = Vec::new();
    for (at, row) in rows.iter().enumerate() {
        match *row {
            Row::Mark {
                case,
                reading,
                axis: 0,
            } => {
                let key = (case, measurement.cases[case].marks[reading].part);
                if blocks.last().is_none_or(|(last, _)| *last != key) {
                    let empty = MarkBlock {
                        rows: Vec::new(),
                        levers: Vec::new(),
                        unit,
                    };
                    blocks.push((key, empty));
                }
                if let Some((_, block)) = blocks.last_mut() {
                    block.rows.push(at);
                    block.levers.push(seen(case, reading));
                }
            }
            Row::Mark { .. } => {}
            Row::Wheel { component, .. } => {
                let scale = if component < 3 {
                    NoiseScale::WheelPosition
                } else {
                    NoiseScale::WheelAngles
                };
                single.push((at, Some(scale)));
            }
            Row::Channel { channel, .. } => {
                single.push((at, Some(NoiseScale::Channel(channel))));
            }
        }
    }
    for (_, block) in &mut blocks {
        let mean = block.levers.iter().sum::<Vec3>() / block.levers.len() as f64;
        for lever in &mut block.levers {
            *lever -= mean;
        }
    }
    (blocks.into_iter().map(|(_, block)| block).collect(), single)
}

/// Returns a function of the case and the reading index. Its result is the error vector of that mark reading: reading minus prediction, in
/// length units. `misfit` is prediction minus reading in units of `sigma`.
fn off<'a>(
    rows: &'a [Row],
    misfit: &'a DVector<f64>,
    sigma: f64,
) -> impl Fn(usize, usize) -> Option<Vec3> + 'a {
    move |case, reading| {
        let first = rows.iter().position(
            |row| matches!(*row, Row::Mark { case: c, reading: r, axis: 0 } if (c, r) == (case, reading)),
        )?;
        Some(Vec3::from_fn(|axis, _| -misfit[first + axis] * sigma))
    }
}

/// Selection of the cases that a fit uses.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Data {
    /// Cases that are not held out.
    Fitted,
    /// All cases.
    All,
}
