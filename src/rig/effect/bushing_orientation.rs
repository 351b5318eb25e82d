//! Bushing orientation: a bushing is mounted at a wrong orientation. Both of its markers are rotated on their parts by the same rotation
//! vector.

use super::{EffectSpec, GroundTruth};
use admire_solver::mechanics::{Pose, Vec3};
use admire_syntax::diagnostic::Diagnostic;

/// Plants a wrong bushing orientation. Values of the effect: the rotation vector `ax_deg, ay_deg, az_deg` in J axes.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let bushing = reality.object(spec, &["BUSHING", "FIELD"])?;
    let rotation = Pose {
        p: Vec3::zeros(),
        R: spec.turn()?,
    };
    for side in ["I", "J"] {
        reality.rehang(spec, &bushing, side, None, &rotation)?;
    }
    Ok(())
}
