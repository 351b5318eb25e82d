//! Progressive stiffness: a bushing whose force grows faster than linearly with one component of the deflection.
//!
//! Cubic law: `F = -K u - cubic u^3`. Exponential law: the stiffness is `K exp(rate |u|)`, so `F = -K (exp(rate |u|) - 1) / rate * sgn u`.

use super::reality::displacement;
use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// Plants a progressive stiffness. Values of the effect: `law=cubic,cubic=...` or `law=exponential,rate=...`.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let address = reality.object(spec, &["BUSHING", "FIELD"])?;
    let (pair, component) = reality.bushing_component(spec, &address)?;
    let u = displacement(pair, component);
    let force = if spec.word("law", &["cubic", "exponential"])? == "cubic" {
        format!("-{:e}*({u})**3", spec.positive("cubic")?)
    } else {
        let rate = spec.positive("rate")?;
        let k = reality.stiffness(spec, &address, component)?;
        // The deck's bushing already contains the linear term.
        format!("-{k:e}*SIGN(1.0,{u})*((EXP({rate:e}*ABS({u}))-1.0)/{rate:e}-ABS({u}))")
    };
    reality.add_component_force(spec, pair, &[(component, force)])
}
