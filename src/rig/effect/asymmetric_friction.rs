//! Outside the catalogue: friction that is stronger one way than the other, as a seal or a one-way damper leaf gives.

use super::dry_friction::{place, slider, start};
use super::memory::MemoryLaw;
use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// `force=...,back=...,stiffness=...`: the force toward positive and toward negative displacements; `start=0`.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let at = place(spec, reality)?;
    let law = MemoryLaw::Slip {
        stiffness: spec.positive("stiffness")?,
        limits: [spec.positive("force")?, spec.positive("back")?],
        start: start(spec)?,
    };
    slider(spec, reality, at, law)
}
