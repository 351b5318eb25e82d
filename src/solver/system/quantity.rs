//! Quantities that are read from an equilibrium, with their derivatives with respect to the unknowns and to theta.

use super::NoValue;
use super::catalogue::Role;
use super::compiled_function::Exerted;
use super::structure::{Action, ParameterSource};
use super::{Configuration, ConstraintIx, ElementIx, Slot, System};
use crate::mechanics::{Vec3, Vec6};
use crate::model::{MarkerIx, PartIx};

/// Relative step of differences with respect to theta at fixed unknowns. The differences are of fourth order, so only a round-off of 1e-12
/// remains.
const STEP: f64 = 1e-4;

/// Scalar quantity read from an equilibrium. The last index of a vector quantity is its component, in ground axes. Components 0 to 2 are x,
/// y, z of the first vector, and components 3 to 5 are x, y, z of the second vector.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Quantity {
    /// Motion of a part: displacement of its origin, then rotation vector.
    Motion(PartIx, usize),
    /// Force element: force on I, then torque about the I origin.
    Element(ElementIx, usize),
    /// Constraint: reaction force on I, then torque about the I origin. For COUPLER and GEAR, the reaction at the first joint.
    Constraint(ConstraintIx, usize),
    /// Function of a REQUEST: index of the request in the model, then component 0 to 7 for F1 to F8.
    Request(usize, usize),
}

impl Configuration<'_> {
    /// Returns the value of a quantity. The value of `Motion` is zero, because it is the change from the present configuration.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element is undefined in this configuration.
    pub fn quantity(&mut self, quantity: Quantity) -> Result<f64, NoValue> {
        match quantity {
            Quantity::Motion(..) => Ok(0.0),
            Quantity::Element(ElementIx(k), component) => {
                let who = Exerted::Element(k);
                Ok(self.exerted(who, false)?[component])
            }
            Quantity::Constraint(ConstraintIx(k), component) => {
                let mut sum = 0.0;
                for at in 0..self.system.joints[k].at_first() {
                    sum += self.exerted(Exerted::Joint(k, at), false)?[component];
                }
                Ok(sum)
            }
            Quantity::Request(index, component) => Ok(self
                .read_function(index, component)?
                .map_or(0.0, |(value, _)| value)),
        }
    }

    /// Adds the gradient of a quantity with respect to the unknowns to `out`.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element is undefined in this configuration.
    pub fn quantity_by_unknowns(
        &mut self,
        quantity: Quantity,
        out: &mut [f64],
    ) -> Result<(), NoValue> {
        let before = self.scratch.gradient.len();
        let weight = |component| Vec6::ith(component, 1.0);
        match quantity {
            Quantity::Motion(part, component) => {
                let unknowns = self.system.part_unknowns(part);
                if let Some(unknown) = unknowns.clone().nth(component) {
                    out[unknown] += 1.0;
                }
                if component < 3 && unknowns.len() == 6 {
                    // For the displacement of the origin: e . (dphi x -r) = dphi . (-r x e).
                    let arm = -self.system.reference_arm(self.state, part.0);
                    let by_turn = arm.cross(&Vec3::ith(component, 1.0));
                    for (k, by) in by_turn.iter().enumerate() {
                        out[unknowns.start + 3 + k] += by;
                    }
                }
                return Ok(());
            }
            Quantity::Element(ElementIx(k), component) => {
                self.push_force(Exerted::Element(k), false, &weight(component))?;
            }
            Quantity::Constraint(ConstraintIx(k), component) => {
                for at in 0..self.system.joints[k].at_first() {
                    self.push_force(Exerted::Joint(k, at), false, &weight(component))?;
                }
            }
            Quantity::Request(index, component) => {
                let read = self.read_function(index, component)?;
                for &(unknown, by) in read.map_or(&[][..], |(_, gradient)| gradient) {
                    out[unknown] += by;
                }
                return Ok(());
            }
        }
        for &(unknown, by) in &self.scratch.gradient[before..] {
            out[unknown] += by;
        }
        Ok(())
    }

    /// Returns the derivative of a quantity with respect to one parameter at constant unknowns.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element is undefined in this configuration.
    pub(crate) fn quantity_by_slot(
        &mut self,
        quantity: Quantity,
        slot: Slot,
    ) -> Result<f64, NoValue> {
        let along = self.quantities_along(&[quantity], (&[(slot, 1.0)], &[]))?;
        Ok(along[0])
    }

    /// Returns the derivatives of quantities along a change of the parameters at constant unknowns. `slots` are parameters with their changes
    /// per unit. `turns` are markers with their rotation vectors per unit, in radians and in the axes of the marker.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element is undefined in this configuration.
    pub fn quantities_along(
        &mut self,
        quantities: &[Quantity],
        (slots, turns): (&[(Slot, f64)], &[(MarkerIx, Vec3)]),
    ) -> Result<Vec<f64>, NoValue> {
        let (system, state) = (self.system, self.state);
        let touches = |role: Role| quantities.iter().any(|own| system.may_touch(*own, role));
        let slots: Vec<(Slot, f64)> = slots
            .iter()
            .filter(|(slot, rate)| *rate != 0.0 && touches(system.catalogue().group(*slot).role))
            .copied()
            .collect();
        let turns: Vec<(MarkerIx, Vec3)> = turns
            .iter()
            .filter(|(marker, turn)| turn.norm() > 0.0 && touches(Role::Marker(marker.0)))
            .copied()
            .collect();
        // No parameter moves by more than its own step.
        let mut step = f64::INFINITY;
        let mut from = Vec::with_capacity(slots.len());
        for (slot, rate) in &slots {
            let here = self.number(*slot)?;
            step = step.min(STEP * here.abs().max(1.0) / rate.abs());
            from.push(here);
        }
        for (_, turn) in &turns {
            step = step.min(STEP / turn.norm());
        }
        if step.is_infinite() {
            return Ok(vec![0.0; quantities.len()]);
        }
        let parameters = self.parameters;
        let scratch = &mut *self.scratch;
        let mut at = |h: f64| -> Result<Vec<f64>, NoValue> {
            let mut moved = parameters.clone();
            for ((slot, rate), from) in slots.iter().zip(&from) {
                moved.set(*slot, from + h * rate);
            }
            for (marker, turn) in &turns {
                moved.turn(*marker, turn, h);
            }
            let mut there = system.evaluate(&moved, state, scratch)?;
            let each = quantities.iter();
            each.map(|quantity| there.quantity(*quantity)).collect()
        };
        let mut difference = |h: f64| -> Result<Vec<f64>, NoValue> {
            let (plus, minus) = (at(h)?, at(-h)?);
            let pairs = plus.iter().zip(&minus);
            Ok(pairs
                .map(|(plus, minus)| (plus - minus) / (2.0 * h))
                .collect())
        };
        let (coarse, fine) = (difference(step)?, difference(0.5 * step)?);
        self.evaluate()?;
        let pairs = coarse.iter().zip(&fine);
        Ok(pairs
            .map(|(coarse, fine)| (4.0 * fine - coarse) / 3.0)
            .collect())
    }
}

