//! Thermal drift (outside the catalogue): slow thermal growth of the rig and all parts during the measurement. The growth is uniform about the
//! ground origin and proportional to the number of cases already measured.

use super::{EffectSpec, GroundTruth, ReadingFault};
use admire_syntax::diagnostic::Diagnostic;

/// Plants a thermal drift. Value of the effect: `growth=...`, the relative growth reached in the last case.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    if spec.address != "rig" {
        return Err(spec.refuse("the address must be `rig`"));
    }
    let growth = spec.number("growth")?;
    reality.faults.push(ReadingFault::Growth { growth });
    Ok(())
}
