use super::context::{Context, known};
use crate::diagnostic::{Code, Diagnostic};
use crate::expression::Node;
use crate::grammar::{FunctionDef, Solved};
use crate::text::Span;
use crate::{Expression, Value};

/// Reports functions of the positions of parts that are not differentiable everywhere; Newton's method may fail at a kink or jump.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for statement in context.statements() {
        let forces = matches!(
            statement.kind(),
            Some(
                "SFORCE"
                    | "VFORCE"
                    | "VTORQUE"
                    | "GFORCE"
                    | "GCON"
                    | "MOTION"
                    | "VARIABLE"
                    | "DIFF"
            )
        );
        if !forces {
            continue;
        }
        for (argument, def) in known(statement) {
            let Value::Function(expression) = &argument.value else {
                continue;
            };
            let Some((name, span)) = first_bend(expression) else {
                continue;
            };
            let message = format!(
                "{} of {} is not differentiable everywhere: {name} depends on the motion",
                def.name,
                context.title(statement)
            );
            found.push(
                context
                    .note(Code::NoDerivative, span, message)
                    .help("if no equilibrium is found, use STEP or a SPLINE instead"),
            );
        }
    }
}

/// Returns the first function call with a kink or jump at certain positions of parts.
fn first_bend(expression: &Expression) -> Option<(&'static str, Span)> {
    let mut found: Option<(&'static str, Span)> = None;
    for node in expression.root.walk() {
        let hit = match node {
            Node::If(parts) if moves(&parts[0]) => Some(("IF", expression.span)),
            Node::Call {
                function,
                arguments,
                span,
            } if bends(function) && arguments.iter().any(moves) => Some((function.name, *span)),
            _ => None,
        };
        if let Some(hit) = hit
            && found.is_none_or(|(_, span)| hit.1.start() < span.start())
        {
            found = Some(hit);
        }
    }
    found
}

fn bends(function: &FunctionDef) -> bool {
    matches!(
        function.name,
        "ABS" | "AINT" | "ANINT" | "DIM" | "INT" | "MAX" | "MIN" | "MOD" | "NINT" | "SIGN"
    )
}

/// Returns true if the value depends on the positions of parts.
fn moves(node: &Node) -> bool {
    node.walk().any(|node| match node {
        Node::Call { function, .. } => {
            matches!(
                function.solved,
                Solved::Native("measure" | "force measure" | "data")
            ) && !matches!(function.name, "AKISPL" | "CUBSPL" | "INTERP" | "SENVAL")
        }
        _ => false,
    })
}
