//! Residual and Jacobian of the static equations.
//!
//! Knows no iteration, no step control and no factorisation.

use super::chain::{Acting, NoJacobian, Place, Sink, add_block, add_wrench, turn};
use super::structure::{Action, Drive, Element, Joint, Name, Rate, System};
use super::{Parameters, Scratch, State};
use crate::constraint::Constraint;
use crate::element::{Degenerate, Law};
use crate::mechanics::{Mat6, Pose, RelativeMotion, Vec3, Vec6};

/// An element that has no value in this configuration.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
#[error("{element}: {reason}")]
pub struct NoValue {
    /// Which element.
    pub element: Name,
    /// Why.
    pub reason: Reason,
}

/// Why an element has no value.
#[derive(Clone, PartialEq, Debug, thiserror::Error)]
pub enum Reason {
    /// The motion is one at which the law has no value.
    #[error(transparent)]
    Degenerate(#[from] Degenerate),
    /// Its function has no value.
    #[error(transparent)]
    Function(#[from] crate::function::EvalError),
}

impl System {
    /// The imbalance of every equation: forces and torques about the part origins (ground axes), constraints, variables, rates.
    ///
    /// # Errors
    /// [`NoValue`] if an element is undefined in this configuration.
    pub fn residual(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        g: &mut [f64],
    ) -> Result<(), NoValue> {
        self.assemble(parameters, state, scratch, g, &mut NoJacobian)
    }

    /// Residual, and Jacobian into the sink. Entries come in the same order every time.
    pub(crate) fn assemble<S: Sink>(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        g: &mut [f64],
        sink: &mut S,
    ) -> Result<(), NoValue> {
        g.fill(0.0);
        scratch.largest = 0.0;
        self.place_markers(parameters, state, scratch);
        self.evaluate_functions(parameters, state, scratch)?;
        self.add_gravity(parameters, scratch, g, sink);
        for element in &self.elements {
            if element.active {
                self.add_element(element, parameters, state, scratch, g, sink)?;
            }
        }
        for multi in self.multis.iter().filter(|m| m.active) {
            self.add_multi(multi, parameters, state, scratch, g, sink)?;
        }
        for joint in &self.joints {
            self.add_joint(joint, parameters, state, scratch, g, sink);
        }
        self.add_conditions(parameters, state, scratch, g, sink)?;
        self.add_data(state, scratch, g, sink);
        Ok(())
    }

    /// Poses of the used markers in ground, and their arms.
    pub(crate) fn place_markers(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) {
        for &marker in &self.used {
            let part = &state.poses[self.owners[marker]];
            let local = &parameters.markers()[marker];
            let arm = part.R * local.p;
            scratch.arms[marker] = arm;
            scratch.markers[marker] = Pose {
                p: part.p + arm,
                R: part.R * local.R,
            };
        }
    }

    pub(crate) fn place(&self, part: usize) -> Place {
        Place {
            first: self.bodies[part].first,
            freedoms: self.bodies[part].freedoms,
        }
    }

    /// From the origin of a part to the origin of a marker that may be on another part.
    pub(crate) fn arm_to(
        &self,
        marker: usize,
        part: usize,
        state: &State,
        scratch: &Scratch,
    ) -> Vec3 {
        if self.owners[marker] == part {
            scratch.arms[marker]
        } else {
            scratch.markers[marker].p - state.poses[part].p
        }
    }

    /// The motion of I in J. Angles only where somebody reads them.
    pub(crate) fn motion(
        scratch: &Scratch,
        state: &State,
        (i, j, pair): (usize, usize, usize),
        angles: bool,
    ) -> RelativeMotion {
        let (i, j) = (&scratch.markers[i], &scratch.markers[j]);
        if angles {
            return RelativeMotion::between(i, j, &state.pair_angles[pair]);
        }
        let R_jg = j.R.transpose();
        RelativeMotion {
            p_ij_j: R_jg * (i.p - j.p),
            R_ji: R_jg * i.R,
            angles: Vec3::zeros(),
        }
    }

    fn add_gravity<S: Sink>(
        &self,
        parameters: &Parameters,
        scratch: &mut Scratch,
        g: &mut [f64],
        sink: &mut S,
    ) {
        let theta = parameters.theta();
        let gravity = self.gravity_vector(theta);
        for (part, body) in self.bodies.iter().enumerate() {
            let place = self.place(part);
            let Some(cm) = body.cm else {
                // Every part has its block in the pattern.
                if S::WANTED {
                    add_block(sink, place, place, &Mat6::zeros());
                }
                continue;
            };
            if body.freedoms == 0 {
                continue;
            }
            let F = gravity * theta[body.mass];
            scratch.largest = scratch.largest.max(F.amax());
            let acting = Acting {
                F,
                T: Vec3::zeros(),
                D: None,
                a: self.place(part),
                r: scratch.arms[cm],
                b: None,
                c: None,
            };
            acting.add(g, sink);
        }
    }

    /// Gravity over the units consistency factor: weight per mass.
    pub(crate) fn gravity_vector(&self, theta: &[f64]) -> Vec3 {
        Vec3::from_column_slice(&theta[self.gravity..self.gravity + 3]) / self.ucf
    }

    /// Evaluates a law at the state; the result is in `scratch.wrench`, in J axes.
    pub(crate) fn evaluate_law(
        element: &Element,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        with_parameters: bool,
    ) -> Result<(), NoValue> {
        let Action::Law(law, drive) = &element.action else {
            return Ok(());
        };
        let pair = (element.i, element.j, element.pair);
        let motion = Self::motion(scratch, state, pair, law.uses_angles());
        let value;
        let (theta, with_parameters) = match drive {
            Drive::Theta(range) => (&parameters.theta()[range.clone()], with_parameters),
            Drive::Function(function) => {
                value = [scratch.functions[*function].value];
                (&value[..], true)
            }
            Drive::Held(held) => {
                value = [*held];
                (&value[..], true)
            }
        };
        law.evaluate(&motion, theta, with_parameters, &mut scratch.wrench)
            .map_err(|reason| NoValue {
                element: element.name.clone(),
                reason: reason.into(),
            })
    }

    /// The surroundings of an element, for the chain rule.
    pub(crate) fn acting<'a>(
        &self,
        element: &Element,
        state: &State,
        scratch: &Scratch,
        (F, T): (Vec3, Vec3),
        D: Option<&'a Mat6>,
    ) -> Acting<'a> {
        let part = self.owners[element.i];
        Acting {
            F,
            T,
            D,
            a: self.place(part),
            r: scratch.arms[element.i],
            b: element
                .reaction
                .map(|b| (self.place(b), self.arm_to(element.i, b, state, scratch))),
            c: element.frame.map(|frame| {
                let c = self.owners[frame];
                (self.place(c), self.arm_to(element.i, c, state, scratch))
            }),
        }
    }

