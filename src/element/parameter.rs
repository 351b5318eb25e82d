//! Names and dimensions of law parameters. Knows no values.

use crate::units::Dimension;

/// The parameters that come from one argument of a statement.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub struct ParameterGroup {
    /// The argument's keyword in capitals.
    pub argument: &'static str,
    /// Physical dimension of each of its values, in the order written.
    pub dimensions: &'static [Dimension],
}

impl ParameterGroup {
    /// The catalogue name of value `k` (from 0): `K.1`, or the bare keyword where the argument has one value.
    pub fn name(&self, k: usize) -> String {
        if self.dimensions.len() == 1 {
            self.argument.to_owned()
        } else {
            format!("{}.{}", self.argument, k + 1)
        }
    }
}

const fn dimension(force: i8, length: i8, angle: i8) -> Dimension {
    Dimension::new(force, 0, length, 0, angle)
}

/// Force per length.
pub(super) const STIFFNESS: Dimension = dimension(1, -1, 0);
/// Torque per angle.
pub(super) const TORSION: Dimension = dimension(1, 1, -1);
/// Modulus of elasticity.
pub(super) const MODULUS: Dimension = dimension(1, -2, 0);
/// Area.
pub(super) const AREA: Dimension = dimension(0, 2, 0);
/// Second moment of area.
pub(super) const SECOND_MOMENT: Dimension = dimension(0, 4, 0);

/// Coordinates x, y, z, a, b, c.
pub(super) const COORDINATES: [Dimension; 6] = six(Dimension::LENGTH, Dimension::ANGLE);
/// Force and torque.
pub(super) const WRENCH: [Dimension; 6] = six(Dimension::FORCE, Dimension::TORQUE);

const fn six(first: Dimension, last: Dimension) -> [Dimension; 6] {
    [first, first, first, last, last, last]
}

/// KMATRIX of a FIELD, column by column: wrench component i per coordinate j.
pub(super) const FIELD_STIFFNESS: [Dimension; 36] = {
    let mut all = [Dimension::NONE; 36];
    let mut n = 0;
    while n < 36 {
        let (i, j) = (n % 6, n / 6);
        let torque = if i < 3 { 0 } else { 1 };
        all[n] = if j < 3 {
            dimension(1, torque - 1, 0)
        } else {
            dimension(1, torque, -1)
        };
        n += 1;
    }
    all
};
