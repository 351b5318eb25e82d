//! Joint friction: the friction wrench on the parts, computed from the motion and the reaction of a joint. The creep carries over from time
//! step to time step.
//!
//! In statics, only frictions enabled by `creeping` act.
//!
//! Each sliding direction k is a translation along zj, or a rotation about an axis of I or J with the radius as lever arm: `f_k = lever
//! (mu_k N + T0/radius sigma_k)`. `element::FrictionLaw` gives the coefficient mu and the preload direction sigma from surface velocities
//! and creeps. The normal load N follows from the reaction of the joint on I, and T0 is the torque preload. The derivatives with respect to
//! positions, velocities and multipliers are exact.
//!
//! The creep is the integral of the surface velocity since sticking started. Within a time step, the creep changes by the displacement, or
//! the rotation vector, since the end of the last step. The creep therefore needs neither an unknown nor a tolerance of its own.

use super::compiled_function::Exerted;
use super::contribution::{FunctionValue, Of, WrenchEnds};
use super::forces::DerivativeRequest;
use super::surface::{JointFriction, SLOTS, Slide};
use super::{Configuration, NoValue, Parameters, Scratch, State, StictionState, System};
use crate::element::{Coefficient, FrictionLaw};
use crate::function::{RateAxis, RateKind, RateMeasure};
use crate::linear::Sink;
use crate::mechanics::{Mat3, Vec3, Vec6, log, turning_rate};
use crate::model::MarkerIx;

/// Wrench, coefficients, surface velocities and creeps of a FRICTION. Vectors are in the axes of I, except force and torque.
#[derive(Clone, Copy, PartialEq, Debug, Default)]
pub struct FrictionReading {
    /// Force on I at its origin, ground axes.
    pub force: Vec3,
    /// Torque on I, ground axes.
    pub torque: Vec3,
    /// Friction coefficient of the translational sliding.
    pub mu: Vec3,
    /// Friction coefficient of the rotational sliding.
    pub mu_turn: Vec3,
    /// Coefficient mu_1 of the creep term.
    pub mu_1: f64,
    /// Surface velocity of the translational sliding.
    pub velocity: Vec3,
    /// Surface velocity of the rotational sliding.
    pub turn_velocity: Vec3,
    /// Creep of the translational sliding.
    pub creep: Vec3,
    /// Creep of the rotational sliding, as a length on the surface.
    pub turn_creep: Vec3,
    /// Weight beta of the velocity term.
    pub beta: f64,
}

/// Index range (first, end) in `Scratch::gradient`.
type Span = (usize, usize);

/// Velocities, creeps and normal load of a friction, with the index ranges of their gradients.
pub(super) struct Sliding {
    pub v: Vec3,
    pub c: Vec3,
    load: f64,
    pub v_spans: [Span; 3],
    pub c_spans: [Span; 3],
    load_span: Span,
}

impl System {
    /// Returns whether any friction is active.
    pub(crate) fn has_friction(&self) -> bool {
        self.frictions.iter().any(|f| f.active)
    }

    /// Computes the surface speed minus the stiction velocity for every friction that can stick, and NaN for all other frictions.
    pub(crate) fn slips(
        &self,
        parameters: &Parameters,
        state: &State,
        scratch: &mut Scratch,
        slips: &mut Vec<f64>,
    ) {
        slips.clear();
        let mut here = self.at(parameters, state, scratch);
        here.place_markers();
        for friction in &self.frictions {
            let counts = friction.active && friction.sticks;
            slips.push(if counts {
                here.surface_velocity(friction).norm() - friction.law.stiction_velocity
            } else {
                f64::NAN
            });
        }
    }

