//! Anti-dive, anti-lift, anti-squat and the pitch they leave. Source of every formula: guide page `kc`, section "Anti effects".

use serde::{Deserialize, Serialize};

use super::{Compliance, Side, ride};

/// What the anti effects need to know of the vehicle, in the units of the deck. None of it is in the deck.
#[derive(Clone, Copy, PartialEq, Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Vehicle {
    /// Distance of the axles L.
    pub wheelbase: f64,
    /// Height of the centre of mass h over the road.
    pub cg_height: f64,
    /// Sprung mass m.
    pub sprung_mass: f64,
    /// Part of the braking force on the front axle.
    pub front_brake: f64,
    /// Part of the driving force on the front axle.
    pub front_drive: f64,
}

/// The four cases.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Anti {
    /// Front axle, braking.
    DiveBraking,
    /// Rear axle, braking.
    LiftBraking,
    /// Front axle, driving.
    LiftAcceleration,
    /// Rear axle, driving.
    SquatAcceleration,
}

impl Anti {
    /// All of them. Adams/Car writes all for any axle: those of the other axle are formulas only.
    pub const ALL: [Self; 4] = [
        Self::DiveBraking,
        Self::LiftAcceleration,
        Self::LiftBraking,
        Self::SquatAcceleration,
    ];

    /// Longitudinal force per wheel (+X is rearward) and vertical load transfer per wheel, per unit of the total force.
    pub fn force_and_transfer(self, v: &Vehicle) -> (f64, f64) {
        let w = v.cg_height / (2.0 * v.wheelbase);
        match self {
            Self::DiveBraking => (v.front_brake / 2.0, w),
            Self::LiftBraking => ((1.0 - v.front_brake) / 2.0, -w),
            Self::LiftAcceleration => (-v.front_drive / 2.0, -w),
            Self::SquatAcceleration => (-(1.0 - v.front_drive) / 2.0, w),
        }
    }

    /// True if the force acts at the patch; driving forces of an independent axle act at the wheel centre.
    pub const fn at_patch(self) -> bool {
        matches!(self, Self::DiveBraking | Self::LiftBraking)
    }

    /// `-100 Zf / Zw`, in percent: `Zf = F [(C31 - R0 C35) + (C37 - R0 C3,11)]` (no R0 term when driving), `Zw = W (C33 + C39)`.
    pub fn percent(self, c: &Compliance, side: Side, v: &Vehicle, r0: f64) -> f64 {
        let (force, transfer) = self.force_and_transfer(v);
        let lever = if self.at_patch() { r0 } else { 0.0 };
        let zf = force * (c.in_phase(side, 3, 1) - lever * c.in_phase(side, 3, 5));
        let zw = transfer * c.in_phase(side, 3, 3);
        -100.0 * zf / zw
    }

    /// Height change at the axle per g: `m g h / (2 L) [(1 - anti/100) / wheel rate + 1/Kt]`, the weight `m g` in force units; positive
    /// in the sense of the name, so lift is upward and negative where the formula says so.
    pub fn height_per_g(
        self,
        c: &Compliance,
        side: Side,
        v: &Vehicle,
        (r0, tyre, weight): (f64, Option<f64>, f64),
    ) -> f64 {
        let anti = self.percent(c, side, v, r0);
        let give = tyre.map_or(0.0, |k| 1.0 / k);
        weight * v.cg_height / (2.0 * v.wheelbase)
            * ((1.0 - anti / 100.0) / ride::wheel_rate(c, side) + give)
    }

    /// The kinematic anti angle: `atan(-Zf / F / C33)`, the slope of the line to the instant centre in the side view.
    pub fn angle(self, c: &Compliance, side: Side, r0: f64) -> f64 {
        let lever = if self.at_patch() { r0 } else { 0.0 };
        let zf = c.of((side, 3), (side, 1)) - lever * c.of((side, 3), (side, 5));
        libm::atan(-zf / c.of((side, 3), (side, 3)))
    }

    /// (percent, per g): the names of Adams/Car's requests.
    pub const fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::DiveBraking => ("anti_dive_braking", "dive_braking"),
            Self::LiftBraking => ("anti_lift_braking", "lift_braking"),
            Self::LiftAcceleration => ("anti_lift_acceleration", "lift_acceleration"),
            Self::SquatAcceleration => ("anti_squat_acceleration", "squat_acceleration"),
        }
    }
}
