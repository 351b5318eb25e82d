//! Derivatives of the residual by theta and by wrenches that are not in the model.

use super::assemble::{NoValue, halves};
use super::catalogue::Role;
use super::chain::{Acting, Twist, add_wrench, turn};
use super::function::Source;
use super::multi::Multi;
use super::parameters::PER_MARKER;
use super::structure::{Action, Drive, Element, Rate};
use super::{Parameters, Scratch, Slot, State, System};
use crate::mechanics::{Mat3, Mat6, Vec3, Vec6};
use crate::model::MarkerIx;

impl System {
    /// The change of the residual per unit of a number of theta, the unknowns staying as they are. Overwrites `dg`.
    ///
    /// # Errors
    /// [`NoValue`] if an element is undefined in this configuration.
    pub fn residual_by_slot(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        slot: Slot,
        dg: &mut [f64],
    ) -> Result<(), NoValue> {
        dg.fill(0.0);
        self.place_markers(parameters, state, scratch);
        self.evaluate_functions(parameters, state, scratch)?;
        let group = self.catalogue().group(slot);
        if self.acts_through_functions(group.role) {
            return self.residual_difference(parameters, state, scratch, slot, dg);
        }
        let offset = slot.0 - group.first;
        match group.role {
            Role::Law { element } => {
                let element = &self.elements[element];
                if !element.active {
                    return Ok(());
                }
                Self::evaluate_law(element, parameters, state, scratch, true)?;
                if let Action::Law(_, Drive::Theta(range)) = &element.action {
                    let w = scratch.wrench.by_parameter[slot.0 - range.start];
                    let R = scratch.markers[element.j].R;
                    let (F, T) = halves(&R, &w);
                    let acting = self.acting(element, state, scratch, (F, T), None);
                    acting.add(dg, &mut super::chain::NoJacobian);
                }
            }
            Role::Marker(marker) => {
                let k = slot.0 % PER_MARKER;
                self.by_marker(parameters, state, scratch, (marker, k), dg)?;
            }
            Role::Mass(part) => {
                if let Some(cm) = self.bodies[part].cm {
                    let F = self.gravity_vector(parameters.theta());
                    let arm = scratch.arms[cm];
                    add_wrench(dg, self.place(part), 1.0, &F, &Vec3::zeros(), &arm);
                }
            }
            Role::Gravity => {
                let unit = Vec3::ith(slot.0 - self.gravity, 1.0 / self.ucf);
                for (part, body) in self.bodies.iter().enumerate() {
                    if let Some(cm) = body.cm {
                        let F = unit * parameters.theta()[body.mass];
                        let arm = scratch.arms[cm];
                        add_wrench(dg, self.place(part), 1.0, &F, &Vec3::zeros(), &arm);
                    }
                }
            }
            Role::Joint { joint } => {
                let joint = &self.joints[joint];
                let out = Self::removed(joint, state);
                if !joint.active || out[0] {
                    return Ok(());
                }
                let lambda = Self::evaluate_term(joint, 0, out, parameters, state, scratch);
                dg[self.first_equation + joint.first] = scratch.equations.residual_by_parameter;
                let term = &joint.terms[0];
                let R = scratch.markers[term.j].R;
                let w = scratch.equations.jacobian_by_parameter * -lambda[0];
                let (F, T) = halves(&R, &w);
                self.add_opposite((term.i, term.j), state, scratch, (&F, &T), dg);
            }
            Role::Multi => return self.residual_difference(parameters, state, scratch, slot, dg),
            Role::Literals(function) => {
                let rate =
                    self.function_by_literal(parameters, state, scratch, function, offset)?;
                self.by_function(parameters, state, scratch, (function, rate), dg)?;
            }
            Role::Override(function) => {
                self.by_function(parameters, state, scratch, (function, 1.0), dg)?;
            }
        }
        Ok(())
    }

    /// The residual of a wrench on marker I, given in J axes, with its opposite at the same point of the part of J.
    pub fn unit_wrench_column(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        (i, j): (MarkerIx, MarkerIx),
        wrench_j: &Vec6,
    ) -> Vec<f64> {
        let mut dg = vec![0.0; self.unknowns];
        for marker in [i.0, j.0] {
            let part = &state.poses[self.owners[marker]];
            let local = &parameters.markers()[marker];
            scratch.markers[marker] = part.compose(local);
            scratch.arms[marker] = part.R * local.p;
        }
        let R = scratch.markers[j.0].R;
        let (F, T) = halves(&R, wrench_j);
        self.add_opposite((i.0, j.0), state, scratch, (&F, &T), &mut dg);
        dg
    }

    fn add_opposite(
        &self,
        (i, j): (usize, usize),
        state: &State,
        scratch: &Scratch,
        (F, T): (&Vec3, &Vec3),
        dg: &mut [f64],
    ) {
        let (a, b) = (self.owners[i], self.owners[j]);
        add_wrench(dg, self.place(a), 1.0, F, T, &scratch.arms[i]);
        let arm = self.arm_to(i, b, state, scratch);
        add_wrench(dg, self.place(b), -1.0, F, T, &arm);
    }

