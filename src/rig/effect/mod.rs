//! Effects that a model may lack. They are planted in the ground truth that a virtual rig measures. Each cause of guide/study.md has its own
//! file.
//!
//! An effect is planted before the deck is compiled. It adds statements to the deck, changes parameters of the deck, changes loads, or adds
//! faults of the readings. The laws of history-dependent effects (friction, creep) are in `memory`. This module is independent of the way in
//! which the diagnosis finds an effect.
//!
//! Six further effects are outside the catalogue of guide/study.md. If one of them is present, the diagnosis must not name a cause of the
//! catalogue with confidence.

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

/// All causes of guide/study.md, each with the function that plants it.
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

/// Effects outside the catalogue of guide/study.md that may occur on a rig, each with the function that plants it.
const OUTSIDE: &[(&str, Plant)] = &[
    ("creep", creep::plant),
    ("part-flexibility", part_flexibility::plant),
    ("asymmetric-friction", asymmetric_friction::plant),
    ("thermal-drift", thermal_drift::plant),
    ("marks-exchanged", marks_exchanged::plant),
    ("load-direction", load_direction::plant),
];

/// Returns the names of the causes of guide/study.md. All of them can be planted.
pub fn causes() -> impl Iterator<Item = &'static str> {
    CAUSES.iter().map(|(name, _)| *name)
}

/// Returns the names of the effects that can be planted but are not causes of guide/study.md.
pub fn outside_causes() -> impl Iterator<Item = &'static str> {
    OUTSIDE.iter().map(|(name, _)| *name)
}

/// Plants an effect in the ground truth.
///
/// # Errors
/// Fails if the cause does not exist, if the address names no suitable object, or if a value is missing, unknown or out of range.
pub fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let mut known = CAUSES.iter().chain(OUTSIDE);
    let Some((_, plant)) = known.find(|(name, _)| *name == spec.cause) else {
        let names: Vec<&str> = causes().chain(outside_causes()).collect();
        return Err(spec
            .refuse(format!(
                "`{}` is not a cause that can be planted",
                spec.cause
            ))
            .help(format!("the causes are {}", names.join(", "))));
    };
    plant(spec, reality)?;
    spec.all_used()
}
