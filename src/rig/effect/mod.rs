//! Effects a model may lack, planted in the reality a virtual rig measures: one file per cause of STUDY-FORMAT.
//!
//! The force laws of the effects live here, as edits of the deck: more statements, other numbers, other loads, faults of the
//! readings. Knows nothing about how an effect is found again.

mod assembly_offset;
mod body_compliance;
mod bushing_coupling;
mod bushing_orientation;
mod channel_fault;
mod dry_friction;
mod element_parameter;
mod frame_drift;
mod hardpoint_error;
mod link_compliance;
mod load_crosstalk;
mod load_gain;
mod load_point_error;
mod mark_outlier;
mod progressive_stiffness;
mod reality;
mod spec;
mod stop_contact;

pub use reality::{Memory, Reality, ReadingFault};
pub use spec::EffectSpec;

use crate::diagnostic::Diagnostic;

type Plant = fn(&EffectSpec, &mut Reality) -> Result<(), Diagnostic>;

/// Every cause of STUDY-FORMAT, and what plants it.
const CAUSES: &[(&str, Plant)] = &[
    ("progressive-stiffness", progressive_stiffness::plant),
    ("dry-friction", dry_friction::plant),
    ("link-compliance", link_compliance::plant),
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
    ("channel-fault", channel_fault::plant),
];

/// The causes that can be planted.
pub fn causes() -> impl Iterator<Item = &'static str> {
    CAUSES.iter().map(|(name, _)| *name)
}

/// Plants an effect.
///
/// # Errors
/// A cause that does not exist, an address that names nothing suitable, a value that is missing, unknown or out of range.
pub fn plant(spec: &EffectSpec, reality: &mut Reality) -> Result<(), Diagnostic> {
    let Some((_, plant)) = CAUSES.iter().find(|(name, _)| *name == spec.cause) else {
        let names: Vec<&str> = causes().collect();
        return Err(spec
            .refuse(format!("`{}` is no cause that can be planted", spec.cause))
            .help(format!("causes: {}", names.join(", "))));
    };
    plant(spec, reality)?;
    spec.all_used()
}
