//! Hardpoint error: wrong position of a connection point.
//!
//! With `form=part`, one part was made wrong: only its marker is displaced, and the axle is assembled under strain. With `form=point`, the
//! connection point is displaced on all parts that meet there, and the axle is assembled without strain. Marks, mass centres and all other
//! markers keep their positions on their parts.

use super::point::{on_part, points};
use super::{EffectSpec, GroundTruth};
use admire_solver::mechanics::Vec3;
use admire_solver::model::Model;
use admire_syntax::Address;
use admire_syntax::diagnostic::Diagnostic;

/// Plants a hardpoint error. Values of the effect: `form=part` (default) or `form=point`, and the displacement `x, y, z`. The displacement is
/// in the axes of the marker's part for `form=part`, and in ground axes for `form=point`.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let marker = reality.object(spec, &["MARKER"])?;
    let shift = spec.shift()?;
    if spec.word("form", &["part", "point"])? == "part" {
        return reality.shift_marker(spec, &marker, &shift);
    }
    let model = reality.model();
    let id = marker.id.unwrap_or(0);
    let found = points(&model)
        .into_iter()
        .find(|point| point.members.contains(&id));
    let Some(point) = found else {
        return Err(spec.refuse(format!("no joint or force connects parts at MARKER/{id}")));
    };
    for id in point.members.iter().chain(&point.followers) {
        let Some(shift) = on_part(&model, *id, &shift) else {
            continue;
        };
        move_connection(spec, reality, (&model, *id), &shift)?;
    }
    Ok(())
}

/// Moves the marker of a connection on its part. If the marker is also the mass centre of the part, a copy at the old position becomes the mass
/// centre.
fn move_connection(
    spec: &EffectSpec,
    reality: &mut GroundTruth,
    (model, id): (&Model, u32),
    shift: &Vec3,
) -> Result<(), Diagnostic> {
    let at = model.marker(id);
    for part in model
        .parts
        .iter()
        .filter(|part| part.cm == at && at.is_some())
    {
        let (_, _, frame) = reality.marker(spec, id)?;
        let copy = reality.add_marker(part.header.id, &frame);
        let centre = Address {
            kind: "PART".to_string(),
            id: Some(part.header.id),
            argument: Some("CM".to_string()),
            index: None,
        };
        reality.set(&centre, f64::from(copy))?;
    }
    let address = Address {
        kind: "MARKER".to_string(),
        id: Some(id),
        argument: None,
        index: None,
    };
    reality.shift_marker(spec, &address, shift)
}
