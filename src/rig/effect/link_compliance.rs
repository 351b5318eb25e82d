//! A part that deforms along the line of its two joints.
//!
//! The far end becomes a part of its own that slides along this line on the rest, held by a spring. The given stiffness acts at one end, or
//! twice the stiffness acts at each of both ends. With `rated` the spring stiffens as the rubber eye of a link does: `F = k u (1 + (k u /
//! rated)^2)`.

use super::{EffectSpec, GroundTruth};
use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::Model;
use admire_syntax::Address;
use admire_syntax::diagnostic::Diagnostic;

/// Plants the effect. Values: `stiffness=...`, `ends=one` or `both`, and optionally `rated=...`. At the deflection where a linear spring would
/// carry `rated`, this spring carries twice as much.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let part = reality.object(spec, &["PART"])?.id.unwrap_or(0);
    let stiffness = spec.positive("stiffness")?;
    let both = spec.word("ends", &["one", "both"])? == "both";
    let ([near, far], line) = line(spec, reality, part)?;
    let each = if both { 2.0 * stiffness } else { stiffness };
    let mut springs = vec![cut(spec, reality, part, &far, &line, each)?];
    if both {
        springs.push(cut(spec, reality, part, &near, &-line, each)?);
    }
    if let Some(rated) = spec.optional("rated")? {
        for pair in springs {
            reality.stiffen(spec, pair, 2, each, rated)?;
        }
    }
    Ok(())
}

/// A joint or bushing on the part: its address, the argument that names the part's marker, and the marker's position on the part.
type End = (Address, &'static str, Vec3);

/// Returns both ends of a part, and the vector from the first to the second.
pub(super) fn line(
    spec: &EffectSpec,
    reality: &GroundTruth,
    part: u32,
) -> Result<([End; 2], Vec3), Diagnostic> {
    let found = ends(&reality.model(), part);
    let count = found.len();
    let Ok([near, far]) = <[End; 2]>::try_from(found) else {
        return Err(spec.refuse(format!("PART/{part} has {count} joints, not two")));
    };
    let line = far.2 - near.2;
    if line.norm() < 1e-9 {
        return Err(spec.refuse(format!("both joints of PART/{part} are at one point")));
    }
    Ok(([near, far], line))
}

fn ends(model: &Model, part: u32) -> Vec<End> {
    let mut found = Vec::new();
    let joints = model
        .joints
        .iter()
        .map(|joint| ("JOINT", joint.header.id, joint.i, joint.j));
    let bushings = model
        .bushings
        .iter()
        .map(|law| ("BUSHING", law.header.id, law.i, law.j));
    for (kind, id, i, j) in joints.chain(bushings) {
        for (argument, marker) in [("I", i), ("J", j)] {
            let frame = &model.markers[marker.0];
            if model.parts[frame.part.0].header.id == part {
                let address = Address {
                    kind: kind.to_string(),
                    id: Some(id),
                    argument: None,
                    index: None,
                };
                found.push((address, argument, frame.qp));
            }
        }
    }
    found
}

/// Makes an end a part of its own that slides along the line on the rest, held by a spring. Returns the markers of the spring.
pub(super) fn cut(
    spec: &EffectSpec,
    reality: &mut GroundTruth,
    part: u32,
    end: &End,
    line: &Vec3,
    stiffness: f64,
) -> Result<[u32; 2], Diagnostic> {
    let new = reality.twin(part);
    reality.rehang(spec, &end.0, end.1, Some(new), &Pose::identity())?;
    let frame = Pose {
        p: end.2,
        R: super::reality::along(&line.normalize()),
    };
    let ids = [new, part].map(|part| reality.add_marker(part, &frame));
    let markers = ids.map(|id| id.to_string());
    let pair = [
        ("I", Some(markers[0].clone())),
        ("J", Some(markers[1].clone())),
    ];
    let mut joint = vec![("TRANSLATIONAL", None)];
    joint.extend(pair.clone());
    reality.add("JOINT", &joint);
    let mut spring = pair.to_vec();
    spring.push(("K", Some(format!("0.0, 0.0, {stiffness:e}"))));
    spring.push(("KT", Some("0.0, 0.0, 0.0".to_string())));
    reality.add("BUSHING", &spring);
    Ok(ids)
}
