use std::collections::BTreeMap;

use super::{ResultsError, ResultsReader, SelectedColumn, Selection, StepKind};

/// When two values are the same: |a - b| <= absolute + relative max(|a|, |b|).
#[derive(Clone, Copy, PartialEq, Debug, serde::Serialize)]
pub struct Tolerance {
    /// Absolute part, in the unit of each column.
    pub absolute: f64,
    /// Relative part.
    pub relative: f64,
}

/// What two results files have in common and what not.
#[derive(Clone, PartialEq, Debug, serde::Serialize)]
pub struct Comparison {
    /// The tolerance it was made with.
    pub tolerance: Tolerance,
    /// Steps compared.
    pub steps: usize,
    /// Steps of A without a counterpart.
    pub steps_only_in_a: usize,
    /// Steps of B without a counterpart.
    pub steps_only_in_b: usize,
    /// Steps, from 1 among those compared, whose kinds differ in more than the word for an equilibrium; a
    /// step whose file does not tell its kind differs from none.
    pub kinds_differ: Vec<usize>,
    /// Columns in both, in the order of A.
    pub columns: Vec<ColumnDifference>,
    /// Names of columns only in A.
    pub only_in_a: Vec<String>,
    /// Names of columns only in B.
    pub only_in_b: Vec<String>,
    /// Columns in both whose units differ; their numbers are not compared.
    pub units_differ: Vec<UnitsDiffer>,
}

/// A column whose unit is not the same in both files.
#[derive(Clone, PartialEq, Eq, Debug, serde::Serialize)]
pub struct UnitsDiffer {
    /// Full name.
    pub path: String,
    /// Unit in A.
    pub a: Option<String>,
    /// Unit in B.
    pub b: Option<String>,
}

/// The largest difference of one column.
#[derive(Clone, PartialEq, Debug, serde::Serialize)]
pub struct ColumnDifference {
    /// Full name.
    pub path: String,
    /// Unit.
    pub units: Option<String>,
    /// Largest |a - b|.
    pub largest: f64,
    /// Largest |a - b| / max(|a|, |b|).
    pub largest_relative: f64,
    /// Number of steps beyond the tolerance.
    pub beyond: usize,
    /// Where |a - b| exceeds its tolerance most, or is largest when none does.
    pub worst: Option<Worst>,
}

/// Two values that differ.
#[derive(Clone, Copy, PartialEq, Debug, serde::Serialize)]
pub struct Worst {
    /// Step, from 1 among those compared.
    pub step: usize,
    /// Time in A.
    pub time: f64,
    /// Value in A.
    pub a: f64,
    /// Value in B.
    pub b: f64,
    #[serde(skip)]
    excess: f64,
}

impl Comparison {
    /// True if everything both files should share is there and within the tolerance. The exit code of `admire compare`.
    pub fn agrees(&self) -> bool {
        self.columns.iter().all(|column| column.beyond == 0)
            && self.steps_only_in_a == 0
            && self.steps_only_in_b == 0
            && self.only_in_a.is_empty()
            && self.only_in_b.is_empty()
            && self.units_differ.is_empty()
            && self.kinds_differ.is_empty()
    }
}

