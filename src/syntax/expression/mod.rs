//! FUNCTION expressions as trees with spans.
//!
//! Knows the grammar of expressions and the names of functions, not what they compute.

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
    /// The tree.
    pub root: Node,
    /// Its text with continuation marks and comments removed, for messages and reports.
    pub text: String,
    /// Where it stands in the file.
    pub span: Span,
    /// Every number literal in order of appearance: value (radians if it has the degree suffix) and place in the file. Literal k
    /// is the address `....FUNCTION.{k+1}`.
    pub literals: Vec<super::Number>,
}

/// An operator of two operands.
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

/// A constant by name.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
#[allow(missing_docs)] // The names are the manual's.
pub enum Constant {
    Pi,
    Rtod,
    Dtor,
}

/// A node of the tree.
#[derive(Clone, PartialEq, Debug)]
pub enum Node {
    /// A number literal: its index in [`Expression::literals`].
    Literal(usize),
    /// PI, RTOD, DTOR.
    Constant(Constant),
    /// A name without arguments that the state defines: TIME, MODE.
    Name(&'static FunctionDef),
    /// Minus.
    Negate(Box<Node>),
    /// Two operands.
    Binary(BinaryOperator, Box<Node>, Box<Node>),
    /// IF(test: negative, zero, positive).
    If(Box<[Node; 4]>),
    /// `[x, y, z]`, a vector of three expressions.
    Vector(Box<[Node; 3]>),
    /// A function call, with the place of the whole call.
    Call {
        /// Which function.
        function: &'static FunctionDef,
        /// Its arguments.
        arguments: Vec<Node>,
        /// Where the call stands in the file.
        span: Span,
    },
}

impl Node {
    /// What stands directly inside of it, in order.
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

    /// It and everything inside of it; of what stands side by side the last first.
    pub fn walk(&self) -> impl Iterator<Item = &Self> {
        let mut open = vec![self];
        std::iter::from_fn(move || {
            let node = open.pop()?;
            open.extend(node.children());
            Some(node)
        })
    }
}
