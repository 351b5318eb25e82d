//! Outside the catalogue: the rig and all parts grow slowly while the cases are measured, evenly in all directions about the ground
//! origin and in proportion to the number of cases done.

use super::{EffectSpec, GroundTruth, ReadingFault};
use admire_syntax::diagnostic::Diagnostic;

/// `growth=1e-4`: relative, reached at the last case.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    if spec.address != "rig" {
        return Err(spec.refuse("sits at `rig`"));
    }
    let growth = spec.number("growth")?;
    reality.faults.push(ReadingFault::Growth { growth });
    Ok(())
}
