use std::collections::BTreeMap;

use super::available::Available;
use super::kc_curves::Helper;
use super::orientation::{Orientation, OrientationError, absolute_orientation};
use super::settings::WheelSettings;
use super::summary::Summary;
use super::wheel::{SpinDirection, WheelReading};
use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::{MarkerIx, Model, PartIx};
use admire_syntax::diagnostic::Diagnostic;
use admire_syntax::text::Span;
use admire_syntax::units::Dimension;

/// A mark (measured point) on a part, with its position from the first session on the coordinate measuring machine.
#[derive(Clone, PartialEq, Debug)]
pub struct PartMark {
    /// Label of the mark, as in both files of mark readings.
    pub label: String,
    /// Position of the mark in the part's own frame.
    pub p: Vec3,
}

/// A part that carries marks (measured points).
#[derive(Clone, PartialEq, Debug)]
pub struct MarkedPart {
    /// Index of the part in the model.
    pub part: PartIx,
    /// Id of the part.
    pub id: u32,
    /// View name of the part.
    pub name: String,
    /// Marks in the order of the file.
    pub marks: Vec<PartMark>,
}

/// Measured position of one mark in one load case.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MarkReading {
    /// Index into [`Measurement::parts`].
    pub part: usize,
    /// Index into [`MarkedPart::marks`].
    pub mark: usize,
    /// Measured position of the mark in ground.
    pub x: Vec3,
    /// Position of the row in the file of readings.
    pub place: Span,
}

/// A load case and its readings.
#[derive(Clone, PartialEq, Debug)]
pub struct Case {
    /// Label of the load case.
    pub label: String,
    /// Values of the loads, in the order of the study's load columns and in the units of the file.
    pub loads: Vec<f64>,
    /// Readings of marks, sorted by part and mark.
    pub marks: Vec<MarkReading>,
    /// Reading of the wheel, if there is one.
    pub wheel: Option<WheelReading>,
    /// Reading of each channel; `None` if it is missing.
    pub channels: Vec<Option<f64>>,
    /// True if the case is held out of all fits. Its loads are still applied in order.
    pub held_out: bool,
    /// Position of the row in the file of load cases.
    pub place: Span,
}

/// The measured wheel of a study.
#[derive(Clone, PartialEq, Debug)]
pub struct Wheel {
    /// Marker on the wheel carrier.
    pub marker: MarkerIx,
    /// Spin axis of the wheel.
    pub spin: SpinDirection,
    /// Standard deviation of the wheel position, per coordinate.
    pub sigma_position: f64,
    /// Standard deviation of camber and steer, in degrees.
    pub sigma_angle_deg: f64,
}

/// A channel: a scalar sensor that measures a function of the deck.
#[derive(Clone, PartialEq, Debug)]
pub struct Channel {
    /// Name of the channel.
    pub name: String,
    /// Name of the column in the file, and the factor from the unit of the column to the unit of the channel.
    pub column: (String, f64),
    /// ADAMS function expression that the sensor measures.
    pub function: String,
    /// Auxiliary markers that this function needs in addition to the markers of the deck.
    pub helpers: Vec<Helper>,
    /// Standard deviation of one reading. If the study does not state it, it is first set to a tenth of the rms of the readings, and later
    /// estimated from the residuals of a fit.
    pub sigma: f64,
    /// True if `sigma` is neither stated nor known from repeated readings.
    pub sigma_estimated: bool,
    /// Unit of the readings, for reports.
    pub unit: Option<String>,
    /// Zero reference: the case whose value is subtracted from each reading.
    pub relative_to: Option<Reference>,
    /// Summary over several cases, if the reading is a gradient or loop width of a curve. The reading is stored in the last of these cases.
    pub summary: Option<Summary>,
    /// True if the channel is held out of all fits.
    pub held_out: bool,
}

impl Channel {
    /// Returns true if the channel has a separate reading in each case, so it is neither a summary nor an auxiliary curve.
    pub fn is_read_by_case(&self) -> bool {
        self.summary.is_none() && !self.column.0.is_empty()
    }

    /// Returns true if every reading of the channel depends on one case only, so it is neither a summary nor relative to another case.
    pub fn is_of_single_cases(&self) -> bool {
        self.summary.is_none() && self.relative_to.is_none()
    }

    /// Returns the unit as a suffix of a number, with a leading blank. The result is empty if the study states no unit.
    pub fn behind(&self) -> String {
        self.unit
            .as_ref()
            .map_or_else(String::new, |unit| format!(" {unit}"))
    }
}

/// Zero reference of a channel.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reference {
    /// The value in the case with this index.
    Case(usize),
    /// The value in the preceding case, as for a gauge that is set to zero before each load.
    Previous,
}

impl Channel {
    /// Returns the index of the case whose value is subtracted from the reading in `case`; `None` if there is none.
    pub fn reference(&self, case: usize) -> Option<usize> {
        match self.relative_to? {
            Reference::Case(zero) => Some(zero),
            Reference::Previous => case.checked_sub(1),
        }
    }
}

