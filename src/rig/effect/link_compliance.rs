//! Link compliance: a part that deforms along the line through its two joints.
//!
//! The far end becomes a separate part that slides along this line on the rest of the part and is held by a spring. The compliance may also be
//! split between both ends, each with a spring of twice the stiffness. With `rated`, the spring stiffens like the rubber eye of a link: `F = k
//! u (1 + (k u / rated)^2)`.

use super::{EffectSpec, GroundTruth};
use admire_solver::mechanics::{Pose, Vec3};
use admire_solver::model::Model;
use admire_syntax::Address;
use admire_syntax::diagnostic::Diagnostic;

/// Plants a link compliance. Values of the effect: `stiffness=...`, `ends=one` or `ends=both`, and optionally `rated=...`. At the deflection
/// where a linear spring would carry the force `rated`, this spring carries twice that force.
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

/// End of a link: address of the joint, bushing or FIELD there, argument that names its marker on the link, and position of this marker on the link.
type End = (Address, &'static str, Vec3);

/// Returns both ends of a part with two joints, and the vector from the first end to the second.
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
        return Err(spec.refuse(format!("both joints of PART/{part} are at the same point")));
    }
    Ok(([near, far], line))
}

fn ends(model: &Model, part: u32) -> Vec<End> {
    let mut found = Vec::new();
    let joints = model
        .joints
        .iter()
        .map(|joint| ("JOINT", joint.header.id, joint.i, joint.j));
    let elastic = model.elastic_pairs();
    let elastic = elastic.map(|e| (e.kind, e.header.id, e.i, e.j));
    for (kind, id, i, j) in joints.chain(elastic) {
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

/// Makes one end of a part a separate part that slides along `line` on the rest and is held by a spring. Returns the markers of the spring.
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
