//! How a program depends on some of its inputs.

use super::Input;
use super::program::{Kind, Program};

/// The degree in some inputs taken together.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub(crate) enum Degree {
    /// Not at all.
    Nothing,
    /// Linear, with coefficients and a rest that do not depend on them.
    Linear,
    /// Any other way, or one that the text does not tell.
    Higher,
}

impl Degree {
    /// Of a product.
    fn times(self, other: Self) -> Self {
        match (self, other) {
            (Self::Nothing, of) | (of, Self::Nothing) => of,
            _ => Self::Higher,
        }
    }

    /// Of a function that is neither sum nor product.
    fn inside(self) -> Self {
        self.times(self)
    }
}

impl Program {
    /// The degree of its value, from those of its inputs. Sums, products, quotients and the parts of an IF are followed; in any other
    /// function an input is of higher degree.
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
                // Every part of an IF has its own step to the same place.
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
