//! FUNCTION expressions as trees with spans.
//!
//! The module covers the grammar of expressions and the names of functions; it does not evaluate them.

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
    /// All number literals in order of appearance, with value (radians if it has the degree suffix) and location.
    ///
    /// Literal k has the address `....FUNCTION.{k+1}`.
    pub literals: Vec<super::Number>,
}

/// An operator with two operands.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names say it.
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
#[allow(missing_docs)] // The names are the manual's.
pub enum Constant {
    Pi,
    Rtod,
    Dtor,
}

/// A node of the expression tree.
#[derive(Clone, PartialEq, Debug)]
pub enum Node {
    /// A number literal, as an index into [`Expression::literals`].
    Literal(usize),
    /// PI, RTOD, DTOR.
    Constant(Constant),
    /// A function without arguments whose value depends on the state of the run: TIME, MODE.
    Name(&'static FunctionDef),
    /// Unary minus.
    Negate(Box<Node>),
    /// A binary operation.
    Binary(BinaryOperator, Box<Node>, Box<Node>),
    /// A choice by sign: IF(test: negative, zero, positive).
    If(Box<[Node; 4]>),
    /// `[x, y, z]`, a vector of three expressions.
    Vector(Box<[Node; 3]>),
    /// A function call.
    Call {
        /// Function that is called.
        function: &'static FunctionDef,
        /// Arguments of the call.
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

    /// Iterates over the node and all its descendants; siblings are visited from last to first.
    pub fn walk(&self) -> impl Iterator<Item = &Self> {
        let mut open = vec![self];
        std::iter::from_fn(move || {
            let node = open.pop()?;
            open.extend(node.children());
            Some(node)
        })
    }
}
