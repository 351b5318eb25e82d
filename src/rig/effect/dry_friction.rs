//! Rate-independent friction at a bushing deflection or along a joint: the answer depends on the order of the loads.
//!
//! Prandtl: a spring in series with a slider, `f = -max(-F, min(F, k (u - anchor)))`. Dahl: after each reversal the force
//! approaches the limit exponentially, `df/du = k (1 - f sgn(du) / F)`. What is remembered sits in VARIABLEs, changed after each case.

use super::reality::{Memory, displacement};
use super::{EffectSpec, Reality};
use crate::diagnostic::Diagnostic;

/// `force=...,stiffness=...` and `law=prandtl` or `dahl`; `axis=z` or `az` for a joint.
pub(super) fn plant(spec: &EffectSpec, reality: &mut Reality) -> Result<(), Diagnostic> {
    let address = reality.object(spec, &["BUSHING", "JOINT"])?;
    let (pair, component) = if address.kind == "BUSHING" {
        reality.bushing_component(spec, &address)?
    } else {
        let statement = reality.dataset.find(&address);
        let slides = statement.is_some_and(|s| s.has("TRANSLATIONAL") || s.has("CYLINDRICAL"));
        let words = if slides { ["z", "az"] } else { ["az", "z"] };
        let component = if spec.word("axis", &words)? == "z" { 2 } else { 5 };
        (reality.pair(spec, &address)?, component)
    };
    let (limit, stiffness) = (spec.positive("force")?, spec.positive("stiffness")?);
    let gradual = spec.word("law", &["prandtl", "dahl"])? == "dahl";
    let zero = [("FUNCTION", Some("0.0".to_string()))];
    let u = displacement(pair, component);
    let (force, variables) = if gradual {
        let (from, held) = (reality.add("VARIABLE", &zero), reality.add("VARIABLE", &zero));
        let moved = format!("({u}-VARVAL({from}))");
        let way = |sign: &str| {
            let goal = format!("{sign}{limit:e}");
            format!(
                "({goal}-({goal}-VARVAL({held}))*EXP(-{:e}*ABS({moved})))",
                stiffness / limit
            )
        };
        let force = format!("-IF({moved}: {}, VARVAL({held}), {})", way("-"), way("+"));
        (force, vec![from, held])
    } else {
        let anchor = reality.add("VARIABLE", &zero);
        let spring = format!("{stiffness:e}*({u}-VARVAL({anchor}))");
        (format!("-MAX(-{limit:e},MIN({limit:e},{spring}))"), vec![anchor])
    };
    reality.memories.push(Memory {
        variables,
        markers: pair,
        component,
        limit,
        stiffness,
        gradual,
    });
    reality.add_component_force(spec, pair, &[(component, force)])
}
