use serde::{Deserialize, Serialize};

use admire_solver::mechanics::{Mat3, Vec3};

/// Direction relative to the vehicle.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Direction {
    /// Driving direction.
    Forward,
    /// Opposite of the driving direction.
    Rearward,
    /// The driver's left.
    Left,
    /// The driver's right.
    Right,
    /// Away from the road.
    Up,
    /// Towards the road.
    Down,
}

impl Direction {
    /// Returns the unit vector of the direction in this crate's axes.
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

/// Named axes of a vehicle, all right-handed. Vectors are converted to this crate's axes before any formula is applied.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Convention {
    /// Adams/Car, and this crate: X rearward, Y to the right, Z up.
    #[default]
    AdamsCar,
    /// ISO 8855: X forward, Y to the left, Z up.
    Iso,
    /// SAE J670 with Z down: X forward, Y to the right.
    Sae,
}

impl Convention {
    /// Returns the directions in which X, Y and Z of the convention point.
    pub const fn axes(self) -> [Direction; 3] {
        use Direction::{Down, Forward, Left, Rearward, Right, Up};
        match self {
            Self::AdamsCar => [Rearward, Right, Up],
            Self::Iso => [Forward, Left, Up],
            Self::Sae => [Forward, Right, Down],
        }
    }

    /// Returns the factor, 1 or -1, that converts a value of this sense from this crate's axes to this convention.
    pub fn factor(self, sense: Sense) -> f64 {
        let along = |k: usize| self.axes()[k].vector()[k];
        match sense {
            Sense::Own => 1.0,
            // A proper rotation transforms polar and axial vectors alike.
            Sense::X | Sense::AboutX => along(0),
            Sense::Y => along(1),
            Sense::Z | Sense::AboutZ => along(2),
            // Adams/Car counts this angle positive to the right although its Z points up; the other conventions count it about their Z.
            Sense::ToTheRight if self == Self::AdamsCar => 1.0,
            Sense::ToTheRight => -along(2),
        }
    }

    /// Returns the name of the convention in files: `adams-car`, `iso` or `sae`.
    pub const fn word(self) -> &'static str {
        match self {
            Self::AdamsCar => "adams-car",
            Self::Iso => "iso",
            Self::Sae => "sae",
        }
    }
}

/// Meaning of a characteristic's sign, which decides how it changes with the axes.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Sense {
    /// Sign that does not depend on the axes, as of toe-in, camber, a rate or a length.
    Own,
    /// Component of a displacement or force along X.
    X,
    /// Component of a displacement or force along Y.
    Y,
    /// Component of a displacement or force along Z.
    Z,
    /// Rotation about X.
    AboutX,
    /// Rotation about Z.
    AboutZ,
    /// Steer angle: positive to the right in Adams/Car, positive about Z in the other conventions.
    ToTheRight,
}

/// Orientation of a deck's axes.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Frame {
    /// Rotation from the deck's ground axes to this crate's axes: X rearward, Y right, Z up.
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
    /// Creates the frame from the directions of the deck's X, Y and Z. `None` unless they are right-handed axes.
    pub fn new(axes: [Direction; 3]) -> Option<Self> {
        let from_deck = Mat3::from_columns(&axes.map(Direction::vector));
        (from_deck.determinant() > 0.5).then_some(Self { from_deck })
    }

    /// Converts a vector from the deck's axes to this crate's axes.
    pub(crate) fn vector(&self, v: &Vec3) -> Vec3 {
        self.from_deck * v
    }

    /// Converts a rotation from the deck's axes to this crate's axes.
    pub(crate) fn rotation(&self, R: &Mat3) -> Mat3 {
        self.from_deck * R * self.from_deck.transpose()
    }

    /// Converts a vector from this crate's axes to the deck's axes.
    pub fn to_deck(self, v: &Vec3) -> Vec3 {
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

    /// A left steer angle is positive in ISO axes and negative in SAE axes.
    #[test]
    fn steer_counts_about_the_axis_of_the_convention() {
        let left_in_adams_car = -0.1;
        assert!(Convention::Iso.factor(Sense::ToTheRight) * left_in_adams_car > 0.0);
        assert!(Convention::Sae.factor(Sense::ToTheRight) * left_in_adams_car < 0.0);
    }
}
