//! Polynomial degree of a compiled function expression (program) in some of its inputs.

use super::Input;
use super::program::{Kind, Program};

/// Polynomial degree of an expression in a group of inputs.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum Degree {
    /// Independent of these inputs.
    Nothing,
    /// Linear: coefficients and constant term are independent of these inputs.
    Linear,
    /// Nonlinear, or not recognisable as linear from the text.
    Higher,
}

impl Degree {
    /// Returns the degree of a product.
    fn times(self, other: Self) -> Self {
        match (self, other) {
            (Self::Nothing, of) | (of, Self::Nothing) => of,
            _ => Self::Higher,
        }
    }

    /// Returns the degree of a nonlinear function whose argument has this degree.
    fn inside(self) -> Self {
        self.times(self)
    }
}

impl Program {
    /// Returns the degree of the program's value, given the degree of each input. The analysis follows sums, products, quotients and the
    /// parts of an IF. Any other function of an input of nonzero degree counts as nonlinear.
    pub(crate) fn degree(&self, of: impl FnMut(&Input) -> Degree) -> Degree {
        let mut degrees: Vec<Degree> = self.inputs.iter().map(of).collect();
        let slots = self.slots.max(self.result as usize + 1);
        degrees.resize(slots.max(degrees.len()), Degree::Nothing);
        for step in &self.steps {
            let operands = &self.operands[step.first as usize..(step.first + step.count) as usize];
            let mut each = operands.iter().map(|&slot| degrees[slot as usize]);
            let degree = match step.kind {
                Kind::Jump(_) => continue,
                Kind::Branch { .. } => match each.next() {
                    None | Some(Degree::Nothing) => continue,
                    Some(_) => return Degree::Higher,
                },
                // Each part of an IF has its own Move step to the same target; the target takes the highest degree.
                Kind::Move => each
                    .next()
                    .unwrap_or(Degree::Nothing)
                    .max(degrees[step.target as usize]),
                Kind::Negate | Kind::Add | Kind::Subtract => each.max().unwrap_or(Degree::Nothing),
                Kind::Multiply => each.fold(Degree::Nothing, Degree::times),
                Kind::Divide => {
                    let above = each.next().unwrap_or(Degree::Nothing);
                    above.times(each.next().unwrap_or(Degree::Nothing).inside())
                }
                _ => each.max().unwrap_or(Degree::Nothing).inside(),
            };
            degrees[step.target as usize] = degree;
        }
        degrees[self.result as usize]
    }
}
