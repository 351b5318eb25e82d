use std::collections::BTreeMap;

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

/// A mark on a part, as measured in the first CMM session.
#[derive(Clone, PartialEq, Debug)]
pub struct PartMark {
    /// Label of the mark in both files.
    pub label: String,
    /// Position in the part's own frame.
    pub p: Vec3,
}

/// A part that carries marks.
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

/// Reading of one mark in one load case.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MarkReading {
    /// Index into [`Measurement::parts`].
    pub part: usize,
    /// Index into [`MarkedPart::marks`].
    pub mark: usize,
    /// Measured position in ground.
    pub x: Vec3,
    /// Row of the file.
    pub place: Span,
}

/// One load case and its readings.
#[derive(Clone, PartialEq, Debug)]
pub struct Case {
    /// Label of the case.
    pub label: String,
    /// Loads in the order of the study's columns.
    pub loads: Vec<f64>,
    /// Readings of marks, sorted by part and mark.
    pub marks: Vec<MarkReading>,
    /// Reading of the wheel.
    pub wheel: Option<WheelReading>,
    /// One value per channel; `None` if it is missing.
    pub channels: Vec<Option<f64>>,
    /// True if the case is held out of all fits. It is still applied in its order.
    pub held_out: bool,
    /// Row in the file of load cases.
    pub place: Span,
}

/// The wheel of a study.
#[derive(Clone, PartialEq, Debug)]
pub struct Wheel {
    /// Marker on the wheel carrier.
    pub marker: MarkerIx,
    /// Spin axis of the wheel.
    pub spin: SpinDirection,
    /// Standard deviation of a coordinate.
    pub sigma_position: f64,
    /// Standard deviation of camber and steer, in degrees.
    pub sigma_angle_deg: f64,
}

/// A scalar sensor.
#[derive(Clone, PartialEq, Debug)]
pub struct Channel {
    /// Name of the channel.
    pub name: String,
    /// Column in the file, and the factor from its unit to the channel's unit.
    pub column: (String, f64),
    /// Text of an ADAMS function of the deck.
    pub function: String,
    /// Auxiliary markers of this function that the deck does not contain.
    pub helpers: Vec<Helper>,
    /// Standard deviation of one reading. If the study does not state it, it starts at a tenth of the readings' rms until a fit's residuals
    /// give an estimate.
    pub sigma: f64,
    /// True if the study does not state `sigma`.
    pub sigma_estimated: bool,
    /// Unit of the values, for reports.
    pub unit: Option<String>,
    /// Case whose value is subtracted.
    pub relative_to: Option<Reference>,
    /// Summary over several cases, if the reading is a number taken from a curve. The reading is stored in the last of these cases.
    pub summary: Option<Summary>,
    /// True if the channel is held out of all fits.
    pub held_out: bool,
}

impl Channel {
    /// Returns true if the channel is read in each case.
    pub fn is_read_by_case(&self) -> bool {
        self.summary.is_none() && !self.column.0.is_empty()
    }

    /// Returns the unit to follow a number: with a leading blank, or empty if the study states none.
    pub fn behind(&self) -> String {
        self.unit
            .as_ref()
            .map_or_else(String::new, |unit| format!(" {unit}"))
    }
}

/// Zero reference of a reading.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reference {
    /// Value in this case.
    Case(usize),
    /// Value in the preceding case, as on a gauge that is set to zero before each load.
    Previous,
}

impl Channel {
    /// Returns the index of the case whose value is subtracted in a given case.
    pub fn reference(&self, case: usize) -> Option<usize> {
        match self.relative_to? {
            Reference::Case(zero) => Some(zero),
            Reference::Previous => case.checked_sub(1),
        }
    }
}

/// All readings of a study, with every name resolved against the deck's model.
#[derive(Clone, PartialEq, Debug)]
pub struct Measurement {
    /// Load cases in the order of application.
    pub cases: Vec<Case>,
    /// Parts that carry marks.
    pub parts: Vec<MarkedPart>,
    /// Standard deviation of one measured mark coordinate; zero if the readings are exact.
    pub sigma: f64,
    /// True if `sigma` was estimated from the marks themselves.
    pub sigma_estimated: bool,
    /// Standard deviation of one coordinate of the first session, constant over cases.
    pub sigma_on_parts: f64,
    /// The wheel and its noise.
    pub wheel: Option<Wheel>,
    /// Scalar sensors.
    pub channels: Vec<Channel>,
}

impl Measurement {
    /// Computes the pose of a marked part in a case from its marks.
    ///
    /// # Errors
    /// Too few or collinear marks.
    pub fn orientation(&self, case: usize, part: usize) -> Result<Orientation, OrientationError> {
        let (on_part, measured) = self.pairs(case, part);
        absolute_orientation(&on_part, &measured, self.sigma)
    }

    /// Returns the positions of a part's marks in a case: in the part frame, and as measured in ground.
    pub fn pairs(&self, case: usize, part: usize) -> (Vec<Vec3>, Vec<Vec3>) {
        self.cases[case]
            .marks
            .iter()
            .filter(|reading| reading.part == part)
            .map(|reading| (self.parts[part].marks[reading.mark].p, reading.x))
            .unzip()
    }

    /// Returns the measured pose of every part of the model in a case. Ground has the identity; a part without a pose is `None`.
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

    /// Returns true if a fit restricted to the cases accepted by `is_seen` uses the reading of a channel stored in `case`.
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

    /// Returns the index of the case with this label.
    pub fn case(&self, label: &str) -> Option<usize> {
        self.cases.iter().position(|case| case.label == label)
    }
}

/// Resolves the wheel settings of a study against the model.
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

/// Diagnostics grouped by a key, so that a fault of a whole file is reported once.
#[derive(Default)]
pub(super) struct Grouped(BTreeMap<String, (Diagnostic, usize)>);

impl Grouped {
    /// Adds one occurrence. The first of a group is reported, the others are counted.
    pub(crate) fn add(&mut self, key: String, diagnostic: impl FnOnce() -> Diagnostic) {
        let entry = self.0.entry(key).or_insert_with(|| (diagnostic(), 0));
        entry.1 += 1;
    }

    /// Appends the collected diagnostics to `out`.
    pub(crate) fn finish(self, out: &mut Vec<Diagnostic>) {
        for (mut diagnostic, count) in self.0.into_values() {
            if count > 1 {
                diagnostic.message += &format!(" (and {} more)", count - 1);
            }
            out.push(diagnostic);
        }
    }
}
