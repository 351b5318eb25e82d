use super::reader::Reader;
use crate::model::{
    Coupler, CouplerKind, Gcon, Gear, Joint, JointKind, MarkerIx, Motion, MotionAxis, MotionOrder,
    Primitive, PrimitiveKind,
};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Lowers a JOINT.
pub(super) fn joint(reader: &mut Reader) -> Option<Joint> {
    let kinds = [
        JointKind::Spherical,
        JointKind::Revolute,
        JointKind::Translational,
        JointKind::Cylindrical,
        JointKind::Planar,
        JointKind::Fixed,
        JointKind::Hooke,
        JointKind::Universal,
        JointKind::Convel,
        JointKind::Screw {
            pitch: reader.real("PITCH"),
        },
        JointKind::RackPin {
            pitch_diameter: reader.real("PD"),
        },
    ];
    let kind = reader.first_flag(&kinds.map(|kind| (kind.word(), kind)))?;
    let slides = matches!(kind, JointKind::Translational | JointKind::Cylindrical);
    let turns = matches!(kind, JointKind::Revolute | JointKind::Cylindrical);
    let one = slides != turns;
    for (argument, applies) in [("IC", one), ("ICTRAN", slides), ("ICROT", turns)] {
        let Some(displacement) = reader.first(argument) else {
            continue;
        };
        let owner = reader.called();
        let complaint = if !applies {
            let message = format!(
                "{argument} of {owner} has no effect: a {} joint has no such displacement",
                kind.word()
            );
            Diagnostic::warning(Code::ConflictingArguments, message).help(
                "IC belongs to REVOLUTE and TRANSLATIONAL joints, ICTRAN and ICROT to CYLINDRICAL joints",
            )
        } else if displacement != 0.0 {
            let message = format!(
                "the initial displacement of {owner} is not applied in statics, which starts from the positions of the parts; kinematic and dynamic simulations use it"
            );
            Diagnostic::warning(Code::InactiveInStatics, message).help(
                "place the parts in the intended start positions, or hold the joint with a MOTION",
            )
        } else {
            continue;
        };
        let (source, span) = reader.place(argument);
        reader.complain(complaint, source, span);
    }
    let initial = |name: &str| {
        let numbers = reader.numbers(name);
        let value = |k: usize| numbers.get(k).map(|number| number.value);
        value(0).map(|displacement| (displacement, value(1)))
    };
    let ic = initial("IC").filter(|_| one);
    let initial_translation = initial("ICTRAN").or(ic).filter(|_| slides);
    let initial_rotation = initial("ICROT").or(ic).filter(|_| turns);
    Some(Joint {
        header: reader.header(),
        kind,
        i: reader.marker("I")?,
        j: reader.marker("J")?,
        initial_translation,
        initial_rotation,
    })
}

/// Lowers a JPRIM.
pub(super) fn primitive(reader: &mut Reader) -> Option<Primitive> {
    let kinds = [
        PrimitiveKind::AtPoint,
        PrimitiveKind::Inline,
        PrimitiveKind::Inplane,
        PrimitiveKind::Orientation,
        PrimitiveKind::ParallelAxes,
        PrimitiveKind::Perpendicular,
    ];
    let kind = reader.first_flag(&kinds.map(|kind| (kind.word(), kind)))?;
    Some(Primitive {
        header: reader.header(),
        kind,
        i: reader.marker("I")?,
        j: reader.marker("J")?,
    })
}

/// Lowers a COUPLER with SCALES.
pub(super) fn coupler(reader: &mut Reader) -> Option<Coupler> {
    let joints = joints(reader, "JOINTS")?;
    let mut scales = reader.reals("SCALES").unwrap_or_default();
    // If there is one scale fewer than joints, the first scale is one (guide/formats.md 2.6).
    if scales.len() + 1 == joints.len() {
        scales.insert(0, 1.0);
    }
    if scales.len() != joints.len() {
        let (source, span) = reader.place("SCALES");
        let diagnostic = Diagnostic::error(
            Code::WrongCount,
            format!(
                "{} needs one of the SCALES for each joint; joints: {}, scales: {}",
                reader.called(),
                joints.len(),
                scales.len()
            ),
        );
        reader.complain(diagnostic, source, span);
        return None;
    }
    let words: Vec<CouplerKind> = reader
        .choices("TYPE")
        .unwrap_or_default()
        .iter()
        .map(|word| match *word {
            "T" => CouplerKind::Translation,
            _ => CouplerKind::Rotation,
        })
        .collect();
    let ids = reader.written_ids("JOINTS")?;
    let mut terms = Vec::new();
    for (k, ((joint, free), scale)) in joints.into_iter().zip(scales).enumerate() {
        let kind = words.get(k).copied().unwrap_or(free);
        let (_, of) = reader.joint(ids[k])?;
        let of = of.kind;
        if !leaves_free(of, kind) {
            return refuse(reader, "TYPE", ids[k], of, Some(kind));
        }
        terms.push((joint, kind, scale));
    }
    Some(Coupler {
        header: reader.header(),
        terms,
    })
}

