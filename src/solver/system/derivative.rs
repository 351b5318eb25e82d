//! Derivatives of the residual with respect to parameters in theta and to wrenches added to the model.

use super::NoValue;
use super::carried::Moved;
use super::catalogue::Role;
use super::chain::Twist;
use super::chain::add_wrench;
use super::compiled_function::Exerted;
use super::compiled_function::Source;
use super::contribution::{Of, halves};
use super::forces::DerivativeRequest;
use super::parameters::PER_MARKER;
use super::scratch::{FunctionNumber, Seed};
use super::structure::{Action, Element, ParameterSource, StateRhs};
use super::{Configuration, Parameters, Scratch, Slot, State, System};
use crate::element::{CarNumbers, ElementLaw};
use crate::linear::Sink;
use crate::mechanics::{Vec3, Vec6};
use crate::model::MarkerIx;

impl System {
    /// Computes the derivative of the residual with respect to one parameter at constant unknowns. Overwrites `dg`.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element is undefined in this configuration.
    pub fn residual_by_slot(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        slot: Slot,
        dg: &mut [f64],
    ) -> Result<(), NoValue> {
        self.evaluate(parameters, state, scratch)?
            .residual_by_slot(slot, dg)
    }

    /// Returns the change of the residual due to an additional wrench on marker I, given in J axes. The opposite wrench acts at the same
    /// point on the part of J.
    pub fn unit_wrench_column(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        (i, j): (MarkerIx, MarkerIx),
        wrench_j: &Vec6,
    ) -> Vec<f64> {
        let mut here = self.at(parameters, state, scratch);
        here.place_marker(i.0);
        here.place_marker(j.0);
        let (a, b) = (self.owners[i.0], self.owners[j.0]);
        let (F, T) = halves(&here.scratch.markers[j.0].R, wrench_j);
        let mut dg = vec![0.0; self.unknowns];
        let r = here.scratch.arms[i.0];
        add_wrench(&mut dg, self.place(a), 1.0, &F, &T, &r);
        let s = here.arm_to(i.0, b);
        add_wrench(&mut dg, self.place(b), -1.0, &F, &T, &s);
        dg
    }
}

impl Element {
    fn driven_by(&self, function: usize) -> bool {
        match &self.action {
            Action::Law(_, drive) => {
                matches!(drive, ParameterSource::Function(f) if *f == function)
            }
            Action::Vector(components) => components.contains(&Some(function)),
        }
    }
}