/// All readings of a study, with every name resolved in the model of the deck.
#[derive(Clone, PartialEq, Debug)]
pub struct Measurement {
    /// Load cases in the order of application.
    pub cases: Vec<Case>,
    /// Parts that carry marks.
    pub parts: Vec<MarkedPart>,
    /// Standard deviation of the measured mark positions, per coordinate; zero if the readings are exact.
    pub sigma: f64,
    /// True if `sigma` is not stated by the study but estimated from the marks themselves.
    pub sigma_estimated: bool,
    /// Standard deviation of the mark positions on their parts, per coordinate, as measured in the first session. The error is constant over the
    /// cases.
    pub sigma_on_parts: f64,
    /// The measured wheel and the noise of its readings, if the study has a wheel.
    pub wheel: Option<Wheel>,
    /// Channels (scalar sensors).
    pub channels: Vec<Channel>,
    /// Measurements that the laboratory can add.
    pub available: Available,
}

impl Measurement {
    /// Computes the pose of a marked part in a case from its marks.
    ///
    /// # Errors
    /// Fails if the part has too few marks in the case, or if they are collinear.
    pub fn orientation(&self, case: usize, part: usize) -> Result<Orientation, OrientationError> {
        let (on_part, measured) = self.pairs(case, part);
        absolute_orientation(&on_part, &measured, self.sigma)
    }

    /// Returns the positions of the marks of a part that were read in a case: in the part frame, and as measured in ground.
    pub fn pairs(&self, case: usize, part: usize) -> (Vec<Vec3>, Vec<Vec3>) {
        self.cases[case]
            .marks
            .iter()
            .filter(|reading| reading.part == part)
            .map(|reading| (self.parts[part].marks[reading.mark].p, reading.x))
            .unzip()
    }

    /// Returns the measured pose of every part of the model in a case. The pose of ground is the identity. The entry of a part whose pose is
    /// not measured is `None`.
    pub fn poses(&self, case: usize, model: &Model) -> Vec<Option<Orientation>> {
        let mut poses: Vec<Option<Orientation>> = vec![None; model.parts.len()];
        if let Some(ground) = model.ground() {
            poses[ground.0] = Some(Orientation {
                pose: Pose::identity(),
                covariance: admire_solver::mechanics::Mat6::zeros(),
                residuals: Vec::new(),
                chi_square: None,
                dof: 0,
                p_value: None,
            });
        }
        for (at, marked) in self.parts.iter().enumerate() {
            if Some(marked.part) != model.ground() {
                poses[marked.part.0] = self.orientation(case, at).ok();
            }
        }
        poses
    }

    /// Returns the indices of the cases that a fit may use.
    pub fn fitted_cases(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.cases.len()).filter(|&case| !self.cases[case].held_out)
    }

    /// Returns true if a fit may use the reading of a channel that is stored in `case`. `is_seen` returns true for the cases that the fit uses.
    pub fn sees_channel(
        &self,
        channel: usize,
        case: usize,
        is_seen: &dyn Fn(usize) -> bool,
    ) -> bool {
        let info = &self.channels[channel];
        let of = info
            .summary
            .as_ref()
            .map_or(std::slice::from_ref(&case), |s| &s.cases);
        !info.held_out && of.iter().all(|case| is_seen(*case))
    }

    /// Returns the index of the load case with this label.
    pub fn case(&self, label: &str) -> Option<usize> {
        self.cases.iter().position(|case| case.label == label)
    }
}

/// Returns the wheel of a study from its settings and its marker in the model.
pub(super) fn wheel(settings: &WheelSettings, marker: MarkerIx, model: &Model) -> Wheel {
    let frame = &model.markers[marker.0];
    let part = &model.parts[frame.part.0].pose;
    let design = part.compose(&Pose {
        p: frame.qp,
        R: frame.R,
    });
    Wheel {
        marker,
        spin: SpinDirection::at_design(&design, settings.axis),
        sigma_position: (settings.sigma_position).in_units(&model.units, Dimension::LENGTH),
        sigma_angle_deg: settings.sigma_angle_deg,
    }
}

/// Diagnostics grouped by a key, so a fault that occurs in many rows is reported only once.
#[derive(Default)]
pub(super) struct Grouped(BTreeMap<String, (Diagnostic, usize)>);

impl Grouped {
    /// Adds one occurrence of a fault to the group `key`. The first occurrence in a group is reported, the others are counted.
    pub(crate) fn add(&mut self, key: String, diagnostic: impl FnOnce() -> Diagnostic) {
        let entry = self.0.entry(key).or_insert_with(|| (diagnostic(), 0));
        entry.1 += 1;
    }

    /// Appends one diagnostic per group to `out`, with the number of occurrences if there are several.
    pub(crate) fn finish(self, out: &mut Vec<Diagnostic>) {
        for (mut diagnostic, count) in self.0.into_values() {
            if count > 1 {
                diagnostic.message += &format!(" (in {count} places)");
            }
            out.push(diagnostic);
        }
    }
}
