use crate::grammar::{Solved, StatementDef};
use crate::syntax::{Statement, Value};
use crate::text::Source;

/// Why only real ADAMS can solve a statement; `None` if the built-in solver does, or if statics does not need it.
pub(super) fn unsolved(
    statement: &Statement,
    def: &'static StatementDef,
    source: &Source,
) -> Option<String> {
    if let Solved::External(why) = def.solved {
        return Some(why.to_string());
    }
    let user = statement
        .argument("FUNCTION")
        .is_some_and(|argument| matches!(argument.value, Value::User(_)));
    let formulation = statement
        .argument("FORMULATION")
        .and_then(|argument| argument.choices(source).first().copied());
    let reason = match def.name {
        "COUPLER" | "FIELD" | "SPLINE" | "GFORCE" | "VFORCE" | "VTORQUE" if user => {
            "its values come from a user subroutine"
        }
        "FIELD" if formulation == Some("NONLINEAR") => {
            "FORMULATION=NONLINEAR: its law is not published"
        }
        "FRICTION" if formulation == Some("LUGRE") => "FORMULATION=LUGRE: its law is not published",
        "FRICTION"
            if statement.has("MAX_FRICTION_FORCE") || statement.has("MAX_FRICTION_TORQUE") =>
        {
            "how ADAMS limits its force is not published"
        }
        "BEAM" if formulation == Some("STRING") => {
            "FORMULATION=STRING: its simplified non-linear law is not published"
        }
        "BEAM" if formulation == Some("NONLINEAR") => {
            "FORMULATION=NONLINEAR: the discretisation of its Euler-Bernoulli law is not published"
        }
        "MARKER" if statement.has("CURVE") || statement.has("SURFACE") => {
            "it moves along a curve or on a surface, which the built-in solver does not follow"
        }
        "SPLINE" if statement.has("FILE") => "its points are in a file that was not read",
        "GFORCE" | "VFORCE" | "VTORQUE" if statement.has("FXYZ") || statement.has("TXYZ") => {
            "vector expressions are not evaluated by the built-in solver"
        }
        _ => return None,
    };
    Some(reason.to_string())
}
