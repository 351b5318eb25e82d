//! A bushing mounted at a wrong orientation: both of its markers are rotated by the same rotation vector.

use super::{EffectSpec, GroundTruth};
use admire_solver::mechanics::{Pose, Vec3};
use admire_syntax::diagnostic::Diagnostic;

/// Plants the effect. Values: the rotation vector `ax_deg, ay_deg, az_deg` in J axes.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let bushing = reality.object(spec, &["BUSHING"])?;
    let rotation = Pose {
        p: Vec3::zeros(),
        R: spec.turn()?,
    };
    for side in ["I", "J"] {
        reality.rehang(spec, &bushing, side, None, &rotation)?;
    }
    Ok(())
}
