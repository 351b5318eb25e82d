//! Load gain: a load of the rig that differs from its stated value by a factor.

use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// Plants a wrong load gain. Value of the effect: `gain=...`, the ratio of the acting load to the stated load. With `law=growing`, which
/// represents a nonlinear load cell, the relative error grows with the load. At zero load it is half of its value at the largest load.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let load = reality.load(spec, &spec.address)?;
    let gain = spec.number("gain")?;
    let course = reality.course(spec, load)?;
    for (case, share) in reality.programme.cases.iter_mut().zip(course) {
        case.values[load] *= 1.0 + (gain - 1.0) * share;
    }
    Ok(())
}
