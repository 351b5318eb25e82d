//! GCONs: functions constrained to zero.

use super::NoValue;
use super::compiled_function::Source;
use super::scratch::NeighbourState;
use super::structure::{GconEquation, ParameterSource};
use super::{Configuration, Name, Scratch, State, System};
use crate::linear::Sink;
use crate::mechanics::Vec3;
use crate::model::{MarkerIx, PartIx};

/// Step for differences of gradients: relative to the model's length for translations, in radians for rotations.
const STEP: f64 = 1e-6;

impl Configuration<'_> {
    /// Returns the reaction of a GCON on the part of a marker: force, and torque about the marker's origin, in ground axes.
    /// [`Configuration::evaluate`] must have been called. The reaction is zero if the GCON is inactive or redundant.
    pub fn read_condition(&self, id: u32, marker: MarkerIx) -> (Vec3, Vec3) {
        let (system, state, scratch) = (self.system, self.state, &*self.scratch);
        let place = system.place(system.owners[marker.0]);
        let is_it = |c: &&GconEquation| c.name.id == id && !self.is_out(c);
        let Some(condition) = system.conditions.iter().find(is_it) else {
            return (Vec3::zeros(), Vec3::zeros());
        };
        let lambda = state.multipliers[condition.equation];
        // Generalised forces of a constraint: minus the multiplier times the gradient.
        let on = |first: usize, freedoms: usize| {
            let mut reaction = [0.0; 6];
            for (unknown, derivative) in constraint_gradient(system, condition, scratch) {
                if (first..first + freedoms).contains(&unknown) {
                    reaction[unknown - first] -= lambda * derivative;
                }
            }
            (
                Vec3::new(reaction[0], reaction[1], reaction[2]),
                Vec3::new(reaction[3], reaction[4], reaction[5]),
            )
        };
        if place.freedoms > 0 {
            let (force, about_part) = on(place.first, place.freedoms);
            // T_I = T_part - r x F, with r from the part's reference point to I.
            let arm = scratch.arms[marker.0];
            return (force, about_part - arm.cross(&force));
        }
        // The reaction on ground balances the reactions on all other parts, because a function of positions is invariant to a common motion
        // of all parts.
        let at = scratch.markers[marker.0].p;
        let (mut force, mut torque) = (Vec3::zeros(), Vec3::zeros());
        for (part, body) in system.bodies.iter().enumerate() {
            let (F, T) = on(body.first, body.freedoms);
            force -= F;
            torque -= T + (system.reference_point(state, PartIx(part)) - at).cross(&F);
        }
        (force, torque)
    }

    /// Returns whether a GCON is ignored: it is inactive, redundant, or a velocity constraint in statics.
    pub(super) fn is_out(&self, condition: &GconEquation) -> bool {
        let at_rest = self.system.is_nonholonomic[condition.equation] && !self.moving();
        at_rest || !self.system.is_effective(self.state, condition.equation)
    }

    /// Adds `f(q, V, t) - G V` of each nonholonomic GCON to its entry in `rates`. G is the gradient of f with respect to the velocities V.
    pub(super) fn add_nonholonomic_offset(&self, rates: &mut [f64]) {
        let (system, scratch) = (self.system, &*self.scratch);
        for condition in &system.conditions {
            if !system.is_nonholonomic[condition.equation] || self.is_out(condition) {
                continue;
            }
            let mut asked = scratch.functions[condition.function].value;
            for (column, by) in constraint_gradient(system, condition, scratch) {
                asked -= by * self.velocity_of(column);
            }
            rates[condition.equation] += asked;
        }
    }

    /// Adds the residuals of the GCONs, their gradients and their reactions to the equations.
    pub(crate) fn add_conditions<S: Sink>(
        &mut self,
        g: &mut [f64],
        sink: &mut S,
    ) -> Result<(), NoValue> {
        let (system, state) = (self.system, self.state);
        for condition in &system.conditions {
            let row = system.first_equation + condition.equation;
            let lambda = state.multipliers[condition.equation];
            let out = self.is_out(condition);
            if S::ROWS {
                sink.add(row, row, f64::from(u8::from(out)));
            }
            let value = self.scratch.functions[condition.function];
            g[row] = if out { lambda } else { value.value };
            let on = f64::from(u8::from(!out));
            for &(column, derivative) in &self.scratch.gradient[value.first..value.last] {
                sink.add(row, column, on * derivative);
            }
            for (unknown, derivative) in constraint_gradient(system, condition, self.scratch) {
                g[unknown] -= on * lambda * derivative;
                sink.add(unknown, row, -on * derivative);
            }
            if S::NEEDS_ENTRIES {
                self.add_curvature(condition, on * lambda, sink)?;
            }
        }
        Ok(())
    }

    /// Adds `-multiplier` times the derivative of a GCON's gradient to the Jacobian. The derivative is found by central differences,
    /// because programs give first derivatives only.
    fn add_curvature<S: Sink>(
        &mut self,
        condition: &GconEquation,
        lambda: f64,
        sink: &mut S,
    ) -> Result<(), NoValue> {
        let (system, state, scratch) = (self.system, self.state, &mut *self.scratch);
        let value = scratch.functions[condition.function];
        let mut beside = scratch.beside.take().unwrap_or_else(|| {
            Box::new(NeighbourState {
                state: State::empty(),
                scratch: Scratch::new(system),
                step: vec![0.0; system.unknowns],
            })
        });
        let mut result = Ok(());
        let mut columns: Vec<usize> = scratch.gradient[value.first..value.last]
            .iter()
            .map(|entry| entry.0)
            .filter(|unknown| *unknown < system.first_equation)
            .collect();
        columns.sort_unstable();
        columns.dedup();
        for column in columns {
            // The rotation unknowns of a part follow its translations.
            let turns = system
                .bodies
                .iter()
                .any(|b| b.freedoms == 6 && (b.first + 3..b.first + 6).contains(&column));
            let h = if turns { STEP } else { STEP * system.length };
            for sign in [1.0, -1.0] {
                beside.state.clone_from(state);
                beside.step.fill(0.0);
                beside.step[column] = sign * h;
                system.advance(&mut beside.state, &beside.step);
                let near = &mut *beside;
                if let Err(error) = system.evaluate(self.parameters, &near.state, &mut near.scratch)
                {
                    result = Err(error);
                    break;
                }
                for (unknown, derivative) in constraint_gradient(system, condition, &near.scratch) {
                    let change = sign * derivative / (2.0 * h);
                    sink.add(unknown, column, -lambda * change);
                }
            }
        }
        scratch.beside = Some(beside);
        result
    }
}

