//! Goals: the samples of the tests that each goal reads, and the misses of its values.

use crate::settings::LIMIT_SLACK;
use admire_kc::{
    Branch, Config, Convention, KcRun, Reading, Sample, TestRun, driven_unit, has_reading_change,
    reading_change, shown, slope,
};
use admire_study::{GoalScope, GoalSettings, Table, TargetSettings, Wanted, did_you_mean};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::Source;
use admire_syntax::units::Units;

/// Contribution of the misses of a goal to the cost.
#[derive(Clone, Copy, PartialEq, Eq, Debug)]
pub enum GoalKind {
    /// Half the mean square of the misses, in units of the tolerance, is part of the cost.
    Squares,
    /// Half the square of the largest miss is part of the cost.
    Minimax,
    /// No miss is allowed.
    Limit,
}

/// A goal with its names resolved. Numbers are in the units of `curves.csv` and `gradients.csv`, in the axes of Adams/Car.
#[derive(Clone, PartialEq, Debug)]
pub struct Goal {
    /// Name of the test; `ride` for ride height.
    pub test: String,
    /// Characteristic, such as `toe_angle.left`.
    pub of: String,
    /// Part of the characteristic.
    pub scope: GoalScope,
    /// Contribution of the misses to the cost.
    pub kind: GoalKind,
    /// Unit of values, tolerance and misses.
    pub unit: String,
    /// Unit of the test's variable; empty at ride height.
    pub at_unit: String,
    /// Unit of the misses, and largest miss with which the goal is met.
    pub tolerance: f64,
    /// Values that are compared.
    pub rows: Vec<Row>,
    /// True if the derivatives of the values are exact; otherwise they are differences.
    pub is_exact: bool,
    /// Factor of the goal in the cost; 1 unless a Pareto front is sought.
    pub weight: f64,
}

/// One value that a goal compares: a linear combination of samples.
#[derive(Clone, PartialEq, Debug)]
pub struct Row {
    /// Value of the test's variable; 0 for a gradient and at ride height.
    pub at: f64,
    /// Smallest and largest wanted value. They are equal unless the goal is a limit.
    pub wanted: [f64; 2],
    /// Samples of the combination, each with its factor. A sample is given by the index of its test in the run and its index in the test. `None`
    /// stands for ride height.
    parts: Vec<(Option<(usize, usize)>, f64)>,
}

impl Goal {
    /// Returns the name: the test, the characteristic, and the part of the characteristic unless it is a whole curve.
    pub fn name(&self) -> String {
        let part = match self.scope {
            GoalScope::Curve => "",
            GoalScope::Value => ", value",
            GoalScope::Gradient => ", gradient",
        };
        let limits = if self.kind == GoalKind::Limit {
            ", limits"
        } else {
            ""
        };
        format!("{} {}{part}{limits}", self.test, self.of)
    }

    /// Returns the miss up to which the goal is met, in its unit.
    pub(crate) fn allowed(&self) -> f64 {
        match self.kind {
            GoalKind::Limit => LIMIT_SLACK * self.tolerance,
            GoalKind::Squares | GoalKind::Minimax => self.tolerance,
        }
    }
}

impl Row {
    /// Returns the miss of a value: positive above the wanted range, negative below it, and zero within it.
    pub fn miss(&self, value: f64) -> f64 {
        let [least, most] = self.wanted;
        if value < least {
            value - least
        } else if value > most {
            value - most
        } else if value.is_nan() {
            f64::NAN
        } else {
            0.0
        }
    }

    /// Returns the largest size of a miss over all values that are off by `widening` at most, to both sides.
    pub(crate) fn reach(&self, value: f64, widening: f64) -> f64 {
        let [least, most] = self.wanted;
        let beyond = (value + widening - most).max(least - (value - widening));
        if beyond.is_nan() {
            f64::NAN
        } else {
            beyond.max(0.0)
        }
    }

    /// Returns the value of the row in a run; NaN if the characteristic is not defined there.
    pub fn value(&self, of: &str, run: &KcRun) -> f64 {
        let each = self.parts.iter();
        each.map(|(at, factor)| factor * reading(sample(run, *at), of).map_or(f64::NAN, value))
            .sum()
    }

