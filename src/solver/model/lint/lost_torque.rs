use super::Design;
use crate::model::{Function, Header, MarkerIx, PartKind, SforceKind, SpringKind, VectorForceKind};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Reports elements that exert a torque on a POINT_MASS, where a torque has no effect. On a POINT_MASS, `state_point_mass` allows only
/// ACCGRAV, VFORCE and the translational forms of SFORCE and SPRINGDAMPER.
pub(super) fn check(design: &Design<'_>, found: &mut Vec<Diagnostic>) {
    let model = design.model;
    let acts = |values: &[f64]| values.iter().any(|value| *value != 0.0);
    let mut turning: Vec<(&str, &Header, [MarkerIx; 2])> = Vec::new();
    for b in &model.bushings {
        if acts(&b.kt) || acts(&b.torque) || acts(&b.ct) {
            turning.push(("BUSHING", &b.header, [b.i, b.j]));
        }
    }
    for s in &model.springdampers {
        if s.kind == SpringKind::Rotational {
            turning.push(("SPRINGDAMPER", &s.header, [s.i, s.j]));
        }
    }
    for f in &model.pair_forces {
        turning.push((f.def.name, &f.header, [f.i, f.j]));
    }
    for s in &model.sforces {
        if s.kind == SforceKind::Rotational {
            let on = if s.action_only { s.i } else { s.j };
            turning.push(("SFORCE", &s.header, [s.i, on]));
        }
    }
    for v in &model.vector_forces {
        let kind = match v.kind {
            VectorForceKind::Vforce => continue,
            VectorForceKind::Vtorque => "VTORQUE",
            VectorForceKind::Gforce => "GFORCE",
        };
        if v.components[3..].iter().flatten().any(is_not_zero) {
            turning.push((kind, &v.header, [v.i, v.jfloat]));
        }
    }
    for (kind, header, markers) in turning {
        let parts = markers.map(|marker| &model.parts[model.markers[marker.0].part.0]);
        let Some(part) = parts.iter().find(|part| part.kind == PartKind::PointMass) else {
            continue;
        };
        let message = format!(
            "{} exerts a torque on POINT_MASS/{}, which does not rotate, so the torque has no effect",
            design.title(kind, header),
            part.header.id
        );
        found.push(
            design
                .warning(Code::LostTorque, header, message)
                .help("replace the POINT_MASS by a PART with IP, or remove the torque"),
        );
    }
}

/// Returns whether a function is anything other than the literal number zero.
fn is_not_zero(function: &Function) -> bool {
    match function {
        Function::Expression(expression) => expression.text.trim().parse::<f64>().ok() != Some(0.0),
        Function::User(_) => true,
    }
}
