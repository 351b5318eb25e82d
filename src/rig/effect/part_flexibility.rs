//! Part flexibility (outside the catalogue): a part that bends or twists.
//!
//! The part is cut half way between one marker and the mean position of its other connections. The piece on the side of the marker becomes a
//! separate part. It carries the connections at that marker and all marks on that side. It rotates about the cut on a spherical joint and is
//! held by torsion springs.

use super::{EffectSpec, GroundTruth};
use admire_solver::mechanics::{Pose, Vec3};
use admire_syntax::diagnostic::Diagnostic;

/// Ratio of the torsional stiffnesses of the stiff and the flexible mode, if only bending or only twisting is flexible.
const RIGID: f64 = 1e3;

/// Plants a part flexibility. Values of the effect: `marker=...` (id of the marker), `stiffness=...` (torque per radian), and `mode=both`,
/// `mode=bend` or `mode=twist`.
pub(super) fn plant(spec: &EffectSpec, reality: &mut GroundTruth) -> Result<(), Diagnostic> {
    let part = reality.object(spec, &["PART"])?.id.unwrap_or(0);
    let end = spec.number("marker")? as u32;
    let stiffness = spec.positive("stiffness")?;
    let (bend, twist) = match spec.word("mode", &["both", "bend", "twist"])? {
        "bend" => (stiffness, RIGID * stiffness),
        "twist" => (RIGID * stiffness, stiffness),
        _ => (stiffness, stiffness),
    };
    let holders = reality.attachments(part);
    let named = holders.iter().find(|h| h.marker == end).map(|h| h.place);
    let here = |place: Vec3| named.is_some_and(|named| (place - named).norm() < 1e-6);
    let (at_end, others): (Vec<_>, Vec<_>) = holders.iter().partition(|h| here(h.place));
    if at_end.is_empty() {
        return Err(spec.refuse(format!(
            "no joint or force connects PART/{part} at MARKER/{end}"
        )));
    }
    if others.is_empty() {
        return Err(spec.refuse(format!(
            "PART/{part} is connected only at MARKER/{end}, and a flexible part needs a second connection"
        )));
    }
    let place = at_end[0].place;
    let rest = others.iter().map(|h| h.place).sum::<Vec3>() / others.len() as f64;
    let line = place - rest;
    if line.norm() < 1e-9 {
        return Err(spec.refuse("both ends of the part are at the same point"));
    }
    let new = reality.twin(part);
    for holder in &at_end {
        reality.rehang(
            spec,
            &holder.object,
            holder.argument,
            Some(new),
            &Pose::identity(),
        )?;
    }
    let z = line.normalize();
    let frame = Pose {
        p: rest + line * 0.5,
        R: super::reality::along(&z),
    };
    reality.carry_marks(part, new, |p| (p - frame.p).dot(&z) > 0.0);
    let markers = [new, part].map(|part| reality.add_marker(part, &frame).to_string());
    let pair = [
        ("I", Some(markers[0].clone())),
        ("J", Some(markers[1].clone())),
    ];
    let mut joint = vec![("SPHERICAL", None)];
    joint.extend(pair.clone());
    reality.add("JOINT", &joint);
    let mut spring = pair.to_vec();
    spring.push(("K", Some("0.0, 0.0, 0.0".to_string())));
    spring.push(("KT", Some(format!("{bend:e}, {bend:e}, {twist:e}"))));
    reality.add("BUSHING", &spring);
    Ok(())
}
