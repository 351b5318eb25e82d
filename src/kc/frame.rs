use serde::{Deserialize, Serialize};

use admire_solver::mechanics::{Mat3, Vec3};

/// A direction of the vehicle.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Where it drives to.
    Forward,
    /// The opposite.
    Rearward,
    /// The driver's left.
    Left,
    /// The driver's right.
    Right,
    /// Away from the road.
    Up,
    /// Towards it.
    Down,
}

impl Direction {
    /// The unit vector in the axes of this room.
    fn vector(self) -> Vec3 {
        match self {
            Self::Rearward => Vec3::x(),
            Self::Forward => -Vec3::x(),
            Self::Right => Vec3::y(),
            Self::Left => -Vec3::y(),
            Self::Up => Vec3::z(),
            Self::Down => -Vec3::z(),
        }
    }
}

/// Named axes of a vehicle. All are right-handed; vectors are converted, and formulas applied afterwards.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Convention {
    /// Adams/Car: X rearward, Y to the right, Z up. The axes of this room.
    #[default]
    AdamsCar,
    /// ISO 8855: X forward, Y to the left, Z up.
    Iso,
    /// SAE J670 with Z down: X forward, Y to the right.
    Sae,
}

impl Convention {
    /// The axes.
    pub const fn axes(self) -> [Direction; 3] {
        use Direction::{Down, Forward, Left, Rearward, Right, Up};
        match self {
            Self::AdamsCar => [Rearward, Right, Up],
            Self::Iso => [Forward, Left, Up],
            Self::Sae => [Forward, Right, Down],
        }
    }

    /// What a number of this sense in the axes of this room is multiplied by: how a component of a vector, or a rotation about an axis,
    /// changes with the axes.
    pub fn factor(self, sense: Sense) -> f64 {
        let along = |k: usize| self.axes()[k].vector()[k];
        match sense {
            Sense::Own => 1.0,
            // A proper rotation turns polar and axial vectors alike.
            Sense::X | Sense::AboutX => along(0),
            Sense::Y => along(1),
            Sense::Z | Sense::AboutZ => along(2),
            // Adams/Car counts the angle to the right though its Z points up; the others about their Z.
            Sense::ToTheRight if self == Self::AdamsCar => 1.0,
            Sense::ToTheRight => -along(2),
        }
    }

    /// `adams-car`, `iso`, `sae`.
    pub const fn word(self) -> &'static str {
        match self {
            Self::AdamsCar => "adams-car",
            Self::Iso => "iso",
            Self::Sae => "sae",
        }
    }
}

/// What the sign of a characteristic means.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Sense {
    /// Its own meaning, the same in all axes: toe-in, camber, a rate, a length.
    Own,
    /// A component of a displacement or force along X.
    X,
    /// Along Y.
    Y,
    /// Along Z.
    Z,
    /// A rotation about X.
    AboutX,
    /// A rotation about Z.
    AboutZ,
    /// A rotation to the right in Adams/Car, about Z elsewhere.
    ToTheRight,
}

/// The axes of a deck.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Frame {
    /// From components in ground axes of the deck to the axes of this room: X rearward, Y right, Z up.
    pub from_deck: Mat3,
}

impl Default for Frame {
    fn default() -> Self {
        Self {
            from_deck: Mat3::identity(),
        }
    }
}

impl Frame {
    /// From what the deck's X, Y and Z point to. `None` unless they are right-handed axes of a vehicle.
    pub fn new(axes: [Direction; 3]) -> Option<Self> {
        let from_deck = Mat3::from_columns(&axes.map(Direction::vector));
        (from_deck.determinant() > 0.5).then_some(Self { from_deck })
    }

    /// A vector of the deck in the axes of this room.
    pub(crate) fn vector(&self, v: &Vec3) -> Vec3 {
        self.from_deck * v
    }

    /// A rotation of the deck in the axes of this room.
    pub(crate) fn rotation(&self, R: &Mat3) -> Mat3 {
        self.from_deck * R * self.from_deck.transpose()
    }

    /// A vector of this room in the axes of the deck.
    pub(crate) fn to_deck(self, v: &Vec3) -> Vec3 {
        self.from_deck.transpose() * v
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn named_axes_are_right_handed_and_others_are_refused() {
        for convention in [Convention::AdamsCar, Convention::Iso, Convention::Sae] {
            let frame = Frame::new(convention.axes()).expect("right-handed");
            let x = frame.vector(&Vec3::x());
            assert_eq!(x, convention.axes()[0].vector());
        }
        use Direction::{Forward, Right, Up};
        assert_eq!(Frame::new([Forward, Right, Up]), None);
        assert_eq!(Frame::new([Forward, Forward, Up]), None);
    }

    /// A wheel turned to the left is a positive rotation in ISO axes and a negative one in SAE axes.
    #[test]
    fn steer_counts_about_the_axis_of_the_convention() {
        let left_in_adams_car = -0.1;
        assert!(Convention::Iso.factor(Sense::ToTheRight) * left_in_adams_car > 0.0);
        assert!(Convention::Sae.factor(Sense::ToTheRight) * left_in_adams_car < 0.0);
    }
}
