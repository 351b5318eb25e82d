//! Predicted readings of candidate measurements in units of their noise, with derivatives with respect to the unknowns of a fit.

use nalgebra::{DMatrix, DVector};

use super::candidate::{
    New, ProposedMeasurement, ProposedMeasurements, sigma_of_a_cell, sigma_of_a_mark,
};
use super::forecast::{Forecast, ForecastRequest, nearest};
use super::load_values::usual;
use super::wheel_place::WheelPlace;
use crate::settings::LEAST_RANGE_SIGMAS;
use admire_diagnosis::{DiagnosisProblem, FittedModel, at_point, by_frame, centroid, motions};
use admire_identify::global::{CaseChange, CasePrediction, NuisanceLayout, Observations, Row};
use admire_identify::tolerance::{EffectGroup, MarkBlock, Whitening};
use admire_solver::mechanics::Vec3;
use admire_solver::model::{PartIx, PartKind};
use admire_study::wheel::WheelReading;
use admire_study::{Case, MarkReading, Measurement};
use admire_syntax::text::Span;

/// Predicted readings of one candidate measurement.
#[derive(Clone, Debug)]
pub(super) struct Readings {
    /// Derivatives of the whitened (independent, unit variance) rows. The first columns belong to the unknowns of the fit, the others to the
    /// additional unknowns of the candidate.
    pub jacobian: DMatrix<f64>,
    /// Prior standard deviations of the additional unknowns.
    pub further: Vec<f64>,
    /// Whitened rows of the study that `jacobian` contains a second time, because they share errors with the new readings.
    pub replaced: DMatrix<f64>,
    /// Predicted values of the readings, each in units of its noise.
    value: DVector<f64>,
    /// Noise of each reading, which is the unit of its value.
    unit: Vec<f64>,
    /// Whitening transformation of differences of the readings, and the weights that scale to unit variance. `None` if the readings are
    /// independent.
    turning: Option<(Whitening, DVector<f64>)>,
    /// Derivatives of the new readings alone, if `jacobian` also contains other rows.
    own: Option<DMatrix<f64>>,
}

impl Readings {
    /// Creates readings with independent errors.
    pub(super) fn new(jacobian: DMatrix<f64>, value: DVector<f64>, unit: Vec<f64>) -> Self {
        Self {
            further: Vec::new(),
            replaced: DMatrix::zeros(0, jacobian.ncols()),
            turning: None,
            own: None,
            jacobian,
            value,
            unit,
        }
    }

    /// Returns the differences between two predictions of the same readings by two models: `other` minus `self`, in independent rows of unit
    /// variance. Also returns the derivatives of these rows by the model of `self`. Returns `None` if the models do not predict the same
    /// readings.
    pub(super) fn against(&self, other: &Self) -> Option<(DVector<f64>, &DMatrix<f64>)> {
        if self.value.len() != other.value.len() {
            return None;
        }
        let each = other.value.iter().zip(&other.unit);
        let each = each.zip(self.value.iter().zip(&self.unit));
        let each = each.map(|((b, of_b), (a, of_a))| b * (of_b / of_a) - a);
        let difference = DVector::from_iterator(self.value.len(), each);
        let difference = match &self.turning {
            Some((whitening, weights)) => {
                whitening.apply_vector(&difference).component_mul(weights)
            }
            None => difference,
        };
        Some((difference, self.own.as_ref().unwrap_or(&self.jacobian)))
    }
}

/// Predictor of candidate measurements by a fitted model.
pub(super) struct MeasurementPredictor<'a, 'b> {
    subject: &'a DiagnosisProblem<'b>,
    fitted: &'a FittedModel,
    forecast: Forecast,
    candidates: &'a ProposedMeasurements,
    /// Index in the forecast of each candidate's sequence of cases. `None` for an instrument.
    sequence: Vec<Option<usize>>,
    wheel: Option<WheelPlace>,
    /// Cases that the fit used.
    seen: Vec<usize>,
}

