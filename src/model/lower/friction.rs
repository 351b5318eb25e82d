use super::reader::Reader;
use crate::diagnostic::{Code, Diagnostic};
use crate::model::{Friction, FrictionInputs, JointKind};

/// TRANSITION_VELOCITY_COEFFICIENT where nothing is given (grammar/NOTES.md, FRICTION).
const TRANSITION: f64 = 1.5;

/// FRICTION.
pub(super) fn friction(reader: &mut Reader, old: Option<&Friction>) -> Option<Friction> {
    let joint = match (reader.written_id("JOINT", None), old) {
        (Some(id), _) => {
            let Some((index, joint)) = reader.joint(id) else {
                // The reference itself is complained about.
                return None;
            };
            let kind = joint.kind;
            if !has_friction(kind) {
                let message = format!(
                    "{} is in JOINT/{id}, and a {} joint knows no friction",
                    reader.called(),
                    kind.word()
                );
                let place = reader.place("JOINT");
                reader.complain(Diagnostic::error(Code::WrongType, message), place);
                return None;
            }
            index
        }
        (None, Some(old)) => old.joint,
        (None, None) => return reader.missing("JOINT"),
    };
    let yoke = reader.choice("YOKE");
    let stated = [
        reader.statement.has("I_YOKE") || yoke == Some("I_YOKE"),
        reader.statement.has("J_YOKE") || yoke == Some("J_YOKE"),
    ];
    let yokes = match (stated, old) {
        ([false, false], Some(old)) => old.yokes,
        ([false, false], None) => [true, true],
        (stated, _) => stated,
    };
    let of = |effects: &[&str], word: &str| effects.contains(&"ALL") || effects.contains(&word);
    let (stiction, sliding) = match (reader.choices("EFFECT"), old) {
        (Some(effects), _) => (of(&effects, "STICTION"), of(&effects, "SLIDING")),
        (None, Some(old)) => (old.stiction, old.sliding),
        (None, None) => (true, true),
    };
    let inputs = match (reader.choices("INPUTS"), old) {
        (Some(words), _) => FrictionInputs {
            preload: of(&words, "PRELOAD"),
            reaction_force: of(&words, "REACTION_FORCE"),
            bending_moment: of(&words, "BENDING_MOMENT"),
            torsional_moment: of(&words, "TORSIONAL_MOMENT"),
        },
        (None, Some(old)) => old.inputs,
        (None, None) => FrictionInputs {
            preload: true,
            reaction_force: true,
            bending_moment: true,
            torsional_moment: true,
        },
    };
    let overlap_by_displacement = match (reader.choice("OVERLAP_DELTA"), old) {
        (Some("INCREASE"), _) => 1.0,
        (Some("DECREASE"), _) => -1.0,
        (None, Some(old)) => old.overlap_by_displacement,
        _ => 0.0,
    };
    let sticks = reader.statement.sticks_in_statics(reader.source);
    let in_statics = old.is_none_or(|old| old.in_statics) && sticks;
    let number = |name: &str, of: fn(&Friction) -> f64| reader.real(name, old.map(of));
    Some(Friction {
        header: reader.header(old.map(|old| &old.header)),
        joint,
        yokes,
        mu_static: number("MU_STATIC", |f| f.mu_static),
        mu_dynamic: number("MU_DYNAMIC", |f| f.mu_dynamic),
        stiction_velocity: number("STICTION_TRANSITION_VELOCITY", |f| f.stiction_velocity),
        transition: reader
            .statement
            .first("TRANSITION_VELOCITY_COEFFICIENT")
            .or(old.map(|old| old.transition))
            .unwrap_or(TRANSITION),
        deformation: number("MAX_STICTION_DEFORMATION", |f| f.deformation),
        force_preload: number("FRICTION_FORCE_PRELOAD", |f| f.force_preload),
        torque_preload: number("FRICTION_TORQUE_PRELOAD", |f| f.torque_preload),
        stiction,
        sliding,
        inputs,
        in_statics,
        ball_radius: number("BALL_RADIUS", |f| f.ball_radius),
        pin_radius: number("PIN_RADIUS", |f| f.pin_radius),
        reaction_arm: number("REACTION_ARM", |f| f.reaction_arm),
        friction_arm: number("FRICTION_ARM", |f| f.friction_arm),
        bending_arm: number("BENDING_REACTION_ARM", |f| f.bending_arm),
        overlap: number("INITIAL_OVERLAP", |f| f.overlap),
        overlap_by_displacement,
    })
}

/// The joints that FRICTION may stand in (`state_friction`).
fn has_friction(kind: JointKind) -> bool {
    matches!(
        kind,
        JointKind::Translational
            | JointKind::Revolute
            | JointKind::Cylindrical
            | JointKind::Hooke
            | JointKind::Universal
            | JointKind::Spherical
    )
}
