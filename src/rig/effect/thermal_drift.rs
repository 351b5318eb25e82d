//! Outside the catalogue: slow thermal growth of the rig and all parts during the measurement. The growth is uniform about the ground origin
//! and proportional to the number of cases done.

use super::{EffectSpec, GroundTruth, ReadingFault};
use admire_syntax::diagnostic::Diagnostic;

/// Plants the effect. Value: `growth=1e-4`, the relative growth reached at the last case.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    if spec.address != "rig" {
        return Err(spec.refuse("sits at `rig`"));
    }
    let growth = spec.number("growth")?;
    reality.faults.push(ReadingFault::Growth { growth });
    Ok(())
}
