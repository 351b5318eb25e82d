//! Wheel and sensor readings while one load increases and decreases: the hysteresis loops of a K&C rig.

use super::diagnose::Outcome;
use crate::settings::{RUN_MAX_CHANNELS, RUN_MIN_CASES};
use admire_identify::global::Row;

/// Angles of the wheel, each with its component index in a wheel row.
const ANGLES: [(&str, usize); 2] = [("steer", 4), ("camber", 3)];

/// Readings and predictions along a run of successive cases in which only one load changes.
#[derive(Clone, PartialEq, Debug)]
pub struct WheelRun {
    /// Name of the load.
    pub load: String,
    /// Name of the reading: `steer` or `camber` of the wheel, or a channel.
    pub what: String,
    /// Unit of the reading, if it has one.
    pub unit: Option<String>,
    /// Measurement: pairs of load and reading, in the order of application.
    pub read: Vec<(f64, f64)>,
    /// Original model: pairs of load and prediction.
    pub before: Vec<(f64, f64)>,
    /// Extended model: pairs of load and prediction.
    pub after: Vec<(f64, f64)>,
    /// True if the predictions come from models that were not fitted to these readings.
    pub unseen: bool,
}

/// Kind of reading along a run.
#[derive(Clone, Copy)]
enum Read {
    /// Wheel angle, given by its component index in a wheel row.
    Wheel(usize),
    /// Channel, given by its index.
    Channel(usize),
}

impl Outcome<'_> {
    /// Returns, for each load, the readings along the longest run of cases in which only that load changes. A run of held-out cases is
    /// preferred if it is long enough. Within a load, the wheel angles come first, then the channels.
    pub fn wheel_runs(&self) -> Vec<WheelRun> {
        let (programme, measurement) = (
            self.subject.problem.programme,
            self.subject.problem.measurement,
        );
        let mut reads: Vec<(String, Option<String>, Read)> = Vec::new();
        if measurement.wheel.is_some() {
            let angle = |(name, row): (&str, usize)| {
                (name.to_string(), Some("deg".to_string()), Read::Wheel(row))
            };
            reads.extend(ANGLES.map(angle));
        }
        let channels = measurement.channels.iter().enumerate();
        let by_case = channels.filter(|(_, channel)| channel.is_read_by_case());
        reads.extend(by_case.take(RUN_MAX_CHANNELS).map(|(k, channel)| {
            let unit = channel.unit.clone();
            (channel.name.clone(), unit, Read::Channel(k))
        }));
        let mut out = Vec::new();
        for (load, of) in programme.loads.iter().enumerate() {
            let unseen = |case: usize| self.unseen.is_some() && self.subject.is_held_out(case);
            let run = [true, false].into_iter().find_map(|hidden| {
                let usable = |case: usize| !hidden || unseen(case);
                let run = longest(programme.cases.len(), |a, b| {
                    let (a_values, b_values) =
                        (&programme.cases[a].values, &programme.cases[b].values);
                    let others = |(k, (a, b)): (usize, (&f64, &f64))| k == load || a == b;
                    usable(a) && usable(b) && a_values.iter().zip(b_values).enumerate().all(others)
                });
                let moves = run.clone().any(|case| {
                    programme.cases[case].values[load] != programme.cases[run.start].values[load]
                });
                (run.len() >= RUN_MIN_CASES && moves).then_some((run, hidden))
            });
            let Some((run, hidden)) = run else { continue };
            for (what, unit, read) in &reads {
                let held = match read {
                    Read::Channel(k) => measurement.channels[*k].held_out,
                    Read::Wheel(_) => false,
                };
                let fits = match &self.unseen {
                    Some(unseen) if hidden || held => {
                        unseen.predicted.each_ref().map(|blind| &blind.misfit)
                    }
                    _ => [&self.baseline.residual, &self.extended.residual],
                };
                let points: Vec<[(f64, f64); 3]> = run
                    .clone()
                    .filter_map(|case| {
                        let (row, reading, sigma) = self.row(*read, case)?;
                        let value = programme.cases[case].values[load];
                        let by = |off: f64| (value, reading + off * sigma);
                        Some([by(0.0), by(fits[0][row]), by(fits[1][row])])
                    })
                    .collect();
                if points.len() < RUN_MIN_CASES {
                    continue;
                }
                let [read, before, after] =
                    [0, 1, 2].map(|k| points.iter().map(|point| point[k]).collect());
                out.push(WheelRun {
                    load: of.name.clone(),
                    what: what.clone(),
                    unit: unit.clone(),
                    read,
                    before,
                    after,
                    unseen: self.unseen.is_some() && (hidden || held),
                });
            }
        }
        out
    }

    /// Returns the residual row of a reading in a case, the value of the reading, and the standard deviation that is the unit of the row.
    fn row(&self, read: Read, case: usize) -> Option<(usize, f64, f64)> {
        let measurement = self.subject.problem.measurement;
        let of = &measurement.cases[case];
        let (reading, sigma) = match read {
            Read::Wheel(component) => {
                let wheel = of.wheel?;
                let angle = [wheel.camber_deg, wheel.steer_deg][component - 3];
                (angle, measurement.wheel.as_ref()?.sigma_angle_deg)
            }
            Read::Channel(channel) => (of.channels[channel]?, measurement.channels[channel].sigma),
        };
        let row = self
            .subject
            .rows
            .iter()
            .position(|row| match (*row, read) {
                (
                    Row::Wheel {
                        case: of,
                        component,
                    },
                    Read::Wheel(own),
                ) => of == case && component == own,
                (Row::Channel { case: of, channel }, Read::Channel(own)) => {
                    of == case && channel == own
                }
                _ => false,
            })?;
        Some((row, reading, sigma))
    }
}

/// Returns the longest range of cases in which `together` holds for every pair of successive cases.
fn longest(count: usize, together: impl Fn(usize, usize) -> bool) -> std::ops::Range<usize> {
    let (mut best, mut start) = (0..0, 0);
    for end in 1..=count {
        if end == count || !together(end - 1, end) {
            if end - start > best.len() {
                best = start..end;
            }
            start = end;
        }
    }
    best
}
