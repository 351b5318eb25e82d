//! Body compliance: a compliant attachment of a joint, bushing or spring to ground.
//!
//! The marker on ground is moved to an additional massless part. Springs hold this part to ground in translation, and it cannot rotate. The
//! factors `x`, `y` and `z` scale the stiffness along the ground axes, because a bracket is not equally stiff in all directions. With `rated`,
//! the springs stiffen as for `link-compliance`.

use super::{EffectSpec, GroundTruth};
use admire_solver::mechanics::{Mat3, Pose};
use admire_syntax::diagnostic::Diagnostic;

/// Plants a body compliance. Values of the effect: `stiffness=...`, and optionally the factors `x=...,y=...,z=...` (default 1) and `rated=...`.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let kinds = ["JOINT", "SPRINGDAMPER", "BUSHING", "JPRIM"];
    let object = reality.object(spec, &kinds)?;
    let stiffness = spec.positive("stiffness")?;
    let model = reality.model();
    let pair = reality.pair(spec, &object)?;
    let on_ground = |id: u32| {
        let marker = model.marker(id)?;
        let frame = &model.markers[marker.0];
        (Some(frame.part) == model.ground()).then_some(frame.qp)
    };
    let (argument, place) = match (on_ground(pair[0]), on_ground(pair[1])) {
        (_, Some(place)) => ("J", place),
        (Some(place), None) => ("I", place),
        (None, None) => return Err(spec.refuse(format!("{object} is not attached to ground"))),
    };
    let Some(ground) = model.ground() else {
        return Err(spec.refuse("the deck has no ground part"));
    };
    let ground = model.parts[ground.0].header.id;
    let block = reality.add("PART", &[("QG", Some("0.0, 0.0, 0.0".to_string()))]);
    reality.rehang(spec, &object, argument, Some(block), &Pose::identity())?;
    let frame = Pose {
        p: place,
        R: Mat3::identity(),
    };
    let ids = [block, ground].map(|part| reality.add_marker(part, &frame));
    let markers = ids.map(|id| id.to_string());
    let pair = [
        ("I", Some(markers[0].clone())),
        ("J", Some(markers[1].clone())),
    ];
    let mut hold = vec![("ORIENTATION", None)];
    hold.extend(pair.clone());
    reality.add("JPRIM", &hold);
    let mut along = [stiffness; 3];
    for (k, name) in along.iter_mut().zip(["x", "y", "z"]) {
        let factor = spec.optional(name)?.unwrap_or(1.0);
        if !(factor > 0.0) {
            return Err(spec.refuse(format!("{name} must be above zero")));
        }
        *k *= factor;
    }
    let mut spring = pair.to_vec();
    spring.push((
        "K",
        Some(format!("{:e}, {:e}, {:e}", along[0], along[1], along[2])),
    ));
    spring.push(("KT", Some("0.0, 0.0, 0.0".to_string())));
    reality.add("BUSHING", &spring);
    if let Some(rated) = spec.optional("rated")? {
        for (axis, k) in along.into_iter().enumerate() {
            reality.stiffen(spec, ids, axis, k, rated)?;
        }
    }
    Ok(())
}
