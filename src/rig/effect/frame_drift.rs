//! Frame drift: displacement of the measuring frame in one load case. The address names the case, such as `case 7`.

use super::{EffectSpec, GroundTruth, ReadingFault};
use admire_solver::mechanics::Pose;
use admire_syntax::diagnostic::Diagnostic;

/// Plants a frame drift. Values of the effect: the rigid motion `x, y, z, ax_deg, ay_deg, az_deg` of all mark readings of the case, with the
/// rotation about the ground origin. With `creep=1`, the frame keeps moving while the marks are read one by one. The stated motion is then
/// reached half way through the list of marks.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let Some(label) = spec.address.strip_prefix("case ") else {
        return Err(spec.refuse("the address must name a load case, for example `case 7`"));
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