    fn add_element<S: Sink>(
        &self,
        element: &Element,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        g: &mut [f64],
        sink: &mut S,
    ) -> Result<(), NoValue> {
        match &element.action {
            Action::Law(_, drive) => {
                Self::evaluate_law(element, parameters, state, scratch, false)?;
                let R = scratch.markers[element.j].R;
                let (F, T) = halves(&R, &scratch.wrench.value);
                scratch.largest = scratch.largest.max(F.amax().max(T.amax() / self.length));
                if !S::WANTED {
                    self.acting(element, state, scratch, (F, T), None)
                        .add(g, sink);
                    return Ok(());
                }
                let D = turn(&R, &scratch.wrench.by_motion);
                let acting = self.acting(element, state, scratch, (F, T), Some(&D));
                acting.add(g, sink);
                if let Drive::Function(function) = drive {
                    let unit = halves(&R, &scratch.wrench.by_parameter[0]);
                    Self::add_gradient(&acting, unit, *function, scratch, sink);
                }
            }
            Action::Vector(components) => {
                let R = element
                    .frame
                    .map_or_else(crate::mechanics::Mat3::identity, |m| scratch.markers[m].R);
                let mut w = Vec6::zeros();
                for k in 0..6 {
                    w[k] = components[k].map_or(0.0, |f| scratch.functions[f].value);
                }
                let (F, T) = halves(&R, &w);
                scratch.largest = scratch.largest.max(F.amax().max(T.amax() / self.length));
                let acting = self.acting(element, state, scratch, (F, T), None);
                acting.add(g, sink);
                if S::WANTED {
                    for k in 0..6 {
                        if let Some(function) = components[k] {
                            let unit = halves(&R, &Vec6::ith(k, 1.0));
                            Self::add_gradient(&acting, unit, function, scratch, sink);
                        }
                    }
                }
            }
        }
        Ok(())
    }

