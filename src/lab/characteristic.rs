//! Characteristics that laboratories measure, with the words for their signs.

use super::quantity::Quantity;
use admire_kc::Side;

/// Content of a column.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Target {
    /// A characteristic of a wheel or of the axle.
    Characteristic(Characteristic),
    /// Name of the test.
    Test,
    /// Side of the wheel.
    Side,
    /// Time, which determines the order of the rows of a test.
    Time,
}

/// Characteristic of a wheel or of the axle, named as in the guide page `kc`.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum Characteristic {
    /// Toe angle, positive for toe-in.
    ToeAngle,
    /// Camber angle, positive with the top of the wheel outboard.
    CamberAngle,
    /// Steer angle, positive to the right.
    SteerAngle,
    /// Caster angle of the steer axis, positive with its top rearward.
    CasterAngle,
    /// Pitch of the wheel carrier since design, positive with the top rearward.
    SideViewAngle,
    /// Inclination of the steer axis, positive with its top inboard.
    KingpinInclAngle,
    /// Vertical displacement of the wheel centre, positive in jounce.
    WheelTravel,
    /// Longitudinal displacement of the wheel centre, positive rearward.
    WheelTravelBase,
    /// Lateral displacement of the wheel centre, positive to the right.
    WheelTravelTrack,
    /// Longitudinal displacement of the contact point, positive rearward.
    PatchBase,
    /// Lateral displacement of the contact point, positive to the right.
    PatchTrack,
    /// Vertical load of the wheel, positive if the road pushes the wheel up.
    VerticalForce,
    /// Lateral force on the wheel, positive to the left.
    LateralForce,
    /// Longitudinal force at the contact patch, positive rearward.
    BrakingForce,
    /// Longitudinal force at the wheel centre, positive forward.
    DrivingForce,
    /// Torque about the vertical on the wheel, positive if it turns the wheel to the left.
    AligningTorque,
    /// Roll angle of the line through the wheel centres, positive with the left wheel up.
    RollAngle,
    /// Distance between the contact points.
    TotalTrack,
    /// Input of the steering, in the unit of the driven parameter of the deck.
    SteeringInput,
}

