//! Creep (outside the catalogue): rubber that creeps from case to case.
//!
//! The force is `F = -K (u - c)` with the crept deflection `c`. After each case, `c` moves towards `u` by the fraction `rate` of their
//! difference, so the response depends on the number of earlier cases.

use super::memory::{HistoryState, MemoryLaw};
use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// Plants creep. Value of the effect: `rate=...`, above 0 and below 1.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let address = reality.object(spec, &["BUSHING", "FIELD"])?;
    let (pair, component) = reality.bushing_component(spec, &address)?;
    let rate = spec.positive("rate")?;
    if rate >= 1.0 {
        return Err(spec.refuse("rate must be below one"));
    }
    let stiffness = reality.stiffness(spec, &address, component)?;
    let flown = reality.add("VARIABLE", &[("FUNCTION", Some("0.0".to_string()))]);
    reality.memories.push(HistoryState {
        variables: vec![flown],
        markers: pair,
        component,
        law: MemoryLaw::Creep { rate },
    });
    // The deck's bushing already contains the linear term.
    let force = format!("{stiffness:e}*VARVAL({flown})");
    reality.add_component_force(spec, pair, &[(component, force)])
}
