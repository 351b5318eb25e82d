//! The measuring frame moved in one load case: `case 7`.

use super::{EffectSpec, GroundTruth, ReadingFault};
use admire_solver::mechanics::Pose;
use admire_syntax::diagnostic::Diagnostic;

/// `x, y, z, ax_deg, ay_deg, az_deg`: all coordinates of the case are read so much further along, turned about the origin.
/// `creep=1`: it goes on moving while the marks are read one by one, here as far as it had gone half way.
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
