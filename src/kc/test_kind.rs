use super::Unit;
use super::test_settings::{Hold, LoadPoint, TestSettings};
use admire_syntax::units::Units;

/// Standard test of an axle on a rig.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Debug)]
pub enum TestKind {
    /// Both wheels move up and down together.
    Bounce,
    /// The left wheel moves up, the right wheel down.
    Roll,
    /// Steering input.
    Steering,
    /// The same lateral force acts on both wheels.
    Lateral,
    /// Lateral forces act outward on both wheels.
    LateralOpposed,
    /// A lateral force acts on the left wheel, or on the only wheel.
    LateralSingle,
    /// Rearward forces act at the patches, with the brakes on.
    Braking,
    /// Forward forces act at the wheel centres.
    Traction,
    /// The same torque about the vertical acts on both wheels.
    Aligning,
    /// Opposite torques about the vertical act on the two wheels.
    AligningOpposed,
}

/// Driven input of a test. The two factors are the input of the left and the right wheel per unit of the test's variable.
#[derive(Clone, Copy, PartialEq, Debug)]
pub enum Driven {
    /// Heights of the wheel centres.
    Height([f64; 2]),
    /// Steering input.
    Steering,
    /// Longitudinal forces, +X rearward.
    Fx([f64; 2]),
    /// Lateral forces, +Y to the right.
    Fy([f64; 2]),
    /// Torques about +Z.
    Mz([f64; 2]),
}

impl TestKind {
    /// All tests in the order they are run.
    pub const ALL: [Self; 10] = [
        Self::Bounce,
        Self::Roll,
        Self::Steering,
        Self::Lateral,
        Self::LateralOpposed,
        Self::LateralSingle,
        Self::Braking,
        Self::Traction,
        Self::Aligning,
        Self::AligningOpposed,
    ];

    /// Returns the name in `kc.toml` and in outputs.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Bounce => "bounce",
            Self::Roll => "roll",
            Self::Steering => "steering",
            Self::Lateral => "lateral",
            Self::LateralOpposed => "lateral_opposed",
            Self::LateralSingle => "lateral_single",
            Self::Braking => "braking",
            Self::Traction => "traction",
            Self::Aligning => "aligning",
            Self::AligningOpposed => "aligning_opposed",
        }
    }

    /// Returns true if the test runs by default.
    pub(crate) const fn is_standard(self) -> bool {
        !matches!(self, Self::LateralSingle)
    }

    /// Returns true if the test is meaningless for a single wheel.
    pub(crate) const fn needs_two_wheels(self) -> bool {
        matches!(
            self,
            Self::Roll | Self::LateralOpposed | Self::AligningOpposed
        )
    }

    /// Returns the part of the configuration that the test requires.
    pub(crate) const fn needs(self) -> &'static str {
        match self {
            Self::Steering => "`steering.drive`",
            _ => "two wheels, or `wheels.mirror = true`",
        }
    }

    /// Returns the driven input. The variable of a roll test is half the difference of the travels, left minus right.
    pub const fn driven(self) -> Driven {
        match self {
            Self::Bounce => Driven::Height([1.0, 1.0]),
            Self::Roll => Driven::Height([1.0, -1.0]),
            Self::Steering => Driven::Steering,
            Self::Lateral => Driven::Fy([1.0, 1.0]),
            Self::LateralOpposed => Driven::Fy([-1.0, 1.0]),
            Self::LateralSingle => Driven::Fy([1.0, 0.0]),
            Self::Braking => Driven::Fx([1.0, 1.0]),
            Self::Traction => Driven::Fx([-1.0, -1.0]),
            Self::Aligning => Driven::Mz([1.0, 1.0]),
            Self::AligningOpposed => Driven::Mz([-1.0, 1.0]),
        }
    }

    /// Returns the name of the test's variable.
    pub const fn variable(self) -> &'static str {
        match self {
            Self::Bounce => "wheel travel",
            Self::Roll => "antiphase travel",
            Self::Steering => "steering input",
            Self::Lateral | Self::LateralOpposed | Self::LateralSingle => "lateral force",
            Self::Braking => "braking force",
            Self::Traction => "driving force",
            Self::Aligning | Self::AligningOpposed => "aligning torque",
        }
    }

    /// Returns the unit of the test's variable, from the units of the deck.
    pub fn unit(self, units: &Units) -> String {
        match self.driven() {
            Driven::Height(_) => Unit::Length.word(units),
            Driven::Steering => "unit of steering.drive".to_string(),
            Driven::Fx(_) | Driven::Fy(_) => Unit::Force.word(units),
            Driven::Mz(_) => Unit::Torque.word(units),
        }
    }

    /// Returns the usual settings; `length` is a millimetre and `force` a newton in units of the deck. A travel of 50 mm is usual on rigs;
    /// the other levels are customary but have no cited source.
    pub(crate) fn settings(self, length: f64, force: f64, tyre: bool) -> TestSettings {
        let (reach, window) = match self {
            Self::Bounce => (50.0 * length, 15.0 * length),
            Self::Roll => (40.0 * length, 15.0 * length),
            Self::Steering => (20.0 * length, 5.0 * length),
            Self::Lateral | Self::LateralOpposed | Self::LateralSingle => {
                (3000.0 * force, 1000.0 * force)
            }
            Self::Braking | Self::Traction => (3000.0 * force, 1000.0 * force),
            Self::Aligning | Self::AligningOpposed => (2e5 * force * length, 1e5 * force * length),
        };
        let centre = !tyre || self == Self::Traction;
        TestSettings {
            range: [-reach, reach],
            points: 13,
            window,
            point: if centre {
                LoadPoint::Centre
            } else {
                LoadPoint::Patch
            },
            hold: match self {
                Self::Bounce | Self::Roll | Self::Steering => Hold::Height,
                _ => Hold::Load,
            },
            steering_locked: true,
        }
    }
}
