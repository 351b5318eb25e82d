//! Comparison of readings with predictions: whitened residuals and their derivatives.
//!
//! Besides the unknowns of the deck, the residuals depend on unknowns of the measurement. These are a displacement of the measuring frame in
//! each case, motions of the frame over all cases, and position errors of the marks on their parts. This module is independent of the solver.

use nalgebra::{DMatrix, DVector, Dyn, U1};

use super::free::FreeRows;
use super::predictor::{CaseChange, CasePrediction, Observed};
use crate::settings::{FREE_UNAFFECTED_SIGMA, MIN_RELATIVE_MARK_SIGMA};
use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::Model;
use admire_study::wheel::{camber_deg, steer_deg};
use admire_study::{Case, Measurement, Over, Summary};

/// Mutable view of a row of a Jacobian.
type RowViewMut<'a, T> = nalgebra::MatrixViewMut<'a, T, U1, Dyn, U1, Dyn>;

/// Identifies the scalar reading that a row of residuals belongs to.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Row {
    /// A coordinate of a mark.
    Mark {
        /// Index of the load case.
        case: usize,
        /// Index into the mark readings of the case.
        reading: usize,
        /// Ground axis: 0, 1, 2 for x, y, z.
        axis: usize,
    },
    /// A component of a wheel reading.
    Wheel {
        /// Index of the load case.
        case: usize,
        /// Component of the wheel reading: 0 to 2 for the position, 3 for camber, 4 for steer.
        component: usize,
    },
    /// A reading of a channel (scalar sensor).
    Channel {
        /// Index of the load case.
        case: usize,
        /// Index into the channels of the measurement.
        channel: usize,
    },
}

impl Row {
    /// Returns the index of the load case that the row belongs to.
    pub const fn case(self) -> usize {
        match self {
            Self::Mark { case, .. } | Self::Wheel { case, .. } | Self::Channel { case, .. } => case,
        }
    }
}

/// Displacement of the measuring frame over the load cases: a sum of rigid motions. Each motion has six unknowns and is multiplied by one known
/// factor per case.
#[derive(Clone, PartialEq, Debug)]
pub struct FrameMotions {
    /// Index of the first unknown. Each motion has six unknowns: three of the translation, then three of the rotation vector.
    pub first: usize,
    /// Centre of the rotations, in ground.
    pub centre: Vec3,
    /// Rotation in radians per unit of a rotation-vector unknown.
    pub turn: f64,
    /// Factor of each motion in each case, as `[motion][case]`.
    pub factors: Vec<Vec<f64>>,
}

impl FrameMotions {
    /// Iterates over the motions in a load case. Yields the index of the first unknown of each motion, and its factor.
    pub fn of(&self, case: usize) -> impl Iterator<Item = (usize, f64)> {
        let each = self.factors.iter().enumerate();
        each.map(move |(k, factors)| (self.first + 6 * k, factors[case]))
    }
}

/// Layout of the unknowns of the measurement (nuisance parameters). In the vector of all unknowns they follow the unknowns of the deck.
#[derive(Clone, PartialEq, Debug, Default)]
pub struct NuisanceLayout {
    /// Index of the first frame unknown; `None` if there are none. Each case has six: the translation of the frame, and its rotation vector
    /// about the centroid of the marks read in the case.
    pub frames: Option<usize>,
    /// Motions of the measuring frame over all cases; `None` if there are none.
    pub motions: Option<FrameMotions>,
    /// Index of the first mark unknown; `None` if there are none. Each mark of every part has three: the error of its position on the part.
    pub marks: Option<usize>,
    /// Position of the first mark of each marked part in the list of all marks.
    pub first_mark: Vec<usize>,
    /// Prior standard deviation of each unknown of the measurement, in order.
    pub sd: Vec<f64>,
}

impl NuisanceLayout {
    /// Creates the layout. If the standard deviations of the frame's shift (length) and turn (radians) are both zero, there are no frame
    /// unknowns. If `sigma_on_parts` is zero, there are no mark unknowns.
    pub(crate) fn new(
        measurement: &Measurement,
        deck_unknowns: usize,
        frame_shift_sd: f64,
        frame_turn_sd: f64,
    ) -> Self {
        let mut layout = Self::default();
        let mut next = deck_unknowns;
        if frame_shift_sd > 0.0 || frame_turn_sd > 0.0 {
            layout.frames = Some(next);
            for _ in &measurement.cases {
                layout.sd.extend([frame_shift_sd; 3]);
                layout.sd.extend([frame_turn_sd; 3]);
                next += 6;
            }
        }
        let mut marks = 0;
        for part in &measurement.parts {
            layout.first_mark.push(marks);
            marks += part.marks.len();
        }
        if measurement.sigma_on_parts > 0.0 {
            layout.marks = Some(next);
            layout
                .sd
                .extend(std::iter::repeat_n(measurement.sigma_on_parts, 3 * marks));
        }
        layout
    }
}