    /// Returns the exact derivative of the row along a direction of the run; NaN if there is none.
    pub(crate) fn change(&self, of: &str, run: &KcRun, direction: usize) -> f64 {
        let one = |at: Option<(usize, usize)>| {
            let sample = sample(run, at)?;
            let sense = reading(Some(sample), of)?.sense;
            Some(Convention::AdamsCar.factor(sense) * reading_change(sample, direction, of)?)
        };
        let each = self.parts.iter();
        each.map(|(at, factor)| factor * one(*at).unwrap_or(f64::NAN))
            .sum()
    }
}

fn value(reading: &Reading) -> f64 {
    reading.value_in(Convention::AdamsCar)
}

fn sample(run: &KcRun, at: Option<(usize, usize)>) -> Option<&Sample> {
    match at {
        None => Some(&run.ride),
        Some((test, sample)) => run.tests.get(test)?.samples.get(sample),
    }
}

fn reading<'r>(sample: Option<&'r Sample>, path: &str) -> Option<&'r Reading> {
    let (entity, component) = path.split_once('.')?;
    let mut all = sample?.readings.iter();
    all.find(|reading| reading.entity == entity && reading.component == component)
}

/// Inputs for the resolution of goals.
struct Reader<'a> {
    study: &'a Source,
    run: &'a KcRun,
    config: &'a Config,
    units: &'a Units,
}

/// Resolves the goals of a target. `run` is the run of the tests on the deck of the study. Names that cannot be resolved are reported in `out`.
pub(crate) fn goals(
    target: &TargetSettings,
    study: &Source,
    (run, config): (&KcRun, &Config),
    units: &Units,
    out: &mut Vec<Diagnostic>,
) -> Vec<Goal> {
    let reader = Reader {
        study,
        run,
        config,
        units,
    };
    let mut all = Vec::new();
    for goal in &target.goals {
        match reader.goal(goal) {
            Ok(found) => all.push(found),
            Err(wrong) => out.push(*wrong),
        }
    }
    all
}

