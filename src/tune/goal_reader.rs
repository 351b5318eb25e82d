//! Resolution of goals: the states that each goal reads, and the wanted values.

use crate::answers::Answers;
use crate::goal::{Goal, GoalKind, Reads, Row, StateIx, reading};
use crate::goal_names::{CaseGoal, GoalNames};
use crate::reading_name::Named;
use admire_kc::{
    Branch, Config, KcRun, Reading, Sample, TestKind, TestRun, Unit, driven_unit,
    has_reading_change, shown, slope,
};
use admire_study::{GoalPlace, GoalScope, GoalSettings, Table, Wanted, did_you_mean};
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Source, Span};
use admire_syntax::units::Units;

/// States of a row, each with its factor in the linear combination.
type Parts = Vec<(StateIx, f64)>;

/// Inputs for the resolution of goals.
struct Reader<'a> {
    study: &'a Source,
    /// Results on the deck of the study.
    answers: &'a Answers,
    config: Option<&'a Config>,
    units: &'a Units,
}

/// Quantity that a goal of a test reads: a probe or characteristic, with its factor and unit.
struct Read {
    reads: Reads,
    factor: f64,
    unit: String,
    is_exact: bool,
}

/// Resolves the goals of a target. `names` come from [`GoalNames::new`]. `answers` holds the results on the deck of the study, including the
/// values of the probes in `names`. Names that cannot be resolved are reported in `out`.
pub(crate) fn goals(
    settings: &[GoalSettings],
    study: &Source,
    names: &GoalNames,
    (answers, config): (&Answers, Option<&Config>),
    units: &Units,
    out: &mut Vec<Diagnostic>,
) -> Vec<Goal> {
    let reader = Reader {
        study,
        answers,
        config,
        units,
    };
    let mut all = Vec::new();
    for (k, goal) in settings.iter().enumerate() {
        let found = match (&goal.place, names.of_cases.get(&k)) {
            (GoalPlace::Test(test), _) => reader.of_test(goal, test, names.of_tests.get(&k)),
            (GoalPlace::Case { label, .. }, Some(own)) => reader.of_case(goal, &label.text, own),
            // Reported with the names.
            (GoalPlace::Case { .. }, None) => continue,
        };
        match found {
            Ok(found) => all.push(found),
            Err(wrong) => out.push(*wrong),
        }
    }
    all
}

