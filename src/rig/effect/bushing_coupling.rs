//! Off-diagonal stiffness of a bushing: `F_a = -k u_b`, `F_b = -k u_a`.

use super::reality::displacement;
use super::{EffectSpec, Reality};
use crate::diagnostic::Diagnostic;

/// One or more of `xy, xz, yz, xax, xay, ... , axay, axaz, ayaz`.
pub(super) fn plant(spec: &EffectSpec, reality: &mut Reality) -> Result<(), Diagnostic> {
    let bushing = reality.object(spec, &["BUSHING"])?;
    let pair = reality.pair(spec, &bushing)?;
    let names = ["x", "y", "z", "ax", "ay", "az"];
    let mut forces = Vec::new();
    for b in 0..6 {
        for a in 0..b {
            if let Some(k) = spec.optional(&format!("{}{}", names[a], names[b]))? {
                // Each is the next term of a sum.
                forces.push((a, format!("-({k:e})*{}", displacement(pair, b))));
                forces.push((b, format!("-({k:e})*{}", displacement(pair, a))));
            }
        }
    }
    if forces.is_empty() {
        return Err(spec.refuse("needs a coupling, for example xy=500"));
    }
    reality.add_component_force(spec, pair, &forces)
}