impl<'a, 'b> MeasurementPredictor<'a, 'b> {
    /// Solves all cases that the candidates need. Returns `None` if a case of the study has no equilibrium.
    pub(super) fn new(
        subject: &'a DiagnosisProblem<'b>,
        fitted: &'a FittedModel,
        candidates: &'a ProposedMeasurements,
    ) -> Option<Self> {
        let mut sequences: Vec<Vec<Vec<f64>>> = Vec::new();
        let mut sequence = Vec::new();
        let wheel = WheelPlace::of(subject);
        let mut parts: Vec<PartIx> = wheel.iter().map(|wheel| wheel.part).collect();
        for candidate in &candidates.list {
            let cases = candidate.sequence();
            sequence.push((!cases.is_empty()).then_some(sequences.len()));
            if !cases.is_empty() {
                sequences.push(cases.to_vec());
            }
            if let New::Mark(part, _) = candidate.new {
                parts.push(part);
            }
        }
        let asked = |functions| ForecastRequest {
            sequences: &sequences,
            parts: &parts,
            functions,
        };
        // If one of the forces cannot be computed in this deck, load cells are left out.
        let forecast = Forecast::new(subject, fitted, asked(&candidates.functions))
            .or_else(|| Forecast::new(subject, fitted, asked(&[])))?;
        let mut seen: Vec<usize> = Vec::new();
        for (row, class) in subject.rows.iter().zip(&fitted.whitening.class_of) {
            if class.is_some() && seen.last() != Some(&row.case()) {
                seen.push(row.case());
            }
        }
        Some(Self {
            subject,
            fitted,
            forecast,
            candidates,
            sequence,
            wheel,
            seen,
        })
    }

    /// Returns the readings of candidate `at`, or `None` if a load case has no equilibrium or nothing would be read.
    pub(super) fn readings(&self, at: usize) -> Option<Readings> {
        let candidate = &self.candidates.list[at];
        match &candidate.new {
            New::Cases(_) => self.of_cases(candidate, self.sequence[at]?),
            New::Mark(part, place) => self.of_a_mark(*part, place),
            New::Wheel(component, sigma) => {
                let wheel = self.wheel.as_ref()?;
                let at = self.place(wheel.part)?;
                self.alone(
                    *sigma,
                    &|case| wheel.place(case)[*component],
                    &|case, change| wheel.change(case, change, at)[*component],
                )
            }
            New::Functions(range) => self.of_functions(range.clone()),
        }
    }

    /// Returns the ratio of the deflections in a candidate's load cases to the largest deflections in the cases of the study. Deflections are
    /// displacements of the deck's markers on moving parts, along each axis, from their positions in the case nearest to the usual loads. Returns one
    /// for an instrument, and `None` if a load case has no equilibrium.
    pub(super) fn reach(&self, at: usize) -> Option<f64> {
        let Some(sequence) = self.sequence[at] else {
            return Some(1.0);
        };
        let further = self.forecast.there[sequence].as_ref()?;
        let programme = self.subject.problem.programme;
        let rest = self.case(nearest(programme, &usual(programme))?)?;
        let least = LEAST_RANGE_SIGMAS * sigma_of_a_mark(self.subject);
        let model = self.subject.problem.model;
        let mut reach = 0.0_f64;
        for marker in &model.markers {
            let part = marker.part.0;
            if model.parts[part].kind == PartKind::Ground {
                continue;
            }
            let place = |case: &CasePrediction| case.poses[part].point(&marker.qp);
            let from_rest = |case: &CasePrediction| (place(case) - place(rest)).abs();
            let seen = self.seen.iter().filter_map(|case| self.case(*case));
            let seen = seen.fold(Vec3::repeat(least), |most, case| most.sup(&from_rest(case)));
            let most = further
                .iter()
                .fold(Vec3::zeros(), |most, case| most.sup(&from_rest(case)));
            reach = reach.max(most.component_div(&seen).max());
        }
        Some(reach)
    }

