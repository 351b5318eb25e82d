use admire_results::EntityKind;
use admire_solver::mechanics::{Mat3, Pose, Vec3, euler313, psi_theta_phi};
use admire_solver::model::{LinearStates, MarkerIx, Model, RequestKind};
use admire_solver::system::{
    Configuration, ConstraintIx, ElementIx, Parameters, Reading, Scratch, State, System,
};

use super::columns::{Columns, Item};

/// Evaluates forces, reactions and requests at one state of a system.
///
/// A quantity that has no value at this state, such as a force along a line of zero length, becomes zero, because results files contain
/// only numbers.
pub(super) struct Measures<'s> {
    system: &'s System,
    parameters: &'s Parameters,
    pub state: &'s State,
    scratch: &'s mut Scratch,
}

/// Element or constraint that exerts a force.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Exerting {
    Element(ElementIx),
    Constraint(ConstraintIx),
}

impl<'s> Measures<'s> {
    /// Evaluates the system at a state.
    pub(crate) fn new(
        system: &'s System,
        parameters: &'s Parameters,
        state: &'s State,
        scratch: &'s mut Scratch,
    ) -> Self {
        // Elements whose functions have no value at this state exert no force.
        let _ = system.evaluate_leniently(parameters, state, scratch);
        Self {
            system,
            parameters,
            state,
            scratch,
        }
    }

    /// Returns the configuration of the system at the state.
    fn here(&mut self) -> Configuration<'_> {
        self.system.at(self.parameters, self.state, self.scratch)
    }

    fn element(&mut self, element: ElementIx) -> Option<Reading> {
        self.here().read_element(element).ok()
    }

    fn constraint(&mut self, constraint: ConstraintIx) -> Reading {
        self.here().read_constraint(constraint)
    }

    /// Returns the force and torque that an element or constraint exerts on a marker, in ground axes. If the marker is not the J marker,
    /// the force on the I marker is returned.
    pub(super) fn load_on(&mut self, by: Exerting, marker: MarkerIx) -> Option<[f64; 6]> {
        let reading = match by {
            Exerting::Element(element) => self.element(element)?,
            Exerting::Constraint(constraint) => self.constraint(constraint),
        };
        let (f, t) = if marker == reading.j {
            (reading.force_on_j, reading.torque_on_j)
        } else {
            (reading.force, reading.torque)
        };
        let six = [f.x, f.y, f.z, t.x, t.y, t.z];
        six.iter().all(|value| value.is_finite()).then_some(six)
    }

    fn multi(&mut self, id: u32) -> Vec<Reading> {
        self.here().read_nforce(id).unwrap_or_default()
    }

    fn variable(&mut self, index: Option<usize>) -> f64 {
        let value = index.and_then(|k| self.here().read_variable(k).ok());
        value.filter(|value| value.is_finite()).unwrap_or(0.0)
    }

    /// Appends the states x, which begin at index `first` of the dynamic states, and the outputs y = C x + D u.
    fn linear_states(
        &mut self,
        states: &LinearStates,
        first: usize,
        inputs: &[Option<usize>],
        values: &mut Vec<f64>,
    ) {
        let x: Vec<f64> = (first..first + states.a.len())
            .map(|at| self.state.states.get(at).copied().unwrap_or(0.0))
            .collect();
        let u: Vec<f64> = inputs.iter().map(|index| self.variable(*index)).collect();
        let dot = |row: &[f64], v: &[f64]| -> f64 { row.iter().zip(v).map(|(a, b)| a * b).sum() };
        values.extend(&x);
        for (k, row) in states.c.iter().enumerate() {
            let through = states.d.get(k).map_or(0.0, |row| dot(row, &u));
            values.push(dot(row, &x) + through);
        }
    }

    /// Returns the pose of a marker relative to ground.
    fn marker(&self, model: &Model, marker: MarkerIx) -> Pose {
        let part = model.markers[marker.0].part;
        self.state.poses[part.0].compose(self.parameters.marker(marker))
    }

    /// Returns the eight components of a request, in the form that the OUTPUT statement sets. The components are zero if the request is
    /// switched off or has no value.
    pub(crate) fn request(&mut self, model: &Model, index: usize) -> [f64; 8] {
        let request = &model.requests[index];
        if !request.header.active {
            return [0.0; 8];
        }
        let read = self.here().read_request(request, index);
        let mut values = read.unwrap_or_default();
        let output = &model.output;
        let smallest = match &request.kind {
            RequestKind::Displacement { .. } => {
                if output.ypr {
                    let R = euler313(values[5], values[6], values[7]);
                    values[5..].copy_from_slice(&yaw_pitch_roll(&R));
                }
                output.zero[0]
            }
            RequestKind::Velocity { .. } => output.zero[1],
            RequestKind::Acceleration { .. } => output.zero[2],
            RequestKind::Force { .. } => output.zero[3],
            RequestKind::Functions(_) | RequestKind::User(_) => 0.0,
        };
        values.map(|value| {
            let shown = value.is_finite() && value.abs() >= smallest;
            if shown { value } else { 0.0 }
        })
    }
}

