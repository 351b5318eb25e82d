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
    let chosen = |name: &str| {
        statement
            .argument(name)
            .is_some_and(|argument| argument.choices(source).contains(&"NONLINEAR"))
    };
    let inactive = || statement.has("INACTIVE") || statement.has("INACTIVE_DURING");
    let reason = match def.name {
        "FRICTION" if !inactive() => {
            "stiction, which in ADAMS also acts in statics, is left out: joints move without resistance"
        }
        "COUPLER" | "FIELD" | "SPLINE" | "GFORCE" | "VFORCE" | "VTORQUE" if user => {
            "its values come from a user subroutine"
        }
        "FIELD" if chosen("FORMULATION") => "FORMULATION=NONLINEAR: its law is not published",
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
