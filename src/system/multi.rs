//! NFORCE: wrenches on several markers that depend on the motion of all of them.

use super::Configuration;
use super::assemble::NoValue;
use super::chain::turn;
use super::contribution::{Cross, Ends};
use super::structure::Name;
use crate::element::MultiPoint;

/// A force between n markers and one.
#[derive(Debug)]
pub(crate) struct Multi {
    pub name: Name,
    pub i: Vec<usize>,
    pub j: usize,
    pub theta: std::ops::Range<usize>,
    /// Angle references, one per I marker.
    pub pairs: Vec<usize>,
    pub active: bool,
}

impl Multi {
    pub(super) fn law(&self) -> MultiPoint {
        MultiPoint {
            markers: self.i.len(),
        }
    }
}

impl Configuration<'_> {
    /// All wrenches of an NFORCE, into `scratch.multi`.
    pub(super) fn evaluate_multi(&mut self, multi: &Multi) -> Result<(), NoValue> {
        self.scratch.motions.clear();
        for (&i, &pair) in multi.i.iter().zip(&multi.pairs) {
            let motion = self.motion((i, multi.j, pair), true);
            self.scratch.motions.push(motion);
        }
        let theta = &self.parameters.theta()[multi.theta.clone()];
        let scratch = &mut *self.scratch;
        multi
            .law()
            .evaluate(&scratch.motions, theta, &mut scratch.multi)
            .map_err(|reason| NoValue {
                element: multi.name.clone(),
                reason: reason.into(),
            })
    }

    /// The wrench of an NFORCE at one of its markers, into `scratch.contribution`, after [`Self::evaluate_multi`]; zero, with the same
    /// pattern, if it is deactivated.
    pub(super) fn multi(&mut self, multi: &Multi, at: usize, tangent: bool) {
        let system = self.system;
        let on = f64::from(u8::from(multi.active));
        let n = multi.i.len();
        let part_j = system.owners[multi.j];
        let ends = Ends {
            i: multi.i[at],
            j: multi.j,
            pair: multi.pairs[at],
            frame: Some(multi.j),
            reaction: Some(part_j),
        };
        self.begin(ends, self.scratch.multi.value[at] * on);
        if !tangent {
            return;
        }
        let R = self.scratch.contribution.R;
        for (k, &marker) in multi.i.iter().enumerate() {
            let D = turn(&R, &self.scratch.multi.by_motion[at * n + k]) * on;
            if k == at {
                self.scratch.contribution.D = Some(D);
                continue;
            }
            let cross = Cross {
                marker,
                place: system.place(system.owners[marker]),
                r: self.scratch.arms[marker],
                s: self.arm_to(marker, part_j),
                D,
            };
            self.scratch.contribution.cross.push(cross);
        }
    }
}
