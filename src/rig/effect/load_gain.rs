//! The rig's load is wrong by a factor.

use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// `gain=1.02`: what acts is so many times what the study says. With `law=growing` a load cell that is not straight: the error
/// per load is half as large where there is no load.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let load = reality.load(spec, &spec.address)?;
    let gain = spec.number("gain")?;
    let course = reality.course(spec, load)?;
    for (case, share) in reality.programme.cases.iter_mut().zip(course) {
        case.values[load] *= 1.0 + (gain - 1.0) * share;
    }
    Ok(())
}
