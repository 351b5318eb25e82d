use super::axle::Given;
use super::bench::{Observation, Observed, Probed, WheelChanges};
use super::inputs::Inputs;
use super::reading::{Reading, Unit};
use super::{Sense, Side};

/// Direction in which the test's variable was driven to a sample.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum Branch {
    /// Upward, to the highest value.
    Up,
    /// Downward, back to the lowest value.
    Down,
}

impl Branch {
    /// Returns `up` or `down`.
    pub(crate) const fn word(self) -> &'static str {
        match self {
            Self::Up => "up",
            Self::Down => "down",
        }
    }
}

/// One solved point of a test.
#[derive(Clone, PartialEq, Debug)]
pub struct Sample {
    /// Direction in which the variable was driven.
    pub branch: Branch,
    /// Value of the test's variable.
    pub value: f64,
    /// Inputs that the rig imposes on the axle.
    pub inputs: Inputs,
    /// Solved state of the axle.
    pub seen: Observation,
    /// All characteristics, preceded by the loads of the rig.
    pub readings: Vec<Reading>,
    /// Motion and load of the wheels per unit of each change of [`Bench::differentiate`](super::Bench::differentiate); empty without changes. The
    /// derivatives include the change of ride height, on which the loads and heights of the rig depend.
    pub changes: Vec<WheelChanges>,
    /// Values and derivatives of the probes given to [`Bench::probe`](super::Bench::probe). The derivatives include the effect of the
    /// change of ride height.
    pub probed: Probed,
}

impl Sample {
    /// Evaluates a state. The turn radius of the state, if it has one, is kept in `given` for the states that follow.
    pub(super) fn of(
        branch: Branch,
        value: f64,
        (inputs, found): (Inputs, Observed),
        given: &mut Given,
    ) -> Self {
        let seen = found.seen;
        use Sense::{AboutZ, Own};
        let mut readings = Vec::new();
        for side in Side::BOTH {
            let k = side.index();
            if seen.axle.wheels[k].is_none() {
                continue;
            }
            let [fx, fy, _, mz] = inputs.loads[k];
            let mut push = |entity, [left, right]: [&'static str; 2], unit, sense, value| {
                readings.push(Reading {
                    entity,
                    component: if side == Side::Left { left } else { right },
                    unit,
                    sense,
                    value,
                });
            };
            // Signs of Adams/Car: lateral to the left of the vehicle, braking rearward, driving forward.
            let long = "wheel_load_longitudinal";
            let (braking, driving) = if inputs.plane_at_patch {
                (fx, 0.0)
            } else {
                (0.0, -fx)
            };
            push(
                long,
                ["braking_left", "braking_right"],
                Unit::Force,
                Own,
                braking,
            );
            push(
                long,
                ["driving_left", "driving_right"],
                Unit::Force,
                Own,
                driving,
            );
            push(
                "wheel_load_lateral",
                ["lateral_left", "lateral_right"],
                Unit::Force,
                Own,
                -fy,
            );
            let name = ["vertical_left_force", "vertical_right_force"];
            push(
                "wheel_load_vertical_force",
                name,
                Unit::Force,
                Own,
                seen.load[k],
            );
            let name = ["algn_torque_left", "algn_torque_right"];
            push("wheel_load_align", name, Unit::Torque, AboutZ, mz);
        }
        readings.extend(seen.axle.readings(given));
        let turn = seen.axle.steering(given);
        given.last_turn_radius = turn
            .and_then(|turn| turn.turn_radius())
            .or(given.last_turn_radius);
        Self {
            branch,
            value,
            inputs,
            seen,
            readings,
            changes: found.changes,
            probed: found.probed,
        }
    }
}
