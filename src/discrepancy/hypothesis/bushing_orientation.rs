//! `bushing-orientation`: the bushing is mounted turned about an axis.
//!
//! Both markers turn together, so nothing is preloaded: to first order the stiffness matrix changes by `w x K - K x w`.

use crate::mechanics::{Mat3, Vec3, Vec6, skew};

use super::super::cause::Cause;
use super::super::survey::Survey;

use super::{Column, Hypothesis, Number, SIX, Turn, Unknown};

/// Radians a bushing may well be turned.
pub const SD: f64 = 0.3;

/// Every axis of every bushing.
pub fn hypotheses(survey: &Survey<'_>, out: &mut Vec<Hypothesis>) {
    for (k, bushing) in survey.model.bushings.iter().enumerate() {
        if !bushing.header.active || !survey.can_turn(bushing.i) || !survey.can_turn(bushing.j) {
            continue;
        }
        let deflections = survey.bushing_deflections(k);
        let stiffness = survey.stiffnesses(k);
        let block = |first: usize| {
            Mat3::from_diagonal(&Vec3::new(
                stiffness[first],
                stiffness[first + 1],
                stiffness[first + 2],
            ))
        };
        for axis in 0..3 {
            let turn = skew(&Vec3::ith(axis, 1.0));
            let change = |first: usize| turn * block(first) - block(first) * turn;
            let (by_shift, by_turn) = (change(0), change(3));
            let wrench = deflections
                .iter()
                .map(|u| {
                    let F = -by_shift * Vec3::new(u[0], u[1], u[2]);
                    let T = -by_turn * Vec3::new(u[3], u[4], u[5]);
                    Vec6::new(F.x, F.y, F.z, T.x, T.y, T.z)
                })
                .collect();
            let with_id = |marker| (marker, survey.marker_id(marker));
            out.push(Hypothesis::plain(
                Cause::BushingOrientation,
                format!("BUSHING/{}", bushing.header.id),
                SIX[axis],
                vec![Number {
                    column: Column::Wrench((bushing.i, bushing.j), wrench),
                    ..Number::new(
                        format!("angle_{}", SIX[axis]),
                        SD,
                        Unknown::Turn(Turn {
                            markers: [with_id(bushing.i), with_id(bushing.j)],
                            axis,
                        }),
                    )
                }],
            ));
        }
    }
}
