use super::reader::Reader;
use crate::diagnostic::{Code, Diagnostic};
use crate::model::{
    Coupler, CouplerKind, Gcon, Gear, Joint, JointKind, MarkerIx, Motion, MotionAxis, MotionOrder,
    Primitive, PrimitiveKind,
};

/// JOINT.
pub(super) fn joint(reader: &mut Reader, old: Option<&Joint>) -> Option<Joint> {
    let pitch = match old.map(|old| old.kind) {
        Some(JointKind::Screw { pitch }) => Some(pitch),
        _ => None,
    };
    let diameter = match old.map(|old| old.kind) {
        Some(JointKind::RackPin { pitch_diameter }) => Some(pitch_diameter),
        _ => None,
    };
    let screw = JointKind::Screw {
        pitch: reader.real("PITCH", pitch),
    };
    let rack_pin = JointKind::RackPin {
        pitch_diameter: reader.real("PD", diameter),
    };
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
        screw,
        rack_pin,
    ];
    let kind = reader
        .first_flag(&kinds.map(|kind| (kind.word(), kind)))
        .or(match old.map(|old| old.kind) {
            Some(JointKind::Screw { .. }) => Some(screw),
            Some(JointKind::RackPin { .. }) => Some(rack_pin),
            kind => kind,
        });
    let Some(kind) = kind else {
        return reader.missing("its type, such as REVOLUTE");
    };
    let initial = |name: &str| {
        let numbers = reader.statement.numbers(name);
        let value = |k: usize| numbers.get(k).map(|number| number.value);
        value(0).map(|displacement| (displacement, value(1)))
    };
    let ic = initial("IC");
    let slides = matches!(kind, JointKind::Translational);
    let initial_translation = initial("ICTRAN")
        .or(ic.filter(|_| slides))
        .or(old.and_then(|old| old.initial_translation));
    let initial_rotation = initial("ICROT")
        .or(ic.filter(|_| !slides))
        .or(old.and_then(|old| old.initial_rotation));
    for argument in ["IC", "ICTRAN", "ICROT"] {
        if reader.statement.first(argument).is_some_and(|ic| ic != 0.0) {
            let message = format!(
                "the initial displacement of {} is not applied: statics looks for equilibrium from the positions of the parts; a motion begins there",
                reader.called()
            );
            let place = reader.place(argument);
            let diagnostic = Diagnostic::warning(Code::InactiveInStatics, message).help(
                "place the parts where the search is to start, or hold the joint with a MOTION",
            );
            reader.complain(diagnostic, place);
        }
    }
    Some(Joint {
        header: reader.header(old.map(|old| &old.header)),
        kind,
        i: reader.marker("I", old.map(|old| old.i))?,
        j: reader.marker("J", old.map(|old| old.j))?,
        initial_translation,
        initial_rotation,
    })
}

/// JPRIM.
pub(super) fn primitive(reader: &mut Reader, old: Option<&Primitive>) -> Option<Primitive> {
    let kinds = [
        PrimitiveKind::AtPoint,
        PrimitiveKind::Inline,
        PrimitiveKind::Inplane,
        PrimitiveKind::Orientation,
        PrimitiveKind::ParallelAxes,
        PrimitiveKind::Perpendicular,
    ];
    let kind = reader
        .first_flag(&kinds.map(|kind| (kind.word(), kind)))
        .or(old.map(|old| old.kind));
    let Some(kind) = kind else {
        return reader.missing("its type, such as INPLANE");
    };
    Some(Primitive {
        header: reader.header(old.map(|old| &old.header)),
        kind,
        i: reader.marker("I", old.map(|old| old.i))?,
        j: reader.marker("J", old.map(|old| old.j))?,
    })
}