    pub(crate) fn removed(joint: &super::structure::Joint, state: &State) -> [bool; 6] {
        let mut out = [false; 6];
        for (k, out) in out.iter_mut().enumerate().take(joint.count) {
            *out = state.redundant.get(joint.first + k) == Some(&true);
        }
        out
    }

    /// All that depends on a function changes with it at this rate.
    fn by_function(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        (function, rate): (usize, f64),
        dg: &mut [f64],
    ) -> Result<(), NoValue> {
        for element in self.elements.iter().filter(|e| e.active) {
            match &element.action {
                Action::Law(_, Drive::Function(f)) if *f == function => {
                    Self::evaluate_law(element, parameters, state, scratch, true)?;
                    let R = scratch.markers[element.j].R;
                    let (F, T) = halves(&R, &(scratch.wrench.by_parameter[0] * rate));
                    let acting = self.acting(element, state, scratch, (F, T), None);
                    acting.add(dg, &mut super::chain::NoJacobian);
                }
                Action::Vector(components) => {
                    for k in 0..6 {
                        if components[k] == Some(function) {
                            let R = frame_axes(element, scratch);
                            let (F, T) = halves(&R, &Vec6::ith(k, rate));
                            let acting = self.acting(element, state, scratch, (F, T), None);
                            acting.add(dg, &mut super::chain::NoJacobian);
                        }
                    }
                }
                Action::Law(..) => {}
            }
        }
        for joint in self.joints.iter().filter(|j| j.active) {
            if matches!(joint.drive, Drive::Function(f) if f == function)
                && !Self::removed(joint, state)[0]
            {
                let out = Self::removed(joint, state);
                Self::evaluate_term(joint, 0, out, parameters, state, scratch);
                dg[self.first_equation + joint.first] +=
                    scratch.equations.residual_by_parameter * joint.terms[0].scale * rate;
            }
        }
        self.data_by_function(state, (function, rate), dg);
        Ok(())
    }

    /// A marker moves on its part: what it is the I or the frame of changes.
    fn by_marker(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        (marker, k): (usize, usize),
        dg: &mut [f64],
    ) -> Result<(), NoValue> {
        let (shift, axis) = parameters.marker_derivative(marker, k);
        let part = &state.poses[self.owners[marker]];
        let twist = Twist {
            shift: part.R * shift,
            turn: part.R * axis,
        };
        let of = |m: usize| if m == marker { twist } else { Twist::zero() };
        for element in self.elements.iter().filter(|e| e.active) {
            let framed = element.frame == Some(marker);
            if element.i != marker && !framed {
                continue;
            }
            let (w, D, R);
            match &element.action {
                Action::Law(..) => {
                    Self::evaluate_law(element, parameters, state, scratch, false)?;
                    R = scratch.markers[element.j].R;
                    w = halves(&R, &scratch.wrench.value);
                    D = turn(&R, &scratch.wrench.by_motion);
                }
                Action::Vector(components) => {
                    R = frame_axes(element, scratch);
                    let mut local = Vec6::zeros();
                    for k in 0..6 {
                        local[k] = components[k].map_or(0.0, |f| scratch.functions[f].value);
                    }
                    w = halves(&R, &local);
                    D = Mat6::zeros();
                }
            }
            let acting = self.acting(element, state, scratch, w, Some(&D));
            let d = element.frame.map_or_else(Vec3::zeros, |frame| {
                scratch.markers[element.i].p - scratch.markers[frame].p
            });
            let c = element.frame.map_or_else(Twist::zero, of);
            add_change(&acting, &of(element.i), &c, &d, dg);
        }
        for joint in self.joints.iter().filter(|j| j.active) {
            let out = Self::removed(joint, state);
            for (number, term) in joint.terms.iter().enumerate() {
                if term.i != marker && term.j != marker {
                    continue;
                }
                let lambda = Self::evaluate_term(joint, number, out, parameters, state, scratch);
                let R = scratch.markers[term.j].R;
                let d = scratch.markers[term.i].p - scratch.markers[term.j].p;
                let (i, j) = (of(term.i), of(term.j));
                let dp = R.transpose() * (i.shift - j.shift - j.turn.cross(&d));
                let dphi = R.transpose() * (i.turn - j.turn);
                let m = Vec6::new(dp.x, dp.y, dp.z, dphi.x, dphi.y, dphi.z);
                let mut w = Vec6::zeros();
                for k in 0..joint.count {
                    let row = &scratch.equations.jacobian[k];
                    w -= row * lambda[k];
                    if !out[k] {
                        dg[self.first_equation + joint.first + k] += term.scale * row.dot(&m);
                    }
                }
                let mut D = Mat6::zeros();
                let curvature = R * scratch.equations.curvature * R.transpose();
                D.fixed_view_mut::<3, 3>(3, 3).copy_from(&-curvature);
                let (F, T) = halves(&R, &w);
                let part = self.owners[term.j];
                let arm = self.arm_to(term.i, part, state, scratch);
                let acting = Acting {
                    F,
                    T,
                    D: Some(&D),
                    a: self.place(self.owners[term.i]),
                    r: scratch.arms[term.i],
                    b: Some((self.place(part), arm)),
                    c: None,
                };
                add_change(&acting, &i, &j, &d, dg);
            }
        }
        for (part, body) in self.bodies.iter().enumerate() {
            if body.cm == Some(marker) {
                let F = self.gravity_vector(parameters.theta()) * parameters.theta()[body.mass];
                add_wrench(
                    dg,
                    self.place(part),
                    1.0,
                    &Vec3::zeros(),
                    &twist.shift.cross(&F),
                    &Vec3::zeros(),
                );
            }
        }
        Ok(())
    }
}