/// Returns the joints that an argument names, each with a displacement that its type leaves free. For a CYLINDRICAL joint, which leaves two
/// free, this is the rotation.
fn joints(reader: &mut Reader, name: &str) -> Option<Vec<(usize, CouplerKind)>> {
    let mut joints = Vec::new();
    for id in reader.written_ids(name)? {
        let (index, joint) = reader.joint(id)?;
        let kind = joint.kind;
        let free = match kind {
            JointKind::Translational => CouplerKind::Translation,
            _ => CouplerKind::Rotation,
        };
        if !leaves_free(kind, free) {
            return refuse(reader, name, id, kind, None);
        }
        joints.push((index, free));
    }
    Some(joints)
}

/// Returns whether a joint leaves the given displacement along or about z of J free. Only a free displacement can be used by a MOTION,
/// COUPLER or GEAR.
fn leaves_free(kind: JointKind, displacement: CouplerKind) -> bool {
    match kind {
        JointKind::Cylindrical => true,
        JointKind::Revolute => displacement == CouplerKind::Rotation,
        JointKind::Translational => displacement == CouplerKind::Translation,
        _ => false,
    }
}

/// Reports a joint in which the required displacement is not free, or which has no free displacement at all.
fn refuse<T>(
    reader: &mut Reader,
    argument: &str,
    id: u32,
    kind: JointKind,
    displacement: Option<CouplerKind>,
) -> Option<T> {
    let what = match displacement {
        Some(CouplerKind::Rotation) => "the rotation of ",
        Some(CouplerKind::Translation) => "the translation of ",
        None => "",
    };
    let message = format!(
        "{} uses {what}JOINT/{id}, which is {}",
        reader.called(),
        kind.word()
    );
    let diagnostic = Diagnostic::error(Code::WrongType, message).help(
        "allowed are the rotation of a REVOLUTE or CYLINDRICAL joint and the translation of a TRANSLATIONAL or CYLINDRICAL joint",
    );
    let (source, span) = reader.place(argument);
    reader.complain(diagnostic, source, span);
    None
}

/// Lowers a GEAR.
pub(super) fn gear(reader: &mut Reader) -> Option<Gear> {
    let joints = joints(reader, "JOINTS")?;
    let [(first, _), (second, _)] = joints[..] else {
        return None;
    };
    Some(Gear {
        header: reader.header(),
        joints: [first, second],
        cv: reader.marker("CV")?,
    })
}

/// Lowers a GCON.
pub(super) fn gcon(reader: &mut Reader) -> Option<Gcon> {
    Some(Gcon {
        header: reader.header(),
        i: reader.marker("I"),
        function: reader.function("FUNCTION")?,
    })
}

/// Lowers a MOTION.
pub(super) fn motion(reader: &mut Reader) -> Option<Motion> {
    let turn = reader.has("ROTATIONAL");
    let slide = reader.has("TRANSLATIONAL");
    let asked = match (turn, slide) {
        (true, _) => Some(CouplerKind::Rotation),
        (_, true) => Some(CouplerKind::Translation),
        _ => None,
    };
    let mut driven: Option<(usize, MarkerIx, MarkerIx, Option<MotionAxis>)> = None;
    if let Some(id) = reader.written_id("JOINT")
        && let Some((index, joint)) = reader.joint(id)
    {
        let (kind, i, j) = (joint.kind, joint.i, joint.j);
        let displacement = asked.or(match kind {
            JointKind::Translational => Some(CouplerKind::Translation),
            JointKind::Cylindrical => None,
            _ => Some(CouplerKind::Rotation),
        });
        if displacement.is_some_and(|displacement| !leaves_free(kind, displacement)) {
            return refuse(reader, "JOINT", id, kind, asked);
        }
        let axis = displacement.map(|displacement| match displacement {
            CouplerKind::Rotation => MotionAxis::RotationZ,
            CouplerKind::Translation => MotionAxis::Translation(2),
        });
        driven = Some((index, i, j, axis));
    }
    let axis = reader.first_flag(&[
        ("X", MotionAxis::Translation(0)),
        ("Y", MotionAxis::Translation(1)),
        ("Z", MotionAxis::Translation(2)),
        ("B1", MotionAxis::Body123(0)),
        ("B2", MotionAxis::Body123(1)),
        ("B3", MotionAxis::Body123(2)),
        ("TRANSLATIONAL", MotionAxis::Translation(2)),
        ("ROTATIONAL", MotionAxis::RotationZ),
    ]);
    let (joint, i, j, axis) = match driven {
        Some((index, i, j, axis)) => (Some(index), i, j, axis),
        None if reader.argument("JOINT").is_some() => return None,
        None => (None, reader.marker("I")?, reader.marker("J")?, axis),
    };
    let Some(axis) = axis else {
        return reader.missing(match joint {
            Some(_) => "TRANSLATIONAL or ROTATIONAL: its joint has both",
            None => "one of X, Y, Z, B1, B2, B3",
        });
    };
    Some(Motion {
        header: reader.header(),
        joint,
        i,
        j,
        axis,
        order: reader
            .first_flag(&[
                ("DISPLACEMENT", MotionOrder::Displacement),
                ("VELOCITY", MotionOrder::Velocity),
                ("ACCELERATION", MotionOrder::Acceleration),
            ])
            .unwrap_or(MotionOrder::Displacement),
        initial_displacement: reader.first("ICDISP"),
        initial_velocity: reader.first("ICVEL"),
        function: reader.function("FUNCTION")?,
    })
}