/// Whitened residuals and their derivatives. A residual is prediction minus reading, divided by the standard deviation of the reading.
#[derive(Clone, Debug)]
pub struct Evaluation {
    /// Whitened residual of each row.
    pub residual: DVector<f64>,
    /// Derivatives of the residuals, one row per residual and one column per unknown. The matrix has no columns if derivatives were not
    /// requested.
    pub jacobian: DMatrix<f64>,
    /// Orthonormal directions in the space of rows along which free (zero-stiffness) motions move the readings. Each direction is a list of
    /// pairs of row and weight. Residuals along these directions have been removed.
    pub free: Vec<Vec<(usize, f64)>>,
}

/// Readings that a fit compares with predictions, in a fixed order.
#[derive(Clone, Debug)]
pub struct Observations<'a> {
    measurement: &'a Measurement,
    /// Rows of the residual vector, in order.
    pub rows: Vec<Row>,
    /// Parts and marks whose motion the predictor must report.
    pub observed: Observed,
    /// For each marked part of the measurement: its index in `observed.parts`.
    place: Vec<usize>,
    wheel_place: usize,
    wheel_frame: Pose,
    /// Standard deviation per mark coordinate that the fit uses; never zero.
    pub sigma: f64,
}

impl<'a> Observations<'a> {
    /// Collects all readings of the given cases.
    pub fn new(measurement: &'a Measurement, model: &Model, cases: &[usize]) -> Self {
        let mut observed = Observed::of(measurement);
        let parts = measurement.parts.iter();
        let place = parts.map(|marked| observed.place(marked.part)).collect();
        let (mut wheel_place, mut wheel_frame) = (0, Pose::identity());
        if let Some(wheel) = &measurement.wheel {
            let marker = &model.markers[wheel.marker.0];
            wheel_place = observed.place(marker.part);
            wheel_frame = Pose {
                p: marker.qp,
                R: marker.R,
            };
        }
        let mut rows = Vec::new();
        let mut size = 0.0_f64;
        for &case in cases {
            for (reading, mark) in measurement.cases[case].marks.iter().enumerate() {
                rows.extend((0..3).map(|axis| Row::Mark {
                    case,
                    reading,
                    axis,
                }));
                size = size.max(mark.x.amax());
            }
            if measurement.wheel.is_some() && measurement.cases[case].wheel.is_some() {
                rows.extend((0..5).map(|component| Row::Wheel { case, component }));
            }
            for (channel, value) in measurement.cases[case].channels.iter().enumerate() {
                if value.is_some() {
                    rows.push(Row::Channel { case, channel });
                }
            }
        }
        let sigma = measurement
            .sigma
            .max(MIN_RELATIVE_MARK_SIGMA * size.max(1.0));
        Self {
            measurement,
            rows,
            observed,
            place,
            wheel_place,
            wheel_frame,
            sigma,
        }
    }

    /// Collects the readings of the given cases that a fit may use. Held-out channels are left out. A summary of a channel over several
    /// cases is left out unless all its cases are given.
    pub fn fitted(measurement: &'a Measurement, model: &Model, cases: &[usize]) -> Self {
        let mut new = Self::new(measurement, model, cases);
        let is_seen = |case: usize| cases.contains(&case);
        new.rows.retain(|row| match *row {
            Row::Channel { case, channel } => measurement.sees_channel(channel, case, &is_seen),
            _ => true,
        });
        new
    }

    /// Returns the cases whose readings are compared, in the order of the rows.
    pub(crate) fn cases(&self) -> Vec<usize> {
        let mut cases: Vec<usize> = self.rows.iter().map(|row| row.case()).collect();
        cases.dedup();
        cases
    }

