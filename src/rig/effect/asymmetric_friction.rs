//! Outside the catalogue: friction with a different limit in each direction, as in a seal or a one-way damper leaf.

use super::dry_friction::{place, slider, start};
use super::memory::MemoryLaw;
use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// Plants the effect. Values: `force=...` and `back=...` are the friction limits towards positive and negative displacements, `stiffness=...`
/// is the stiffness in series. `start=0` is the fraction of the limit carried before the first case.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let (pair, component) = place(spec, reality)?;
    let law = MemoryLaw::Slip {
        stiffness: spec.positive("stiffness")?,
        limits: [spec.positive("force")?, spec.positive("back")?],
        start: start(spec)?,
    };
    slider(spec, reality, pair, component, law)
}
