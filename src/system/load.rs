use super::structure::{Action, Name};
use super::{NoValue, Parameters, Reading, Scratch, State, System};
use crate::mechanics::Vec3;
use crate::model::PartIx;

/// One force and torque on one part: an arrow of its free-body diagram.
#[derive(Clone, PartialEq, Debug)]
pub struct Load {
    /// What exerts it; `None` for the weight.
    pub by: Option<Name>,
    /// The part that feels it.
    pub part: PartIx,
    /// Where the force attacks, ground coordinates.
    pub point: Vec3,
    /// Force, ground axes.
    pub force: Vec3,
    /// Torque about `point`, ground axes.
    pub torque: Vec3,
}

impl Load {
    /// The torque about another point, ground axes.
    pub fn torque_about(&self, point: &Vec3) -> Vec3 {
        self.torque + (self.point - point).cross(&self.force)
    }
}

impl System {
    /// Every force and torque on every part, ground included; after [`System::look`]. At an equilibrium those on a part cancel.
    ///
    /// Constraint reactions come from the multipliers of the state. Elements that are switched off do nothing and are left out.
    ///
    /// # Errors
    /// [`NoValue`] if an element is undefined in this configuration.
    pub fn loads(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> Result<Vec<Load>, NoValue> {
        let mut out = self.weights(parameters, state, scratch);
        for (number, element) in self.elements.iter().enumerate() {
            if !element.active {
                continue;
            }
            let ix = super::ElementIx(number);
            let reading = self.read_element(parameters, state, scratch, ix)?;
            let p_i = scratch.markers[element.i].p;
            let on_i = Load {
                by: Some(element.name.clone()),
                part: PartIx(self.owners[element.i]),
                point: p_i,
                force: reading.force,
                torque: reading.torque,
            };
            match (&element.action, element.reaction) {
                (_, None) => {}
                // The floating marker stands where I is.
                (Action::Vector(_), Some(part)) => out.push(Load {
                    part: PartIx(part),
                    force: -reading.force,
                    torque: -reading.torque,
                    ..on_i.clone()
                }),
                (Action::Law(..), Some(_)) => out.push(self.on_j(&element.name, &reading, scratch)),
            }
            out.push(on_i);
        }
        for joint in self.joints.iter().filter(|joint| joint.active) {
            for term in 0..joint.terms.len() {
                let reading = self.read_term(joint, term, parameters, state, scratch);
                out.push(self.on_i(&joint.name, &reading, scratch));
                out.push(self.on_j(&joint.name, &reading, scratch));
            }
        }
        for (number, multi) in self.multis.iter().enumerate().filter(|(_, m)| m.active) {
            for at in 0..multi.i.len() {
                let reading = self.read_multi((number, at), parameters, state, scratch)?;
                out.push(self.on_i(&multi.name, &reading, scratch));
                out.push(self.on_j(&multi.name, &reading, scratch));
            }
        }
        self.reactions_of_conditions(state, scratch, &mut out);
        Ok(out)
    }

    fn on_i(&self, by: &Name, reading: &Reading, scratch: &Scratch) -> Load {
        Load {
            by: Some(by.clone()),
            part: PartIx(self.owners[reading.i.0]),
            point: scratch.markers[reading.i.0].p,
            force: reading.force,
            torque: reading.torque,
        }
    }

    fn on_j(&self, by: &Name, reading: &Reading, scratch: &Scratch) -> Load {
        Load {
            by: Some(by.clone()),
            part: PartIx(self.owners[reading.j.0]),
            point: scratch.markers[reading.j.0].p,
            force: reading.force_on_j,
            torque: reading.torque_on_j,
        }
    }

    fn weights(&self, parameters: &Parameters, state: &State, scratch: &Scratch) -> Vec<Load> {
        let gravity = self.gravity_vector(parameters.theta());
        let mut out = Vec::new();
        for (part, body) in self.bodies.iter().enumerate() {
            if let (Some(cm), true) = (body.cm, body.freedoms > 0) {
                out.push(Load {
                    by: None,
                    part: PartIx(part),
                    point: state.poses[part].p + scratch.arms[cm],
                    force: gravity * parameters.theta()[body.mass],
                    torque: Vec3::zeros(),
                });
            }
        }
        out
    }

    /// GCONs: minus multiplier times the gradient of the function, about the part origins.
    fn reactions_of_conditions(&self, state: &State, scratch: &Scratch, out: &mut Vec<Load>) {
        for condition in self.conditions.iter().filter(|c| c.active) {
            if state.redundant.get(condition.equation) == Some(&true) {
                continue;
            }
            let lambda = state.multipliers[condition.equation];
            let value = scratch.functions[condition.function];
            for (part, body) in self.bodies.iter().enumerate() {
                let mut on = [0.0; 6];
                for &(unknown, by) in &scratch.gradient[value.first..value.last] {
                    if (body.first..body.first + body.freedoms).contains(&unknown) {
                        on[unknown - body.first] -= lambda * by;
                    }
                }
                if on != [0.0; 6] {
                    out.push(Load {
                        by: Some(condition.name.clone()),
                        part: PartIx(part),
                        point: state.poses[part].p,
                        force: Vec3::new(on[0], on[1], on[2]),
                        torque: Vec3::new(on[3], on[4], on[5]),
                    });
                }
            }
        }
    }
}
