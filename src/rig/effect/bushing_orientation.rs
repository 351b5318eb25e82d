//! A bushing mounted turned about an axis: both of its sides.

use super::{EffectSpec, GroundTruth};
use admire_solver::mechanics::Vec3;
use admire_syntax::diagnostic::Diagnostic;

/// `ax_deg, ay_deg, az_deg`: a rotation vector in J axes.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let bushing = reality.object(spec, &["BUSHING"])?;
    let turn = spec.turn()?;
    for side in ["I", "J"] {
        reality.rehang(spec, (&bushing, side), None, (&Vec3::zeros(), &turn))?;
    }
    Ok(())
}
