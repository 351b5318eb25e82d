//! Load crosstalk: a fraction of one load also acts along another load. In the address `SFORCE/2<-SFORCE/3`, a fraction of SFORCE/3 also acts
//! along SFORCE/2.

use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// Plants a load crosstalk. Value of the effect: `fraction=...`, the fraction of the load on the right of the arrow that also acts along the
/// load on the left. With `law=growing`, which represents a rig that leans under load, the fraction grows with the load. At zero load it is
/// half of its value at the largest load.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let Some((to, from)) = spec.address.split_once("<-") else {
        return Err(spec.refuse("the address must name two loads, for example SFORCE/2<-SFORCE/3"));
    };
    let (to, from) = (reality.load(spec, to)?, reality.load(spec, from)?);
    let fraction = spec.number("fraction")?;
    let course = reality.course(spec, from)?;
    for (case, share) in reality.programme.cases.iter_mut().zip(course) {
        case.values[to] += fraction * share * case.values[from];
    }
    Ok(())
}
