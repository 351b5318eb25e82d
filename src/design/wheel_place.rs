//! Position and angles of the wheel. They are predicted even if the study does not measure them.

use super::candidate::loaded_marker;
use admire_diagnosis::DiagnosisProblem;
use admire_identify::global::{CaseChange, CasePrediction};
use admire_solver::mechanics::Vec3;
use admire_solver::model::PartIx;

/// Wheel, fixed to its carrier part.
#[derive(Clone, PartialEq, Debug)]
pub(super) struct WheelPlace {
    /// Text that states how the wheel was defined.
    pub told: String,
    /// Carrier part.
    pub part: PartIx,
    /// Wheel centre in the frame of the carrier.
    centre: Vec3,
    /// Spin axis in the frame of the carrier.
    spin: Vec3,
}

/// Position of the wheel centre (x, y, z) in the deck's length unit, then camber and toe in degrees. Constant offsets and signs of the
/// angles are not defined.
pub(super) type Five = [f64; 5];

impl WheelPlace {
    /// Returns the wheel defined by the section `[wheel]` of the study, otherwise by `[kc]`. If both are absent, the wheel centre is the
    /// point where the loads act, and the spin axis is parallel to y of ground.
    pub(super) fn of(subject: &DiagnosisProblem<'_>) -> Option<Self> {
        let (model, measurement) = (subject.problem.model, subject.problem.measurement);
        if let Some(wheel) = &measurement.wheel {
            let marker = &model.markers[wheel.marker.0];
            let column: Vec3 = marker.R.column(wheel.spin.axis).into();
            return Some(Self {
                told: format!("MARKER/{}", marker.header.id),
                part: marker.part,
                centre: marker.qp,
                spin: column * wheel.spin.sense,
            });
        }
        // Channels of rig curves define helper markers: first the wheel centre, then a point on the spin axis.
        let helpers = measurement.channels.iter().map(|channel| &channel.helpers);
        if let Some([centre, outboard, ..]) = helpers
            .map(Vec::as_slice)
            .find(|helpers| helpers.len() == 3)
        {
            let beside = &model.markers[model.marker(centre.beside)?.0];
            return Some(Self {
                told: format!("MARKER/{}", centre.beside),
                part: beside.part,
                centre: centre.place,
                spin: outboard.place - centre.place,
            });
        }
        let marker = &model.markers[loaded_marker(subject)?.0];
        let part = &model.parts[marker.part.0];
        Some(Self {
            told: format!(
                "MARKER/{}, where the loads act, with the spin axis along y",
                marker.header.id
            ),
            part: marker.part,
            centre: marker.qp,
            spin: part.pose.R.transpose() * Vec3::y(),
        })
    }

    /// Returns the position and the angles of the wheel in a case.
    pub(super) fn place(&self, case: &CasePrediction) -> Five {
        let pose = &case.poses[self.part.0];
        let (p, s) = (pose.point(&self.centre), pose.R * self.spin);
        // The toe angle of the spin axis as a line does not depend on the sense of the axis.
        let toe = if s.y.abs() > s.x.abs() {
            -libm::atan(s.x / s.y)
        } else {
            libm::atan(s.y / s.x)
        };
        [
            p.x,
            p.y,
            p.z,
            -libm::asin(s.z).to_degrees(),
            toe.to_degrees(),
        ]
    }

    /// Returns the derivatives of position and angles with respect to an unknown. `at` is the index of the carrier among the observed parts.
    pub(super) fn change(&self, case: &CasePrediction, change: CaseChange<'_>, at: usize) -> Five {
        let pose = &case.poses[self.part.0];
        let [x, y, z, a, b, c] = change.parts[at];
        let turn = Vec3::new(a, b, c);
        let dp = Vec3::new(x, y, z) + turn.cross(&(pose.R * self.centre));
        let s = pose.R * self.spin;
        let ds = turn.cross(&s);
        let level = s.x * s.x + s.y * s.y;
        [
            dp.x,
            dp.y,
            dp.z,
            -(ds.z / level.sqrt()).to_degrees(),
            ((s.x * ds.y - s.y * ds.x) / level).to_degrees(),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use admire_identify::global::CaseChanges;
    use admire_solver::mechanics::{Pose, exp};

    #[test]
    fn changes_are_those_of_the_place() {
        let wheel = WheelPlace {
            told: String::new(),
            part: PartIx(0),
            centre: Vec3::new(20.0, -30.0, 10.0),
            spin: Vec3::new(0.03, -0.99, 0.1).normalize(),
        };
        let at = |step: f64| {
            let turn = Vec3::new(0.2, -0.1, 0.3) + Vec3::new(0.4, -0.3, 0.2) * 0.0;
            let R = exp(&(Vec3::new(0.4, -0.3, 0.2) * step)) * exp(&turn);
            CasePrediction {
                poses: vec![Pose {
                    p: Vec3::new(1.0, 2.0, 3.0) + Vec3::new(-1.0, 0.5, 2.0) * step,
                    R,
                }],
                channels: Vec::new(),
                by_unknown: CaseChanges::default(),
                free: CaseChanges::default(),
            }
        };
        let change = CaseChange {
            parts: &[[-1.0, 0.5, 2.0, 0.4, -0.3, 0.2]],
            channels: &[],
        };
        let exact = wheel.change(&at(0.0), change, 0);
        let step = 1e-5;
        let (up, down) = (wheel.place(&at(step)), wheel.place(&at(-step)));
        for k in 0..5 {
            let difference = (up[k] - down[k]) / (2.0 * step);
            assert!(
                (difference - exact[k]).abs() < 1e-7 * (1.0 + exact[k].abs()),
                "{k}"
            );
        }
    }
}
