//! Compliances to forces in the road plane and to aligning torques, for equal ("parallel") and opposite ("opposed") loads on the two
//! wheels.
//!
//! Forces act at the contact patch, `R0` below the wheel centre along Z, where R0 is the **unloaded** radius as in Adams/Car. Rotations
//! about +Z are positive to the left. Source of every formula: guide page `kc`, section "Forces".

use super::{Compliance, Side};

/// Load pattern of the two wheels.
#[derive(Clone, Copy, PartialEq, Eq, Default, Debug, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum Pairing {
    /// The same load on both wheels.
    #[default]
    Parallel,
    /// Opposite loads.
    Opposed,
}

impl Pairing {
    fn c(self, c: &Compliance, side: Side, i: usize, j: usize) -> f64 {
        match self {
            Self::Parallel => c.in_phase(side, i, j),
            Self::Opposed => c.antiphase(side, i, j),
        }
    }
}

/// Returns displacement `i` of the wheel centre per lateral force +Y at the patch: `Ci2 + R0 Ci4`.
fn lateral(c: &Compliance, side: Side, i: usize, r0: f64, pairing: Pairing) -> f64 {
    pairing.c(c, side, i, 2) + r0 * pairing.c(c, side, i, 4)
}

/// Returns the lateral displacement of the wheel centre per lateral force.
pub(crate) fn lateral_deflection(c: &Compliance, side: Side, r0: f64, pairing: Pairing) -> f64 {
    lateral(c, side, 2, r0, pairing)
}

/// Returns steer per lateral force, positive to the left.
pub(crate) fn lateral_steer(c: &Compliance, side: Side, r0: f64, pairing: Pairing) -> f64 {
    lateral(c, side, 6, r0, pairing)
}

/// Returns camber per lateral force, positive with the top outboard.
pub(crate) fn lateral_camber(c: &Compliance, side: Side, r0: f64, pairing: Pairing) -> f64 {
    -side.outboard_sign() * lateral(c, side, 4, r0, pairing)
}

/// Returns steer per aligning torque, both positive to the left: `C66 + C6,12` for parallel loads.
pub(crate) fn aligning_steer(c: &Compliance, side: Side, pairing: Pairing) -> f64 {
    pairing.c(c, side, 6, 6)
}

/// Returns camber per aligning torque. For parallel loads it is `C46 + C4,12` on the left and `-(C10,6 + C10,12)` on the right. Adams'
/// documentation prints the right formula without the brackets, presumably a misprint: `-C(10,6) + C(10,12)`.
pub(crate) fn aligning_camber(c: &Compliance, side: Side, pairing: Pairing) -> f64 {
    -side.outboard_sign() * pairing.c(c, side, 4, 6)
}

/// Returns the longitudinal force per recession of the wheel centre: `1 / (C11 + C17)` for parallel loads.
pub(crate) fn fore_aft_stiffness(c: &Compliance, side: Side, pairing: Pairing) -> f64 {
    1.0 / pairing.c(c, side, 1, 1)
}

/// Returns displacement `i` per longitudinal force +X: `Ci1 - R0 Ci5`. `i` is 6 for steer to the left and 5 for caster. The force acts at
/// the patch, or at the wheel centre if `r0` is zero.
pub(crate) fn longitudinal(c: &Compliance, side: Side, i: usize, r0: f64, pairing: Pairing) -> f64 {
    pairing.c(c, side, i, 1) - r0 * pairing.c(c, side, i, 5)
}
