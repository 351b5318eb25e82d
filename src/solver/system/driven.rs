//! MOTIONs that prescribe a velocity or an acceleration: their displacement, integrated from the stored constants.

use super::NoValue;
use super::structure::{ParameterSource, RateDrive};
use super::{Configuration, Driven, Parameters, Scratch, State, System};
use crate::constraint::{PairConstraint, RelativeCoordinate};

/// Gauss-Legendre nodes and weights on [-1, 1].
const POINTS: [(f64, f64); 5] = [
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683, 0.478_628_670_499_366_47),
    (-0.538_469_310_105_683, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
];
/// Maximum number of successive bisections of an integration interval.
const HALVINGS: usize = 14;
/// Relative tolerance for the difference between the integral over an interval and the sum of the integrals over its halves.
const AGREED: f64 = 1e-13;

impl System {
    /// Returns the active MOTIONs that prescribe a velocity or acceleration.
    pub(crate) fn rate_drives(&self) -> impl Iterator<Item = RateDrive> + '_ {
        self.joints.iter().filter_map(|joint| match joint.drive {
            ParameterSource::Rate(drive) if joint.active => Some(drive),
            _ => None,
        })
    }

    /// Starts the active MOTIONs that prescribe a velocity or acceleration and that were inactive or never started. Each starts at ICDISP
    /// or, without ICDISP, at the present displacement. Inactive MOTIONs are reset.
    pub fn begin_drives(&self, parameters: &Parameters, state: &mut State, scratch: &mut Scratch) {
        for joint in &self.joints {
            let ParameterSource::Rate(drive) = joint.drive else {
                continue;
            };
            if !joint.active {
                state.driven[drive.index].time = f64::NAN;
            } else if state.driven[drive.index].time.is_nan() {
                let mut here = self.at(parameters, state, scratch);
                here.place_markers();
                let mut value = drive.start.unwrap_or(0.0);
                if drive.start.is_none() {
                    for term in &joint.terms {
                        if let PairConstraint::Drive(law) = term.law {
                            let motion = here.motion(term.i, term.j, term.pair, true);
                            value = law.measure.evaluate(&motion, 0.0).value;
                        }
                    }
                }
                state.driven[drive.index] = Driven {
                    time: state.time,
                    value,
                    rate: drive.start_rate,
                };
            }
        }
    }

    /// Sets the reference angles of driven marker pairs to the prescribed values, so that full turns are counted from these values.
    ///
    /// # Errors
    /// Returns [`NoValue`] if a function has no value in this state.
    pub(crate) fn count_from_drives(
        &self,
        parameters: &Parameters,
        state: &mut State,
        scratch: &mut Scratch,
    ) -> Result<(), NoValue> {
        self.at(parameters, state, scratch).evaluate_constraints()?;
        for joint in self.joints.iter().filter(|joint| joint.active) {
            let value = match joint.drive {
                ParameterSource::Function(function) => scratch.functions[function].value,
                ParameterSource::Rate(drive) => scratch.driven[drive.index][0],
                ParameterSource::Theta(_) | ParameterSource::Constant(_) => continue,
            };
            for term in &joint.terms {
                if let PairConstraint::Drive(drive) = term.law {
                    match drive.measure {
                        RelativeCoordinate::Angle(axis) => {
                            state.pair_angles[term.pair][axis] = value;
                        }
                        RelativeCoordinate::Body123(0) => state.pair_angles[term.pair].x = value,
                        RelativeCoordinate::Translation(_)
                        | RelativeCoordinate::Body123(_)
                        | RelativeCoordinate::Pinion => {}
                    }
                }
            }
        }
        Ok(())
    }

    /// Advances the integration constants of the MOTIONs to the time of the state, so that the next integration interval is short.
    ///
    /// # Errors
    /// Returns [`NoValue`] if a function has no value within the interval.
    pub(crate) fn drive_on(
        &self,
        parameters: &Parameters,
        state: &mut State,
        scratch: &mut Scratch,
    ) -> Result<(), NoValue> {
        if state.driven.is_empty() || !state.moves() {
            return Ok(());
        }
        self.at(parameters, state, scratch).drive()?;
        for drive in self.rate_drives() {
            let [value, rate, _] = scratch.driven[drive.index];
            state.driven[drive.index] = Driven {
                time: state.time,
                value,
                rate,
            };
        }
        Ok(())
    }
}

