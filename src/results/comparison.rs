use std::collections::BTreeMap;

use super::{DifferenceFloor, ResultsError, ResultsReader, SelectedColumn, Selection, StepKind};

/// Tolerance for comparing values: a and b count as equal if |a - b| <= absolute + relative max(|a|, |b|).
#[derive(Clone, Copy, PartialEq, Debug, serde::Serialize)]
pub struct Tolerance {
    /// Absolute tolerance, in the unit of each column.
    pub absolute: f64,
    /// Relative tolerance, as a fraction of the larger of the two magnitudes.
    pub relative: f64,
}

/// Result of the comparison of two results files, A and B.
#[derive(Clone, PartialEq, Debug, serde::Serialize)]
pub struct Comparison {
    /// Tolerance with which values were compared.
    pub tolerance: Tolerance,
    /// Number of compared output steps.
    pub steps: usize,
    /// Number of output steps in A that have no counterpart in B.
    pub steps_only_in_a: usize,
    /// Number of output steps in B that have no counterpart in A.
    pub steps_only_in_b: usize,
    /// Numbers (from 1) of the compared output steps whose kinds differ. All kinds of static equilibrium count as the same kind, and
    /// [`StepKind::Unlisted`] counts as equal to any kind.
    pub kinds_differ: Vec<usize>,
    /// Columns that both files contain, in the order of A.
    pub columns: Vec<ColumnDifference>,
    /// Full names of the columns that only A contains.
    pub only_in_a: Vec<String>,
    /// Full names of the columns that only B contains.
    pub only_in_b: Vec<String>,
    /// Columns that both files contain in different units; their values are not compared.
    pub units_differ: Vec<UnitsDiffer>,
}

/// A column whose unit differs between the two files.
#[derive(Clone, PartialEq, Eq, Debug, serde::Serialize)]
pub struct UnitsDiffer {
    /// Full name of the column.
    pub path: String,
    /// Unit of the column in A; `None` if A gives no unit.
    pub a: Option<String>,
    /// Unit of the column in B; `None` if B gives no unit.
    pub b: Option<String>,
}

/// Differences between the values of one column, over all compared output steps.
#[derive(Clone, PartialEq, Debug, serde::Serialize)]
pub struct ColumnDifference {
    /// Full name of the column.
    pub path: String,
    /// Unit of the column in A.
    pub units: Option<String>,
    /// Largest difference that counts as round-off, in the unit of the column.
    pub floor: f64,
    /// Largest absolute difference |a - b|.
    pub largest: f64,
    /// Largest relative difference |a - b| / max(|a|, |b|).
    pub largest_relative: f64,
    /// Number of output steps in which the difference exceeds the tolerance.
    pub beyond: usize,
    /// Output step in which the difference exceeds the tolerance most, or comes closest to it if no difference exceeds it. `None` if all
    /// values are equal.
    pub worst: Option<Worst>,
}

/// Two different values of a column in the same output step.
#[derive(Clone, Copy, PartialEq, Debug, serde::Serialize)]
pub struct Worst {
    /// Number of the output step among all compared steps, from 1.
    pub step: usize,
    /// Time of the output step in A.
    pub time: f64,
    /// Value in A.
    pub a: f64,
    /// Value in B.
    pub b: f64,
    #[serde(skip)]
    excess: f64,
}

impl Comparison {
    /// Returns true if both files have the same columns, units, steps and kinds of steps, and all differences are within the tolerance.
    ///
    /// The exit code of `admire compare` depends on this result.
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

/// Compares the remaining output steps of two files. Columns are paired by name and steps by order. Memory is needed for only one step of
/// each file.
///
/// Steps of kind `input` are skipped because they contain no solution. PSI, THETA and PHI are compared modulo one turn. Two NaN values
/// count as equal; NaN and a number count as different.
///
/// # Errors
/// Returns an error if one of the files cannot be read further.
pub fn compare(
    a: &mut dyn ResultsReader,
    b: &mut dyn ResultsReader,
    tolerance: Tolerance,
) -> Result<Comparison, ResultsError> {
    compare_above(a, b, tolerance, &DifferenceFloor::default())
}

/// Compares the remaining output steps of two files as [`compare`] does. Differences up to the floor of their unit also count as equal.
///
/// # Errors
/// Returns an error if one of the files cannot be read further.
pub fn compare_above(
    a: &mut dyn ResultsReader,
    b: &mut dyn ResultsReader,
    tolerance: Tolerance,
    floor: &DifferenceFloor,
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
                    floor: floor.of(column.units.as_deref().or(other.units.as_deref())),
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
        let allowed = (tolerance.absolute + tolerance.relative * scale).max(self.floor);
        // An infinite difference exceeds every tolerance, even if the relative tolerance times an infinite value gives an infinite bound.
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
        // If one file gives no unit, it is assumed to be the unit in the other file.
        _ => true,
    }
}

/// Returns the size of one turn in the unit of the column if the column is PSI, THETA or PHI; `None` for any other column.
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