impl Reader<'_> {
    fn goal(&self, goal: &GoalSettings) -> Result<Goal, Box<Diagnostic>> {
        let complain = |span, message: String, help: String| {
            let error = Diagnostic::error(Code::BadSetting, message);
            Box::new(error.label(self.study.name(), span, "").help(help))
        };
        let test = self.run.tests.iter().enumerate();
        let test = test
            .into_iter()
            .find(|(_, test)| test.kind.name() == goal.test.text);
        if test.is_none() && goal.test.text != "ride" {
            let mut names: Vec<String> = admire_kc::TestKind::ALL
                .iter()
                .map(|kind| kind.name().to_string())
                .collect();
            names.push("ride".to_string());
            let known = names.contains(&goal.test.text);
            let message = if known {
                format!(
                    "`{}` is not run: {} leaves it out",
                    goal.test.text,
                    self.config.source.name()
                )
            } else {
                format!("`{}` is no test", goal.test.text)
            };
            let help = if known {
                "give the test its section in kc.toml".to_string()
            } else {
                did_you_mean(&goal.test.text, "the rig", &names)
            };
            return Err(complain(goal.test.span, message, help));
        }
        let first = test.map_or(Some(&self.run.ride), |(_, test)| test.samples.first());
        let Some(found) = reading(first, &goal.of.text) else {
            let all = first.into_iter().flat_map(|sample| &sample.readings);
            let paths: Vec<String> = all.map(Reading::path).collect();
            let message = format!("`{}` is not a characteristic of this axle", goal.of.text);
            let help = did_you_mean(&goal.of.text, "the axle", &paths);
            return Err(complain(goal.of.span, message, help));
        };
        let (factor, unit) = match (goal.scope, test) {
            (GoalScope::Gradient, Some((_, test))) => {
                slope(1.0, found.unit, test.kind.driven(), self.units)
            }
            _ => shown(1.0, found.unit, self.units),
        };
        let rows = match (test, goal.scope) {
            (None, GoalScope::Gradient) => {
                let help = "name the test whose variable drives it".to_string();
                let message = "ride height has no gradient".to_string();
                return Err(complain(goal.test.span, message, help));
            }
            (None, _) => vec![(0.0, vec![(None, factor)])],
            (Some(test), GoalScope::Curve) => curve(test, factor),
            (Some(test), GoalScope::Gradient) => vec![(0.0, gradient(test, factor))],
            (Some(test), GoalScope::Value) => {
                let parts = value_at(test, goal.at, factor).ok_or_else(|| {
                    let [low, high] = test.1.settings.range;
                    let help = format!("the test goes from {low} to {high}");
                    let message = format!("test `{}` does not reach {}", goal.test.text, goal.at);
                    complain(goal.span, message, help)
                })?;
                vec![(goal.at, parts)]
            }
        };
        if rows.iter().any(|(_, parts)| parts.is_empty()) {
            let message = "fewer than two samples lie within the window of the test".to_string();
            let help = "give the test a wider window or more points in kc.toml".to_string();
            return Err(complain(goal.span, message, help));
        }
        let wanted = self.wanted(goal, &unit)?;
        let row = |(at, parts): (f64, Vec<_>)| {
            let wanted = wanted(at)?;
            Some(Row { at, wanted, parts })
        };
        let rows: Vec<Row> = rows.into_iter().filter_map(row).collect();
        if rows.is_empty() {
            let message = "the wanted curve has no value within the range of the test".to_string();
            return Err(complain(
                goal.span,
                message,
                "the column `value` is the test's variable".to_string(),
            ));
        }
        let undefined = rows
            .iter()
            .find(|row| !row.value(&goal.of.text, self.run).is_finite());
        if let Some(row) = undefined {
            let message = format!("`{}` is not defined at {}", goal.of.text, row.at);
            let help = "`admire kc` shows where a characteristic has values".to_string();
            return Err(complain(goal.of.span, message, help));
        }
        let rubs = self.run.ride.seen.friction.is_some();
        Ok(Goal {
            test: goal.test.text.clone(),
            of: goal.of.text.clone(),
            scope: goal.scope,
            kind: match goal.wanted {
                Wanted::Limits(_) => GoalKind::Limit,
                _ if goal.minimax => GoalKind::Minimax,
                _ => GoalKind::Squares,
            },
            unit,
            at_unit: test.map_or_else(String::new, |(_, test)| {
                driven_unit(test.kind.driven(), self.units)
            }),
            tolerance: goal.tolerance,
            rows,
            is_exact: has_reading_change(&goal.of.text) && !rubs,
            weight: 1.0,
        })
    }

    /// Returns the wanted range as a function of the test's variable. The function returns `None` outside of a wanted curve.
    fn wanted(
        &self,
        goal: &GoalSettings,
        unit: &str,
    ) -> Result<Box<dyn Fn(f64) -> Option<[f64; 2]>>, Box<Diagnostic>> {
        match &goal.wanted {
            Wanted::Number(value) => {
                let value = *value;
                Ok(Box::new(move |_| Some([value, value])))
            }
            Wanted::Limits(limits) => {
                let limits = *limits;
                Ok(Box::new(move |_| Some(limits)))
            }
            Wanted::Curve(table) => {
                let points = self.points(table, goal, unit)?;
                Ok(Box::new(move |at| {
                    interpolated(&points, at).map(|value| [value, value])
                }))
            }
        }
    }

    /// Reads the wanted curve of a goal, in ascending order of the test's variable and in the unit of the goal.
    fn points(
        &self,
        table: &Table,
        goal: &GoalSettings,
        unit: &str,
    ) -> Result<Vec<(f64, f64)>, Box<Diagnostic>> {
        let file = table.source.name();
        let lacks = |what: String| {
            let error = Diagnostic::error(Code::MissingColumn, what);
            Box::new(error.label(file, table.header_span(), "").help(
                "a wanted curve must have the columns `value` and, as in curves.csv, a characteristic such as `toe_angle.left [deg]`",
            ))
        };
        let value = table
            .column("value")
            .ok_or_else(|| lacks("the column `value` is missing".to_string()))?;
        let named = |head: &String| {
            head.split('[')
                .next()
                .unwrap_or_default()
                .trim()
                .eq_ignore_ascii_case(&goal.of.text)
        };
        let heads = table.header();
        let own = heads
            .iter()
            .position(named)
            .ok_or_else(|| lacks(format!("no column is `{}`", goal.of.text)))?;
        let word = heads[own]
            .split_once('[')
            .map_or("", |(_, word)| word.trim_end_matches([']', ' ']));
        if !word.is_empty() && word.trim() != unit {
            return Err(lacks(format!(
                "the column `{}` must be in {unit}",
                heads[own]
            )));
        }
        let test = table.column("test");
        let mut wrong = Vec::new();
        let mut points = Vec::new();
        for row in table.rows() {
            let other = test
                .and_then(|k| row.get(k))
                .is_some_and(|cell| cell.text != goal.test.text);
            let empty = |k: usize| row.get(k).is_none_or(|cell| cell.text.is_empty());
            if other || empty(value) || empty(own) {
                continue;
            }
            let at = table.number(row, value, &mut wrong);
            points.extend(at.zip(table.number(row, own, &mut wrong)));
        }
        if let Some(first) = wrong.into_iter().next() {
            return Err(Box::new(first));
        }
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        points.dedup_by(|a, b| a.0 == b.0);
        Ok(points)
    }
}

