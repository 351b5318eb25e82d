//! Stop contact: a one-sided spring that acts along a joint or a spring beyond a clearance.
//!
//! The compression of the stop is `gap = s (u - u_design) - clearance` with the sense `s` = +1 or -1. If `gap` is positive, the opposing force
//! is `stiffness * gap` (linear) or `stiffness * gap^2` (quadratic). Otherwise the force is zero.

use super::reality::displacement;
use super::{EffectSpec, GroundTruth};
use admire_solver::mechanics::Pose;
use admire_syntax::diagnostic::Diagnostic;

/// Plants a stop contact. Values of the effect: `clearance=...,stiffness=...`, `law=linear` or `law=quadratic`. The side is `side=plus` or
/// `side=minus` for a joint, and `side=bump` or `side=rebound` for a spring.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let address = reality.object(spec, &["JOINT", "SPRINGDAMPER"])?;
    let pair = reality.pair(spec, &address)?;
    let (clearance, stiffness) = (spec.number("clearance")?, spec.positive("stiffness")?);
    let power = match spec.word("law", &["linear", "quadratic"])? {
        "linear" => "",
        _ => "**2",
    };
    let (model, i, frame_i) = reality.marker(spec, pair[0])?;
    let (_, j, frame_j) = reality.marker(spec, pair[1])?;
    let place = |marker: admire_solver::model::MarkerIx, frame: &Pose| {
        model.parts[model.markers[marker.0].part.0]
            .pose
            .compose(frame)
    };
    let (i, j) = (place(i, &frame_i), place(j, &frame_j));
    let gap = |u: &str, at: f64, plus: bool| {
        let way = if plus {
            format!("({u}-({at:.12e}))")
        } else {
            format!("(({at:.12e})-{u})")
        };
        format!("MAX(0.0,{way}-({clearance:e}))")
    };
    if address.kind == "SPRINGDAMPER" {
        // A positive SFORCE pushes its ends apart.
        let bump = spec.word("side", &["bump", "rebound"])? == "bump";
        let length = format!("DM({},{})", pair[0], pair[1]);
        let law = gap(&length, (i.p - j.p).norm(), !bump);
        let sign = if bump { "" } else { "-" };
        reality.add(
            "SFORCE",
            &[
                ("TRANSLATIONAL", None),
                ("I", Some(pair[0].to_string())),
                ("J", Some(pair[1].to_string())),
                (
                    "FUNCTION",
                    Some(format!("{sign}{stiffness:e}*{law}{power}")),
                ),
            ],
        );
        return Ok(());
    }
    let plus = spec.word("side", &["plus", "minus"])? == "plus";
    let along = (j.R.transpose() * (i.p - j.p)).z;
    let law = gap(&displacement(pair, 2), along, plus);
    let sign = if plus { "-" } else { "" };
    reality.add_component_force(
        spec,
        pair,
        &[(2, format!("{sign}{stiffness:e}*{law}{power}"))],
    )
}