impl Configuration<'_> {
    /// Computes displacement, velocity and acceleration of every MOTION that prescribes a velocity or acceleration, into the scratch. In
    /// statics, the displacement is constant.
    ///
    /// Velocity motion: `s = s0 + integral f`, s' = f, s'' = df/dt. Acceleration motion: `s' = s0' + integral f`, `s = s0 + s0' (t - t0) +
    /// integral (t - tau) f`. The integrals use the five-point Gauss rule. Intervals are bisected until the sum over the halves agrees with
    /// the whole.
    ///
    /// # Errors
    /// Returns [`NoValue`] if a function has no value within the interval.
    pub(crate) fn drive(&mut self) -> Result<(), NoValue> {
        if self.state.driven.is_empty() {
            return Ok(());
        }
        self.scratch
            .driven
            .resize(self.state.driven.len(), [0.0; 3]);
        let system = self.system;
        for drive in system.rate_drives() {
            let from = self.state.driven[drive.index];
            self.scratch.driven[drive.index] = if self.moving() {
                let (value, slope) = self.at_time(drive.function, self.state.time)?;
                let time = self.state.time - from.time;
                let [once, twice] = if time == 0.0 {
                    [0.0; 2]
                } else {
                    self.integral(drive.function, (from.time, self.state.time))?
                };
                if drive.second {
                    [
                        from.value + from.rate * time + twice,
                        from.rate + once,
                        value,
                    ]
                } else {
                    [from.value + once, value, slope]
                }
            } else {
                [from.value, 0.0, 0.0]
            };
        }
        Ok(())
    }

    /// Returns `integral f` and `integral (b - tau) f` over tau in a..b, where f is the function.
    fn integral(&mut self, function: usize, (a, b): (f64, f64)) -> Result<[f64; 2], NoValue> {
        let mut sum = [0.0; 2];
        let mut open = vec![(a, b, self.panel(function, (a, b), b)?, 0)];
        while let Some((from, to, whole, depth)) = open.pop() {
            let middle = 0.5 * (from + to);
            let left = self.panel(function, (from, middle), b)?;
            let right = self.panel(function, (middle, to), b)?;
            let both = [left[0] + right[0], left[1] + right[1]];
            let size = left[2].max(right[2]) * (to - from).abs();
            let apart = (both[0] - whole[0]).abs();
            if apart <= AGREED * size || depth >= HALVINGS {
                sum[0] += both[0];
                sum[1] += both[1];
            } else {
                open.push((from, middle, left, depth + 1));
                open.push((middle, to, right, depth + 1));
            }
        }
        Ok(sum)
    }

    /// Returns the integrals of f and of (end - tau) f over one interval by the Gauss rule, and the largest magnitude of f.
    fn panel(
        &mut self,
        function: usize,
        (from, to): (f64, f64),
        end: f64,
    ) -> Result<[f64; 3], NoValue> {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let mut out = [0.0; 3];
        for (point, weight) in POINTS {
            let time = middle + half * point;
            let (value, _) = self.at_time(function, time)?;
            out[0] += half * weight * value;
            out[1] += half * weight * value * (end - time);
            out[2] = value.abs().max(out[2]);
        }
        Ok(out)
    }

    /// Returns the value and derivative of a function of time alone at `time`. Other functions are rejected when the model is compiled.
    fn at_time(&mut self, number: usize, time: f64) -> Result<(f64, f64), NoValue> {
        let found = self.in_time(number, time, false)?.unwrap_or_default();
        Ok((found.value, found.slope))
    }
}