/// Returns the samples of a test one by one, with the value of its variable.
fn curve(
    (k, test): (usize, &TestRun),
    factor: f64,
) -> Vec<(f64, Vec<(Option<(usize, usize)>, f64)>)> {
    let each = test.samples.iter().enumerate();
    each.map(|(n, sample)| (sample.value, vec![(Some((k, n)), factor)]))
        .collect()
}

/// Returns the weights of the samples in a gradient: the slope of the least-squares line within the window, averaged over both branches.
fn gradient((k, test): (usize, &TestRun), factor: f64) -> Vec<(Option<(usize, usize)>, f64)> {
    let inside = |sample: &Sample| sample.value.abs() <= test.settings.window * (1.0 + 1e-9);
    let branch = |branch: Branch| -> Vec<(usize, f64)> {
        let each = test.samples.iter().enumerate();
        let own = each.filter(|(_, sample)| sample.branch == branch && inside(sample));
        let points: Vec<(usize, f64)> = own.map(|(n, sample)| (n, sample.value)).collect();
        let mean = points.iter().map(|(_, x)| x).sum::<f64>() / points.len() as f64;
        let square: f64 = points.iter().map(|(_, x)| (x - mean) * (x - mean)).sum();
        if points.len() < 2 {
            return Vec::new();
        }
        points
            .into_iter()
            .map(|(n, x)| (n, (x - mean) / square))
            .collect()
    };
    let both = [branch(Branch::Up), branch(Branch::Down)];
    let share = factor / both.iter().filter(|own| !own.is_empty()).count().max(1) as f64;
    let all = both.iter().flatten();
    all.map(|(n, weight)| (Some((k, *n)), share * weight))
        .collect()
}

/// Returns the weights of the two samples next to a value of the test's variable, on the upward branch. Returns `None` outside of the test's
/// range.
fn value_at(
    (k, test): (usize, &TestRun),
    at: f64,
    factor: f64,
) -> Option<Vec<(Option<(usize, usize)>, f64)>> {
    let each = test.samples.iter().enumerate();
    let up: Vec<(usize, f64)> = each
        .filter(|(_, sample)| sample.branch == Branch::Up)
        .map(|(n, sample)| (n, sample.value))
        .collect();
    let pair = up
        .windows(2)
        .find(|pair| pair[0].1 <= at && at <= pair[1].1)?;
    let share = (at - pair[0].1) / (pair[1].1 - pair[0].1);
    Some(vec![
        (Some((k, pair[0].0)), factor * (1.0 - share)),
        (Some((k, pair[1].0)), factor * share),
    ])
}

/// Interpolates a curve linearly. Returns `None` outside of the curve; round-off at its ends is tolerated.
fn interpolated(points: &[(f64, f64)], at: f64) -> Option<f64> {
    let (first, last) = (points.first()?, points.last()?);
    let slack = 1e-9 * (last.0 - first.0);
    if at < first.0 - slack || at > last.0 + slack {
        return None;
    }
    let next = points
        .iter()
        .position(|point| point.0 >= at)
        .unwrap_or(points.len() - 1);
    let (a, b) = (points[next.saturating_sub(1)], points[next]);
    if b.0 == a.0 || at >= b.0 {
        return Some(b.1);
    }
    Some(a.1 + (b.1 - a.1) * (at - a.0) / (b.0 - a.0))
}
