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

/// A mark made on a part, as the first CMM session measured it.
#[derive(Clone, PartialEq, Debug)]
pub struct PartMark {
    /// Its label in both files.
    pub label: String,
    /// In the part's own frame.
    pub p: Vec3,
}

/// A part that carries marks.
#[derive(Clone, PartialEq, Debug)]
pub struct MarkedPart {
    /// Which part.
    pub part: PartIx,
    /// Its id.
    pub id: u32,
    /// Its view name.
    pub name: String,
    /// Its marks in the order of the file.
    pub marks: Vec<PartMark>,
}

/// One mark read in one load case.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct MarkReading {
    /// Index into [`Measurement::parts`].
    pub part: usize,
    /// Index into [`MarkedPart::marks`].
    pub mark: usize,
    /// In ground.
    pub x: Vec3,
    /// The row of the file.
    pub place: Span,
}

/// One load case and what was read in it.
#[derive(Clone, PartialEq, Debug)]
pub struct Case {
    /// Its label.
    pub label: String,
    /// The loads, in the order of the study's columns.
    pub loads: Vec<f64>,
    /// Marks, sorted by part and mark.
    pub marks: Vec<MarkReading>,
    /// The wheel.
    pub wheel: Option<WheelReading>,
    /// One value per channel; `None` where it is missing.
    pub channels: Vec<Option<f64>>,
    /// No fit sees it; it is still applied in its order.
    pub held_out: bool,
    /// Its row of the load cases.
    pub place: Span,
}

/// The wheel of a study.
#[derive(Clone, PartialEq, Debug)]
pub struct Wheel {
    /// The marker on the wheel carrier.
    pub marker: MarkerIx,
    /// Its spin axis.
    pub spin: SpinDirection,
    /// Sd of a coordinate.
    pub sigma_position: f64,
    /// Sd of camber and steer, degrees.
    pub sigma_angle_deg: f64,
}

/// A scalar sensor.
#[derive(Clone, PartialEq, Debug)]
pub struct Channel {
    /// Its name.
    pub name: String,
    /// Its column, and what one unit there is in units of the channel.
    pub column: (String, f64),
    /// The text of an ADAMS function of the deck.
    pub function: String,
    /// Markers of this function that the deck has not.
    pub helpers: Vec<Helper>,
    /// Sd of one reading. Where it is not stated, a tenth of the readings' rms until it is estimated from what a fit leaves.
    pub sigma: f64,
    /// True if the study does not state `sigma`.
    pub sigma_estimated: bool,
    /// Its unit, for reports.
    pub unit: Option<String>,
    /// The case whose value is subtracted.
    pub relative_to: Option<Reference>,
    /// What is taken from its values in several cases, if that is what was read; the reading stands in the last of them.
    pub summary: Option<Summary>,
    /// No fit sees it.
    pub held_out: bool,
}

impl Channel {
    /// True if it is read in each case.
    pub fn is_read_by_case(&self) -> bool {
        self.summary.is_none() && !self.column.0.is_empty()
    }

    /// Its unit as it stands behind a number: a blank before it, nothing where the study states none.
    pub fn behind(&self) -> String {
        self.unit
            .as_ref()
            .map_or_else(String::new, |unit| format!(" {unit}"))
    }
}

/// What a reading counts from.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Reference {
    /// The value in this case.
    Case(usize),
    /// The value in the case before, as a gauge shows that is set to zero before each load.
    Previous,
}

impl Channel {
    /// Index of the case whose value is subtracted in a case.
    pub fn reference(&self, case: usize) -> Option<usize> {
        match self.relative_to? {
            Reference::Case(zero) => Some(zero),
            Reference::Previous => case.checked_sub(1),
        }
    }
}

/// What was measured, with every name resolved against the deck's model.
#[derive(Clone, PartialEq, Debug)]
pub struct Measurement {
    /// Load cases in the order of application.
    pub cases: Vec<Case>,
    /// Parts that carry marks.
    pub parts: Vec<MarkedPart>,
    /// Sd of one measured mark coordinate; zero if the readings are exact.
    pub sigma: f64,
    /// True if `sigma` was estimated from the marks themselves.
    pub sigma_estimated: bool,
    /// Sd of one coordinate of the first session, constant over cases.
    pub sigma_on_parts: f64,
    /// The wheel.
    pub wheel: Option<Wheel>,
    /// Scalar sensors.
    pub channels: Vec<Channel>,
}

impl Measurement {
    /// The pose of a marked part in a case, from its marks.
    ///
    /// # Errors
    /// Too few or collinear marks.
    pub fn orientation(&self, case: usize, part: usize) -> Result<Orientation, OrientationError> {
        let (on_part, measured) = self.pairs(case, part);
        absolute_orientation(&on_part, &measured, self.sigma)
    }

    /// The marks of a part in a case: in the part frame and as measured.
    pub fn pairs(&self, case: usize, part: usize) -> (Vec<Vec3>, Vec<Vec3>) {
        self.cases[case]
            .marks
            .iter()
            .filter(|reading| reading.part == part)
            .map(|reading| (self.parts[part].marks[reading.mark].p, reading.x))
            .unzip()
    }

    /// The measured pose of every part of the model in a case: ground is where it is, a part without a pose is `None`.
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

    /// The cases a fit may see.
    pub fn fitted_cases(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.cases.len()).filter(|&case| !self.cases[case].held_out)
    }

    /// Whether a fit that does not see these cases sees the reading of a channel that stands in `case`.
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

    /// Index of the case with this label.
    pub fn case(&self, label: &str) -> Option<usize> {
        self.cases.iter().position(|case| case.label == label)
    }
}

/// The wheel of a study, resolved.
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

/// Complaints are grouped by what they say, so that a fault of a whole file is said once.
#[derive(Default)]
pub(super) struct Grouped(BTreeMap<String, (Diagnostic, usize)>);

impl Grouped {
    /// Adds one occurrence; the first one is shown, the others counted.
    pub(crate) fn add(&mut self, key: String, diagnostic: impl FnOnce() -> Diagnostic) {
        let entry = self.0.entry(key).or_insert_with(|| (diagnostic(), 0));
        entry.1 += 1;
    }

    /// Hands over what was found.
    pub(crate) fn finish(self, out: &mut Vec<Diagnostic>) {
        for (mut diagnostic, count) in self.0.into_values() {
            if count > 1 {
                diagnostic.message += &format!(" (and {} more)", count - 1);
            }
            out.push(diagnostic);
        }
    }
}
