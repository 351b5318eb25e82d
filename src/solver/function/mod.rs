//! FUNCTION expressions compiled to flat programs: value and exact derivatives.
//!
//! A program works on plain numbers: the state quantities that it reads ([`Input`]) and the literals of its text. The caller passes both. A
//! program is independent of part positions, of forces and of the assembly of a system. Geometric quantities are evaluated in [`measure`]
//! from given poses. Forces of other elements enter as inputs that the caller fills.

mod akima;
mod breaks;
mod build;
mod call;
mod called;
mod compiler;
mod cubic;
mod curves;
mod degree;
mod error;
mod euler;
mod impact;
mod input;
mod interpolant;
mod intrinsic;
pub mod measure;
mod program;
pub mod rate;
mod second;
mod series;
mod step;
mod switch;
#[cfg(test)]
mod tests;

pub(crate) use breaks::time_breaks;
pub use compiler::ExpressionCompiler;
pub use curves::{Curves, akima_value};
pub(crate) use degree::Degree;
pub(crate) use error::{EvalError, Fault};
pub(crate) use input::{
    ForceComponent, ForceMeasure, MeasureKind, MeasuredElement, RateAxis, RateKind, RateMeasure,
    RotationSequence,
};
pub use input::{Input, Measure};
pub use measure::Reference;
pub(crate) use program::Program;
pub use program::{EvaluationMemory, ProgramNumbers};
pub(crate) use rate::MovingFrame;
pub(crate) use switch::{Piece, SwitchState, between, half_width};
