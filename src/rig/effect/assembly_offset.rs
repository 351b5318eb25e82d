//! Assembly offset: the two sides of a bushing are displaced relative to each other from their positions in the deck, by the same amount in
//! every load case (equation 9 of the paper). The offset is the measured deflection minus the real deflection.

use super::{EffectSpec, GroundTruth};
use admire_solver::mechanics::Pose;
use admire_syntax::diagnostic::Diagnostic;

/// Plants an assembly offset. Values of the effect: the offset `x, y, z, ax_deg, ay_deg, az_deg` in J axes.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let bushing = reality.object(spec, &["BUSHING", "FIELD"])?;
    let (p, R) = spec.motion()?;
    // The offset moves J from its position in the deck. The real deflection of I relative to J is therefore smaller by the offset.
    reality
        .rehang(spec, &bushing, "J", None, &Pose { p, R })
        .map(drop)
}
