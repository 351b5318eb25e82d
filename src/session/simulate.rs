use super::moment::Moment;
use admire_syntax::Statement;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Source, Span};

/// Maximum number of output steps of one SIMULATE command. Without a limit, a typing error might fill the disk.
const MOST_STEPS: f64 = 100_000.0;

/// Analysis that a SIMULATE command requests.
#[derive(Clone, PartialEq, Debug)]
pub(super) enum Analysis {
    /// A static solution: one equilibrium at the current time.
    Static,
    /// A quasi-static simulation: equilibria at these output times.
    QuasiStatic(OutputTimes),
    /// A kinematic simulation of a system without degrees of freedom: positions at these output times.
    Kinematic(OutputTimes),
    /// A dynamic simulation, with output at these times.
    Dynamic(OutputTimes),
    /// A kinematic simulation if the system has no degrees of freedom, a dynamic simulation otherwise.
    Transient(OutputTimes),
    /// An initial-conditions analysis, up to this phase.
    InitialConditions(Phases),
}

/// Last phase of an initial-conditions analysis.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum Phases {
    /// Positions only.
    Displacement,
    /// Positions and velocities.
    Velocity,
    /// Positions, velocities, accelerations and forces.
    All,
}

/// Kind of simulation over time that a SIMULATE command requests.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub(super) enum RequestedAnalysis {
    Kinematic,
    Dynamic,
    /// A kinematic simulation if the system has no degrees of freedom, a dynamic simulation otherwise.
    Transient,
}

/// Output times of a simulation: the start, and `count` further times up to the end.
#[derive(Clone, Copy, PartialEq, Debug)]
pub(super) struct OutputTimes {
    /// Start of the simulation, which is the current time.
    pub start: f64,
    /// End of the simulation, which is the time of the last output.
    pub end: f64,
    /// Number of output times after the start.
    pub count: usize,
    /// Time between two outputs, if DTOUT gives it. The last interval may be shorter.
    pub interval: Option<f64>,
}

impl OutputTimes {
    /// Returns output time number k, from 1 to `count`: `t0 + k (end - t0) / count`, or `t0 + k DTOUT` (guide/formats.md 5.3).
    pub(crate) fn at(&self, k: usize) -> f64 {
        if k >= self.count {
            return self.end;
        }
        match self.interval {
            Some(interval) => self.start + k as f64 * interval,
            None => self.start + k as f64 * (self.end - self.start) / self.count as f64,
        }
    }
}

impl OutputTimes {
    /// Returns the progress of the simulation at an output time.
    pub(crate) fn moment(&self, time: f64, step: f64) -> Moment {
        Moment {
            time,
            start: self.start,
            end: self.end,
            step,
        }
    }

    /// Returns output times at intervals of `dt` from `now` to the same end; `None` if there would be too many.
    pub(crate) fn every(&self, dt: f64, now: f64) -> Option<Self> {
        // The tolerance absorbs round-off if the interval divides the span exactly.
        let count = ((self.end - now) / dt - 1e-9).ceil().max(1.0);
        (count <= MOST_STEPS).then_some(Self {
            start: now,
            end: self.end,
            count: count as usize,
            interval: Some(dt),
        })
    }
}

impl Analysis {
    /// Parses a SIMULATE command that is given at time `now`.
    ///
    /// # Errors
    /// Returns a diagnostic located at the wrong argument.
    pub(crate) fn of(command: &Statement, source: &Source, now: f64) -> Result<Self, Diagnostic> {
        let times = || output_times(command, source, now);
        let timed = ["END", "DURATION", "STEPS", "DTOUT"]
            .iter()
            .any(|name| command.has(name));
        let typed = command
            .argument("TYPE")
            .map(|argument| argument.choices(source))
            .unwrap_or_default();
        let asks = |name: &str| command.has(name) || typed.contains(&name);
        if asks("STATICS") {
            return Ok(if timed {
                Self::QuasiStatic(times()?)
            } else {
                Self::Static
            });
        }
        if asks("KINEMATICS") {
            return Ok(Self::Kinematic(times()?));
        }
        if asks("TRANSIENT") {
            return Ok(Self::Transient(times()?));
        }
        if asks("INITIAL_CONDITIONS") {
            let asks = |name: &str| command.has(name);
            return Ok(Self::InitialConditions(if asks("DISPLACEMENT") {
                Phases::Displacement
            } else if asks("VELOCITY") {
                Phases::Velocity
            } else {
                Phases::All
            }));
        }
        if asks("DYNAMICS") {
            return Ok(Self::Dynamic(times()?));
        }
        Err(at(
            source,
            command.span,
            Diagnostic::error(Code::MissingArgument, "SIMULATE names no analysis"),
        )
        .help("for example SIMULATE/STATICS"))
    }
}

