use super::frame;
use super::reader::Reader;
use admire_syntax::diagnostic::Code;
use admire_syntax::grammar::Solved;

/// Returns the reason why only real ADAMS can solve a statement. Returns `None` if the built-in solver solves the statement or the
/// statement has no effect.
pub(super) fn unsolved(statement: &Reader) -> Option<(Code, String)> {
    let def = statement.def;
    match def.solved {
        Solved::External(why) => return Some((Code::NotSolvedNatively, why.to_string())),
        Solved::Subroutine(why) => return Some((Code::UserSubroutine, why.to_string())),
        Solved::Native(_) | Solved::NoEffect(_) => {}
    }
    let formulation = statement
        .choices("FORMULATION")
        .and_then(|words| words.first().copied());
    let reason = match def.name {
        "COUPLER" | "FIELD" | "SPLINE" | "GFORCE" | "VFORCE" | "VTORQUE"
            if statement.is_user("FUNCTION") =>
        {
            let mut why = "its values come from a user subroutine".to_string();
            match statement.car_field() {
                Some(Ok(_)) if formulation != Some("NONLINEAR") => return None,
                Some(Err(misfit)) => why += &format!(", and {misfit}"),
                _ => {}
            }
            return Some((Code::UserSubroutine, why));
        }
        "FIELD" if formulation == Some("NONLINEAR") => {
            "FORMULATION=NONLINEAR: its law is not published"
        }
        "FRICTION" if formulation == Some("LUGRE") => "FORMULATION=LUGRE: its law is not published",
        "FRICTION"
            if statement.has("MAX_FRICTION_FORCE") || statement.has("MAX_FRICTION_TORQUE") =>
        {
            "the law by which ADAMS limits its force is not published"
        }
        "BEAM" if formulation == Some("STRING") => {
            "FORMULATION=STRING: its simplified non-linear law is not published"
        }
        "BEAM" if formulation == Some("NONLINEAR") => {
            "FORMULATION=NONLINEAR: the discretisation of its Euler-Bernoulli law is not published"
        }
        "MARKER" if frame::moves(statement) => {
            "it moves along a curve or on a surface, which the built-in solver does not support"
        }
        "SPLINE" if statement.has("FILE") => "its points are in a file that was not read",
        "GFORCE" | "VFORCE" | "VTORQUE" if statement.has("FXYZ") || statement.has("TXYZ") => {
            "vector expressions are not evaluated by the built-in solver"
        }
        _ => return None,
    };
    Some((Code::NotSolvedNatively, reason.to_string()))
}
