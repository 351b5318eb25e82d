use super::{State, System};
use crate::mechanics::{Mat3, RelativeMotion, Vec3, exp};
use crate::model::PartIx;

impl System {
    /// Adds a correction of the unknowns to a state. Translations of the reference points are added; rotations act about the reference
    /// points as `R <- exp(dphi) R`.
    pub fn advance(&self, state: &mut State, correction: &[f64]) {
        for part in 0..self.bodies.len() {
            self.displace(state, PartIx(part), correction);
        }
        for (k, multiplier) in state.multipliers.iter_mut().enumerate() {
            *multiplier += correction[self.first_equation + k];
        }
        for (k, unknown) in self.implicit_variables() {
            state.variables[k] += correction[unknown];
        }
        let moving = state.moves();
        for (k, value) in state.states.iter_mut().enumerate() {
            if let Some(unknown) = self.state_unknown(k, moving) {
                *value += correction[unknown];
            }
        }
    }

    /// Applies the correction of the unknowns to the pose of one part.
    pub fn displace(&self, state: &mut State, part: PartIx, correction: &[f64]) {
        let d = &correction[self.part_unknowns(part)];
        if d.is_empty() {
            return;
        }
        let reference = self.local_reference(state, part.0);
        let pose = &mut state.poses[part.0];
        pose.p += Vec3::new(d[0], d[1], d[2]);
        if d.len() == 6 {
            let turned = orthonormal(&(exp(&Vec3::new(d[3], d[4], d[5])) * pose.R));
            pose.p += (pose.R - turned) * reference;
            pose.R = turned;
        }
    }

    /// Returns the pose change of a part due to a small change of the unknowns: translation of the part's origin, then rotation vector, in
    /// ground axes.
    pub fn pose_change(&self, state: &State, part: PartIx, dx: &[f64]) -> [f64; 6] {
        let mut change = [0.0; 6];
        let d = &dx[self.part_unknowns(part)];
        change[..d.len()].copy_from_slice(d);
        let turn = Vec3::new(change[3], change[4], change[5]);
        let by_turn = turn.cross(&-self.reference_arm(state, part.0));
        for (change, by) in change.iter_mut().zip(by_turn.iter()) {
            *change += by;
        }
        change
    }

    /// Accepts the configuration as an equilibrium: updates the reference angles for counting full turns.
    pub(crate) fn accept(
        &self,
        parameters: &super::Parameters,
        state: &mut State,
        scratch: &mut super::Scratch,
    ) {
        self.at(parameters, state, scratch).place_markers();
        for element in &self.elements {
            Self::count_turns((element.i, element.j, element.pair), state, scratch);
        }
        for multi in &self.multis {
            for (&i, &pair) in multi.i.iter().zip(&multi.pairs) {
                Self::count_turns((i, multi.j, pair), state, scratch);
            }
        }
        self.count_measured_turns(state, scratch);
        for joint in &self.joints {
            for term in &joint.terms {
                Self::count_turns((term.i, term.j, term.pair), state, scratch);
            }
        }
    }

    fn count_turns(
        (i, j, pair): (usize, usize, usize),
        state: &mut State,
        scratch: &super::Scratch,
    ) {
        let (i, j) = (&scratch.markers[i], &scratch.markers[j]);
        state.pair_angles[pair] = RelativeMotion::between(i, j, &state.pair_angles[pair]).angles;
    }
}

/// Removes the round-off of a product of rotations by one Newton step towards the polar factor.
pub(crate) fn orthonormal(R: &Mat3) -> Mat3 {
    R * (Mat3::identity() * 1.5 - R.transpose() * R * 0.5)
}
