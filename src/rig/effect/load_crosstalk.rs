//! The rig applies part of one load along another: `SFORCE/2<-SFORCE/3`.

use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// `fraction=0.02` of the load on the right acts along the one on the left besides. With `law=growing` a rig that leans the more
/// the more it is loaded: the fraction is half as large where there is no load.
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
