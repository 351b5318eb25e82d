//! `dry-friction`: rate-independent hysteresis, so that the answer depends on the order of the loads.
//!
//! Elasto-slip: a spring of length `F / k` slips when it is stretched further. The state before the first case is unknown.

use crate::model::{JointKind, MarkerIx};

use super::super::cause::Cause;
use super::super::survey::Survey;

use super::{Change, Column, Hypothesis, Number, Unknown, number};

/// Newtons of friction that are nothing unusual.
const SD: f64 = 300.0;
/// Slip lengths, in units of the range of the displacement, and the state before the first case as a part of the force.
const FORMS: [(f64, f64, &str); 9] = [
    (0.01, 0.0, "short, from rest"),
    (0.01, 1.0, "short, from above"),
    (0.01, -1.0, "short, from below"),
    (0.08, 0.0, "middle, from rest"),
    (0.08, 1.0, "middle, from above"),
    (0.08, -1.0, "middle, from below"),
    (0.3, 0.0, "long, from rest"),
    (0.3, 1.0, "long, from above"),
    (0.3, -1.0, "long, from below"),
];

/// A contact that slips along one component of a pair of markers.
#[derive(Clone, PartialEq, Debug)]
pub struct Slip {
    /// I and J.
    pub pair: (MarkerIx, MarkerIx),
    /// 0 to 5, axes of J.
    pub axis: usize,
    /// Displacement from rest to slip.
    pub length: f64,
    /// Force before the first case as a part of the force of slipping.
    pub start: f64,
    /// The number that carries the force in each case; it acts on I along the axis, times this factor.
    pub force: (crate::syntax::Address, f64),
}

impl Slip {
    /// The force of each case as a part of the force of slipping, against the displacement.
    pub fn pattern(&self, u: &[f64]) -> Vec<f64> {
        let mut anchor: Option<f64> = None;
        u.iter()
            .map(|&u| {
                let at = anchor.unwrap_or(-self.start * self.length);
                let stretch = ((u - at) / self.length).clamp(-1.0, 1.0);
                anchor = Some(u - stretch * self.length);
                -stretch
            })
            .collect()
    }
}

/// Every component of every bushing, and the free motions of joints.
pub fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    for (k, bushing) in survey.model.bushings.iter().enumerate() {
        if !bushing.header.active {
            continue;
        }
        let deflections = survey.bushing_deflections(k);
        for axis in 0..6 {
            let u: Vec<f64> = deflections.iter().map(|d| d[axis]).collect();
            let word = if axis < 3 { "FORCE" } else { "TORQUE" };
            let id = bushing.header.id;
            let slot = number("BUSHING", id, word, Some(axis % 3 + 1));
            let address = format!("BUSHING/{id}.{}", super::component(axis));
            // A bushing's preload acts against the I marker: F = -K u + FORCE.
            put(
                survey,
                address,
                ((bushing.i, bushing.j), axis),
                &u,
                (slot, 1.0),
                &[],
                out,
            );
        }
    }
    for joint in survey.model.joints.iter().filter(|j| j.header.active) {
        let axes: &[usize] = match joint.kind {
            JointKind::Translational => &[2],
            JointKind::Cylindrical => &[2, 5],
            JointKind::Revolute => &[5],
            _ => continue,
        };
        let readings = survey.constraint("JOINT", joint.header.id);
        for &axis in axes {
            let u: Vec<f64> = readings
                .iter()
                .map(|r| {
                    if axis < 3 {
                        r.motion.p_ij_j[axis]
                    } else {
                        r.motion.angles[axis - 3]
                    }
                })
                .collect();
            let (id, added) = survey.vector_force((joint.i, joint.j), axis, "0.0");
            let slot = number("GFORCE", id, super::FORCES[axis], Some(1));
            let changes: Vec<Change> = added.into_iter().map(Change::Add).collect();
            let address = format!("JOINT/{}", joint.header.id);
            put(
                survey,
                address,
                ((joint.i, joint.j), axis),
                &u,
                (slot, 1.0),
                &changes,
                out,
            );
        }
    }
}

fn put(
    survey: &Survey<'_>,
    address: String,
    (pair, axis): ((MarkerIx, MarkerIx), usize),
    u: &[f64],
    force: (crate::syntax::Address, f64),
    changes: &[Change],
    out: &mut Vec<Hypothesis>,
) {
    let (low, high) = u.iter().fold((0.0_f64, 0.0_f64), |(low, high), u| {
        (low.min(*u), high.max(*u))
    });
    let range = high - low;
    if range < 1e-9 {
        return;
    }
    let lever = if axis < 3 {
        1.0
    } else {
        100.0 * survey.millimetre()
    };
    for (share, start, form) in FORMS {
        let slip = Slip {
            pair,
            axis,
            length: share * range,
            start,
            force: force.clone(),
        };
        let wrench = slip
            .pattern(u)
            .into_iter()
            .map(|p| crate::mechanics::Vec6::ith(axis, p))
            .collect();
        out.push(Hypothesis {
            cause: Cause::DryFriction,
            address: address.clone(),
            form,
            numbers: vec![Number {
                name: "force".to_string(),
                sd: SD * survey.newton() * lever,
                column: Column::Wrench(pair, wrench),
                unknown: Unknown::Slip(slip),
            }],
            one_sided: true,
            changes: changes.to_vec(),
        });
    }
}
