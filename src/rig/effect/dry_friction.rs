//! Dry friction: rate-independent friction in a bushing or along a joint. The response depends on the order of the loads.
//!
//! The Prandtl law is a spring in series with a slider: `f = -max(-F, min(F, k (u - anchor)))`. With the Dahl law, the force approaches the
//! limit exponentially after each reversal: `df/du = k (1 - f sgn(du) / F)`. The history is stored in VARIABLEs of the deck, which are updated
//! after each case. Before the first case, the parts are in the design position and the friction force is `start` times its limit.

use super::memory::{HistoryState, MemoryLaw};
use super::reality::displacement;
use super::{EffectSpec, GroundTruth};
use admire_syntax::diagnostic::Diagnostic;

/// Plants dry friction. Values of the effect: `force=...,stiffness=...`, `law=prandtl` (default) or `law=dahl`, `start=...` (default 0), and
/// for a joint `axis=z` or `axis=az`.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let (pair, component) = place(spec, reality)?;
    let (limit, stiffness) = (spec.positive("force")?, spec.positive("stiffness")?);
    let start = start(spec)?;
    if spec.word("law", &["prandtl", "dahl"])? == "prandtl" {
        return slider(
            spec,
            reality,
            pair,
            component,
            MemoryLaw::Slip {
                stiffness,
                limits: [limit, limit],
                start,
            },
        );
    }
    let zero = [("FUNCTION", Some("0.0".to_string()))];
    let (from, held) = (
        reality.add("VARIABLE", &zero),
        reality.add("VARIABLE", &zero),
    );
    let u = displacement(pair, component);
    let moved = format!("({u}-VARVAL({from}))");
    let way = |sign: &str| {
        let goal = format!("{sign}{limit:e}");
        format!(
            "({goal}-({goal}-VARVAL({held}))*EXP(-{:e}*ABS({moved})))",
            stiffness / limit
        )
    };
    let force = format!("-IF({moved}: {}, VARVAL({held}), {})", way("-"), way("+"));
    reality.memories.push(HistoryState {
        variables: vec![from, held],
        markers: pair,
        component,
        law: MemoryLaw::Dahl {
            stiffness,
            limit,
            start,
        },
    });
    reality.add_component_force(spec, pair, &[(component, force)])
}

/// Returns the I and J markers at which friction acts, and the component (0 to 5). The component is the axis of a bushing stiffness, a component of a
/// FIELD, or the axis of the free motion of a joint.
pub(super) fn place(
    spec: &EffectSpec,
    reality: &GroundTruth,
) -> Result<([u32; 2], usize), Diagnostic> {
    let address = reality.object(spec, &["BUSHING", "FIELD", "JOINT"])?;
    if address.kind != "JOINT" {
        return reality.bushing_component(spec, &address);
    }
    let statement = reality.dataset.find(&address);
    let slides = statement.is_some_and(|s| s.has("TRANSLATIONAL") || s.has("CYLINDRICAL"));
    let words = if slides { ["z", "az"] } else { ["az", "z"] };
    let component = if spec.word("axis", &words)? == "z" {
        2
    } else {
        5
    };
    Ok((reality.pair(spec, &address)?, component))
}

/// Returns the value `start` of an effect: the friction force before the first case as a fraction of its limit, from -1 to 1.
pub(super) fn start(spec: &EffectSpec) -> Result<f64, Diagnostic> {
    let start = spec.optional("start")?.unwrap_or(0.0);
    if start.abs() <= 1.0 {
        Ok(start)
    } else {
        Err(spec.refuse("start must be a fraction of the friction force, from -1 to 1"))
    }
}

/// Plants a Prandtl element: a spring in series with a slider, along one component between two markers.
pub(super) fn slider(
    spec: &EffectSpec,
    reality: &mut GroundTruth,
    pair: [u32; 2],
    component: usize,
    law: MemoryLaw,
) -> Result<(), Diagnostic> {
    let MemoryLaw::Slip {
        stiffness,
        limits: [plus, minus],
        ..
    } = law
    else {
        return Err(spec.refuse("the law must be a spring in series with a slider"));
    };
    let anchor = reality.add("VARIABLE", &[("FUNCTION", Some("0.0".to_string()))]);
    let u = displacement(pair, component);
    let spring = format!("{stiffness:e}*({u}-VARVAL({anchor}))");
    let force = format!("-MAX(-{minus:e},MIN({plus:e},{spring}))");
    reality.memories.push(HistoryState {
        variables: vec![anchor],
        markers: pair,
        component,
        law,
    });
    reality.add_component_force(spec, pair, &[(component, force)])
}