/// Word for a sign convention, with the factors for the left and the right wheel that convert values of this convention to the sign of the table.
pub(crate) type Sense = (&'static str, [f64; 2]);

const IN: Sense = ("in", [1.0, 1.0]);
const OUT: Sense = ("out", [-1.0, -1.0]);
const OUTBOARD: Sense = ("outboard", [1.0, 1.0]);
const INBOARD: Sense = ("inboard", [-1.0, -1.0]);
const RIGHT: Sense = ("right", [1.0, 1.0]);
const LEFT: Sense = ("left", [-1.0, -1.0]);
const REARWARD: Sense = ("rearward", [1.0, 1.0]);
const FORWARD: Sense = ("forward", [-1.0, -1.0]);
const UP: Sense = ("up", [1.0, 1.0]);
const DOWN: Sense = ("down", [-1.0, -1.0]);

/// Positions and displacements along +Y, positive to the right.
const LATERAL: &[Sense] = &[
    RIGHT,
    LEFT,
    ("outboard", [-1.0, 1.0]),
    ("inboard", [1.0, -1.0]),
];

impl Characteristic {
    /// All characteristics.
    pub const ALL: [Self; 19] = [
        Self::ToeAngle,
        Self::CamberAngle,
        Self::SteerAngle,
        Self::CasterAngle,
        Self::SideViewAngle,
        Self::KingpinInclAngle,
        Self::WheelTravel,
        Self::WheelTravelBase,
        Self::WheelTravelTrack,
        Self::PatchBase,
        Self::PatchTrack,
        Self::VerticalForce,
        Self::LateralForce,
        Self::BrakingForce,
        Self::DrivingForce,
        Self::AligningTorque,
        Self::RollAngle,
        Self::TotalTrack,
        Self::SteeringInput,
    ];

    /// Returns the name in a mapping.
    pub const fn word(self) -> &'static str {
        match self {
            Self::ToeAngle => "toe_angle",
            Self::CamberAngle => "camber_angle",
            Self::SteerAngle => "steer_angle",
            Self::CasterAngle => "caster_angle",
            Self::SideViewAngle => "side_view_angle",
            Self::KingpinInclAngle => "kingpin_incl_angle",
            Self::WheelTravel => "wheel_travel",
            Self::WheelTravelBase => "wheel_travel_base",
            Self::WheelTravelTrack => "wheel_travel_track",
            Self::PatchBase => "contact_point_base",
            Self::PatchTrack => "contact_point_track",
            Self::VerticalForce => "vertical_force",
            Self::LateralForce => "lateral_force",
            Self::BrakingForce => "braking_force",
            Self::DrivingForce => "driving_force",
            Self::AligningTorque => "aligning_torque",
            Self::RollAngle => "roll_angle",
            Self::TotalTrack => "total_track",
            Self::SteeringInput => "steering_input",
        }
    }

    /// Returns the characteristic with this name in a mapping.
    pub(crate) fn named(word: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|own| own.word() == word)
    }

    /// Returns the quantity; `None` for the steering input, whose unit is the unit of the driven parameter of the deck.
    pub const fn quantity(self) -> Option<Quantity> {
        Some(match self {
            Self::ToeAngle
            | Self::CamberAngle
            | Self::SteerAngle
            | Self::CasterAngle
            | Self::SideViewAngle
            | Self::KingpinInclAngle
            | Self::RollAngle => Quantity::Angle,
            Self::WheelTravel
            | Self::WheelTravelBase
            | Self::WheelTravelTrack
            | Self::PatchBase
            | Self::PatchTrack
            | Self::TotalTrack => Quantity::Length,
            Self::VerticalForce | Self::LateralForce | Self::BrakingForce | Self::DrivingForce => {
                Quantity::Force
            }
            Self::AligningTorque => Quantity::Torque,
            Self::SteeringInput => return None,
        })
    }

    /// Returns true if each wheel has its own value.
    pub const fn is_sided(self) -> bool {
        !matches!(
            self,
            Self::RollAngle | Self::TotalTrack | Self::SteeringInput
        )
    }

    /// Returns the words for the positive direction of values, with the factors to the sign of the table.
    pub(crate) const fn senses(self) -> &'static [Sense] {
        match self {
            Self::ToeAngle => &[IN, OUT, ("right", [1.0, -1.0]), ("left", [-1.0, 1.0])],
            Self::CamberAngle => &[
                OUTBOARD,
                INBOARD,
                ("right", [-1.0, 1.0]),
                ("left", [1.0, -1.0]),
            ],
            Self::SteerAngle => &[RIGHT, LEFT],
            Self::CasterAngle
            | Self::SideViewAngle
            | Self::WheelTravelBase
            | Self::PatchBase
            | Self::BrakingForce => &[REARWARD, FORWARD],
            Self::KingpinInclAngle => &[("inboard", [1.0, 1.0]), ("outboard", [-1.0, -1.0])],
            Self::WheelTravel | Self::VerticalForce => &[UP, DOWN],
            Self::WheelTravelTrack | Self::PatchTrack => LATERAL,
            Self::LateralForce => &[
                ("left", [1.0, 1.0]),
                ("right", [-1.0, -1.0]),
                ("outboard", [1.0, -1.0]),
                ("inboard", [-1.0, 1.0]),
            ],
            Self::DrivingForce => &[("forward", [1.0, 1.0]), ("rearward", [-1.0, -1.0])],
            Self::AligningTorque => &[
                ("left", [1.0, 1.0]),
                ("right", [-1.0, -1.0]),
                ("in", [-1.0, 1.0]),
                ("out", [1.0, -1.0]),
            ],
            Self::RollAngle => &[("left-up", [1.0, 1.0]), ("right-up", [-1.0, -1.0])],
            Self::SteeringInput => &[("as-driven", [1.0, 1.0]), ("reversed", [-1.0, -1.0])],
            Self::TotalTrack => &[],
        }
    }

    /// Returns the factor from values with this positive direction to the sign of the table. Returns `None` for an unknown word.
    pub(crate) fn sign(self, positive: &str, side: Option<Side>) -> Option<f64> {
        let found = self.senses().iter().find(|(word, _)| *word == positive);
        found.map(|(_, factors)| factors[side.map_or(0, Side::index)])
    }

    /// Describes the meaning of positive values in the table.
    pub const fn positive(self) -> &'static str {
        match self {
            Self::ToeAngle => "toe-in",
            Self::CamberAngle => "top outboard",
            Self::SteerAngle | Self::WheelTravelTrack | Self::PatchTrack => "right",
            Self::CasterAngle | Self::SideViewAngle => "top rearward",
            Self::KingpinInclAngle => "top inboard",
            Self::WheelTravel => "up",
            Self::WheelTravelBase | Self::PatchBase | Self::BrakingForce => "rearward",
            Self::VerticalForce => "wheel pushed up",
            Self::LateralForce => "wheel pushed to the left",
            Self::DrivingForce => "forward",
            Self::AligningTorque => "wheel turned to the left",
            Self::RollAngle => "left wheel up",
            Self::TotalTrack => "distance",
            Self::SteeringInput => "as driven",
        }
    }

    /// Returns the path of the column in the table: a request of Adams/Car and its component, such as `toe_angle.left`. The steering input has no
    /// component.
    pub fn path(self, side: Option<Side>) -> String {
        let side = side.map_or("left", Side::word);
        match self {
            Self::WheelTravel => format!("wheel_travel.vertical_{side}"),
            Self::WheelTravelBase => format!("wheel_travel_base.base_{side}"),
            Self::WheelTravelTrack => format!("wheel_travel_track.track_{side}"),
            Self::PatchBase => format!("{side}_tire_contact_point.base_change_{side}"),
            Self::PatchTrack => format!("{side}_tire_contact_point.track_change_{side}"),
            Self::VerticalForce => format!("wheel_load_vertical_force.vertical_{side}_force"),
            Self::LateralForce => format!("wheel_load_lateral.lateral_{side}"),
            Self::BrakingForce => format!("wheel_load_longitudinal.braking_{side}"),
            Self::DrivingForce => format!("wheel_load_longitudinal.driving_{side}"),
            Self::AligningTorque => format!("wheel_load_align.algn_torque_{side}"),
            Self::RollAngle => "roll_angle.at_wheel_centers".to_string(),
            Self::TotalTrack => "total_track.track".to_string(),
            Self::SteeringInput => "steering_input".to_string(),
            _ => format!("{}.{side}", self.word()),
        }
    }

    /// Returns the name of the equivalent curve in section `[kc]` of a study, with the same sign; `None` if there is none.
    pub const fn study_curve(self) -> Option<&'static str> {
        match self {
            Self::ToeAngle => Some("toe"),
            Self::CamberAngle => Some("camber"),
            Self::SteerAngle => Some("steer"),
            Self::SideViewAngle => Some("caster"),
            Self::WheelTravel => Some("travel"),
            Self::WheelTravelBase => Some("base"),
            Self::WheelTravelTrack => Some("track"),
            _ => None,
        }
    }
}