    /// Returns the readings of a load cell. Force components that are zero in all cases are left out.
    fn of_functions(&self, functions: std::ops::Range<usize>) -> Option<Readings> {
        let mut all: Option<Readings> = None;
        for function in functions {
            let at = self.forecast.first_function + function;
            let of = |case: &CasePrediction| case.channels.get(at).copied();
            let forces = self.seen.iter().map(|case| self.case(*case).and_then(of));
            let forces: Vec<f64> = forces.collect::<Option<_>>()?;
            let sigma = sigma_of_a_cell(forces.into_iter());
            if !(sigma > 1e-12) || !sigma.is_finite() {
                continue;
            }
            let more = self.alone(sigma, &|case| case.channels[at], &|_, by| by.channels[at])?;
            all = Some(match all {
                Some(before) => before.and(more),
                None => more,
            });
        }
        all
    }

    /// Returns the derivatives of the wheel's position, camber and toe in these cases, with respect to the unknowns of the fit. Load errors
    /// of the rig are left out.
    pub(super) fn wheel(&self, cases: &[usize]) -> Option<(String, DMatrix<f64>)> {
        let wheel = self.wheel.as_ref()?;
        let at = self.place(wheel.part)?;
        let mut out = DMatrix::zeros(5 * cases.len(), self.fitted.x.len());
        for (k, case) in cases.iter().enumerate() {
            let case = self.case(*case)?;
            for (column, change) in case.by_unknown.iter().enumerate() {
                let of_the_rig = matches!(
                    self.fitted.priors[column].group,
                    Some(
                        EffectGroup::LoadGains
                            | EffectGroup::LoadRepeatability
                            | EffectGroup::IdleLoads
                            | EffectGroup::LoadDirections
                            | EffectGroup::LoadPoints
                    )
                );
                if of_the_rig {
                    continue;
                }
                for (row, value) in wheel.change(case, change, at).into_iter().enumerate() {
                    out[(5 * k + row, column)] = value;
                }
            }
        }
        Some((wheel.told.clone(), out))
    }

    fn case(&self, case: usize) -> Option<&CasePrediction> {
        self.forecast.here[case].as_ref()
    }

    fn place(&self, part: PartIx) -> Option<usize> {
        let parts = &self.forecast.observed.parts;
        parts.iter().position(|of| *of == part)
    }