impl Configuration<'_> {
    /// Computes the derivative of the residual with respect to a rotation (radians) of a marker on its part, about an axis fixed to the
    /// marker. Overwrites `dg`.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element is undefined in this configuration.
    pub fn residual_by_turn(
        &mut self,
        marker: MarkerIx,
        axis: &Vec3,
        dg: &mut [f64],
    ) -> Result<(), NoValue> {
        /// Step of the difference, in radians.
        const STEP: f64 = 1e-6;
        dg.fill(0.0);
        let (system, state) = (self.system, self.state);
        if !system.acts_through_functions(Role::Marker(marker.0)) {
            let moved = self.parameters.turn_derivative(marker.0, axis);
            return self.by_markers(&moved, dg);
        }
        let mut minus = vec![0.0; dg.len()];
        for (sign, out) in [(1.0, &mut *dg), (-1.0, &mut minus[..])] {
            let mut moved = self.parameters.clone();
            moved.turn(marker, axis, sign * STEP);
            system.residual(&moved, state, self.scratch, out)?;
        }
        for (plus, minus) in dg.iter_mut().zip(&minus) {
            *plus = (*plus - minus) / (2.0 * STEP);
        }
        self.evaluate()
    }

    /// Computes the derivative of the residual with respect to one parameter at constant unknowns. Overwrites `dg`.
    ///
    /// # Errors
    /// Returns [`NoValue`] if an element is undefined in this configuration.
    pub fn residual_by_slot(&mut self, slot: Slot, dg: &mut [f64]) -> Result<(), NoValue> {
        dg.fill(0.0);
        let system = self.system;
        let group = system.catalogue().group(slot);
        if system.acts_through_functions(group.role) {
            return self.residual_difference(slot, dg);
        }
        let offset = slot.0 - group.first;
        let theta = self.parameters.theta();
        match group.role {
            Role::Law { element: number } => {
                let element = &system.elements[number];
                if let (true, Action::Law(_, ParameterSource::Theta(range))) =
                    (element.active, &element.action)
                {
                    self.element(number, DerivativeRequest::Parameters)?;
                    let w = &self.scratch.wrench.by_parameter[slot.0 - range.start];
                    self.scratch.contribution.spread_local(w, dg);
                }
            }
            Role::Marker(marker) => {
                let moved = self
                    .parameters
                    .marker_derivative(marker, slot.0 % PER_MARKER);
                self.by_markers(&moved, dg)?;
            }
            Role::Mass(part) => self.spread_weight(part, &system.gravity_vector(theta), dg),
            Role::Gravity => {
                let unit = Vec3::ith(slot.0 - system.gravity, 1.0 / system.ucf);
                for (part, body) in system.bodies.iter().enumerate() {
                    if body.cm.is_some() {
                        self.spread_weight(part, &(unit * theta[body.mass]), dg);
                    }
                }
            }
            Role::Joint { joint: number } => {
                let joint = &system.joints[number];
                if !joint.out(self.state)[0] {
                    self.term(number, 0, false);
                    let equations = &self.scratch.equations;
                    dg[system.first_equation + joint.first] = equations.residual_by_parameter;
                    let lambda = self.state.multipliers[joint.first];
                    let w = equations.jacobian_by_parameter * -lambda;
                    self.scratch.contribution.spread_local(&w, dg);
                }
            }
            Role::Multi { multi: number } => {
                let multi = &system.multis[number];
                if multi.active {
                    self.evaluate_multi(multi)?;
                    let mut columns = vec![Vec6::zeros(); multi.i.len()];
                    let theta = &theta[multi.theta.clone()];
                    let p = slot.0 - multi.theta.start;
                    let law = multi.law();
                    law.by_parameter(theta, p, &self.scratch.multi, &mut columns);
                    for (at, w) in columns.iter().enumerate() {
                        self.multi(multi, at, false);
                        self.scratch.contribution.spread_local(w, dg);
                    }
                }
            }
            Role::Spline(spline) => self.by_knot((spline, offset), dg)?,
            Role::Literals(function) => {
                self.by_number_of(function, FunctionNumber::Literal(offset), dg)?;
            }
            Role::Override(function) => {
                self.by_number_of(function, FunctionNumber::Value, dg)?;
            }
        }
        Ok(())
    }

    /// Adds a force at the centre of mass of a part.
    fn spread_weight(&self, part: usize, F: &Vec3, dg: &mut [f64]) {
        if let Some(cm) = self.system.bodies[part].cm {
            let place = self.system.place(part);
            let arm = &self.scratch.arms[cm];
            add_wrench(dg, place, 1.0, F, &Vec3::zeros(), arm);
        }
    }

    /// Adds the derivative of the residual with respect to the y value of a point of a SPLINE. All functions and elements that read the
    /// SPLINE contribute.
    fn by_knot(&mut self, point: (usize, usize), dg: &mut [f64]) -> Result<(), NoValue> {
        let (system, parameters) = (self.system, self.parameters);
        let curves = parameters.curves();
        for (number, function) in system.functions.iter().enumerate() {
            let program = function.program.as_ref();
            if program.is_some_and(|program| program.reads_spline(curves, point.0)) {
                let number_of_function = FunctionNumber::Knot(point.0, point.1);
                self.by_number_of(number, number_of_function, dg)?;
            }
        }
        for (number, element) in system.elements.iter().enumerate() {
            if let Action::Law(ElementLaw::Car(car), ParameterSource::Theta(range)) =
                &element.action
                && element.active
                && car.reads_spline(curves, point.0)
            {
                self.element(number, DerivativeRequest::Tangent)?;
                let motion = self.motion(element.i, element.j, element.pair, true);
                let numbers = CarNumbers {
                    theta: &parameters.theta()[range.clone()],
                    curves,
                };
                let w = car.by_knot(&motion, numbers, point);
                let w = w.map_err(|reason| NoValue {
                    element: element.name.clone(),
                    reason: reason.into(),
                })?;
                self.scratch.contribution.spread_local(&w, dg);
            }
        }
        Ok(())
    }

    /// Adds the derivative of the residual with respect to a number (value, literal or point) of a function.
    fn by_number_of(
        &mut self,
        function: usize,
        number: FunctionNumber,
        dg: &mut [f64],
    ) -> Result<(), NoValue> {
        let (system, state) = (self.system, self.state);
        if !system.in_equations[function] {
            return Ok(());
        }
        if !system.passes_on(function) {
            let rate = match number {
                FunctionNumber::Value => 1.0,
                number => self.function_by_number(function, number)?,
            };
            return self.by_function((function, rate), dg);
        }
        let column = system.first_seed();
        let seed = Seed {
            function,
            number,
            column,
        };
        let mut sink = Seeded {
            first: column,
            columns: vec![vec![0.0; dg.len()]],
        };
        self.scratch.seeds.push(seed);
        let mut g = vec![0.0; dg.len()];
        let done = system.assemble(self.parameters, state, self.scratch, &mut g, &mut sink);
        self.scratch.seeds.clear();
        done?;
        for (sum, own) in dg.iter_mut().zip(&sink.columns[0]) {
            *sum += own;
        }
        self.evaluate()
    }

    /// Adds the change of the element forces, joints and data equations that depend directly on a function. `rate` is the change of the
    /// function value.
    fn by_function(
        &mut self,
        (function, rate): (usize, f64),
        dg: &mut [f64],
    ) -> Result<(), NoValue> {
        let system = self.system;
        for (number, element) in system.elements.iter().enumerate() {
            if !element.active || !element.driven_by(function) {
                continue;
            }
            self.element(number, DerivativeRequest::Tangent)?;
            let wrench = &self.scratch.contribution;
            for scalar in &wrench.scalars {
                if matches!(scalar.of, Of::Function(f) if f == function) {
                    wrench.spread(&(scalar.F * rate), &(scalar.T * rate), dg);
                }
            }
        }
        for (number, joint) in system.joints.iter().enumerate() {
            if matches!(joint.drive, ParameterSource::Function(f) if f == function)
                && !joint.out(self.state)[0]
            {
                self.term(number, 0, false);
                dg[system.first_equation + joint.first] +=
                    self.scratch.equations.residual_by_parameter * joint.terms[0].scale * rate;
            }
        }
        self.data_by_function((function, rate), dg);
        Ok(())
    }

    /// Adds the change of the residual due to markers that move on their parts.
    fn by_markers(&mut self, moved: &[Moved], dg: &mut [f64]) -> Result<(), NoValue> {
        let (system, parameters) = (self.system, self.parameters);
        let of = |marker: usize| {
            let moved = moved.iter().find(|moved| moved.marker == marker);
            moved.map_or_else(Twist::zero, |moved| {
                let part = &self.state.poses[system.owners[marker]];
                Twist {
                    shift: part.R * moved.shift,
                    turn: part.R * moved.turn,
                }
            })
        };
        for who in system.acting_with(moved) {
            self.contribute(who, DerivativeRequest::Tangent)?;
            let wrench = &self.scratch.contribution;
            wrench.by_marker(of, &self.scratch.markers, dg);
            // A row of the constraint Jacobian is minus the effect of its multiplier on the balances.
            let m = wrench.seen(of, &self.scratch.markers);
            for scalar in &wrench.scalars {
                if let Of::Unknown(row) = scalar.of {
                    let (dp, dphi) = (m.fixed_rows::<3>(0), m.fixed_rows::<3>(3));
                    dg[row] -= scalar.F.dot(&dp) + scalar.T.dot(&dphi);
                }
            }
        }
        let theta = parameters.theta();
        let gravity = system.gravity_vector(theta);
        for (part, body) in system.bodies.iter().enumerate() {
            let cm = body.cm.filter(|cm| moved.iter().any(|m| m.marker == *cm));
            if let Some(cm) = cm {
                let T = of(cm).shift.cross(&(gravity * theta[body.mass]));
                let place = system.place(part);
                add_wrench(dg, place, 1.0, &Vec3::zeros(), &T, &Vec3::zeros());
            }
        }
        Ok(())
    }

    /// Adds the change of variables, state rates and GCONs that depend directly on a function. `rate` is the change of the function value.
    fn data_by_function(&self, (function, rate): (usize, f64), dg: &mut [f64]) {
        let system = self.system;
        for (k, row) in system.implicit_variables() {
            if system.variables[k].function == function {
                dg[row] -= rate;
            }
        }
        for equation in &system.states {
            if let (StateRhs::Function(f), Some(row)) = (&equation.rate, equation.unknown)
                && *f == function
            {
                dg[row] += rate;
            }
        }
        for condition in &system.conditions {
            if condition.function == function && !self.is_out(condition) {
                dg[system.first_equation + condition.equation] += rate;
            }
        }
    }

    /// Returns the derivative of a function with respect to one of its numbers, at constant unknowns.
    fn function_by_number(
        &mut self,
        function: usize,
        number: FunctionNumber,
    ) -> Result<f64, NoValue> {
        let compiled = &self.system.functions[function];
        if !self.parameters.theta()[compiled.replacement].is_nan() {
            return Ok(0.0);
        }
        self.evaluate_function(function)?;
        Ok(self.by_number(compiled.program.as_ref(), number))
    }

    /// Returns the value of a parameter. For the parameter that replaces a whole function, returns the function value unless the function
    /// is replaced.
    pub(super) fn number(&mut self, slot: Slot) -> Result<f64, NoValue> {
        let value = self.parameters.get(slot);
        match self.system.catalogue().group(slot).role {
            Role::Override(function) if value.is_nan() => self.value_of(function),
            _ => Ok(value),
        }
    }

    /// Computes the derivative of the residual with respect to one parameter by central differences.
    fn residual_difference(&mut self, slot: Slot, dg: &mut [f64]) -> Result<(), NoValue> {
        /// Step of the difference, relative to the parameter value or to 1.
        const STEP: f64 = 1e-6;
        let (system, state) = (self.system, self.state);
        let here = self.number(slot)?;
        let mut moved = self.parameters.clone();
        let h = STEP * here.abs().max(1.0);
        let mut minus = vec![0.0; dg.len()];
        moved.set(slot, here + h);
        system.residual(&moved, state, self.scratch, dg)?;
        moved.set(slot, here - h);
        system.residual(&moved, state, self.scratch, &mut minus)?;
        for (plus, minus) in dg.iter_mut().zip(&minus) {
            *plus = (*plus - minus) / (2.0 * h);
        }
        self.evaluate()
    }
}

