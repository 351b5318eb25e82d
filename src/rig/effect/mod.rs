//! Effects that a model may lack, planted in the ground truth that a virtual rig measures. Each cause of guide/study.md has its own file.
//!
//! The force laws of the effects are edits of the deck made before it is compiled: additional statements, changed numbers, changed loads,
//! faults of the readings. Only history-dependent effects (friction, creep) have a law of their own, in `memory`. The module is independent of
//! how the diagnosis finds an effect. Six further effects lie outside the catalogue of guide/study.md; for these a diagnosis must not name a
//! cause of the catalogue with confidence.

mod assembly_offset;
mod asymmetric_friction;
mod body_compliance;
mod bushing_coupling;
mod bushing_orientation;
mod channel_fault;
mod creep;
mod dry_friction;
mod element_parameter;
mod frame_drift;
mod free_play;
mod hardpoint_error;
mod link_compliance;
mod load_crosstalk;
mod load_direction;
mod load_gain;
mod load_point_error;
mod mark_outlier;
mod mark_place;
mod marks_exchanged;
mod memory;
mod part_flexibility;
mod point;
mod progressive_stiffness;
mod reality;
mod spec;
mod stop_contact;
mod thermal_drift;

pub(super) use load_direction::direction_of;
pub use memory::HistoryState;
pub(super) use point::{held, points};
pub use reality::Marked;
pub(crate) use reality::{GroundTruth, ReadingFault};
pub use spec::EffectSpec;

use admire_syntax::diagnostic::Diagnostic;

type Plant = fn(&EffectSpec, &mut GroundTruth) -> Result<(), Diagnostic>;

/// Every cause of guide/study.md with the function that plants it.
const CAUSES: &[(&str, Plant)] = &[
    ("progressive-stiffness", progressive_stiffness::plant),
    ("dry-friction", dry_friction::plant),
    ("link-compliance", link_compliance::plant),
    ("free-play", free_play::plant),
    ("body-compliance", body_compliance::plant),
    ("assembly-offset", assembly_offset::plant),
    ("hardpoint-error", hardpoint_error::plant),
    ("bushing-orientation", bushing_orientation::plant),
    ("bushing-coupling", bushing_coupling::plant),
    ("element-parameter", element_parameter::plant),
    ("stop-contact", stop_contact::plant),
    ("load-gain", load_gain::plant),
    ("load-crosstalk", load_crosstalk::plant),
    ("load-point-error", load_point_error::plant),
    ("frame-drift", frame_drift::plant),
    ("mark-outlier", mark_outlier::plant),
    ("mark-place", mark_place::plant),
    ("channel-fault", channel_fault::plant),
];

/// Effects outside the catalogue that a rig may also meet.
const OUTSIDE: &[(&str, Plant)] = &[
    ("creep", creep::plant),
    ("part-flexibility", part_flexibility::plant),
    ("asymmetric-friction", asymmetric_friction::plant),
    ("thermal-drift", thermal_drift::plant),
    ("marks-exchanged", marks_exchanged::plant),
    ("load-direction", load_direction::plant),
];

/// Returns the causes of guide/study.md. All of them can be planted.
pub fn causes() -> impl Iterator<Item = &'static str> {
    CAUSES.iter().map(|(name, _)| *name)
}

/// Returns the effects that can be planted but are not causes of guide/study.md.
pub fn outside_causes() -> impl Iterator<Item = &'static str> {
    OUTSIDE.iter().map(|(name, _)| *name)
}

/// Plants an effect.
///
/// # Errors
/// When the cause does not exist, the address names no suitable object, or a value is missing, unknown or out of range.
pub fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let mut known = CAUSES.iter().chain(OUTSIDE);
    let Some((_, plant)) = known.find(|(name, _)| *name == spec.cause) else {
        let names: Vec<&str> = causes().chain(outside_causes()).collect();
        return Err(spec
            .refuse(format!("`{}` is no cause that can be planted", spec.cause))
            .help(format!("causes: {}", names.join(", "))));
    };
    plant(spec, reality)?;
    spec.all_used()
}
