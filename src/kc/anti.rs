//! Anti-dive, anti-lift and anti-squat percentages, and the resulting height change of the axle. Source of every formula: guide page `kc`,
//! section "Anti effects".

use serde::{Deserialize, Serialize};

use super::{Compliance, Side, Tyre, ride};

/// Place of an axle in the vehicle.
#[derive(Clone, Copy, PartialEq, Eq, Debug, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum AxlePlace {
    /// Front axle.
    Front,
    /// Rear axle.
    Rear,
}

/// Vehicle data for the anti effects, in the units of the deck. They are not part of a deck.
#[derive(Clone, Copy, PartialEq, Debug)]
pub struct Vehicle {
    /// Wheelbase L.
    pub wheelbase: f64,
    /// Height h of the centre of mass above the road.
    pub cg_height: f64,
    /// Sprung mass m.
    pub sprung_mass: f64,
    /// Share of the braking force on the front axle, 0 to 1.
    pub front_brake: f64,
    /// Share of the driving force on the front axle, 0 to 1.
    pub front_drive: f64,
    /// Axle ratio of a live axle (dependent suspension): turns of the drive shaft per turn of the wheels. `None` means an independent
    /// suspension.
    pub axle_ratio: Option<f64>,
    /// Place of this axle in the vehicle.
    pub axle: AxlePlace,
}

/// Anti effect of one axle in one load case. Braking makes the front of the vehicle dive and its rear lift; driving lifts the front and
/// makes the rear squat.
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

impl AxlePlace {
    /// Returns `front` or `rear`.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::Rear => "rear",
        }
    }
}

impl Anti {
    /// The two load cases of an axle, braking and driving, each with the effect on this axle.
    pub(crate) const fn of_axle(place: AxlePlace) -> [Self; 2] {
        match place {
            AxlePlace::Front => [Self::DiveBraking, Self::LiftAcceleration],
            AxlePlace::Rear => [Self::LiftBraking, Self::SquatAcceleration],
        }
    }

    /// Returns the longitudinal force per wheel (+X is rearward) and the vertical load transfer per wheel, both per unit of total
    /// longitudinal force.
    pub(crate) fn force_and_transfer(self, v: &Vehicle) -> (f64, f64) {
        let w = v.cg_height / (2.0 * v.wheelbase);
        match self {
            Self::DiveBraking => (v.front_brake / 2.0, w),
            Self::LiftBraking => ((1.0 - v.front_brake) / 2.0, -w),
            Self::LiftAcceleration => (-v.front_drive / 2.0, -w),
            Self::SquatAcceleration => (-(1.0 - v.front_drive) / 2.0, w),
        }
    }

    /// Returns true if the force acts at the contact patch. Braking forces always act there. Driving forces act at the wheel centre of an
    /// independent suspension. On a live axle, which carries the drive torque of its wheels, they act at the contact patch.
    pub(crate) const fn at_patch(self, v: &Vehicle) -> bool {
        self.brakes() || v.axle_ratio.is_some()
    }

    const fn brakes(self) -> bool {
        matches!(self, Self::DiveBraking | Self::LiftBraking)
    }

    /// Computes the anti percentage `-100 Zf / Zw`: the vertical displacements of the wheel centre caused by the longitudinal force and by
    /// the load transfer.
    ///
    /// `Zf = F [(C31 - R0 C35) + (C37 - R0 C3,11)]`, where F is the force per wheel. The R0 terms are absent if the force acts at the wheel
    /// centre. `Zw = V C33 + V' C39`, where V and V' are the load transfers of this wheel and of the other wheel. Both equal the transfer W
    /// from [`Self::force_and_transfer`]. When a live axle drives, the torque of the drive shaft adds `-t` to the left and `+t` to the
    /// right wheel's load transfer, with `t = R0 |2 F| / axle_ratio / track`.
    pub(crate) fn percent(
        self,
        c: &Compliance,
        side: Side,
        v: &Vehicle,
        r0: f64,
        track: Option<f64>,
    ) -> f64 {
        let (force, transfer) = self.force_and_transfer(v);
        let lever = if self.at_patch(v) { r0 } else { 0.0 };
        let zf = force * (c.in_phase(side, 3, 1) - lever * c.in_phase(side, 3, 5));
        let shaft = match (v.axle_ratio, self.brakes()) {
            (Some(ratio), false) => {
                let track = track.unwrap_or(f64::NAN);
                side.outboard_sign() * r0 * (2.0 * force).abs() / ratio / track
            }
            _ => 0.0,
        };
        let zw = transfer * c.in_phase(side, 3, 3) + shaft * c.antiphase(side, 3, 3);
        -100.0 * zf / zw
    }

    /// Computes the height change at the axle per g: `m g h / (2 L) [(1 - anti/100) / wheel rate + 1/Kt]`, with the `weight` `m g` in force
    /// units. The value is positive in the sense of the name: a positive lift moves the body up.
    pub(crate) fn height_per_g(
        self,
        c: &Compliance,
        side: Side,
        v: &Vehicle,
        tyre: &Tyre,
        track: Option<f64>,
        weight: f64,
    ) -> f64 {
        let anti = self.percent(c, side, v, tyre.radius, track);
        let give = tyre.stiffness.map_or(0.0, |k| 1.0 / k);
        weight * v.cg_height / (2.0 * v.wheelbase)
            * ((1.0 - anti / 100.0) / ride::wheel_rate(c, side) + give)
    }

    /// Returns the names of Adams/Car's requests as two pairs (percentage, height change per g). The first pair is named for a front axle, the
    /// second for a rear axle. Adams/Car writes the values of the present axle under both pairs, whether it is a front or a rear axle.
    pub(crate) const fn names(self) -> [(&'static str, &'static str); 2] {
        if self.brakes() {
            [
                ("anti_dive_braking", "dive_braking"),
                ("anti_lift_braking", "lift_braking"),
            ]
        } else {
            [
                ("anti_lift_acceleration", "lift_acceleration"),
                ("anti_squat_acceleration", "squat_acceleration"),
            ]
        }
    }
}
