//! `[tolerances]` of `study.toml`: how exact the axle and the rig are.

use super::section::Section;
use admire_syntax::diagnostic::Diagnostic;

/// What a user says of a size.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub enum PriorSetting {
    /// `"estimate"`: the readings tell.
    #[default]
    Estimate,
    /// A standard deviation; zero switches the group off.
    Size(f64),
}

/// `[tolerances]`: standard deviations, lengths in millimetres.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct ToleranceSettings {
    /// Each coordinate of each hardpoint, mm.
    pub hardpoints: PriorSetting,
    /// Factor of each load, parts of one.
    pub load_gain: PriorSetting,
    /// Each load in each case by itself, parts of the largest value of that load.
    pub load_repeatability: PriorSetting,
    /// Direction of each load, degrees.
    pub load_direction_deg: PriorSetting,
    /// Places of marks on their parts, mm.
    pub marks_on_parts: PriorSetting,
    /// Where the measuring frame sits, the same in all cases, mm; over half a metre also its turn.
    pub alignment: PriorSetting,
    /// How far all marks move with each load at its largest value, mm; over half a metre also their turn.
    pub mount: PriorSetting,
    /// Rigid error of a part's pose in one case, mm; over a tenth of a metre also its turn.
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
                    .optional_number(key, (0.0, 1e6), out)
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