impl Reader<'_> {
    fn complain(&self, span: Span, message: String, help: String) -> Box<Diagnostic> {
        let error = Diagnostic::error(Code::BadSetting, message);
        Box::new(error.label(self.study.name(), span, "").help(help))
    }

    /// Resolves a goal that reads a test. `named` is the index of its probe and what the probe reads; `None` for a characteristic.
    fn of_test(
        &self,
        goal: &GoalSettings,
        name: &admire_study::section::SpannedText,
        named: Option<&(usize, Named)>,
    ) -> Result<Goal, Box<Diagnostic>> {
        let complain = |span, message, help| self.complain(span, message, help);
        let (Some(run), Some(config)) = (&self.answers.run, self.config) else {
            return Err(complain(
                name.span,
                "the study has no K&C tests".to_string(),
                "name kc.toml in `target.kc`".to_string(),
            ));
        };
        let mut tests = run.tests.iter().enumerate();
        let test = tests.find(|(_, test)| test.kind.name() == name.text);
        if test.is_none() && name.text != "ride" {
            let kinds = TestKind::ALL.iter();
            let mut names: Vec<String> = kinds.map(|kind| kind.name().to_string()).collect();
            names.push("ride".to_string());
            let known = names.contains(&name.text);
            let message = if known {
                let file = config.source.name();
                format!("`{}` is not run: {file} leaves it out", name.text)
            } else {
                format!("`{}` is not a test", name.text)
            };
            let help = if known {
                format!(
                    "add a section [tests.{}] to {}",
                    name.text,
                    config.source.name()
                )
            } else {
                did_you_mean(&name.text, "the rig", &names)
            };
            return Err(complain(name.span, message, help));
        }
        let read = self.read(goal, run, test, named)?;
        let rows = match (test, goal.scope) {
            (None, GoalScope::Gradient) => {
                let help =
                    "a gradient needs a test that varies an input, for example test = \"bounce\""
                        .to_string();
                let message = "ride height has no gradient".to_string();
                return Err(complain(name.span, message, help));
            }
            (None, _) => vec![(0.0, vec![(StateIx::Ride, read.factor)])],
            (Some(test), GoalScope::Curve) => curve(test, read.factor),
            (Some(test), GoalScope::Gradient) => vec![(0.0, gradient(test, read.factor))],
            (Some(test), GoalScope::Value) => {
                let parts = value_at(test, goal.at, read.factor).ok_or_else(|| {
                    let [low, high] = test.1.settings.range;
                    let help = format!("the variable of the test goes from {low} to {high}");
                    let message = format!("test `{}` does not reach {}", name.text, goal.at);
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
        let wanted = self.wanted(goal, &read.unit)?;
        let row = |(at, parts): (f64, Parts)| {
            let wanted = wanted(at)?;
            Some(Row { at, wanted, parts })
        };
        let rows: Vec<Row> = rows.into_iter().filter_map(row).collect();
        if rows.is_empty() {
            let message = "the wanted curve has no value within the range of the test".to_string();
            let help = "the column `value` holds the variable of the test".to_string();
            return Err(complain(goal.span, message, help));
        }
        let at_unit = test.map_or_else(String::new, |(_, test)| {
            driven_unit(test.kind.driven(), self.units)
        });
        let found = Goal {
            test: name.text.clone(),
            case: None,
            at_unit,
            rows,
            ..of_settings(goal, read)
        };
        let undefined = |row: &&Row| !found.value(row, self.answers).is_finite();
        if let Some(row) = found.rows.iter().find(undefined) {
            let of = &goal.of;
            let (message, help) = match found.reads {
                Reads::Characteristic => (
                    format!("`{}` is not defined at {}", of.text, row.at),
                    "`admire kc` shows where a characteristic has values",
                ),
                Reads::Probe(_) => (
                    format!("`{}` has no value on the rig", of.text),
                    "kc.toml removes statements of the deck by `without` or by free steering",
                ),
            };
            return Err(complain(of.span, message, help.to_string()));
        }
        Ok(found)
    }

    /// Returns the quantity that a goal of a test reads: its probe, or otherwise a characteristic of the axle.
    fn read(
        &self,
        goal: &GoalSettings,
        run: &KcRun,
        test: Option<(usize, &TestRun)>,
        named: Option<&(usize, Named)>,
    ) -> Result<Read, Box<Diagnostic>> {
        let first = test.map_or(Some(&run.ride), |(_, test)| test.samples.first());
        let found = first.and_then(|sample| reading(sample, &goal.of.text));
        let (reads, unit) = match (found, named) {
            (Some(found), _) => (Reads::Characteristic, found.unit),
            (None, Some((k, named))) => (Reads::Probe(*k), named.unit.unwrap_or(Unit::One)),
            (None, None) => {
                let all = first.into_iter().flat_map(|sample| &sample.readings);
                let paths: Vec<String> = all.map(Reading::path).collect();
                let of = &goal.of.text;
                let message = format!("`{of}` is not a characteristic of this axle");
                let help = did_you_mean(of, "the axle", &paths);
                return Err(self.complain(goal.of.span, message, help));
            }
        };
        let (factor, unit) = match (goal.scope, test) {
            (GoalScope::Gradient, Some((_, test))) => {
                slope(1.0, unit, test.kind.driven(), self.units)
            }
            _ => shown(1.0, unit, self.units),
        };
        let rubs = run.ride.seen.friction.is_some();
        let has_change = reads != Reads::Characteristic || has_reading_change(&goal.of.text);
        Ok(Read {
            reads,
            factor,
            unit,
            is_exact: has_change && !rubs,
        })
    }

    /// Resolves a goal that reads a load case.
    fn of_case(
        &self,
        goal: &GoalSettings,
        label: &str,
        own: &CaseGoal,
    ) -> Result<Goal, Box<Diagnostic>> {
        let (factor, unit) = own.named.shown(self.units);
        let wanted = self.wanted(goal, &unit)?(0.0).unwrap_or([f64::NAN; 2]);
        let mut parts = vec![(StateIx::Case(own.case), factor)];
        parts.extend(own.relative_to.map(|zero| (StateIx::Case(zero), -factor)));
        let read = Read {
            reads: Reads::Probe(own.probe),
            factor,
            unit,
            is_exact: true,
        };
        let row = Row {
            at: 0.0,
            wanted,
            parts,
        };
        let found = Goal {
            case: Some(label.to_string()),
            rows: vec![row],
            ..of_settings(goal, read)
        };
        if !found.value(&found.rows[0], self.answers).is_finite() {
            let message = format!("`{}` has no value in load case `{label}`", goal.of.text);
            let help = "the function gives no finite number there; check for a division by zero or the root of a negative number".to_string();
            return Err(self.complain(goal.of.span, message, help));
        }
        Ok(found)
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
            .ok_or_else(|| lacks(format!("there is no column `{}`", goal.of.text)))?;
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
        let test_name = match &goal.place {
            GoalPlace::Test(name) => name.text.as_str(),
            GoalPlace::Case { .. } => "",
        };
        let mut wrong = Vec::new();
        let mut points = Vec::new();
        for row in table.rows() {
            let other = test
                .and_then(|k| row.get(k))
                .is_some_and(|cell| cell.text != test_name);
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

/// Returns each sample of a test as a separate row, with the value of the test's variable.
fn curve((k, test): (usize, &TestRun), factor: f64) -> Vec<(f64, Parts)> {
    let each = test.samples.iter().enumerate();
    each.map(|(n, sample)| (sample.value, vec![(StateIx::Sample(k, n), factor)]))
        .collect()
}

/// Returns the weights of the samples in a gradient. The gradient is the slope of the least-squares line within the window, averaged over
/// both branches.
fn gradient((k, test): (usize, &TestRun), factor: f64) -> Parts {
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
    all.map(|(n, weight)| (StateIx::Sample(k, *n), share * weight))
        .collect()
}

/// Returns the weights of the two samples on the upward branch between which a value of the test's variable lies. Returns `None` outside of
/// the test's range.
fn value_at((k, test): (usize, &TestRun), at: f64, factor: f64) -> Option<Parts> {
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
        (StateIx::Sample(k, pair[0].0), factor * (1.0 - share)),
        (StateIx::Sample(k, pair[1].0), factor * share),
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

/// Returns a goal without its test or load case, and without rows.
fn of_settings(goal: &GoalSettings, read: Read) -> Goal {
    Goal {
        test: String::new(),
        case: None,
        of: goal.of.text.clone(),
        scope: goal.scope,
        kind: match goal.wanted {
            Wanted::Limits(_) => GoalKind::Limit,
            _ if goal.minimax => GoalKind::Minimax,
            _ => GoalKind::Squares,
        },
        unit: read.unit,
        at_unit: String::new(),
        tolerance: goal.tolerance,
        rows: Vec::new(),
        is_exact: read.is_exact,
        weight: 1.0,
        reads: read.reads,
    }
}
