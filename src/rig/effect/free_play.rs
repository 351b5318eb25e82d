//! Outside the catalogue: a bushing that does nothing until its play is used up.
//! `F = -K (u - max(-g/2, min(g/2, u)))` with the play `g`.

use super::reality::displacement;
use super::{EffectSpec, Reality};
use crate::diagnostic::Diagnostic;

/// `gap=...`: the whole play.
pub(super) fn plant(spec: &EffectSpec, reality: &mut Reality) -> Result<(), Diagnostic> {
    let address = reality.object(spec, &["BUSHING"])?;
    let (pair, component) = reality.bushing_component(spec, &address)?;
    let half = 0.5 * spec.positive("gap")?;
    let stiffness = reality.dataset.value_at(&address).unwrap_or(0.0);
    let u = displacement(pair, component);
    // The linear part is the bushing's own. A thousandth of the stiffness stays, so that the play has a place to rest.
    let left = 0.999 * stiffness;
    let force = format!("{left:e}*MAX(-{half:e},MIN({half:e},{u}))");
    reality.add_component_force(spec, pair, &[(component, force)])
}