    /// Returns the readings of all instruments of the study in a candidate's load cases.
    fn of_cases(&self, candidate: &ProposedMeasurement, sequence: usize) -> Option<Readings> {
        let (subject, fitted) = (self.subject, self.fitted);
        let further = self.forecast.there[sequence].as_ref()?;
        let measurement = continued(subject, candidate.sequence());
        let count = subject.problem.measurement.cases.len();
        let cases: Vec<usize> = (count..count + further.len()).collect();
        let observations = Observations::new(&measurement, &fitted.deck.model, &cases);
        // Only channel readings can be relative to other cases, so only they require the predictions of the study's cases.
        let mut prediction = if measurement.channels.is_empty() {
            vec![None; count]
        } else {
            self.forecast.here.clone()
        };
        prediction.extend(further.iter().cloned().map(Some));
        let inner = fitted.unknowns.len() + fitted.layout.sd.len();
        let x = &fitted.x[..inner];
        // The pose of the measuring frame in a further case is unknown. It is an additional unknown of the candidate.
        let mut layout = NuisanceLayout {
            frames: None,
            ..fitted.layout.clone()
        };
        if let Some(own) = &mut layout.motions {
            let loads: Vec<&[f64]> = candidate.sequence().iter().map(Vec::as_slice).collect();
            let through = motions(subject, &loads).into_iter();
            own.factors = through.map(|(_, factors)| factors).collect();
        }
        let found = observations.evaluate(&prediction, &layout, x, x.len())?;
        let seen = |case: usize, reading: usize| {
            let read = measurement.cases[case].marks[reading];
            let part = &measurement.parts[read.part];
            further[case - count].poses[part.part.0].point(&part.marks[read.mark].p)
        };
        let whitening =
            subject.whitening_ahead(&observations.rows, &measurement, &seen, &found.free);
        // Unknowns that act on single readings of the study have no effect on new readings.
        let mut jacobian = found.jacobian.resize_horizontally(fitted.x.len(), 0.0);
        let mut prior = Vec::new();
        if fitted.layout.frames.is_some() {
            let size = |group| fitted.sizes.of(group).unwrap_or_default();
            let of_a_case =
                [EffectGroup::FrameShifts, EffectGroup::FrameTurns].map(|group| [size(group); 3]);
            for case in &cases {
                let first = jacobian.ncols();
                let readings = 0..measurement.cases[*case].marks.len();
                let places: Vec<Vec3> = readings.map(|k| seen(*case, k)).collect();
                jacobian = jacobian.resize_horizontally(first + 6, 0.0);
                let by = by_frame(&observations.rows, *case, &places, subject.sigma, 1.0);
                for (k, column) in by.iter().enumerate() {
                    for (row, value) in column {
                        jacobian[(*row, first + k)] = *value;
                    }
                }
                prior.extend(of_a_case.as_flattened());
            }
        }
        let weights = whitening.weights(&fitted.sizes.ln);
        let unit = vec![1.0; found.residual.len()];
        let mut readings = Readings::new(
            weighed(&whitening, &weights, &jacobian),
            found.residual,
            unit,
        );
        readings.turning = Some((whitening, weights));
        readings.further = prior;
        readings.is_finite().then_some(readings)
    }

