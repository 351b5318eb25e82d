//! Displacement of the measuring frame in one load case: `case 7`.

use super::{EffectSpec, GroundTruth, ReadingFault};
use admire_solver::mechanics::Pose;
use admire_syntax::diagnostic::Diagnostic;

/// Plants the effect. Values: the motion `x, y, z, ax_deg, ay_deg, az_deg`, by which all mark readings of the case are shifted and rotated
/// about the origin.
/// With `creep=1` the frame keeps moving while the marks are read one by one. The stated motion is then the one half way through the list.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let Some(label) = spec.address.strip_prefix("case ") else {
        return Err(spec.refuse("sits at a load case, for example `case 7`"));
    };
    let case = reality.case(spec, label.trim())?;
    let (p, R) = spec.motion()?;
    let pose = Pose { p, R };
    let creep = spec.optional("creep")?.unwrap_or(0.0);
    reality
        .faults
        .push(ReadingFault::Frame { case, pose, creep });
    Ok(())
}