impl System {
    /// Returns all active sources of wrenches that act at a moved marker, are resolved in its axes, or depend on its motion.
    fn acting_with(&self, moved: &[Moved]) -> impl Iterator<Item = Exerted> {
        let moves = |marker: usize| moved.iter().any(|moved| moved.marker == marker);
        let elements = self.elements.iter().enumerate();
        let elements = elements
            .filter(move |(_, e)| e.active && (moves(e.i) || e.frame.is_some_and(moves)))
            .map(|(k, _)| Exerted::Element(k));
        let joints = self.joints.iter().enumerate().filter(|(_, j)| j.active);
        let terms = joints.flat_map(move |(k, joint)| {
            let terms = joint.terms.iter().enumerate();
            terms
                .filter(move |(_, term)| moves(term.i) || moves(term.j))
                .map(move |(at, _)| Exerted::Joint(k, at))
        });
        let multis = self.multis.iter().enumerate();
        let markers = multis
            .filter(move |(_, m)| m.active && (moves(m.j) || m.i.iter().any(|&i| moves(i))))
            .flat_map(|(k, multi)| (0..multi.i.len()).map(move |at| Exerted::Multi(k, at)));
        elements.chain(terms).chain(markers)
    }

    /// Returns whether a component of request `index` of the model may change with a parameter at constant unknowns. This is the case if the function
    /// of the component measures a marker or reads a force, or if the parameter is a literal of the function.
    pub fn request_reads(&self, index: usize, component: usize, slot: Slot) -> bool {
        let role = self.catalogue().group(slot).role;
        let function = self.requests[index].get(component).copied().flatten();
        function.is_some_and(|function| self.function_reads(function, role))
    }

