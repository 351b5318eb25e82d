use super::reader::Reader;
use crate::model::{Friction, FrictionInputs, JointKind};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Default of TRANSITION_VELOCITY_COEFFICIENT (grammar/NOTES.md, FRICTION).
const TRANSITION: f64 = 1.5;

/// Lowers a FRICTION.
pub(super) fn friction(reader: &mut Reader) -> Option<Friction> {
    let id = reader.written_id("JOINT")?;
    // An undefined joint is reported elsewhere, as an undefined reference.
    let (joint, of) = reader.joint(id)?;
    let kind = of.kind;
    if !has_friction(kind) {
        let message = format!(
            "{} is in JOINT/{id}, but a {} joint cannot have friction",
            reader.called(),
            kind.word()
        );
        let (source, span) = reader.place("JOINT");
        reader.complain(Diagnostic::error(Code::WrongType, message), source, span);
        return None;
    }
    let yoke = reader.choice("YOKE");
    let stated: Vec<_> = reader.latest(&["I_YOKE", "J_YOKE", "YOKE"]).collect();
    let yokes = ["I_YOKE", "J_YOKE"].map(|name| {
        stated.is_empty()
            || stated.contains(&name)
            || stated.contains(&"YOKE") && yoke == Some(name)
    });
    let of = |effects: &[&str], word: &str| effects.contains(&"ALL") || effects.contains(&word);
    let (stiction, sliding) = match reader.choices("EFFECT") {
        Some(effects) => (of(&effects, "STICTION"), of(&effects, "SLIDING")),
        None => (true, true),
    };
    let inputs = match reader.choices("INPUTS") {
        Some(words) => FrictionInputs {
            preload: of(&words, "PRELOAD"),
            reaction_force: of(&words, "REACTION_FORCE"),
            bending_moment: of(&words, "BENDING_MOMENT"),
            torsional_moment: of(&words, "TORSIONAL_MOMENT"),
        },
        None => FrictionInputs {
            preload: true,
            reaction_force: true,
            bending_moment: true,
            torsional_moment: true,
        },
    };
    let overlap_by_displacement = match reader.choice("OVERLAP_DELTA") {
        Some("INCREASE") => 1.0,
        Some("DECREASE") => -1.0,
        _ => 0.0,
    };
    Some(Friction {
        header: reader.header(),
        joint,
        yokes,
        mu_static: reader.real("MU_STATIC"),
        mu_dynamic: reader.real("MU_DYNAMIC"),
        stiction_velocity: reader.real("STICTION_TRANSITION_VELOCITY"),
        transition: reader
            .first("TRANSITION_VELOCITY_COEFFICIENT")
            .unwrap_or(TRANSITION),
        deformation: reader.real("MAX_STICTION_DEFORMATION"),
        force_preload: reader.real("FRICTION_FORCE_PRELOAD"),
        torque_preload: reader.real("FRICTION_TORQUE_PRELOAD"),
        stiction,
        sliding,
        inputs,
        in_statics: reader.sticks_in_statics(),
        ball_radius: reader.real("BALL_RADIUS"),
        pin_radius: reader.real("PIN_RADIUS"),
        reaction_arm: reader.real("REACTION_ARM"),
        friction_arm: reader.real("FRICTION_ARM"),
        bending_arm: reader.real("BENDING_REACTION_ARM"),
        overlap: reader.real("INITIAL_OVERLAP"),
        overlap_by_displacement,
    })
}

/// Returns whether FRICTION is allowed in a joint of this type (`state_friction`).
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
