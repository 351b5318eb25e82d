//! FUNCTION expressions as trees with spans.
//!
//! The module parses expressions and looks up the names of functions; it does not evaluate expressions.

mod parse;
mod references;
#[cfg(test)]
mod tests;
mod tokens;

pub use parse::parse;
pub use references::argument_space;

use crate::grammar::FunctionDef;
use crate::text::Span;

/// A parsed FUNCTION expression.
#[derive(Clone, PartialEq, Debug)]
pub struct Expression {
    /// Root of the tree.
    pub root: Node,
    /// Text of the expression without continuation marks and comments, for messages and reports.
    pub text: String,
    /// Location in the file.
    pub span: Span,
    /// All literal numbers in order of appearance, with value and location. Angles with the degree suffix are in radians.
    ///
    /// The literal at index k has the address `....FUNCTION.{k+1}`.
    pub literals: Vec<super::Number>,
}

/// An operator with two operands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names are self-explanatory.
pub enum BinaryOperator {
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    /// `%`, the cross product of two vectors.
    Cross,
}

/// A named constant.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names are those of the manual.
pub enum Constant {
    Pi,
    Rtod,
    Dtor,
}

/// A node of the expression tree.
#[derive(Clone, PartialEq, Debug)]
pub enum Node {
    /// A literal number, given by its index in [`Expression::literals`].
    Literal(usize),
    /// A named constant: PI, RTOD or DTOR.
    Constant(Constant),
    /// A function without arguments, such as TIME or MODE; its value depends on the state of the simulation.
    Name(&'static FunctionDef),
    /// Negation by a minus sign.
    Negate(Box<Node>),
    /// A binary operation.
    Binary(BinaryOperator, Box<Node>, Box<Node>),
    /// A selection by sign, `IF(test: negative, zero, positive)`: the test, and one expression for each sign.
    If(Box<[Node; 4]>),
    /// `[x, y, z]`, a vector of three expressions.
    Vector(Box<[Node; 3]>),
    /// A function call.
    Call {
        /// Function that is called.
        function: &'static FunctionDef,
        /// Arguments of the call, in order.
        arguments: Vec<Node>,
        /// Location of the whole call in the file.
        span: Span,
    },
}

impl Node {
    /// Returns the direct children of the node, in order.
    pub fn children(&self) -> Vec<&Self> {
        match self {
            Self::Literal(_) | Self::Constant(_) | Self::Name(_) => Vec::new(),
            Self::Negate(inner) => vec![inner],
            Self::Binary(_, left, right) => vec![left, right],
            Self::If(parts) => parts.iter().collect(),
            Self::Vector(parts) => parts.iter().collect(),
            Self::Call { arguments, .. } => arguments.iter().collect(),
        }
    }

    /// Iterates over the node and all its descendants; the children of a node are visited from last to first.
    pub fn walk(&self) -> impl Iterator<Item = &Self> {
        let mut open = vec![self];
        std::iter::from_fn(move || {
            let node = open.pop()?;
            open.extend(node.children());
            Some(node)
        })
    }
}