    /// Returns whether a component of request `index` of the model may change with the axes of a marker at constant unknowns.
    pub fn request_reads_marker(&self, index: usize, component: usize, marker: MarkerIx) -> bool {
        let function = self.requests[index].get(component).copied().flatten();
        function.is_some_and(|function| self.function_reads(function, Role::Marker(marker.0)))
    }

    /// Returns whether a parameter moves a marker: the parameter belongs to that marker, or to a marker in whose frame that marker is
    /// defined.
    pub(super) fn moves_marker(&self, role: Role, marker: usize) -> bool {
        matches!(role, Role::Marker(first) if self.carried.moves(first, marker))
    }

    fn function_reads(&self, function: usize, role: Role) -> bool {
        let reads = self.reads();
        let is_own = |read: usize| match role {
            Role::Literals(own) | Role::Override(own) => read == own,
            Role::Spline(spline) => self.function_reads_spline(read, spline),
            _ => false,
        };
        let mut through = reads.through_variables(function, false).into_iter();
        if through.any(is_own) {
            return true;
        }
        let is = |m: &Option<MarkerIx>| m.is_some_and(|m| self.moves_marker(role, m.0));
        reads.any(function, |source| match source {
            Source::Measure(m, _) => [m.i, m.j, m.k].iter().any(is),
            Source::Moved(m) => m.markers.iter().any(is),
            Source::Force(_) | Source::Friction(..) | Source::StateRate(..) => true,
            Source::Time
            | Source::Mode
            | Source::Variable(_)
            | Source::State(_)
            | Source::Output(_)
            | Source::Constant(_)
            | Source::Sensor(_) => false,
        })
    }

