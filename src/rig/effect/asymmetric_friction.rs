//! Asymmetric friction (outside the catalogue): friction with a different limit in each direction, as in a seal or a one-way damper leaf.

use super::dry_friction::{place, slider, start};
use super::memory::MemoryLaw;
use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// Plants an asymmetric friction. Values of the effect: `force=...` is the friction limit towards positive displacements, and `back=...` the
/// limit towards negative displacements. `stiffness=...` is the stiffness in series. `start=...` (default 0) is the friction force before the
/// first case as a fraction of its limit.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let (pair, component) = place(spec, reality)?;
    let law = MemoryLaw::Slip {
        stiffness: spec.positive("stiffness")?,
        limits: [spec.positive("force")?, spec.positive("back")?],
        start: start(spec)?,
    };
    slider(spec, reality, pair, component, law)
}
