//! Equivalent swing arms and the kinematic roll centre. Source of every formula: guide page `kc`, section "Swing arms and roll centre".

use super::{Compliance, Side};
use admire_solver::mechanics::Vec3;

/// Vertical load case that moves the wheel. The load cases give different results if an anti-roll bar couples the wheels. Real results do
/// not show which load case Adams/Car uses.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VerticalLoad {
    /// Load on this wheel alone (column 3 of the left wheel's compliance, column 9 of the right).
    #[default]
    OneWheel,
    /// The same load on both wheels.
    InPhase,
    /// Opposite loads on the two wheels.
    Antiphase,
}

impl VerticalLoad {
    /// Returns displacement `i` of a wheel centre under this load case.
    fn row(self, c: &Compliance, side: Side, i: usize) -> f64 {
        match self {
            Self::OneWheel => c.of((side, i), (side, 3)),
            Self::InPhase => c.in_phase(side, i, 3),
            Self::Antiphase => c.antiphase(side, i, 3),
        }
    }

    /// Returns displacement `i` of a wheel centre per vertical travel of the wheel.
    pub(crate) fn per_travel(self, c: &Compliance, side: Side, i: usize) -> f64 {
        self.row(c, side, i) / self.row(c, side, 3)
    }
}

/// Returns the slope angle of the front-view swing arm in radians, positive if the instant centre is above the wheel centre. On the left it
/// is `atan(-C23 / C33)`.
pub fn front_view_angle(c: &Compliance, side: Side, load: VerticalLoad) -> f64 {
    libm::atan(side.outboard_sign() * load.per_travel(c, side, 2))
}

/// Returns the slant length of the front-view swing arm, positive with the instant centre inboard. On the left it is
/// `-1 / (C43/C33 cos angle)`.
pub(crate) fn front_view_length(c: &Compliance, side: Side, load: VerticalLoad) -> f64 {
    let angle = front_view_angle(c, side, load);
    side.outboard_sign() / (load.per_travel(c, side, 4) * libm::cos(angle))
}

/// Returns the slope angle of the side-view swing arm in radians: `atan(-C13 / C33)`. It is negative if the instant centre is ahead of the
/// wheel and above its centre.
pub fn side_view_angle(c: &Compliance, side: Side, load: VerticalLoad) -> f64 {
    libm::atan(-load.per_travel(c, side, 1))
}

/// Returns the slant length of the side-view swing arm, positive with the instant centre ahead of the wheel: `-1 / (C53/C33 cos angle)`.
pub(crate) fn side_view_length(c: &Compliance, side: Side, load: VerticalLoad) -> f64 {
    let angle = side_view_angle(c, side, load);
    -1.0 / (load.per_travel(c, side, 5) * libm::cos(angle))
}

/// Kinematic roll centre in the front view.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct RollCentre {
    /// y of the roll centre: its distance from the vehicle's centre plane.
    pub lateral: f64,
    /// Height above the mean height of the contact points.
    pub vertical: f64,
    /// y of each contact point minus y of the roll centre.
    pub to_patch: [f64; 2],
}

/// Intersects the lines through the contact points, both starting from the same height. `at_patch` is the compliance at the contact points,
/// without tyre.
///
/// The slopes are `sL = -C(2,3) / C(3,3)` and `sR = C(8,9) / C(9,9)`. The lines meet at `y = (sL yL + sR yR) / (sL + sR)`, at the height
/// `sL (y - yL)` above the mean height of the contact points. The result is not finite if the lines are parallel.
pub(crate) fn roll_centre(
    at_patch: &Compliance,
    contact: &[Vec3; 2],
    load: VerticalLoad,
) -> RollCentre {
    let [l, r] = contact;
    let slope = |side: Side| side.outboard_sign() * load.per_travel(at_patch, side, 2);
    let (sl, sr) = (slope(Side::Left), slope(Side::Right));
    let lateral = (sl * l.y + sr * r.y) / (sl + sr);
    RollCentre {
        lateral,
        vertical: sl * (lateral - l.y),
        to_patch: [l.y - lateral, r.y - lateral],
    }
}
