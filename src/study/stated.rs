//! Section `[tolerances]` of `study.toml`: accuracy of the axle and the rig.

use super::section::Section;
use admire_syntax::diagnostic::Diagnostic;

/// Prior of the standard deviation of an error group.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub enum PriorSetting {
    /// `"estimate"`: the standard deviation is estimated from the readings.
    #[default]
    Estimate,
    /// A stated standard deviation; zero switches the group off.
    Size(f64),
}

/// Settings of `[tolerances]`: standard deviations, lengths in millimetres.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct ToleranceSettings {
    /// Standard deviation of the error of each hardpoint coordinate, in mm.
    pub hardpoints: PriorSetting,
    /// Relative standard deviation of the gain of each load.
    pub load_gain: PriorSetting,
    /// Standard deviation of each load in each case, relative to the largest value of that load.
    pub load_repeatability: PriorSetting,
    /// Standard deviation of the direction of each load, in degrees.
    pub load_direction_deg: PriorSetting,
    /// Standard deviation of each coordinate of a mark on its part, in mm.
    pub marks_on_parts: PriorSetting,
    /// Standard deviation of the measuring frame's position, constant over cases, in mm. Divided by 0.5 m it is also that of the rotation.
    pub alignment: PriorSetting,
    /// Standard deviation of the motion of all marks with each load at its largest value, in mm. Divided by 0.5 m it is also that of the
    /// rotation.
    pub mount: PriorSetting,
    /// Standard deviation of the rigid error of a part's pose in one case, in mm. Divided by 0.1 m it is also that of the rotation.
    pub pose: PriorSetting,
}

impl ToleranceSettings {
    pub(super) fn read(section: &mut Section<'_>, out: &mut Vec<Diagnostic>) -> Self {
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
            hardpoints: stated("hardpoints"),
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
