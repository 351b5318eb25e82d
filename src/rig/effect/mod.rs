//! Effects a model may lack, planted in the reality a virtual rig measures: one file per cause of guide/study.md.
//!
//! The force laws of the effects live here, as edits of the deck: more statements, other numbers, other loads, faults of the
//! readings, all before the deck is compiled. Only what remembers the path from case to case (friction, creep) is a law of its own,
//! in `memory`. Knows nothing about how an effect is found again. Besides the causes of guide/study.md there are six outside of that
//! catalogue, against which a diagnosis must not name a cause of it with confidence.

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
pub use memory::Memory;
pub(super) use point::{held, points};
pub use reality::Marked;
pub(crate) use reality::{GroundTruth, ReadingFault};
pub use spec::EffectSpec;

use admire_syntax::diagnostic::Diagnostic;

type Plant = fn(&EffectSpec, &mut GroundTruth) -> Result<(), Diagnostic>;

/// Every cause of guide/study.md, and what plants it.
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

/// What a rig may meet besides.
const OUTSIDE: &[(&str, Plant)] = &[
    ("creep", creep::plant),
    ("part-flexibility", part_flexibility::plant),
    ("asymmetric-friction", asymmetric_friction::plant),
    ("thermal-drift", thermal_drift::plant),
    ("marks-exchanged", marks_exchanged::plant),
    ("load-direction", load_direction::plant),
];

/// The causes of guide/study.md, all of which can be planted.
pub fn causes() -> impl Iterator<Item = &'static str> {
    CAUSES.iter().map(|(name, _)| *name)
}

/// What can be planted besides, and is no cause of guide/study.md.
pub fn outside_causes() -> impl Iterator<Item = &'static str> {
    OUTSIDE.iter().map(|(name, _)| *name)
}

/// Plants an effect.
///
/// # Errors
/// A cause that does not exist, an address that names nothing suitable, a value that is missing, unknown or out of range.
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