/// Returns the error for a sensor whose DT would give too many output steps.
pub(super) fn too_many(dt: f64) -> Diagnostic {
    Diagnostic::error(
        Code::LimitExceeded,
        format!("DT = {dt} of a sensor gives too many output steps"),
    )
}

fn at(source: &Source, span: Span, diagnostic: Diagnostic) -> Diagnostic {
    diagnostic.label(source.name(), span, "")
}

fn output_times(command: &Statement, source: &Source, now: f64) -> Result<OutputTimes, Diagnostic> {
    let given = |name: &str| {
        command
            .argument(name)
            .and_then(|argument| Some((argument.numbers().first()?.value, argument.span)))
    };
    let wrong = |span: Span, message: String| {
        Err(at(
            source,
            span,
            Diagnostic::error(Code::OutOfRange, message),
        ))
    };
    let (end, end_span) = match (given("END"), given("DURATION")) {
        (Some(end), None) => end,
        (None, Some((duration, span))) => (now + duration, span),
        (Some(_), Some((_, span))) => {
            return wrong(span, "END and DURATION exclude each other".into());
        }
        (None, None) => {
            return Err(at(
                source,
                command.span,
                Diagnostic::error(
                    Code::MissingArgument,
                    "the simulation has no END or DURATION",
                ),
            ));
        }
    };
    if !(end > now && end.is_finite()) {
        return wrong(
            end_span,
            format!("the simulation would end at time {end}, but the time is already {now}"),
        );
    }
    let (count, interval, span) = match (given("STEPS"), given("DTOUT")) {
        (Some((steps, span)), None) => {
            if steps < 1.0 {
                return wrong(span, format!("STEPS must be at least 1, not {steps}"));
            }
            (steps.floor(), None, span)
        }
        (None, Some((interval, span))) => {
            if !(interval > 0.0 && interval.is_finite()) {
                return wrong(span, format!("DTOUT must be above zero, not {interval}"));
            }
            // The tolerance absorbs round-off if the interval divides the span exactly.
            let count = ((end - now) / interval - 1e-9).ceil().max(1.0);
            (count, Some(interval), span)
        }
        (None, None) => (1.0, None, command.span),
        (Some(_), Some((_, span))) => {
            return wrong(span, "STEPS and DTOUT exclude each other".into());
        }
    };
    if count > MOST_STEPS {
        return Err(at(
            source,
            span,
            Diagnostic::error(
                Code::LimitExceeded,
                format!("{count} output steps are requested; the limit is {MOST_STEPS}"),
            ),
        )
        .help("split the simulation into several commands if this is intended"));
    }
    Ok(OutputTimes {
        start: now,
        end,
        count: count as usize,
        interval,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_end_at_the_end() {
        let by_steps = OutputTimes {
            start: 1.0,
            end: 2.0,
            count: 4,
            interval: None,
        };
        let times: Vec<f64> = (1..=4).map(|k| by_steps.at(k)).collect();
        assert_eq!(times, [1.25, 1.5, 1.75, 2.0]);
        let by_interval = OutputTimes {
            start: 0.0,
            end: 1.0,
            count: 3,
            interval: Some(0.4),
        };
        let times: Vec<f64> = (1..=3).map(|k| by_interval.at(k)).collect();
        assert_eq!(times, [0.4, 0.8, 1.0]);
    }
}
