//! Bushing coupling: an off-diagonal stiffness `k` between two axes `a` and `b` of a bushing, `F_a = -k u_b` and `F_b = -k u_a`.
//!
//! The coupling of a conical bushing grows with the deflection. With the value `reach` = r, the energy is `k u_a u_b (1 + (u_b / r)^2)`. The
//! forces are then `F_a = -k u_b (1 + (u_b / r)^2)` and `F_b = -k u_a (1 + 3 (u_b / r)^2)`.

use super::reality::displacement;
use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// Plants a bushing coupling. Values of the effect: one or more stiffnesses `xy, xz, yz, xax, xay, ... , axay, axaz, ayaz`, named by the two
/// axes, and optionally `reach=...`. The reach is a deflection along the second axis of each pair.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let bushing = reality.object(spec, &["BUSHING", "FIELD"])?;
    let pair = reality.pair(spec, &bushing)?;
    let names = ["x", "y", "z", "ax", "ay", "az"];
    let reach = match spec.optional("reach")? {
        Some(_) => Some(spec.positive("reach")?),
        None => None,
    };
    let mut forces = Vec::new();
    for b in 0..6 {
        for a in 0..b {
            if let Some(k) = spec.optional(&format!("{}{}", names[a], names[b]))? {
                // `add_component_force` concatenates the terms of one axis to a sum, so each term starts with its sign.
                let [u, v] = [a, b].map(|axis| displacement(pair, axis));
                let more = |times: f64| match reach {
                    Some(r) => format!("*(1.0+{:e}*({v})**2)", times / (r * r)),
                    None => String::new(),
                };
                forces.push((a, format!("-({k:e})*{v}{}", more(1.0))));
                forces.push((b, format!("-({k:e})*{u}{}", more(3.0))));
            }
        }
    }
    if forces.is_empty() {
        return Err(spec.refuse("needs a coupling, for example xy=500"));
    }
    reality.add_component_force(spec, pair, &forces)
}
