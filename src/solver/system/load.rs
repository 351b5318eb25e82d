use super::Name;
use super::compiled_function::Exerted;
use super::condition::constraint_gradient;
use super::forces::DerivativeRequest;
use super::structure::Action;
use super::{Configuration, NoValue, Reading};
use crate::mechanics::Vec3;
use crate::model::PartIx;

/// Force and torque on a part: an arrow of its free-body diagram.
#[derive(Clone, PartialEq, Debug)]
pub struct Load<'s> {
    /// Object that exerts the load; `None` for the weight.
    pub by: Option<&'s Name>,
    /// Part on which the load acts.
    pub part: PartIx,
    /// Point of application, ground coordinates.
    pub point: Vec3,
    /// Force, ground axes.
    pub force: Vec3,
    /// Torque about `point`, ground axes.
    pub torque: Vec3,
}

impl Load<'_> {
    /// Returns the torque about another point, ground axes.
    pub fn torque_about(&self, point: &Vec3) -> Vec3 {
        self.torque + (self.point - point).cross(&self.force)
    }
}

impl<'s> Configuration<'s> {
    /// Returns every force and torque on every part, including ground. [`Configuration::evaluate`] must have been called. At an
    /// equilibrium, the loads on each part cancel.
    ///
    /// Constraint reactions follow from the multipliers of the state. Inactive elements exert no load and are omitted.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element is undefined in this configuration.
    pub fn loads(&mut self) -> Result<Vec<Load<'s>>, NoValue> {
        let mut out = Vec::new();
        self.each_load(|load| out.push(load))?;
        Ok(out)
    }

    /// Passes every load of [`Configuration::loads`] to `show`, one after the other.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element is undefined in this configuration.
    pub(crate) fn each_load(&mut self, mut show: impl FnMut(Load<'s>)) -> Result<(), NoValue> {
        let system = self.system;
        self.weights(&mut show);
        for (number, element) in system.elements.iter().enumerate() {
            if !element.active {
                continue;
            }
            let reading = self.read(Exerted::Element(number))?;
            let on_i = self.on_i(&element.name, &reading);
            match (&element.action, element.reaction) {
                (_, None) => {}
                // The floating marker coincides with I.
                (Action::Vector(_), Some(part)) => show(Load {
                    part: PartIx(part),
                    force: -reading.force,
                    torque: -reading.torque,
                    ..on_i.clone()
                }),
                (Action::Law(..), Some(_)) => show(self.on_j(&element.name, &reading)),
            }
            show(on_i);
        }
        let joints = system.joints.iter().enumerate().filter(|(_, j)| j.active);
        let terms = joints.flat_map(|(number, joint)| {
            let terms = 0..joint.terms.len();
            terms.map(move |at| (&joint.name, Exerted::Joint(number, at)))
        });
        let multis = system.multis.iter().enumerate().filter(|(_, m)| m.active);
        let markers = multis.flat_map(|(number, multi)| {
            let markers = 0..multi.i.len();
            markers.map(move |at| (&multi.name, Exerted::Multi(number, at)))
        });
        for (name, who) in terms.chain(markers) {
            let reading = self.read(who)?;
            show(self.on_i(name, &reading));
            show(self.on_j(name, &reading));
        }
        for (number, friction) in system.frictions.iter().enumerate() {
            if friction.active && (self.moving() || friction.at_rest.is_some()) {
                self.friction(number, DerivativeRequest::Value)?;
                let reading = self.contributed();
                show(self.on_i(&friction.name, &reading));
                show(self.on_j(&friction.name, &reading));
            }
        }
        self.reactions_of_conditions(&mut show);
        Ok(())
    }

    fn on_i(&self, by: &'s Name, reading: &Reading) -> Load<'s> {
        Load {
            by: Some(by),
            part: PartIx(self.system.owners[reading.i.0]),
            point: self.scratch.markers[reading.i.0].p,
            force: reading.force,
            torque: reading.torque,
        }
    }

    fn on_j(&self, by: &'s Name, reading: &Reading) -> Load<'s> {
        Load {
            by: Some(by),
            part: PartIx(self.system.owners[reading.j.0]),
            point: self.scratch.markers[reading.j.0].p,
            force: reading.force_on_j,
            torque: reading.torque_on_j,
        }
    }

    fn weights(&self, mut show: impl FnMut(Load<'s>)) {
        let theta = self.parameters.theta();
        let gravity = self.system.gravity_vector(theta);
        for (part, body) in self.system.bodies.iter().enumerate() {
            if let (Some(cm), true) = (body.cm, body.freedoms > 0) {
                show(Load {
                    by: None,
                    part: PartIx(part),
                    point: self.scratch.markers[cm].p,
                    force: gravity * theta[body.mass],
                    torque: Vec3::zeros(),
                });
            }
        }
    }

    /// Passes the reactions of GCONs to `show`. A reaction is minus the multiplier times the gradient of the function; its torque is about
    /// the reference point of the part.
    fn reactions_of_conditions(&self, mut show: impl FnMut(Load<'s>)) {
        let (system, state, scratch) = (self.system, self.state, &*self.scratch);
        for condition in system.conditions.iter().filter(|c| !self.is_out(c)) {
            let lambda = state.multipliers[condition.equation];
            for (part, body) in system.bodies.iter().enumerate() {
                let mut on = [0.0; 6];
                for (unknown, by) in constraint_gradient(system, condition, scratch) {
                    if (body.first..body.first + body.freedoms).contains(&unknown) {
                        on[unknown - body.first] -= lambda * by;
                    }
                }
                if on != [0.0; 6] {
                    show(Load {
                        by: Some(&condition.name),
                        part: PartIx(part),
                        point: system.reference_point(state, PartIx(part)),
                        force: Vec3::new(on[0], on[1], on[2]),
                        torque: Vec3::new(on[3], on[4], on[5]),
                    });
                }
            }
        }
    }
}
