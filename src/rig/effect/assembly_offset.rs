//! A bushing whose two sides sit displaced from where the deck says, in every load case (equation 9): measured deflection minus
//! real deflection is the offset.

use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// `x, y, z, ax_deg, ay_deg, az_deg` in J axes.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let bushing = reality.object(spec, &["BUSHING"])?;
    let (shift, turn) = spec.motion()?;
    // J sits where the deck puts it, plus the offset: the real deflection is smaller by it.
    reality
        .rehang(spec, (&bushing, "J"), None, (&shift, &turn))
        .map(drop)
}
