//! NFORCE: wrenches on several markers that depend on the motion of all of them.

use super::chain::turn;
use super::contribution::{Cross, WrenchEnds};
use super::structure::NForce;
use super::{Configuration, NoValue};

impl Configuration<'_> {
    /// Computes the wrenches of an NFORCE at all its I markers into `scratch.multi`.
    pub(super) fn evaluate_multi(&mut self, multi: &NForce) -> Result<(), NoValue> {
        self.scratch.motions.clear();
        for (&i, &pair) in multi.i.iter().zip(&multi.pairs) {
            let motion = self.motion(i, multi.j, pair, true);
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

    /// Computes the wrench of an NFORCE at one of its I markers into `scratch.contribution`. Requires [`Self::evaluate_multi`]. An inactive
    /// NFORCE gives a zero wrench with the same sparsity pattern.
    pub(super) fn multi(&mut self, multi: &NForce, at: usize, tangent: bool) {
        let system = self.system;
        let on = f64::from(u8::from(multi.active));
        let n = multi.i.len();
        let part_j = system.owners[multi.j];
        let ends = WrenchEnds {
            i: multi.i[at],
            j: multi.j,
            pair: multi.pairs[at],
            frame: Some(multi.j),
            reaction: Some(part_j),
        };
        let damped = self.moving() && !multi.damping.is_empty();
        let mut w = self.scratch.multi.value[at];
        if damped {
            for (k, &marker) in multi.i.iter().enumerate() {
                w -= multi.damping[at * n + k] * self.relative_rates(marker, multi.j);
            }
        }
        self.init_contribution(ends, w * on);
        if !tangent {
            return;
        }
        let R = self.scratch.contribution.R;
        for (k, &marker) in multi.i.iter().enumerate() {
            let D = turn(&R, &self.scratch.multi.by_motion[at * n + k]) * on;
            let rate = damped.then(|| {
                let E = turn(&R, &(multi.damping[at * n + k] * -on));
                self.by_rate((marker, multi.j), E)
            });
            if k == at {
                self.scratch.contribution.D = Some(D);
                self.scratch.contribution.rate = rate;
                continue;
            }
            let cross = Cross {
                marker,
                place: system.place(system.owners[marker]),
                r: self.scratch.arms[marker],
                s: self.arm_to(marker, part_j),
                D,
                rate,
            };
            self.scratch.contribution.cross.push(cross);
        }
    }
}