fn frame_axes(element: &Element, scratch: &Scratch) -> Mat3 {
    element
        .frame
        .map_or_else(Mat3::identity, |m| scratch.markers[m].R)
}

/// Adds the change of an acting wrench when its markers move on their parts: `d(r x F) = r x dF + dp_i x F`.
fn add_change(acting: &Acting, i: &Twist, c: &Twist, d: &Vec3, dg: &mut [f64]) {
    let (dF, dT) = acting.change(i, c, d);
    let dT = dT + i.shift.cross(&acting.F);
    add_wrench(dg, acting.a, 1.0, &dF, &dT, &acting.r);
    if let Some((b, s)) = &acting.b {
        add_wrench(dg, *b, -1.0, &dF, &dT, s);
    }
}

/// Relative step of the differences below.
const STEP: f64 = 1e-6;

impl System {
    /// True if a number also acts through functions that measure what it changes. Functions have no derivative by that.
    fn acts_through_functions(&self, role: Role) -> bool {
        if let (Role::Marker(marker), false) = (role, self.multis.is_empty()) {
            let touches = |m: &Multi| m.j == marker || m.i.contains(&marker);
            if self.multis.iter().any(touches) {
                return true;
            }
        }
        let sources = || self.order.iter().flat_map(|&f| &self.functions[f].sources);
        match role {
            Role::Marker(marker) => {
                let is = |m: Option<MarkerIx>| m == Some(MarkerIx(marker));
                sources().any(|source| match source {
                    Source::Measure(m, _) => is(m.i) || is(m.j) || is(m.k),
                    Source::Force(_) => true,
                    _ => false,
                })
            }
            Role::Mass(_) | Role::Gravity | Role::Multi => false,
            Role::Law { .. } | Role::Joint { .. } => {
                sources().any(|source| matches!(source, Source::Force(_)))
            }
            Role::Literals(function) | Role::Override(function) => {
                let measured = sources().any(|s| matches!(s, Source::Force(_) | Source::Rate(_)));
                measured || self.conditions.iter().any(|c| c.function == function)
            }
        }
    }

    /// The change of the residual per unit of a number of theta, by central differences.
    fn residual_difference(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        slot: Slot,
        dg: &mut [f64],
    ) -> Result<(), NoValue> {
        let mut moved = parameters.clone();
        let mut here = parameters.get(slot);
        if let (true, Role::Override(function)) = (here.is_nan(), self.catalogue().group(slot).role)
        {
            here = scratch.functions[function].value;
        }
        let h = STEP * here.abs().max(1.0);
        let mut minus = vec![0.0; dg.len()];
        moved.set(slot, here + h);
        self.residual(&moved, state, scratch, dg)?;
        moved.set(slot, here - h);
        self.residual(&moved, state, scratch, &mut minus)?;
        for (plus, minus) in dg.iter_mut().zip(&minus) {
            *plus = (*plus - minus) / (2.0 * h);
        }
        Ok(())
    }

    /// Derivative of a function by one of its literals, the unknowns staying as they are.
    fn function_by_literal(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        function: usize,
        literal: usize,
    ) -> Result<f64, NoValue> {
        if !parameters.theta()[self.functions[function].replacement].is_nan() {
            return Ok(0.0);
        }
        self.evaluate_function(parameters, state, scratch, function)?;
        Ok(scratch.by_literal.get(literal).copied().unwrap_or(0.0))
    }

    /// Variables, rates and GCONs change with a function at this rate.
    fn data_by_function(&self, state: &State, (function, rate): (usize, f64), dg: &mut [f64]) {
        for (k, variable) in self.variables.iter().enumerate() {
            if variable.active && variable.function == function {
                dg[self.first_variable + k] -= rate;
            }
        }
        for equation in &self.states {
            if let (Rate::Function(f), Some(row)) = (&equation.rate, equation.unknown)
                && *f == function
            {
                dg[row] += rate;
            }
        }
        for condition in &self.conditions {
            let out = state.redundant.get(condition.equation) == Some(&true);
            if condition.active && condition.function == function && !out {
                dg[self.first_equation + condition.equation] += rate;
            }
        }
    }
}