    /// Returns the readings of a new mark on a part in all cases that the fit used, together with the existing marks of the part.
    fn of_a_mark(&self, part: PartIx, place: &Vec3) -> Option<Readings> {
        let (subject, fitted) = (self.subject, self.fitted);
        let at = self.place(part)?;
        let sigma = sigma_of_a_mark(subject);
        let own = subject.problem.measurement;
        let marked = own.parts.iter().position(|marked| marked.part == part);
        let n = fitted.x.len();
        let (mut jacobian, mut value, mut precision) = (Vec::new(), Vec::new(), Vec::new());
        let mut blocks = [Vec::new(), Vec::new()];
        let mut free: Vec<Vec<(usize, f64)>> = Vec::new();
        let usual = subject.usual_precision();
        for case in &self.seen {
            let predicted = self.case(*case)?;
            let pose = &predicted.poses[part.0];
            let point = pose.point(place);
            let mut block = MarkBlock {
                rows: Vec::new(),
                levers: Vec::new(),
                unit: sigma,
            };
            // Marks of the same part share the errors of the part's pose.
            for (row, of) in subject.rows.iter().enumerate() {
                let Row::Mark {
                    case: c,
                    reading,
                    axis: 0,
                } = *of
                else {
                    continue;
                };
                let read = own.cases[c].marks[reading];
                if c != *case || Some(read.part) != marked {
                    continue;
                }
                block.rows.push(value.len());
                block.levers.push(read.x);
                for axis in 0..3 {
                    let known: Vec<f64> = fitted.jacobian.row(row + axis).iter().copied().collect();
                    jacobian.push((known, None));
                    value.push(0.0);
                    precision.push(subject.precision[row + axis]);
                }
            }
            let mut before = block.clone();
            block.rows.push(value.len());
            block.levers.push(point);
            let arm = pose.R * place;
            let places: Vec<Vec3> = own.cases[*case].marks.iter().map(|mark| mark.x).collect();
            let by_frame = at_point(&(point - centroid(&places)), 1.0);
            for axis in 0..3 {
                let mut row = vec![0.0; n];
                for (to, change) in row.iter_mut().zip(predicted.by_unknown.iter()) {
                    *to = moved(change, at, &arm)[axis] / sigma;
                }
                if let Some(first) = fitted.layout.frames {
                    let at = first + 6 * case;
                    for (to, by) in row[at..at + 6].iter_mut().zip(&by_frame) {
                        *to = by[axis] / sigma;
                    }
                }
                if let Some(motions) = &fitted.layout.motions {
                    let by = at_point(&(point - motions.centre), motions.turn);
                    for (first, factor) in motions.of(*case) {
                        for (to, by) in row[first..first + 6].iter_mut().zip(&by) {
                            *to = factor * by[axis] / sigma;
                        }
                    }
                }
                let by_place = Vec3::from_fn(|k, _| pose.R[(axis, k)] / sigma);
                jacobian.push((row, Some(by_place)));
                value.push(point[axis] / sigma);
                precision.push(usual);
            }
            // Directions along zero-stiffness motions are excluded from the comparison.
            for motion in predicted.free.iter() {
                let by_mark = |(row, seen): (&usize, &Vec3)| {
                    let by = moved(motion, at, &(seen - pose.p)) / sigma;
                    let first = *row;
                    (0..3).map(move |axis| (first + axis, by[axis]))
                };
                free.push(
                    block
                        .rows
                        .iter()
                        .zip(&block.levers)
                        .flat_map(by_mark)
                        .collect(),
                );
            }
            for block in [&mut block, &mut before] {
                let mean = block.levers.iter().sum::<Vec3>() / block.levers.len().max(1) as f64;
                for lever in &mut block.levers {
                    *lever -= mean;
                }
            }
            blocks[0].push(block);
            blocks[1].push(before);
        }
        let further = self.subject.sizes.group(EffectGroup::Marks).map(|_| {
            let size = self.fitted.sizes.of(EffectGroup::Marks);
            vec![size.unwrap_or_default(); 3]
        });
        let further = further.unwrap_or_default();
        let J = DMatrix::from_fn(value.len(), n + further.len(), |row, column| {
            match (column.checked_sub(n), &jacobian[row].1) {
                (None, _) => jacobian[row].0[column],
                (Some(k), Some(by_place)) => by_place[k],
                (Some(_), None) => 0.0,
            }
        });
        let [all, before] =
            blocks.map(|blocks| Whitening::new(&blocks, &[], &precision, &fitted.sizes, &free));
        let turned = |whitening: &Whitening| {
            let weights = whitening.weights(&fitted.sizes.ln);
            weighed(whitening, &weights, &J)
        };
        let new: Vec<usize> = (0..value.len())
            .filter(|row| jacobian[*row].1.is_some())
            .collect();
        let own = J.select_rows(&new) * usual.sqrt();
        let values = new.iter().map(|row| value[*row] * usual.sqrt());
        let mut readings = Readings::new(
            turned(&all),
            DVector::from_iterator(new.len(), values),
            vec![1.0; new.len()],
        );
        readings.replaced = turned(&before);
        readings.further = further;
        readings.own = Some(own);
        readings.is_finite().then_some(readings)
    }

