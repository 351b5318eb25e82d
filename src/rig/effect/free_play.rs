//! Free play of a bushing, or of a joint along the line through the two joints of a part.
//!
//! For a bushing (outside the catalogue), the force is `F = -K (u - max(-g/2, min(g/2, u)))` with the total play `g`. For a joint, the end of
//! the part slides on the rest of the part against the steeply rising force `F = -f ((2 u / g)^9 + 0.01 (2 u / g))`.

use super::link_compliance::{cut, line};
use super::reality::displacement;
use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// Default force `f` that closes the play of a joint, in the deck's force unit.
const FORCE: f64 = 1000.0;

/// Plants a free play. Values of the effect: the total play `gap=...` and, for the joint of a part, the force `force=...` that closes the
/// play.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let address = reality.object(spec, &["BUSHING", "FIELD", "PART"])?;
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
    let stiffness = reality.stiffness(spec, &address, component)?;
    let u = displacement(pair, component);
    // The deck's bushing already contains the linear term. A thousandth of the stiffness remains inside the play, so the equilibrium there is
    // unique.
    let left = 0.999 * stiffness;
    let force = format!("{left:e}*MAX(-{half:e},MIN({half:e},{u}))");
    reality.add_component_force(spec, pair, &[(component, force)])
}