/// Returns YAW, PITCH and ROLL of a rotation R = Rz(a) Ry(b) Rx(c): the angles a, -b and c (guide/formats.md 4.4).
fn yaw_pitch_roll(R: &Mat3) -> [f64; 3] {
    [
        libm::atan2(R[(1, 0)], R[(0, 0)]),
        libm::asin(R[(2, 0)].clamp(-1.0, 1.0)),
        libm::atan2(R[(2, 1)], R[(2, 2)]),
    ]
}

impl Columns {
    /// Computes the values of the step `input`: displacements of the parts in the dataset, and zeros for everything else.
    pub(crate) fn input(&self, initial: &State, values: &mut Vec<f64>) {
        values.clear();
        values.push(initial.time);
        self.bodies(initial, values);
        values.resize(self.catalogue.len(), 0.0);
    }

    /// Computes the values of all columns at the state of `measures`.
    pub(crate) fn step(&self, model: &Model, measures: &mut Measures<'_>, values: &mut Vec<f64>) {
        let state = measures.state;
        values.clear();
        values.push(state.time);
        self.bodies(state, values);
        for item in &self.items {
            Self::item(item, model, measures, values);
        }
    }

    fn bodies(&self, state: &State, values: &mut Vec<f64>) {
        let mut count = 0;
        for (part, kind) in &self.bodies {
            let whole = *kind == EntityKind::Part;
            count += if whole { 6 } else { 3 };
            if !self.stored.displacements {
                continue;
            }
            let pose = &state.poses[part.0];
            values.extend(pose.p.iter());
            if whole {
                values.extend(psi_theta_phi(&pose.R));
            }
        }
        for (stored, rates) in [
            (self.stored.velocities, &state.velocities),
            (self.stored.accelerations, &state.accelerations),
        ] {
            if !stored {
                continue;
            }
            if rates.is_empty() {
                // A state without rates is at rest, so its velocities and accelerations are zero.
                values.resize(values.len() + count, 0.0);
                continue;
            }
            for (part, kind) in &self.bodies {
                let rates = &rates[part.0];
                values.extend(rates.linear.iter());
                if *kind == EntityKind::Part {
                    values.extend(rates.angular.iter());
                }
            }
        }
    }

    fn item(item: &Item, model: &Model, measures: &mut Measures<'_>, values: &mut Vec<f64>) {
        let wrench = |reading: Option<&Reading>, values: &mut Vec<f64>| match reading {
            Some(reading) => {
                values.extend(reading.force.iter());
                values.extend(reading.torque.iter());
            }
            None => values.extend([0.0; 6]),
        };
        match item {
            Item::Diff { at, .. } => {
                let at = |values: &[f64]| at.and_then(|at| values.get(at)).copied().unwrap_or(0.0);
                values.push(at(&measures.state.states));
                values.push(at(&measures.state.state_rates));
            }
            Item::Variable { at, .. } => values.push(measures.variable(*at)),
            Item::Constraint { at, .. } => {
                let reading = at.map(|at| measures.constraint(at));
                wrench(reading.as_ref(), values);
            }
            Item::Element { at, angles, .. } => {
                let reading = at.and_then(|at| measures.element(at));
                wrench(reading.as_ref(), values);
                if *angles {
                    let angles = reading.map_or_else(Vec3::zeros, |reading| reading.motion.angles);
                    values.extend(angles.iter());
                }
            }
            Item::Request(components) => {
                let mut last: Option<(usize, [f64; 8])> = None;
                for component in components {
                    let Some(request) = component.at else {
                        values.push(0.0);
                        continue;
                    };
                    let all = match last {
                        Some((known, all)) if known == request => all,
                        _ => measures.request(model, request),
                    };
                    last = Some((request, all));
                    values.push(all[component.which]);
                }
            }
            Item::Condition { id, at } => {
                let (force, torque) = at.map_or_else(
                    || (Vec3::zeros(), Vec3::zeros()),
                    |marker| measures.here().read_condition(*id, marker),
                );
                values.extend(force.iter());
                values.extend(torque.iter());
            }
            Item::Multi(id, markers) => {
                let readings = measures.multi(*id);
                for marker in 0..*markers {
                    wrench(readings.get(marker), values);
                }
            }
            Item::Variables { at, .. } => {
                values.extend(at.iter().map(|at| measures.variable(*at)));
            }
            Item::LinearStates {
                columns,
                at,
                first,
                inputs,
                ..
            } => {
                let before = values.len();
                if let Some(at) = *at {
                    measures.linear_states(&model.linear_states[at], *first, inputs, values);
                }
                // The number of columns was fixed at the start of the file. It stays the same even if the number of states has changed.
                values.resize(before + columns, 0.0);
            }
            Item::Friction(id) => {
                let read = measures.here().read_friction(*id).unwrap_or_default();
                for vector in [read.force, read.torque, read.mu, read.mu_turn] {
                    values.extend(vector.iter());
                }
                values.push(read.mu_1);
                for vector in [
                    read.velocity,
                    read.turn_velocity,
                    read.creep,
                    read.turn_creep,
                ] {
                    values.extend(vector.iter());
                }
                values.push(read.beta);
            }
            Item::FloatingMarker { on: Some(i), .. } => {
                let pose = measures.marker(model, *i);
                values.extend(pose.p.iter());
                values.extend(psi_theta_phi(&pose.R));
            }
            // The vector force of this floating marker is no longer in the model.
            Item::FloatingMarker { on: None, .. } => values.extend([0.0; 6]),
        }
    }
}