impl Target {
    /// Returns the name in a mapping.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Characteristic(own) => own.word(),
            Self::Test => "test",
            Self::Side => "side",
            Self::Time => "time",
        }
    }

    /// Returns the target with this name in a mapping.
    pub fn named(word: &str) -> Option<Self> {
        match word {
            "test" => Some(Self::Test),
            "side" => Some(Self::Side),
            "time" => Some(Self::Time),
            _ => Characteristic::named(word).map(Self::Characteristic),
        }
    }

    /// Returns the names of all targets.
    pub fn words() -> Vec<&'static str> {
        let own = Characteristic::ALL.into_iter().map(Characteristic::word);
        own.chain(["test", "side", "time"]).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// If the vehicle steers to the right, the left wheel shows toe-in and the right wheel toe-out. A force to the left is outboard on the left
    /// wheel.
    #[test]
    fn signs_depend_on_the_side_where_directions_of_the_vehicle_count() {
        let sign = |of: Characteristic, word| Side::BOTH.map(|side| of.sign(word, Some(side)));
        assert_eq!(
            sign(Characteristic::ToeAngle, "right"),
            [Some(1.0), Some(-1.0)]
        );
        assert_eq!(
            sign(Characteristic::CamberAngle, "left"),
            [Some(1.0), Some(-1.0)]
        );
        assert_eq!(
            sign(Characteristic::LateralForce, "left"),
            [Some(1.0), Some(1.0)]
        );
        assert_eq!(
            sign(Characteristic::LateralForce, "outboard"),
            [Some(1.0), Some(-1.0)]
        );
        assert_eq!(
            sign(Characteristic::WheelTravelTrack, "outboard"),
            [Some(-1.0), Some(1.0)]
        );
        assert_eq!(
            sign(Characteristic::AligningTorque, "in"),
            [Some(-1.0), Some(1.0)]
        );
        assert_eq!(
            sign(Characteristic::DrivingForce, "forward"),
            [Some(1.0), Some(1.0)]
        );
        assert_eq!(
            sign(Characteristic::KingpinInclAngle, "inboard"),
            [Some(1.0), Some(1.0)]
        );
        assert_eq!(sign(Characteristic::WheelTravel, "left"), [None, None]);
    }

    #[test]
    fn names_are_unique() {
        for word in Target::words() {
            assert_eq!(Target::named(word).map(Target::word), Some(word));
        }
    }
}