    /// Updates the creeps to the state at the end of a time step. Each friction then sticks or slides according to its speed in that state.
    pub(crate) fn advance_stiction(
        &self,
        parameters: &Parameters,
        state: &mut State,
        scratch: &mut Scratch,
    ) {
        if self.frictions.is_empty() {
            return;
        }
        let mut grips = std::mem::take(&mut state.grips);
        self.at(parameters, state, scratch).place_markers();
        for (friction, grip) in self.frictions.iter().zip(&mut grips) {
            let here = self.at(parameters, state, scratch);
            let creep = here.creep(friction, grip);
            let (place, turn) = here.joint_place(friction);
            let speed = here.surface_velocity(friction).norm();
            let sticking = friction.active && friction.sticks && friction.law.sticks(speed);
            let on = sticking && grip.sticking;
            *grip = StictionState {
                sticking,
                creep: if on { creep } else { Vec3::zeros() },
                place,
                turn,
                first: grip.first.or(Some(place)),
            };
        }
        state.grips = grips;
    }
}

impl Configuration<'_> {
    /// Returns the displacement of the origin of I along zj and the rotation matrix of I in J.
    pub(super) fn joint_place(&self, friction: &JointFriction) -> (f64, Mat3) {
        let motion = self.motion(friction.i, friction.j, friction.pair, false);
        (motion.p_ij_j.z, motion.R_ji)
    }

    /// Returns the surface velocity, one component per sliding direction.
    fn surface_velocity(&self, friction: &JointFriction) -> Vec3 {
        let rates = if self.moving() {
            self.relative_rates(friction.i, friction.j)
        } else {
            Vec6::zeros()
        };
        let (_, R_ji) = self.joint_place(friction);
        let w = Vec3::new(rates[3], rates[4], rates[5]);
        let mut v = Vec3::zeros();
        for (k, &slide) in friction.slides.iter().enumerate() {
            v[k] = friction.lever(slide)
                * match slide {
                    Slide::AlongZ => rates[2],
                    Slide::AboutI(axis) => R_ji.column(axis).dot(&w),
                    Slide::AboutJ(axis) => w[axis],
                };
        }
        v
    }

    /// Returns the rotation vector of I in J since the anchor (the end of the last time step), in J axes.
    fn turned(&self, friction: &JointFriction, grip: &StictionState) -> Vec3 {
        let (_, R_ji) = self.joint_place(friction);
        log(&(R_ji * grip.turn.transpose()))
    }

    /// Returns the axis of a rotational sliding direction at the anchor (the end of the last time step), in J axes.
    fn axis(slide: Slide, grip: &StictionState) -> Vec3 {
        match slide {
            Slide::AlongZ => Vec3::z(),
            Slide::AboutI(axis) => grip.turn.column(axis).into(),
            Slide::AboutJ(axis) => Vec3::ith(axis, 1.0),
        }
    }

    /// Returns the creep, one component per sliding direction; zero unless the friction sticks.
    pub(super) fn creep(&self, friction: &JointFriction, grip: &StictionState) -> Vec3 {
        if !grip.sticking {
            return Vec3::zeros();
        }
        let turned = self.turned(friction, grip);
        let (place, _) = self.joint_place(friction);
        let mut c = grip.creep;
        for (k, &slide) in friction.slides.iter().enumerate() {
            c[k] += match slide {
                Slide::AlongZ => place - grip.place,
                _ => friction.radius * Self::axis(slide, grip).dot(&turned),
            };
        }
        c
    }

    fn span_from(&self, first: usize) -> Span {
        (first, self.scratch.gradient.len())
    }

    /// Computes the motion of the surfaces and the normal load. With `tangent`, their gradients are appended, always with the same sparsity
    /// pattern.
    pub(super) fn sliding(&mut self, number: usize, tangent: bool) -> Result<Sliding, NoValue> {
        let friction = &self.system.frictions[number];
        let grip = self.state.grips[number];
        let mut out = Sliding {
            v: self.surface_velocity(friction),
            c: self.creep(friction, &grip),
            load: 0.0,
            v_spans: [(0, 0); 3],
            c_spans: [(0, 0); 3],
            load_span: (0, 0),
        };
        if tangent {
            let (i, j) = (Some(MarkerIx(friction.i)), Some(MarkerIx(friction.j)));
            let turned = self.turned(friction, &grip);
            let (pose_i, pose_j) = (
                self.scratch.markers[friction.i],
                self.scratch.markers[friction.j],
            );
            let on = f64::from(u8::from(grip.sticking));
            for (k, &slide) in friction.slides.iter().enumerate() {
                let first = self.scratch.gradient.len();
                let (kind, axis, frame) = match slide {
                    Slide::AlongZ => (RateKind::Velocity, 2, j),
                    Slide::AboutI(axis) => (RateKind::AngularVelocity, axis, i),
                    Slide::AboutJ(axis) => (RateKind::AngularVelocity, axis, j),
                };
                self.moved(&RateMeasure {
                    kind,
                    axis: RateAxis::Axis(axis),
                    markers: [i, j, frame, j],
                });
                let lever = friction.lever(slide);
                for (_, by) in &mut self.scratch.gradient[first..] {
                    *by *= lever;
                }
                out.v_spans[k] = self.span_from(first);
                let first = self.scratch.gradient.len();
                let (by_i, by_j) = if slide == Slide::AlongZ {
                    let z: Vec3 = pose_j.R.column(2).into();
                    let turn = z.cross(&(pose_i.p - pose_j.p));
                    (
                        Vec6::new(z.x, z.y, z.z, 0.0, 0.0, 0.0),
                        Vec6::new(-z.x, -z.y, -z.z, turn.x, turn.y, turn.z),
                    )
                } else {
                    let by = turning_rate(&turned).transpose() * Self::axis(slide, &grip);
                    let by = pose_j.R * by * lever;
                    let by = Vec6::new(0.0, 0.0, 0.0, by.x, by.y, by.z);
                    (by, -by)
                };
                self.push_motion(friction.i, &(by_i * on));
                self.push_motion(friction.j, &(by_j * on));
                out.c_spans[k] = self.span_from(first);
            }
        }
        let first = self.scratch.gradient.len();
        out.load = self.normal_load(number, tangent)?;
        out.load_span = self.span_from(first);
        Ok(out)
    }

    /// Computes the normal load N and appends its gradient. N is the preload plus factors times components of the joint reaction on I.
    ///
    /// With a the axis, the force has the components `F_a = a . F` and `F_r = |F - a F_a|`. The moment is split in the same way. A zero
    /// component has zero slope.
    fn normal_load(&mut self, number: usize, tangent: bool) -> Result<f64, NoValue> {
        let friction = &self.system.frictions[number];
        let of = friction.pressing;
        let who = Exerted::Joint(friction.joint, 0);
        self.contribute(who, DerivativeRequest::Value)?;
        let (F, T) = (self.scratch.contribution.F, self.scratch.contribution.T);
        let direction = |x: Vec3| x.try_normalize(f64::MIN_POSITIVE).unwrap_or_default();
        let frame = friction.frame();
        let column = match friction.slides.first() {
            Some(Slide::AboutI(axis) | Slide::AboutJ(axis)) => *axis,
            _ => 2,
        };
        let a: Vec3 = self.scratch.markers[frame].R.column(column).into();
        let (mut weight, mut by_turn, mut by_place) = ([Vec3::zeros(); 2], Vec3::zeros(), 0.0);
        let mut load = of.preload;
        if of.ball {
            load += of.across * F.norm();
            weight[0] = direction(F) * of.across;
        } else {
            let (bending, by_overlap) = match of.overlap {
                None => (of.bending, 0.0),
                Some((start, delta)) => {
                    let (place, _) = self.joint_place(friction);
                    // Before the first assembly, there is no displacement.
                    let first = self.state.grips[number].first;
                    let delta = first.map_or(0.0, |_| delta);
                    let moved = delta * (place - first.unwrap_or(place));
                    let least = start * LEAST_OVERLAP;
                    let x = (start + moved).max(least);
                    let slope = if start + moved > least { delta } else { 0.0 };
                    (of.bending / x, -of.bending * slope / (x * x))
                }
            };
            for (half, along, across, x) in
                [(0, of.along, of.across, F), (1, of.torsion, bending, T)]
            {
                let x_a = a.dot(&x);
                let e = direction(x - a * x_a);
                let x_r = e.dot(&x);
                load += along * x_a.abs() + across * x_r;
                let sign = if x_a == 0.0 { 0.0 } else { x_a.signum() };
                weight[half] = a * (along * sign) + e * across;
                by_turn += a.cross(&x) * (along * sign) - a.cross(&e) * (across * x_a);
                if half == 1 {
                    by_place = by_overlap * x_r;
                }
            }
        }
        if tangent {
            let [f, t] = weight;
            let weight = Vec6::new(f.x, f.y, f.z, t.x, t.y, t.z);
            self.push_force(who, false, &weight)?;
            let turn = Vec6::new(0.0, 0.0, 0.0, by_turn.x, by_turn.y, by_turn.z);
            self.push_motion(frame, &turn);
            if of.overlap.is_some() {
                let (i, j) = (friction.i, friction.j);
                let (pose_i, pose_j) = (self.scratch.markers[i], self.scratch.markers[j]);
                let z = pose_j.R.column(2) * by_place;
                let turn = z.cross(&(pose_i.p - pose_j.p));
                self.push_motion(i, &Vec6::new(z.x, z.y, z.z, 0.0, 0.0, 0.0));
                self.push_motion(j, &Vec6::new(-z.x, -z.y, -z.z, turn.x, turn.y, turn.z));
            }
        }
        Ok(load)
    }

    /// Computes the wrench of a friction into `scratch.contribution`. An inactive friction gives a zero wrench with the same sparsity
    /// pattern.
    pub(super) fn friction(
        &mut self,
        number: usize,
        ask: DerivativeRequest,
    ) -> Result<(), NoValue> {
        let system = self.system;
        let friction = &system.frictions[number];
        let tangent = ask == DerivativeRequest::Tangent;
        let sliding = self.sliding(number, tangent)?;
        let (mu, sigma) = coefficients(self.law(friction), &sliding);
        let on = f64::from(u8::from(friction.active));
        let mut w = Vec6::zeros();
        let slots = system.functions.len() + SLOTS * number;
        for (k, &slide) in friction.slides.iter().enumerate() {
            let lever = friction.lever(slide);
            let preload = if slide == Slide::AlongZ {
                0.0
            } else {
                friction.torque_preload
            };
            let value = on * (lever * mu.value[k] * sliding.load + preload * sigma.value[k]);
            w += JointFriction::unit(slide) * value;
            if !tangent {
                continue;
            }
            let gradient = &mut self.scratch.gradient;
            let first = gradient.len();
            let mut push = |(from, to): Span, factor: f64| {
                for at in from..to {
                    let (unknown, by) = gradient[at];
                    gradient.push((unknown, on * factor * by));
                }
            };
            for m in 0..friction.slides.len() {
                let force = lever * sliding.load;
                let by_v = force * mu.by_velocity[(k, m)] + preload * sigma.by_velocity[(k, m)];
                let by_c = force * mu.by_creep[(k, m)] + preload * sigma.by_creep[(k, m)];
                push(sliding.v_spans[m], by_v);
                push(sliding.c_spans[m], by_c);
            }
            push(sliding.load_span, lever * mu.value[k]);
            self.scratch.functions[slots + k] = FunctionValue {
                value,
                first,
                last: self.scratch.gradient.len(),
            };
        }
        let ends = WrenchEnds {
            i: friction.i,
            j: friction.j,
            pair: friction.pair,
            frame: Some(friction.frame()),
            reaction: Some(system.owners[friction.j]),
        };
        self.init_contribution(ends, w);
        if tangent {
            for (k, &slide) in friction.slides.iter().enumerate() {
                let of = Of::Function(slots + k);
                let unit = JointFriction::unit(slide);
                self.scratch.contribution.push_scalar(of, &unit);
            }
        }
        Ok(())
    }

    /// Returns the friction law that applies: in statics the law at rest, if there is one; otherwise the law of motion.
    fn law<'a>(&self, friction: &'a JointFriction) -> &'a FrictionLaw {
        let at_rest = friction.at_rest.as_ref().filter(|_| !self.moving());
        at_rest.unwrap_or(&friction.law)
    }

    /// Adds all frictions to the balances; in statics only the frictions with a law at rest.
    pub(super) fn add_frictions<S: Sink>(
        &mut self,
        g: &mut [f64],
        sink: &mut S,
    ) -> Result<(), NoValue> {
        let ask = if S::NEEDS_ENTRIES {
            DerivativeRequest::Tangent
        } else {
            DerivativeRequest::Value
        };
        for number in 0..self.system.frictions.len() {
            let friction = &self.system.frictions[number];
            if !friction.active || !(self.moving() || friction.at_rest.is_some()) {
                continue;
            }
            let first = self.scratch.gradient.len();
            self.friction(number, ask)?;
            self.add(g, sink);
            self.scratch.gradient.truncate(first);
        }
        Ok(())
    }

    /// Returns the values of a FRICTION in motion, summed over its yokes; zero in statics. [`Configuration::evaluate`] must have been
    /// called.
    ///
    /// # Errors
    /// Returns [`NoValue`] if the friction is undefined in this configuration.
    pub fn read_friction(&mut self, id: u32) -> Result<FrictionReading, NoValue> {
        let system = self.system;
        let mut out = FrictionReading::default();
        if !self.moving() || self.state.grips.len() != system.frictions.len() {
            return Ok(out);
        }
        for (number, friction) in system.frictions.iter().enumerate() {
            if friction.name.id != id || !friction.active {
                continue;
            }
            let sliding = self.sliding(number, false)?;
            let (mu, _) = coefficients(&friction.law, &sliding);
            self.friction(number, DerivativeRequest::Value)?;
            out.force += self.scratch.contribution.F;
            out.torque += self.scratch.contribution.T;
            let (_, R_ji) = self.joint_place(friction);
            for (k, &slide) in friction.slides.iter().enumerate() {
                let axis: Vec3 = match slide {
                    Slide::AlongZ => R_ji.row(2).transpose(),
                    Slide::AboutI(axis) => Vec3::ith(axis, 1.0),
                    Slide::AboutJ(axis) => R_ji.row(axis).transpose(),
                };
                let all = (mu.value[k], sliding.v[k], sliding.c[k]);
                let to = if slide == Slide::AlongZ {
                    [&mut out.mu, &mut out.velocity, &mut out.creep]
                } else {
                    [
                        &mut out.mu_turn,
                        &mut out.turn_velocity,
                        &mut out.turn_creep,
                    ]
                };
                for (to, value) in to.into_iter().zip([all.0, all.1, all.2]) {
                    *to += axis * value;
                }
            }
            out.mu_1 = out.mu_1.max(mu.mu_1);
            out.beta = out.beta.max(mu.beta);
        }
        Ok(out)
    }
}

/// Lower bound of the overlap, relative to the initial overlap.
const LEAST_OVERLAP: f64 = 1e-3;

/// Returns the coefficient mu, which multiplies the normal load, and the direction sigma, which multiplies the preload without a
/// coefficient.
pub(super) fn coefficients(law: &FrictionLaw, sliding: &Sliding) -> (Coefficient, Coefficient) {
    (
        law.coefficient(&sliding.v, &sliding.c),
        law.direction().coefficient(&sliding.v, &sliding.c),
    )
}