impl System {
    /// Returns the name of an active MOTION or GCON that reads dynamic states, if there is one.
    pub fn driven_by_states(&self) -> Option<&Name> {
        let motions = self.joints.iter().filter(|joint| joint.active);
        let motions = motions.filter_map(|joint| match joint.drive {
            ParameterSource::Function(function) => Some((&joint.name, function)),
            _ => None,
        });
        let conditions = self.conditions.iter().filter(|c| c.active);
        let conditions = conditions.map(|c| (&c.name, c.function));
        let mut all = motions.chain(conditions);
        all.find(|(_, function)| self.reads_states(*function))
            .map(|(name, _)| name)
    }

    fn reads_states(&self, function: usize) -> bool {
        self.reads().any(function, |source| {
            matches!(
                source,
                Source::State(_) | Source::StateRate(..) | Source::Output(_)
            )
        })
    }
}

/// Returns the gradient on which the multiplier of a GCON acts, as (part unknown, derivative).
///
/// For a holonomic GCON it is the gradient of the function with respect to the positions; for a nonholonomic GCON, with respect to the
/// velocities. [`Configuration::evaluate`] must have been called.
pub(super) fn constraint_gradient<'a>(
    system: &'a System,
    condition: &GconEquation,
    scratch: &'a Scratch,
) -> impl Iterator<Item = (usize, f64)> + 'a {
    let first = if system.is_nonholonomic[condition.equation] {
        system.moving_unknowns
    } else {
        0
    };
    let columns = first..first + system.first_equation;
    let value = scratch.functions[condition.function];
    let gradient = scratch.gradient[value.first..value.last].iter();
    gradient
        .filter(move |(column, _)| columns.contains(column))
        .map(move |(column, by)| (column - first, *by))
}