impl System {
    /// Returns false if a parameter can change a quantity only through the unknowns.
    fn may_touch(&self, quantity: Quantity, role: Role) -> bool {
        match quantity {
            Quantity::Motion(..) => false,
            Quantity::Element(ElementIx(k), _) => {
                let element = &self.elements[k];
                match (&element.action, role) {
                    (Action::Law(_, ParameterSource::Theta(_)), Role::Law { element }) => {
                        element == k
                    }
                    (Action::Law(_, ParameterSource::Theta(_)), Role::Marker(_)) => {
                        self.moves_marker(role, element.i) || self.moves_marker(role, element.j)
                    }
                    (Action::Law(law, ParameterSource::Theta(_)), Role::Spline(spline)) => {
                        law.reads_spline(self.parameters.curves(), spline)
                    }
                    (Action::Law(_, ParameterSource::Theta(_)), _) => false,
                    (_, role) => !matches!(role, Role::Mass(_) | Role::Gravity),
                }
            }
            Quantity::Constraint(ConstraintIx(k), _) => match role {
                Role::Joint { joint } => joint == k,
                Role::Marker(_) => {
                    let moves = |marker: usize| self.moves_marker(role, marker);
                    let first = self.joints[k].terms.first();
                    first.is_some_and(|t| moves(t.i) || moves(t.j))
                }
                _ => false,
            },
            Quantity::Request(..) => !matches!(role, Role::Mass(_) | Role::Gravity),
        }
    }
}
