use super::newton::Unknowns;
use crate::mechanics::{Vec3, exceeds};
use crate::system::{PartRates, State, System};

/// Scales of relative errors: for each kind of unknown, the largest value so far.
#[derive(Clone, Copy, Debug)]
pub(super) struct ErrorScales {
    pub position: f64,
    velocity: f64,
    spin: f64,
    state: f64,
    variable: f64,
    multiplier: f64,
}

/// Largest component of an error or a correction.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub(super) struct LargestComponent {
    /// Magnitude of the component, as a multiple of its tolerance.
    pub size: f64,
    /// Index of the component among the unknowns.
    pub index: usize,
    /// Whether the component is a velocity.
    pub is_velocity: bool,
}

impl ErrorScales {
    /// Creates the scales with their initial values. The scale of multipliers is the reference mass times the model's length. All other scales
    /// have the value 1.
    pub(crate) fn new(system: &System) -> Self {
        Self {
            position: 1.0,
            velocity: 1.0,
            spin: 1.0,
            state: 1.0,
            variable: 1.0,
            multiplier: system.reference_mass * system.length,
        }
    }

    /// Raises the scales to the largest values in a state.
    pub(crate) fn grow(&mut self, system: &System, reached: &State) {
        let largest = |v: &Vec3| v.amax();
        for pose in &reached.poses {
            self.position = self.position.max(largest(&pose.p));
        }
        for PartRates { linear, angular } in &reached.velocities {
            self.velocity = self.velocity.max(largest(linear));
            self.spin = self.spin.max(largest(angular));
        }
        for state in &reached.states {
            self.state = self.state.max(state.abs());
        }
        for &k in &system.implicit {
            self.variable = self.variable.max(reached.variables[k].abs());
        }
        for multiplier in &reached.multipliers {
            self.multiplier = self.multiplier.max(multiplier.abs());
        }
    }

    /// Returns the largest component of a change of displacements `z` and velocities `w`. VARIABLEs and multipliers are included only
    /// if `variables` is true.
    pub(crate) fn measured(
        &self,
        system: &System,
        tolerance: f64,
        z: &[f64],
        w: &[f64],
        variables: bool,
    ) -> LargestComponent {
        let mut worst = LargestComponent::default();
        self.each(system, tolerance, variables, |at, velocity, size| {
            let value = if velocity { w[at] } else { z[at] };
            let value = (value / size).abs();
            if exceeds(value, worst.size) {
                worst = LargestComponent {
                    size: value,
                    index: at,
                    is_velocity: velocity,
                };
            }
        });
        worst
    }

    /// Returns the reciprocal tolerance of each unknown of a step; zero for unknowns without a tolerance.
    pub(crate) fn weights(&self, system: &System, tolerance: f64) -> Unknowns {
        let mut weights = Unknowns::new(system);
        self.each(system, tolerance, true, |at, velocity, size| {
            let of_stages = if velocity {
                &mut weights.w
            } else {
                &mut weights.z
            };
            for stage in of_stages {
                stage[at] = 1.0 / size;
            }
        });
        weights
    }

    /// Calls `look` for every unknown that has a tolerance, with the index of the unknown, whether it is a velocity, and its tolerance.
    /// VARIABLEs and multipliers are included only if `variables` is true.
    fn each(
        &self,
        system: &System,
        tolerance: f64,
        variables: bool,
        mut look: impl FnMut(usize, bool, f64),
    ) {
        for body in &system.bodies {
            for k in 0..body.freedoms {
                let at = body.first + k;
                if k < 3 {
                    look(at, false, tolerance * self.position);
                    look(at, true, tolerance * self.velocity);
                } else {
                    look(at, false, tolerance);
                    look(at, true, tolerance * self.spin);
                }
            }
        }
        for equation in &system.states {
            look(equation.moving_unknown, false, tolerance * self.state);
        }
        if variables {
            for at in system.first_variable..system.first_state() {
                look(at, false, tolerance * self.variable);
            }
            // Multipliers are extrapolated from step to step. Without a tolerance of their own, their errors would grow.
            for at in system.first_equation..system.first_variable {
                look(at, false, tolerance.sqrt() * self.multiplier);
            }
        }
    }
}