    /// Returns the readings of a sensor with independent errors, in all cases that the fit used.
    fn alone(
        &self,
        sigma: f64,
        value: &dyn Fn(&CasePrediction) -> f64,
        change: &dyn Fn(&CasePrediction, CaseChange<'_>) -> f64,
    ) -> Option<Readings> {
        if !(sigma > 0.0) {
            return None;
        }
        let (rows, n) = (self.seen.len(), self.fitted.x.len());
        let (mut values, mut jacobian) = (DVector::zeros(rows), DMatrix::zeros(rows, n));
        for (row, case) in self.seen.iter().enumerate() {
            let case = self.case(*case)?;
            values[row] = value(case) / sigma;
            for (column, by) in case.by_unknown.iter().enumerate() {
                jacobian[(row, column)] = change(case, by) / sigma;
            }
        }
        let readings = Readings::new(jacobian, values, vec![sigma; rows]);
        readings.is_finite().then_some(readings)
    }
}

impl Readings {
    /// Joins two sets of readings with independent errors.
    fn and(mut self, more: Self) -> Self {
        let (rows, n) = (self.value.len(), self.jacobian.ncols());
        let count = rows + more.value.len();
        let value = self.value.iter().chain(more.value.iter()).copied();
        let value = DVector::from_iterator(count, value);
        let jacobian = DMatrix::from_fn(count, n, |row, column| match row.checked_sub(rows) {
            None => self.jacobian[(row, column)],
            Some(row) => more.jacobian[(row, column)],
        });
        self.unit.extend(more.unit);
        Self::new(jacobian, value, self.unit)
    }

    fn is_finite(&self) -> bool {
        let all = self.value.iter().chain(self.jacobian.iter());
        all.chain(self.replaced.iter()).all(|x| x.is_finite())
    }
}

/// Whitens rows: decorrelates them, and scales them to unit variance.
fn weighed(whitening: &Whitening, weights: &DVector<f64>, rows: &DMatrix<f64>) -> DMatrix<f64> {
    let mut turned = whitening.apply(rows);
    for (mut row, weight) in turned.row_iter_mut().zip(weights.iter()) {
        row *= *weight;
    }
    turned
}

/// Returns the measurement of a study with further cases appended. A new case has a reading of each mark, wheel and channel that the study reads,
/// except summaries over several cases. The new readings are zero. In a model with zero-stiffness motions, however, the new mark readings are
/// those of the nearest case of the study, so that predictions can be aligned with them.
fn continued(subject: &DiagnosisProblem<'_>, further: &[Vec<f64>]) -> Measurement {
    let mut new = subject.problem.measurement.clone();
    // The unit of a mark's row stays the declared noise of the study.
    new.sigma = subject.sigma;
    let mut marks: Vec<(usize, usize)> = new
        .cases
        .iter()
        .flat_map(|case| case.marks.iter().map(|read| (read.part, read.mark)))
        .collect();
    marks.sort_unstable();
    marks.dedup();
    let wheel = new.cases.iter().any(|case| case.wheel.is_some());
    let channels: Vec<Option<f64>> = (0..new.channels.len())
        .map(|k| {
            let read = new.channels[k].summary.is_none()
                && new.cases.iter().any(|case| case.channels[k].is_some());
            read.then_some(0.0)
        })
        .collect();
    let problem = &subject.problem;
    let read = |loads: &[f64], own: (usize, usize)| {
        let near = nearest(problem.programme, loads).filter(|_| !problem.free.is_empty())?;
        let mut marks = problem.measurement.cases[near].marks.iter();
        marks
            .find(|read| (read.part, read.mark) == own)
            .map(|read| read.x)
    };
    for loads in further {
        let marks = marks.iter().map(|(part, mark)| MarkReading {
            part: *part,
            mark: *mark,
            x: read(loads, (*part, *mark)).unwrap_or_default(),
            place: Span::at(0),
        });
        new.cases.push(Case {
            label: String::new(),
            loads: loads.clone(),
            marks: marks.collect(),
            wheel: wheel.then(|| WheelReading {
                position: Vec3::zeros(),
                camber_deg: 0.0,
                steer_deg: 0.0,
            }),
            channels: channels.clone(),
            held_out: false,
            place: Span::at(0),
        });
    }
    new
}

/// Returns the displacement of a point on the observed part `at`. `arm` points from the origin of the part to the point.
fn moved(change: CaseChange<'_>, at: usize, arm: &Vec3) -> Vec3 {
    let [x, y, z, a, b, c] = change.parts[at];
    Vec3::new(x, y, z) + Vec3::new(a, b, c).cross(arm)
}
