//! Crosstalk of the rig: part of one load also acts along another, `SFORCE/2<-SFORCE/3`.

use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// Plants the effect. Value: `fraction=0.02`, the fraction of the load on the right that acts in addition along the load on the left.
/// With `law=growing` the rig leans further the more it is loaded: the fraction at zero load is half of its value at the largest load.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let Some((to, from)) = spec.address.split_once("<-") else {
        return Err(spec.refuse("sits at two loads, for example SFORCE/2<-SFORCE/3"));
    };
    let (to, from) = (reality.load(spec, to)?, reality.load(spec, from)?);
    let fraction = spec.number("fraction")?;
    let course = reality.course(spec, from)?;
    for (case, share) in reality.programme.cases.iter_mut().zip(course) {
        case.values[to] += fraction * share * case.values[from];
    }
    Ok(())
}
