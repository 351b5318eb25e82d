//! GCONs: functions as constraints.

use super::assemble::NoValue;
use super::chain::Sink;
use super::scratch::Beside;
use super::structure::Condition;
use super::{Parameters, Scratch, State, System};
use crate::mechanics::Vec3;
use crate::model::MarkerIx;

/// Steps of the differences of gradients: lengths by the model's length, angles in radians.
const STEP: f64 = 1e-6;

impl System {
    /// The reaction of a GCON on the part of a marker: force, and torque about the marker's origin, ground axes; after
    /// [`System::look`]. Zero if it is switched off or redundant.
    pub fn read_condition(
        &self,
        id: u32,
        marker: MarkerIx,
        state: &State,
        scratch: &Scratch,
    ) -> (Vec3, Vec3) {
        let part = self.owners[marker.0];
        let place = self.place(part);
        let mut reaction = [0.0; 6];
        let is_it = |c: &&Condition| {
            c.name.id == id && c.active && state.redundant.get(c.equation) != Some(&true)
        };
        if let Some(condition) = self.conditions.iter().find(is_it) {
            let lambda = state.multipliers[condition.equation];
            let value = scratch.functions[condition.function];
            for &(unknown, derivative) in &scratch.gradient[value.first..value.last] {
                if (place.first..place.first + place.freedoms).contains(&unknown) {
                    // Generalised forces of a constraint: minus multiplier times gradient.
                    reaction[unknown - place.first] -= lambda * derivative;
                }
            }
        }
        let force = Vec3::new(reaction[0], reaction[1], reaction[2]);
        let about_part = Vec3::new(reaction[3], reaction[4], reaction[5]);
        // T_I = T_part - r x F, with r from the part's origin to I.
        let arm = scratch.arms[marker.0];
        (force, about_part - arm.cross(&force))
    }

    /// Adds residuals, gradients and reactions of the GCONs.
    pub(crate) fn add_conditions<S: Sink>(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        g: &mut [f64],
        sink: &mut S,
    ) -> Result<(), NoValue> {
        for condition in &self.conditions {
            let row = self.first_equation + condition.equation;
            let lambda = state.multipliers[condition.equation];
            let out = !condition.active || state.redundant.get(condition.equation) == Some(&true);
            sink.add(row, row, f64::from(u8::from(out)));
            let value = scratch.functions[condition.function];
            g[row] = if out { lambda } else { value.value };
            let on = f64::from(u8::from(!out));
            for at in value.first..value.last {
                let (unknown, derivative) = scratch.gradient[at];
                sink.add(row, unknown, on * derivative);
                if unknown < self.first_equation {
                    g[unknown] -= on * lambda * derivative;
                    sink.add(unknown, row, -on * derivative);
                }
            }
            if S::WANTED {
                self.add_curvature(condition, on * lambda, parameters, state, scratch, sink)?;
            }
        }
        Ok(())
    }

    /// `-multiplier` times the derivative of the gradient, by central differences: programs have first derivatives only.
    fn add_curvature<S: Sink>(
        &self,
        condition: &Condition,
        lambda: f64,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        sink: &mut S,
    ) -> Result<(), NoValue> {
        let value = scratch.functions[condition.function];
        let mut beside = scratch.beside.take().unwrap_or_else(|| {
            Box::new(Beside {
                state: State::empty(),
                scratch: Scratch::new(self),
                step: vec![0.0; self.unknowns],
            })
        });
        let mut result = Ok(());
        let mut columns: Vec<usize> = scratch.gradient[value.first..value.last]
            .iter()
            .map(|entry| entry.0)
            .filter(|unknown| *unknown < self.first_equation)
            .collect();
        columns.sort_unstable();
        columns.dedup();
        for column in columns {
            // Rotations of a part follow its translations.
            let turns = self
                .bodies
                .iter()
                .any(|b| b.freedoms == 6 && (b.first + 3..b.first + 6).contains(&column));
            let h = if turns { STEP } else { STEP * self.length };
            for sign in [1.0, -1.0] {
                beside.state.clone_from(state);
                beside.step.fill(0.0);
                beside.step[column] = sign * h;
                self.advance(&mut beside.state, &beside.step);
                let near = &mut *beside;
                self.place_markers(parameters, &near.state, &mut near.scratch);
                if let Err(error) =
                    self.evaluate_functions(parameters, &near.state, &mut near.scratch)
                {
                    result = Err(error);
                    break;
                }
                let moved = near.scratch.functions[condition.function];
                for &(unknown, derivative) in &near.scratch.gradient[moved.first..moved.last] {
                    if unknown < self.first_equation {
                        let change = sign * derivative / (2.0 * h);
                        sink.add(unknown, column, -lambda * change);
                    }
                }
            }
        }
        scratch.beside = Some(beside);
        result
    }
}
