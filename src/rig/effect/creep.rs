//! Outside the catalogue: rubber that flows from case to case. `F = -K (u - c)`, and after each case `c` has gone the part `rate`
//! of the way to `u`, so that the answer depends on how many cases came before.

use super::memory::{Memory, MemoryLaw};
use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// `rate=...`, above zero and below one.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let address = reality.object(spec, &["BUSHING"])?;
    let (pair, component) = reality.bushing_component(spec, &address)?;
    let rate = spec.positive("rate")?;
    if rate >= 1.0 {
        return Err(spec.refuse("rate must be below one"));
    }
    let stiffness = reality.dataset.value_at(&address).unwrap_or(0.0);
    let flown = reality.add("VARIABLE", &[("FUNCTION", Some("0.0".to_string()))]);
    reality.memories.push(Memory {
        variables: vec![flown],
        markers: pair,
        component,
        law: MemoryLaw::Creep { rate },
    });
    // The linear part is the bushing's own.
    let force = format!("{stiffness:e}*VARVAL({flown})");
    reality.add_component_force(spec, pair, &[(component, force)])
}
