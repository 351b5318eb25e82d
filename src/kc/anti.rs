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
    /// Of a live axle (dependent suspension): turns of the drive shaft per turn of the wheels. An independent suspension if absent.
    pub axle_ratio: Option<f64>,
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
    pub(crate) const ALL: [Self; 4] = [
        Self::DiveBraking,
        Self::LiftAcceleration,
        Self::LiftBraking,
        Self::SquatAcceleration,
    ];

    /// Longitudinal force per wheel (+X is rearward) and vertical load transfer per wheel, per unit of the total force.
    pub(crate) fn force_and_transfer(self, v: &Vehicle) -> (f64, f64) {
        let w = v.cg_height / (2.0 * v.wheelbase);
        match self {
            Self::DiveBraking => (v.front_brake / 2.0, w),
            Self::LiftBraking => ((1.0 - v.front_brake) / 2.0, -w),
            Self::LiftAcceleration => (-v.front_drive / 2.0, -w),
            Self::SquatAcceleration => (-(1.0 - v.front_drive) / 2.0, w),
        }
    }

    /// True if the force acts at the patch. Driving forces of an independent suspension act at the wheel centre, those of a live axle,
    /// which bears the torque of its wheels, at the patch.
    pub(crate) const fn at_patch(self, v: &Vehicle) -> bool {
        self.brakes() || v.axle_ratio.is_some()
    }

    const fn brakes(self) -> bool {
        matches!(self, Self::DiveBraking | Self::LiftBraking)
    }

    /// `-100 Zf / Zw`, in percent: `Zf = F [(C31 - R0 C35) + (C37 - R0 C3,11)]` (no R0 term when an independent suspension drives),
    /// `Zw = V C33 + V' C39` with V and V' the load transfers of this wheel and the other: W, and for a live axle that drives `-t` on
    /// the left and `+t` on the right besides, `t = R0 |2 F| / axle_ratio / track` by the torque of the drive shaft.
    pub(crate) fn percent(
        self,
        c: &Compliance,
        side: Side,
        v: &Vehicle,
        (r0, track): (f64, Option<f64>),
    ) -> f64 {
        let (force, transfer) = self.force_and_transfer(v);
        let lever = if self.at_patch(v) { r0 } else { 0.0 };
        let zf = force * (c.in_phase(side, 3, 1) - lever * c.in_phase(side, 3, 5));
        let shaft = match (v.axle_ratio, self.brakes()) {
            (Some(ratio), false) => {
                let track = track.unwrap_or(f64::NAN);
                side.outboard() * r0 * (2.0 * force).abs() / ratio / track
            }
            _ => 0.0,
        };
        let zw = transfer * c.in_phase(side, 3, 3) + shaft * c.antiphase(side, 3, 3);
        -100.0 * zf / zw
    }

    /// Height change at the axle per g: `m g h / (2 L) [(1 - anti/100) / wheel rate + 1/Kt]`, the weight `m g` in force units; positive
    /// in the sense of the name, so lift is upward and negative where the formula says so.
    pub(crate) fn height_per_g(
        self,
        c: &Compliance,
        side: Side,
        v: &Vehicle,
        ((r0, tyre, weight), track): ((f64, Option<f64>, f64), Option<f64>),
    ) -> f64 {
        let anti = self.percent(c, side, v, (r0, track));
        let give = tyre.map_or(0.0, |k| 1.0 / k);
        weight * v.cg_height / (2.0 * v.wheelbase)
            * ((1.0 - anti / 100.0) / ride::wheel_rate(c, side) + give)
    }

    /// (percent, per g): the names of Adams/Car's requests.
    pub(crate) const fn names(self) -> (&'static str, &'static str) {
        match self {
            Self::DiveBraking => ("anti_dive_braking", "dive_braking"),
            Self::LiftBraking => ("anti_lift_braking", "lift_braking"),
            Self::LiftAcceleration => ("anti_lift_acceleration", "lift_acceleration"),
            Self::SquatAcceleration => ("anti_squat_acceleration", "squat_acceleration"),
        }
    }
}