/// Compares the remaining steps of two files, column by column by name, step by step in order, in memory for one step.
///
/// Steps of kind `input` are left out: they hold no answer. PSI, THETA and PHI are compared modulo one turn. Two values that
/// are both NaN are the same; NaN and a number are not.
///
/// # Errors
/// When a file cannot be read further.
pub fn compare(
    a: &mut dyn ResultsReader,
    b: &mut dyn ResultsReader,
    tolerance: Tolerance,
) -> Result<Comparison, ResultsError> {
    let in_a = Selection::all(a.catalogue()).columns;
    let in_b = Selection::all(b.catalogue()).columns;
    let key = |column: &SelectedColumn| column.path.to_ascii_lowercase();
    let mut rest: BTreeMap<String, &SelectedColumn> = in_b.iter().map(|c| (key(c), c)).collect();
    let (mut pairs, mut columns) = (Vec::new(), Vec::new());
    let (mut only_in_a, mut units_differ) = (Vec::new(), Vec::new());
    for column in &in_a {
        match rest.remove(&key(column)) {
            None => only_in_a.push(column.path.clone()),
            Some(other) if !same_unit(column, other) => units_differ.push(UnitsDiffer {
                path: column.path.clone(),
                a: column.units.clone(),
                b: other.units.clone(),
            }),
            Some(other) => {
                pairs.push((column.id - 1, other.id - 1, turn(column)));
                columns.push(ColumnDifference {
                    path: column.path.clone(),
                    units: column.units.clone(),
                    largest: 0.0,
                    largest_relative: 0.0,
                    beyond: 0,
                    worst: None,
                });
            }
        }
    }
    let only_in_b = in_b.iter().filter(|c| rest.contains_key(&key(c)));
    let mut report = Comparison {
        tolerance,
        steps: 0,
        steps_only_in_a: 0,
        steps_only_in_b: 0,
        kinds_differ: Vec::new(),
        only_in_b: only_in_b.map(|c| c.path.clone()).collect(),
        columns,
        only_in_a,
        units_differ,
    };
    let (mut values_a, mut values_b) = (Vec::new(), Vec::new());
    loop {
        let kind_a = next_answer(a, &mut values_a)?;
        let kind_b = next_answer(b, &mut values_b)?;
        match (kind_a, kind_b) {
            (None, None) => return Ok(report),
            (Some(_), None) => report.steps_only_in_a += 1,
            (None, Some(_)) => report.steps_only_in_b += 1,
            (Some(kind_a), Some(kind_b)) => {
                report.steps += 1;
                let same = kind_a == kind_b
                    || (kind_a.is_equilibrium() && kind_b.is_equilibrium())
                    || [kind_a, kind_b].contains(&StepKind::Unlisted);
                if !same {
                    report.kinds_differ.push(report.steps);
                }
                let time = values_a.first().copied().unwrap_or(0.0);
                for (column, &(at_a, at_b, turn)) in report.columns.iter_mut().zip(&pairs) {
                    let (a, b) = (values_a[at_a], values_b[at_b]);
                    column.take(report.steps, time, a, b, turn, tolerance);
                }
            }
        }
    }
}

impl ColumnDifference {
    fn take(
        &mut self,
        step: usize,
        time: f64,
        a: f64,
        b: f64,
        turn: Option<f64>,
        tolerance: Tolerance,
    ) {
        if a == b || (a.is_nan() && b.is_nan()) {
            return;
        }
        let mut difference = (a - b).abs();
        if let Some(turn) = turn {
            let rest = difference.rem_euclid(turn);
            difference = rest.min(turn - rest);
        }
        if difference.is_nan() {
            difference = f64::INFINITY;
        }
        let scale = a.abs().max(b.abs());
        self.largest = self.largest.max(difference);
        let relative = if scale.is_finite() {
            difference / scale
        } else {
            f64::INFINITY
        };
        self.largest_relative = self.largest_relative.max(relative);
        let allowed = tolerance.absolute + tolerance.relative * scale;
        // Infinity is beyond any tolerance, also one relative to infinity.
        let beyond = difference.is_infinite() || difference > allowed;
        self.beyond += usize::from(beyond);
        let excess = if difference.is_infinite() {
            f64::INFINITY
        } else {
            difference - allowed
        };
        if self.worst.is_none_or(|worst| excess > worst.excess) {
            self.worst = Some(Worst {
                step,
                time,
                a,
                b,
                excess,
            });
        }
    }
}

fn next_answer(
    reader: &mut dyn ResultsReader,
    values: &mut Vec<f64>,
) -> Result<Option<StepKind>, ResultsError> {
    while let Some(step) = reader.next_step()? {
        if step.kind != StepKind::Input {
            step.values(values)?;
            return Ok(Some(step.kind));
        }
    }
    Ok(None)
}

fn same_unit(a: &SelectedColumn, b: &SelectedColumn) -> bool {
    match (&a.units, &b.units) {
        (Some(a), Some(b)) => a.eq_ignore_ascii_case(b),
        // A file that tells no unit is believed to have the other's.
        _ => true,
    }
}

/// One turn in the unit of an orientation angle.
fn turn(column: &SelectedColumn) -> Option<f64> {
    let (_, component) = column.path.rsplit_once('.')?;
    if !["PSI", "THETA", "PHI"].contains(&component) {
        return None;
    }
    match column.units.as_deref() {
        Some("rad") => Some(std::f64::consts::TAU),
        Some("deg") => Some(360.0),
        _ => None,
    }
}
