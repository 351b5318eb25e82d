//! Play: of a bushing that does nothing until it is used up, and in a joint of a part with two joints, along their line.
//!
//! Of a bushing, which is outside of the catalogue, `F = -K (u - max(-g/2, min(g/2, u)))` with the play `g`. In a joint the end slides
//! on the rest of the part, and what holds it rises steeply: `F = -f ((2 u / g)^9 + 0.01 (2 u / g))`.

use super::link_compliance::{cut, line};
use super::reality::displacement;
use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// Newtons (of the deck's force unit) that use up all of the play of a joint, if not stated.
const FORCE: f64 = 1000.0;

/// `gap=...`: the whole play; of a part besides `force=...`: what uses it up.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let address = reality.object(spec, &["BUSHING", "PART"])?;
    let half = 0.5 * spec.positive("gap")?;
    if address.kind == "PART" {
        let part = address.id.unwrap_or(0);
        let force = spec.optional("force")?.unwrap_or(FORCE);
        if !(force > 0.0) {
            return Err(spec.refuse("force must be above zero"));
        }
        let ([_, far], line) = line(spec, reality, part)?;
        let pair = cut(spec, reality, part, &far, &line, 0.01 * force / half)?;
        let law = format!("-{force:e}*({}/{half:e})**9", displacement(pair, 2));
        return reality.add_component_force(spec, pair, &[(2, law)]);
    }
    let (pair, component) = reality.bushing_component(spec, &address)?;
    let stiffness = reality.dataset.value_at(&address).unwrap_or(0.0);
    let u = displacement(pair, component);
    // The linear part is the bushing's own. A thousandth of the stiffness stays, so that the play has a place to rest.
    let left = 0.999 * stiffness;
    let force = format!("{left:e}*MAX(-{half:e},MIN({half:e},{u}))");
    reality.add_component_force(spec, pair, &[(component, force)])
}