    /// Returns whether other functions or states read a function of the equations. Such a function acts on more than the elements it
    /// drives.
    fn passes_on(&self, function: usize) -> bool {
        let reads = self.reads();
        let is_it = |k: usize| reads.explicit(k) == Some(function);
        let drives_states = self.states.iter().any(|state| match &state.rate {
            StateRhs::Linear(_, by_variable) => by_variable.iter().any(|(k, _)| is_it(*k)),
            StateRhs::Function(_) | StateRhs::Held => false,
        });
        let mut order = self.order.iter();
        drives_states || order.any(|&f| reads.of(f).contains(&function))
    }

    /// Returns whether a parameter also acts through functions that measure quantities changed by the parameter. Functions provide no
    /// derivative with respect to such a parameter.
    fn acts_through_functions(&self, role: Role) -> bool {
        let sources = || self.order.iter().flat_map(|&f| &self.functions[f].sources);
        match role {
            Role::Marker(_) => {
                let is = |m: Option<MarkerIx>| m.is_some_and(|m| self.moves_marker(role, m.0));
                sources().any(|source| match source {
                    Source::Measure(m, _) => is(m.i) || is(m.j) || is(m.k),
                    Source::Force(_) => true,
                    _ => false,
                })
            }
            Role::Mass(_) | Role::Gravity => false,
            Role::Law { .. } | Role::Joint { .. } | Role::Multi { .. } => {
                sources().any(|source| matches!(source, Source::Force(_)))
            }
            Role::Literals(function) | Role::Override(function) => {
                self.acts_through_condition(|read| read == function)
            }
            Role::Spline(spline) => {
                let curves = self.parameters.curves();
                let drives_element = self.elements.iter().any(|element| {
                    matches!(&element.action, Action::Law(law, _) if law.reads_spline(curves, spline))
                });
                let is_measured = || sources().any(|source| matches!(source, Source::Force(_)));
                (drives_element && is_measured())
                    || self.acts_through_condition(|read| self.function_reads_spline(read, spline))
            }
        }
    }

    /// Returns whether a GCON reads one of the functions that `is_it` selects. Such a function also changes the direction of the GCON's reaction.
    fn acts_through_condition(&self, is_it: impl Fn(usize) -> bool) -> bool {
        let conditions = self.conditions.iter().map(|c| c.function);
        let mut read = self.reads().components(conditions).into_iter().flatten();
        read.any(is_it)
    }

    /// Returns whether a function itself reads a SPLINE.
    fn function_reads_spline(&self, function: usize, spline: usize) -> bool {
        let program = self.functions[function].program.as_ref();
        program.is_some_and(|program| program.reads_spline(self.parameters.curves(), spline))
    }

    /// Returns the first column after the columns of the unknowns, of their first and second time derivatives, and of the time.
    pub(crate) fn first_seed(&self) -> usize {
        3 * self.moving_unknowns + 1
    }
}

/// Sink that keeps only the Jacobian columns of [`Seed`]s.
pub(crate) struct Seeded {
    pub first: usize,
    pub columns: Vec<Vec<f64>>,
}

impl Sink for Seeded {
    fn add(&mut self, row: usize, column: usize, value: f64) {
        let at = column.checked_sub(self.first);
        if let Some(column) = at.and_then(|at| self.columns.get_mut(at)) {
            column[row] += value;
        }
    }

    fn add_column(&mut self, _: usize, _: usize, _: &[f64]) {
        // Blocks of the unknowns are not needed here.
    }

    fn add_reaction(&mut self, _: usize, _: usize, _: &[f64]) {}
}
