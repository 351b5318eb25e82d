//! The rig's load is wrong by a factor.

use super::{EffectSpec, Reality};
use crate::diagnostic::Diagnostic;

/// `gain=1.02`: what acts is so many times what the study says.
pub(super) fn plant(spec: &EffectSpec, reality: &mut Reality) -> Result<(), Diagnostic> {
    let load = reality.load(spec, &spec.address)?;
    let gain = spec.number("gain")?;
    for case in &mut reality.programme.cases {
        case.values[load] *= gain;
    }
    Ok(())
}
