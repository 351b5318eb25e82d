//! Wrong gain of a rig load.

use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// Plants the effect. Value: `gain=1.02`, the ratio of the acting load to the stated load.
/// `law=growing` represents a nonlinear load cell: the relative error at zero load is half of its value at the largest load.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let load = reality.load(spec, &spec.address)?;
    let gain = spec.number("gain")?;
    let course = reality.course(spec, load)?;
    for (case, share) in reality.programme.cases.iter_mut().zip(course) {
        case.values[load] *= 1.0 + (gain - 1.0) * share;
    }
    Ok(())
}
