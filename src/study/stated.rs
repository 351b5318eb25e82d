//! Section `[tolerances]` of `study.toml`: manufacturing tolerances of the axle and accuracy of the rig.

use super::section::Section;
use admire_syntax::diagnostic::Diagnostic;

/// Setting for the standard deviation of a group of errors.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub enum PriorSetting {
    /// `"estimate"`: the standard deviation is estimated from the readings.
    #[default]
    Estimate,
    /// The study states the standard deviation. Zero switches the group off.
    Size(f64),
}

/// Settings of `[tolerances]`: standard deviations of groups of errors. Lengths are in millimetres.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct ToleranceSettings {
    /// True if the study contains the section `[tolerances]`.
    pub is_stated: bool,
    /// Standard deviation of the error of each hardpoint coordinate, in mm.
    pub hardpoints: PriorSetting,
    /// Standard deviation of the direction error of each axis of bushings and joints, in degrees.
    pub axes_deg: PriorSetting,
    /// Standard deviation of each spring force in the design position, relative to its value.
    pub preloads: PriorSetting,
    /// Standard deviation of each spring rate, relative to its value.
    pub spring_rates: PriorSetting,
    /// Standard deviation of each bushing stiffness that is not identified, relative to its value.
    pub stiffnesses: PriorSetting,
    /// Relative standard deviation of the gain of each load.
    pub load_gain: PriorSetting,
    /// Standard deviation of the error of each load in each case, relative to the largest value of that load.
    pub load_repeatability: PriorSetting,
    /// Standard deviation of the direction error of each load, in degrees.
    pub load_direction_deg: PriorSetting,
    /// Standard deviation of the position error of a mark on its part, per coordinate, in mm.
    pub marks_on_parts: PriorSetting,
    /// Standard deviation of the position error of the measuring frame, which is constant over the cases, in mm. The standard deviation of the
    /// frame's rotation, in radians, is this value divided by 0.5 m.
    pub alignment: PriorSetting,
    /// Standard deviation of the common displacement of all marks at the largest value of each load, in mm. The standard deviation of their
    /// rotation, in radians, is this value divided by 0.5 m.
    pub mount: PriorSetting,
    /// Standard deviation of the translational error of a part's measured pose in one case, in mm. The standard deviation of the rotational
    /// error, in radians, is this value divided by 0.1 m.
    pub pose: PriorSetting,
}

impl ToleranceSettings {
    pub(super) fn read(section: &mut Section<'_>, out: &mut Vec<Diagnostic>) -> Self {
        let is_stated = section.is_present();
        let mut stated = |key: &'static str| {
            if section.is_text(key) {
                section.choice(
                    key,
                    PriorSetting::Estimate,
                    &[("estimate", PriorSetting::Estimate)],
                    out,
                )
            } else {
                section
                    .optional_number(key, 0.0..=1e6, out)
                    .map_or(PriorSetting::Estimate, PriorSetting::Size)
            }
        };
        Self {
            is_stated,
            hardpoints: stated("hardpoints"),
            axes_deg: stated("axes_deg"),
            preloads: stated("preloads"),
            spring_rates: stated("spring_rates"),
            stiffnesses: stated("stiffnesses"),
            load_gain: stated("load_gain"),
            load_repeatability: stated("load_repeatability"),
            load_direction_deg: stated("load_direction_deg"),
            marks_on_parts: stated("marks_on_parts"),
            alignment: stated("alignment"),
            mount: stated("mount"),
            pose: stated("pose"),
        }
    }
}
