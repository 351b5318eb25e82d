//! A bushing whose force grows faster than linearly with one deflection component.
//!
//! Cubic: `F = -K u - cubic u^3`. Exponential rate: the stiffness is `K exp(rate |u|)`, `F = -K (exp(rate |u|) - 1) / rate * sgn u`.

use super::reality::displacement;
use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// Plants the effect. Values: `law=cubic,cubic=...` or `law=exponential,rate=...`.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let address = reality.object(spec, &["BUSHING"])?;
    let (pair, component) = reality.bushing_component(spec, &address)?;
    let u = displacement(pair, component);
    let force = if spec.word("law", &["cubic", "exponential"])? == "cubic" {
        format!("-{:e}*({u})**3", spec.positive("cubic")?)
    } else {
        let rate = spec.positive("rate")?;
        let k = reality.dataset.value_at(&address).unwrap_or(0.0);
        // The linear term is already in the bushing.
        format!("-{k:e}*SIGN(1.0,{u})*((EXP({rate:e}*ABS({u}))-1.0)/{rate:e}-ABS({u}))")
    };
    reality.add_component_force(spec, pair, &[(component, force)])
}