    /// Adds unit wrench times the gradient of a function.
    fn add_gradient<S: Sink>(
        acting: &Acting,
        (F, T): (Vec3, Vec3),
        function: usize,
        scratch: &Scratch,
        sink: &mut S,
    ) {
        let value = &scratch.functions[function];
        let mut on = |place: Place, arm: &Vec3, sign: f64| {
            let mut column = [0.0; 6];
            let local = Place {
                first: 0,
                freedoms: place.freedoms,
            };
            add_wrench(&mut column, local, sign, &F, &T, arm);
            for &(unknown, derivative) in &scratch.gradient[value.first..value.last] {
                for k in 0..place.freedoms {
                    sink.add(place.first + k, unknown, column[k] * derivative);
                }
            }
        };
        on(acting.a, &acting.r, 1.0);
        if let Some((b, s)) = &acting.b {
            on(*b, s, -1.0);
        }
    }

    fn add_joint<S: Sink>(
        &self,
        joint: &Joint,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        g: &mut [f64],
        sink: &mut S,
    ) {
        let first = self.first_equation + joint.first;
        let lambda = &state.multipliers[joint.first..joint.first + joint.count];
        let mut out = [false; 6];
        for k in 0..joint.count {
            out[k] = !joint.active || state.redundant.get(joint.first + k) == Some(&true);
            // A removed equation says that its multiplier is zero.
            sink.add(first + k, first + k, f64::from(u8::from(out[k])));
            g[first + k] = if out[k] { lambda[k] } else { -joint.offset };
        }
        if !joint.active {
            self.add_empty_joint(joint, sink);
            return;
        }
        for (number, term) in joint.terms.iter().enumerate() {
            let multipliers = Self::evaluate_term(joint, number, out, parameters, state, scratch);
            let R = scratch.markers[term.j].R;
            let (a, c) = (self.owners[term.i], self.owners[term.j]);
            let (place_a, place_c) = (self.place(a), self.place(c));
            let r = scratch.arms[term.i];
            let s = self.arm_to(term.i, c, state, scratch);
            let (mut F, mut T) = (Vec3::zeros(), Vec3::zeros());
            for k in 0..joint.count {
                let (row_t, row_r) = halves(&R, &scratch.equations.jacobian[k]);
                F -= multipliers[k] * row_t;
                T -= multipliers[k] * row_r;
                if !out[k] {
                    g[first + k] += term.scale * scratch.equations.residual[k];
                }
                if S::WANTED {
                    let factor = if out[k] { 0.0 } else { term.scale };
                    for (place, arm, sign) in [(place_a, &r, factor), (place_c, &s, -factor)] {
                        let mut row = [0.0; 6];
                        let local = Place {
                            first: 0,
                            freedoms: place.freedoms,
                        };
                        add_wrench(&mut row, local, sign, &row_t, &row_r, arm);
                        for m in 0..place.freedoms {
                            sink.add(first + k, place.first + m, row[m]);
                            sink.add(place.first + m, first + k, -row[m]);
                        }
                    }
                }
            }
            scratch.largest = scratch.largest.max(F.amax().max(T.amax() / self.length));
            let mut D = Mat6::zeros();
            if S::WANTED {
                let curvature = R * scratch.equations.curvature * R.transpose();
                D.fixed_view_mut::<3, 3>(3, 3).copy_from(&-curvature);
            }
            let acting = Acting {
                F,
                T,
                D: Some(&D),
                a: place_a,
                r,
                b: Some((place_c, s)),
                c: Some((place_c, s)),
            };
            acting.add(g, sink);
        }
        if S::WANTED
            && let Drive::Function(function) = joint.drive
        {
            let value = &scratch.functions[function];
            let by = if out[0] {
                0.0
            } else {
                scratch.equations.residual_by_parameter * joint.terms[0].scale
            };
            for &(unknown, derivative) in &scratch.gradient[value.first..value.last] {
                sink.add(first, unknown, by * derivative);
            }
        }
    }

