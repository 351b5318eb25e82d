//! The wheel's steer while one load goes up and down: the hysteresis loop of a K&C rig.

use nalgebra::DVector;

use super::diagnose::Outcome;
use crate::identify::global::Row;

/// Fewer cases in a row are no run.
const LEAST: usize = 4;
/// Row of the wheel that holds its steer.
const STEER: usize = 4;

/// Steer against one load, the others standing still.
#[derive(Clone, PartialEq, Debug)]
pub struct WheelRun {
    /// Column of the load.
    pub load: String,
    /// Load and steer in degrees as read, in the order of application.
    pub read: Vec<(f64, f64)>,
    /// The same by the model as it was.
    pub before: Vec<(f64, f64)>,
    /// The same by the extended model.
    pub after: Vec<(f64, f64)>,
    /// True if neither fit has seen these cases.
    pub unseen: bool,
}

impl Outcome<'_> {
    /// For each load the longest run of cases in which it alone changes; of runs that no fit has seen, if there are any.
    pub fn wheel_runs(&self) -> Vec<WheelRun> {
        let programme = self.subject.problem.programme;
        if self.subject.problem.measurement.wheel.is_none() {
            return Vec::new();
        }
        let mut out = Vec::new();
        for (load, of) in programme.loads.iter().enumerate() {
            let unseen = |case: usize| self.unseen.is_some() && self.subject.is_held_out(case);
            let run = [true, false].into_iter().find_map(|hidden| {
                let usable = |case: usize| hidden == unseen(case);
                let run = longest(programme.cases.len(), |a, b| {
                    let (a_values, b_values) =
                        (&programme.cases[a].values, &programme.cases[b].values);
                    let others = |(k, (a, b)): (usize, (&f64, &f64))| k == load || a == b;
                    usable(a) && usable(b) && a_values.iter().zip(b_values).enumerate().all(others)
                });
                let moves = run.clone().any(|case| {
                    programme.cases[case].values[load] != programme.cases[run.start].values[load]
                });
                (run.len() >= LEAST && moves).then_some((run, hidden))
            });
            let Some((run, hidden)) = run else { continue };
            let fits = match &self.unseen {
                Some(unseen) if hidden => unseen.predicted.each_ref().map(|blind| &blind.misfit),
                _ => [&self.baseline.misfit, &self.extended.misfit],
            };
            let points = |misfit: Option<&DVector<f64>>| self.steer(load, run.clone(), misfit);
            out.push(WheelRun {
                load: of.name.clone(),
                read: points(None),
                before: points(Some(fits[0])),
                after: points(Some(fits[1])),
                unseen: hidden,
            });
        }
        out
    }

    fn steer(
        &self,
        load: usize,
        run: std::ops::Range<usize>,
        misfit: Option<&DVector<f64>>,
    ) -> Vec<(f64, f64)> {
        let measurement = self.subject.problem.measurement;
        let sigma = measurement
            .wheel
            .as_ref()
            .map_or(0.0, |w| w.sigma_angle_deg);
        run.filter_map(|case| {
            let reading = measurement.cases[case].wheel?.steer_deg;
            let row = self.subject.rows.iter().position(
                |row| matches!(*row, Row::Wheel { case: of, component: STEER } if of == case),
            )?;
            let off = misfit.map_or(0.0, |misfit| misfit[row] * sigma);
            let value = self.subject.problem.programme.cases[case].values[load];
            Some((value, reading + off))
        })
        .collect()
    }
}

/// The longest run of cases of which each goes with the next.
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