/// COUPLER with SCALES.
pub(super) fn coupler(reader: &mut Reader, old: Option<&Coupler>) -> Option<Coupler> {
    let joints = joints(reader, "JOINTS")?;
    let mut scales = reader.reals("SCALES").unwrap_or_default();
    // One factor fewer than joints: the first is one (guide/formats.md 2.6).
    if scales.len() + 1 == joints.len() {
        scales.insert(0, 1.0);
    }
    if scales.len() != joints.len() {
        let place = reader.place("SCALES");
        let diagnostic = Diagnostic::error(
            Code::WrongCount,
            format!(
                "{} has {} joints and {} scales",
                reader.called(),
                joints.len(),
                scales.len()
            ),
        );
        reader.complain(diagnostic, place);
        return None;
    }
    let words = reader.choices("TYPE").unwrap_or_default();
    let terms = joints
        .into_iter()
        .zip(scales)
        .enumerate()
        .map(|(k, ((joint, kind), scale))| {
            let kind = match words.get(k) {
                Some(&"T") => CouplerKind::Translation,
                Some(_) => CouplerKind::Rotation,
                None => kind,
            };
            (joint, kind, scale)
        })
        .collect();
    Some(Coupler {
        header: reader.header(old.map(|old| &old.header)),
        terms,
    })
}

/// The joints an argument names, with the displacement their type leaves free.
fn joints(reader: &Reader, name: &str) -> Option<Vec<(usize, CouplerKind)>> {
    reader
        .written_ids(name)?
        .into_iter()
        .map(|id| {
            let (index, joint) = reader.joint(id)?;
            let free = match joint.kind {
                JointKind::Translational => CouplerKind::Translation,
                _ => CouplerKind::Rotation,
            };
            Some((index, free))
        })
        .collect()
}

/// GEAR.
pub(super) fn gear(reader: &mut Reader, old: Option<&Gear>) -> Option<Gear> {
    let joints = joints(reader, "JOINTS")?;
    let [(first, _), (second, _)] = joints[..] else {
        return None;
    };
    Some(Gear {
        header: reader.header(old.map(|old| &old.header)),
        joints: [first, second],
        cv: reader.marker("CV", old.map(|old| old.cv))?,
    })
}

/// GCON.
pub(super) fn gcon(reader: &mut Reader, old: Option<&Gcon>) -> Option<Gcon> {
    Some(Gcon {
        header: reader.header(old.map(|old| &old.header)),
        i: reader.marker("I", old.and_then(|old| old.i)),
        function: reader.function("FUNCTION", old.map(|old| &old.function))?,
    })
}

/// MOTION.
pub(super) fn motion(reader: &mut Reader, old: Option<&Motion>) -> Option<Motion> {
    let turn = reader.flag("ROTATIONAL", false);
    let slide = reader.flag("TRANSLATIONAL", false);
    let along_joint = |kind: JointKind| match kind {
        _ if turn => Some(MotionAxis::RotationZ),
        _ if slide => Some(MotionAxis::Translation(2)),
        JointKind::Revolute => Some(MotionAxis::RotationZ),
        JointKind::Translational => Some(MotionAxis::Translation(2)),
        _ => None,
    };
    let driven: Option<(usize, MarkerIx, MarkerIx, Option<MotionAxis>)> = reader
        .written_id("JOINT", None)
        .and_then(|id| reader.joint(id))
        .map(|(index, joint)| (index, joint.i, joint.j, along_joint(joint.kind)));
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
        None if reader.given("JOINT").is_some() => return None,
        None => (
            old.and_then(|old| old.joint),
            reader.marker("I", old.map(|old| old.i))?,
            reader.marker("J", old.map(|old| old.j))?,
            axis.or(old.map(|old| old.axis)),
        ),
    };
    let Some(axis) = axis else {
        return reader.missing(match joint {
            Some(_) => "TRANSLATIONAL or ROTATIONAL: its joint has both",
            None => "one of X, Y, Z, B1, B2, B3",
        });
    };
    Some(Motion {
        header: reader.header(old.map(|old| &old.header)),
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
            .or(old.map(|old| old.order))
            .unwrap_or(MotionOrder::Displacement),
        initial_displacement: reader
            .statement
            .first("ICDISP")
            .or(old.and_then(|old| old.initial_displacement)),
        initial_velocity: reader
            .statement
            .first("ICVEL")
            .or(old.and_then(|old| old.initial_velocity)),
        function: reader.function("FUNCTION", old.map(|old| &old.function))?,
    })
}