    /// Returns the measurement that the readings belong to.
    pub(crate) fn measurement(&self) -> &'a Measurement {
        self.measurement
    }

    /// Returns all cases with the mark readings replaced by their predictions. `residual` holds the whitened residuals (prediction minus
    /// reading) of all rows.
    pub fn predicted(&self, residual: &DVector<f64>) -> Vec<Case> {
        let mut out = self.measurement.cases.clone();
        for (row, residual) in self.rows.iter().zip(residual.iter()) {
            if let Row::Mark {
                case,
                reading,
                axis,
            } = *row
            {
                out[case].marks[reading].x[axis] += residual * self.sigma;
            }
        }
        out
    }

    /// Computes the residuals of all rows and their derivatives with respect to the first `columns` unknowns of `x`.
    ///
    /// In `x`, the unknowns of the deck precede the unknowns of the measurement. Columns without a predicted derivative are zero. Returns
    /// `None` if a compared case has no prediction.
    pub fn evaluate(
        &self,
        prediction: &[Option<CasePrediction>],
        layout: &NuisanceLayout,
        x: &[f64],
        columns: usize,
    ) -> Option<Evaluation> {
        let mut residual = DVector::zeros(self.rows.len());
        let mut jacobian = DMatrix::zeros(self.rows.len(), columns);
        for (at, row) in self.rows.iter().enumerate() {
            let case = row.case();
            let predicted = prediction[case].as_ref()?;
            match *row {
                // All three rows of a mark are filled when the first of them is reached.
                Row::Mark {
                    reading, axis: 0, ..
                } => {
                    self.mark(
                        at,
                        case,
                        reading,
                        predicted,
                        (layout, x),
                        (&mut residual, &mut jacobian),
                    );
                }
                Row::Wheel { component: 0, .. } => {
                    self.wheel(at, case, predicted, (&mut residual, &mut jacobian));
                }
                Row::Mark { .. } | Row::Wheel { .. } => {}
                Row::Channel { channel, .. } => {
                    let info = &self.measurement.channels[channel];
                    if let Some(summary) = &info.summary {
                        let row = (&mut residual[at], jacobian.row_mut(at));
                        self.summary(summary, (case, channel), prediction, columns, row)?;
                        continue;
                    }
                    let other = match info.reference(case) {
                        Some(zero) => Some(prediction[zero].as_ref()?),
                        None => None,
                    };
                    let reading = self.measurement.cases[case].channels[channel]?;
                    let zero = other.map_or(0.0, |p| p.channels[channel]);
                    residual[at] = (predicted.channels[channel] - zero - reading) / info.sigma;
                    for (k, change) in predicted.by_unknown.iter().enumerate().take(columns) {
                        let zero = other.map_or(0.0, |p| p.by_unknown.get(k).channels[channel]);
                        jacobian[(at, k)] = (change.channels[channel] - zero) / info.sigma;
                    }
                }
            }
        }
        let free = self.without_free(prediction, (&mut residual, &mut jacobian));
        Some(Evaluation {
            residual,
            jacobian,
            free,
        })
    }

    /// Removes the effect of free motions from residuals and derivatives. Returns the directions in the space of rows that were removed.
    fn without_free(
        &self,
        prediction: &[Option<CasePrediction>],
        (residual, jacobian): (&mut DVector<f64>, &mut DMatrix<f64>),
    ) -> Vec<Vec<(usize, f64)>> {
        let mut out = Vec::new();
        let mut first = 0;
        for own in self.rows.chunk_by(|a, b| a.case() == b.case()) {
            let from = first;
            first += own.len();
            let Some(predicted) = &prediction[own[0].case()] else {
                continue;
            };
            let Some((rows, free)) = self.free_rows(own, predicted) else {
                continue;
            };
            let rows: Vec<usize> = rows.into_iter().map(|row| from + row).collect();
            let mut left = DMatrix::from_columns(&[residual.select_rows(&rows)]);
            let projection = free.projection(&left.column(0).into_owned());
            projection.apply(&mut left);
            let mut changes = jacobian.select_rows(&rows);
            projection.apply(&mut changes);
            for (k, row) in rows.iter().enumerate() {
                residual[*row] = left[k];
                jacobian.set_row(*row, &changes.row(k));
            }
            for direction in free.basis().column_iter() {
                out.push(
                    rows.iter()
                        .copied()
                        .zip(direction.iter().copied())
                        .collect(),
                );
            }
        }
        out
    }

    /// Returns the rows of a case that its free motions affect, with their derivatives. `None` if no row is affected. Summaries over several
    /// cases count as unaffected.
    fn free_rows(
        &self,
        rows: &[Row],
        predicted: &CasePrediction,
    ) -> Option<(Vec<usize>, FreeRows)> {
        if predicted.free.is_empty() {
            return None;
        }
        let mut F = DMatrix::zeros(rows.len(), predicted.free.len());
        for (at, row) in rows.iter().enumerate() {
            for (k, change) in predicted.free.iter().enumerate() {
                match *row {
                    Row::Mark {
                        case,
                        reading,
                        axis: 0,
                    } => {
                        let reading = self.measurement.cases[case].marks[reading];
                        let local = self.measurement.parts[reading.part].marks[reading.mark].p;
                        let place = self.place[reading.part];
                        let arm = predicted.poses[self.observed.parts[place].0].R * local;
                        let by = moved(&change.parts[place], &arm) / self.sigma;
                        F.fixed_view_mut::<3, 1>(at, k).copy_from(&by);
                    }
                    Row::Wheel { component: 0, .. } => {
                        for (axis, by) in self.wheel_change(predicted, &change).iter().enumerate() {
                            F[(at + axis, k)] = *by;
                        }
                    }
                    Row::Mark { .. } | Row::Wheel { .. } => {}
                    Row::Channel { channel, .. } => {
                        let info = &self.measurement.channels[channel];
                        if info.summary.is_none() {
                            F[(at, k)] = change.channels[channel] / info.sigma;
                        }
                    }
                }
            }
        }
        let moves = |at: usize, count: usize| F.rows(at, count).amax() > FREE_UNAFFECTED_SIGMA;
        let mut readings = Vec::new();
        let mut moved = Vec::new();
        for (at, row) in rows.iter().enumerate() {
            let count = match row {
                Row::Mark { axis: 0, .. } => 3,
                Row::Mark { .. } => continue,
                Row::Wheel { .. } | Row::Channel { .. } => 1,
            };
            if moves(at, count) {
                readings.push((moved.len(), count));
                moved.extend(at..at + count);
            }
        }
        (!moved.is_empty()).then(|| {
            let rows = FreeRows::new(F.select_rows(&moved), readings);
            (moved, rows)
        })
    }

    /// Evaluates the residual and the derivatives of a summary of a channel over several cases. Returns `None` if a case has no prediction.
    fn summary(
        &self,
        summary: &Summary,
        (case, channel): (usize, usize),
        prediction: &[Option<CasePrediction>],
        columns: usize,
        (residual, mut row): (&mut f64, RowViewMut<'_, f64>),
    ) -> Option<()> {
        let sigma = self.measurement.channels[channel].sigma;
        let reading = self.measurement.cases[case].channels[channel]?;
        let cases = summary.cases.iter();
        let cases: Vec<&CasePrediction> = cases
            .map(|k| prediction[*k].as_ref())
            .collect::<Option<_>>()?;
        let of = |channel: usize| cases.iter().map(|case| case.channels[channel]).collect();
        let curve: Vec<f64> = of(channel);
        let taken = summary.take(&curve, &of);
        *residual = (taken.value - reading) / sigma;
        let over = match summary.over {
            Over::Channel(over) => Some(over),
            Over::Load(_) => None,
        };
        for (k, case) in cases.iter().enumerate() {
            for (column, change) in case.by_unknown.iter().enumerate().take(columns) {
                let by_over = over.map_or(0.0, |over| taken.by_over[k] * change.channels[over]);
                row[column] += (taken.by_curve[k] * change.channels[channel] + by_over) / sigma;
            }
        }
        Some(())
    }

    fn mark(
        &self,
        at: usize,
        case: usize,
        reading: usize,
        predicted: &CasePrediction,
        (layout, x): (&NuisanceLayout, &[f64]),
        (residual, jacobian): (&mut DVector<f64>, &mut DMatrix<f64>),
    ) {
        let reading = self.measurement.cases[case].marks[reading];
        let part = &self.measurement.parts[reading.part];
        let place = self.place[reading.part];
        let pose = &predicted.poses[self.observed.parts[place].0];
        let mut local = part.marks[reading.mark].p;
        let error = layout
            .marks
            .map(|first| first + 3 * (layout.first_mark[reading.part] + reading.mark));
        if let Some(k) = error {
            local += Vec3::new(x[k], x[k + 1], x[k + 2]);
        }
        let arm = pose.R * local;
        let mut point = pose.p + arm;
        let mut turned = Vec3::zeros();
        let around = layout.motions.as_ref().map(|motions| {
            let lever = point - motions.centre;
            for (k, factor) in motions.of(case) {
                point += factor * Vec3::new(x[k], x[k + 1], x[k + 2]);
                turned += factor * motions.turn * Vec3::new(x[k + 3], x[k + 4], x[k + 5]);
            }
            point += turned.cross(&lever);
            (motions, lever)
        });
        let frame = layout.frames.map(|first| first + 6 * case);
        let lever = reading.x - self.centroid(case);
        if let Some(k) = frame {
            point += Vec3::new(x[k], x[k + 1], x[k + 2])
                + Vec3::new(x[k + 3], x[k + 4], x[k + 5]).cross(&lever);
        }
        let difference = (point - reading.x) / self.sigma;
        for axis in 0..3 {
            residual[at + axis] = difference[axis];
        }
        let columns = jacobian.ncols();
        if columns == 0 {
            return;
        }
        let mut put = |column: usize, change: Vec3| {
            if column >= columns {
                return;
            }
            for axis in 0..3 {
                jacobian[(at + axis, column)] = change[axis] / self.sigma;
            }
        };
        for (k, change) in predicted.by_unknown.iter().enumerate() {
            let change = moved(&change.parts[place], &arm);
            put(k, change + turned.cross(&change));
        }
        for k in 0..3 {
            if let Some(first) = error {
                let along: Vec3 = pose.R.column(k).into();
                put(first + k, along + turned.cross(&along));
            }
            if let Some(first) = frame {
                put(first + k, Vec3::ith(k, 1.0));
                put(first + 3 + k, Vec3::ith(k, 1.0).cross(&lever));
            }
            if let Some((motions, lever)) = &around {
                let by_turn = Vec3::ith(k, motions.turn).cross(lever);
                for (first, factor) in motions.of(case) {
                    put(first + k, Vec3::ith(k, factor));
                    put(first + 3 + k, factor * by_turn);
                }
            }
        }
    }

    fn wheel(
        &self,
        at: usize,
        case: usize,
        predicted: &CasePrediction,
        (residual, jacobian): (&mut DVector<f64>, &mut DMatrix<f64>),
    ) {
        let (Some(wheel), Some(reading)) =
            (&self.measurement.wheel, self.measurement.cases[case].wheel)
        else {
            return;
        };
        let part = &predicted.poses[self.observed.parts[self.wheel_place].0];
        let marker = part.compose(&self.wheel_frame);
        let (s, s0) = (wheel.spin.now(&marker), wheel.spin.s0);
        let (position, angle) = (wheel.sigma_position, wheel.sigma_angle_deg);
        let difference = (marker.p - reading.position) / position;
        for k in 0..3 {
            residual[at + k] = difference[k];
        }
        residual[at + 3] = (camber_deg(&s0, &s) - reading.camber_deg) / angle;
        residual[at + 4] = wrapped_deg(steer_deg(&s0, &s) - reading.steer_deg) / angle;
        let columns = jacobian.ncols();
        for (k, change) in predicted.by_unknown.iter().enumerate().take(columns) {
            for (axis, by) in self.wheel_change(predicted, &change).iter().enumerate() {
                jacobian[(at + axis, k)] = *by;
            }
        }
    }

    /// Returns the whitened change of the five components of the wheel reading that a change of the part poses causes.
    fn wheel_change(&self, predicted: &CasePrediction, change: &CaseChange<'_>) -> [f64; 5] {
        let Some(wheel) = &self.measurement.wheel else {
            return [0.0; 5];
        };
        let part = &predicted.poses[self.observed.parts[self.wheel_place].0];
        let s = wheel.spin.now(&part.compose(&self.wheel_frame));
        let (position, angle) = (wheel.sigma_position, wheel.sigma_angle_deg);
        let six = &change.parts[self.wheel_place];
        let dp = moved(six, &(part.R * self.wheel_frame.p)) / position;
        let ds = Vec3::new(six[3], six[4], six[5]).cross(&s);
        // camber = asin(s0.z) - asin(s.z); steer = atan2(s.y, s.x) - atan2(s0.y, s0.x).
        let horizontal = s.x * s.x + s.y * s.y;
        let camber = (-ds.z / horizontal.sqrt()).to_degrees() / angle;
        let steer = ((s.x * ds.y - s.y * ds.x) / horizontal).to_degrees() / angle;
        [dp.x, dp.y, dp.z, camber, steer]
    }

    /// Returns the centroid of the marks read in a case. The measuring frame rotates about it, so its rotation and translation remain
    /// uncorrelated.
    fn centroid(&self, case: usize) -> Vec3 {
        let marks = &self.measurement.cases[case].marks;
        marks.iter().map(|m| m.x).sum::<Vec3>() / marks.len().max(1) as f64
    }
}

/// Returns the displacement of a point of a part. `six` holds the part's translation and rotation vector, `arm` the vector from the part's
/// origin to the point.
fn moved(six: &[f64; 6], arm: &Vec3) -> Vec3 {
    Vec3::new(six[0], six[1], six[2]) + Vec3::new(six[3], six[4], six[5]).cross(arm)
}

/// Wraps an angle difference in degrees to (-180, 180].
fn wrapped_deg(angle: f64) -> f64 {
    let wrapped = angle.rem_euclid(360.0);
    if wrapped > 180.0 {
        wrapped - 360.0
    } else {
        wrapped
    }
}