    /// Evaluates one term of a constraint into `scratch.equations`; gives the multipliers of the term.
    pub(crate) fn evaluate_term(
        joint: &Joint,
        number: usize,
        removed: [bool; 6],
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
    ) -> [f64; 6] {
        let term = &joint.terms[number];
        let mut multipliers = [0.0; 6];
        for k in 0..joint.count {
            if !removed[k] {
                multipliers[k] = term.scale * state.multipliers[joint.first + k];
            }
        }
        let motion = Self::motion(
            scratch,
            state,
            (term.i, term.j, term.pair),
            term.law.uses_angles(),
        );
        let value;
        let theta = match &joint.drive {
            Drive::Theta(range) => &parameters.theta()[range.clone()],
            Drive::Function(function) => {
                value = [scratch.functions[*function].value];
                &value[..]
            }
            Drive::Held(held) => {
                value = [*held];
                &value[..]
            }
        };
        term.law
            .evaluate(&motion, theta, &multipliers, &mut scratch.equations);
        multipliers
    }

    /// A deactivated joint has the same pattern, all zero.
    fn add_empty_joint<S: Sink>(&self, joint: &Joint, sink: &mut S) {
        if !S::WANTED {
            return;
        }
        for term in &joint.terms {
            for part in [self.owners[term.i], self.owners[term.j]] {
                let place = self.place(part);
                for k in 0..joint.count {
                    let row = self.first_equation + joint.first + k;
                    for m in 0..place.freedoms {
                        sink.add(row, place.first + m, 0.0);
                        sink.add(place.first + m, row, 0.0);
                    }
                }
            }
        }
    }

    fn add_data<S: Sink>(&self, state: &State, scratch: &Scratch, g: &mut [f64], sink: &mut S) {
        for (k, variable) in self.variables.iter().enumerate() {
            let row = self.first_variable + k;
            sink.add(row, row, 1.0);
            g[row] = state.variables[k];
            if variable.active {
                let value = &scratch.functions[variable.function];
                g[row] -= value.value;
                for &(unknown, derivative) in &scratch.gradient[value.first..value.last] {
                    sink.add(row, unknown, -derivative);
                }
            }
        }
        for equation in &self.states {
            let Some(row) = equation.unknown else {
                continue;
            };
            match &equation.rate {
                Rate::Held => {}
                Rate::Function(function) => {
                    let value = &scratch.functions[*function];
                    g[row] = value.value;
                    for &(unknown, derivative) in &scratch.gradient[value.first..value.last] {
                        sink.add(row, unknown, derivative);
                    }
                }
                Rate::Linear(by_state, by_variable) => {
                    for &(k, a) in by_state {
                        g[row] += a * state.states[k];
                        if let Some(unknown) = self.states[k].unknown {
                            sink.add(row, unknown, a);
                        }
                    }
                    for &(k, b) in by_variable {
                        g[row] += b * state.variables[k];
                        sink.add(row, self.first_variable + k, b);
                    }
                }
            }
        }
    }
}

/// Force and torque of a wrench in the axes R, turned to ground.
pub(crate) fn halves(R: &crate::mechanics::Mat3, w: &Vec6) -> (Vec3, Vec3) {
    (
        R * Vec3::new(w[0], w[1], w[2]),
        R * Vec3::new(w[3], w[4], w[5]),
    )
}
