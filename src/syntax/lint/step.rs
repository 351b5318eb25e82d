use super::context::Context;
use crate::diagnostic::{Code, Diagnostic};
use crate::expression::{BinaryOperator, Constant, Node};
use crate::{Expression, Value};

/// Reports STEP, STEP5 and HAVSIN calls that begin and end at the same x, where their value is undefined.
pub(super) fn check(context: &Context<'_>, found: &mut Vec<Diagnostic>) {
    for statement in context.statements() {
        for argument in &statement.arguments {
            let Value::Function(expression) = &argument.value else {
                continue;
            };
            for node in expression.root.walk() {
                if let Node::Call {
                    function,
                    arguments,
                    span,
                } = node
                    && matches!(function.name, "STEP" | "STEP5" | "HAVSIN")
                    && let [_, x0, _, x1, _] = &arguments[..]
                    && let (Some(from), Some(to)) = (value(expression, x0), value(expression, x1))
                    && from == to
                {
                    let message = format!(
                        "{} of {} begins and ends at {from}: it has no width",
                        function.name,
                        context.title(statement)
                    );
                    found.push(
                        context
                            .warning(Code::StepWithoutWidth, *span, message)
                            .help(format!(
                                "{}(x, x0, h0, x1, h1) goes from h0 at x0 to h1 at x1",
                                function.name
                            )),
                    );
                }
            }
        }
    }
}

/// Evaluates an expression that consists of literal numbers and constants; returns `None` for any other expression.
fn value(expression: &Expression, node: &Node) -> Option<f64> {
    Some(match node {
        Node::Literal(at) => expression.literals[*at].value,
        Node::Constant(Constant::Pi) => std::f64::consts::PI,
        Node::Constant(Constant::Rtod) => 1f64.to_degrees(),
        Node::Constant(Constant::Dtor) => 1f64.to_radians(),
        Node::Negate(inner) => -value(expression, inner)?,
        Node::Binary(operator, left, right) => {
            let (left, right) = (value(expression, left)?, value(expression, right)?);
            match operator {
                BinaryOperator::Add => left + right,
                BinaryOperator::Subtract => left - right,
                BinaryOperator::Multiply => left * right,
                BinaryOperator::Divide => left / right,
                BinaryOperator::Power => libm::pow(left, right),
                BinaryOperator::Cross => return None,
            }
        }
        Node::Name(_) | Node::If(_) | Node::Vector(_) | Node::Call { .. } => return None,
    })
}
