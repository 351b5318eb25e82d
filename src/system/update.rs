use super::{State, System};
use crate::mechanics::{Mat3, RelativeMotion, Vec3, exp};

impl System {
    /// Moves a state along a correction of the unknowns: translations add, `R <- exp(dphi) R`.
    pub fn advance(&self, state: &mut State, correction: &[f64]) {
        for (body, pose) in self.bodies.iter().zip(&mut state.poses) {
            if body.freedoms == 0 {
                continue;
            }
            let d = &correction[body.first..body.first + body.freedoms];
            pose.p += Vec3::new(d[0], d[1], d[2]);
            if body.freedoms == 6 {
                pose.R = orthonormal(&(exp(&Vec3::new(d[3], d[4], d[5])) * pose.R));
            }
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

    /// Takes the configuration as an equilibrium: turns are counted from here on.
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

/// Takes away the round-off of a product of rotations: one Newton step towards the polar factor.
pub(crate) fn orthonormal(R: &Mat3) -> Mat3 {
    R * (Mat3::identity() * 1.5 - R.transpose() * R * 0.5)
}
