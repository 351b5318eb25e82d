//! The table of imported curves.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write as _;

use super::block::Block;
use super::characteristic::{Characteristic, Target};
use super::conversion::{Row, Series, converted, driven};
use super::mapping::Mapping;
use super::quantity::Quantity;
use super::resolved::find;
use super::sheet::Sheet;
use admire_kc::{Driven, Side, TestKind};
use admire_study::did_you_mean;
use admire_syntax::diagnostic::{Code, Diagnostic};
use admire_syntax::text::{Source, Span};

/// Largest difference of the variables of two rows that are joined, as a fraction of the range of the test.
const MAX_JOINED_DIFFERENCE: f64 = 0.02;

/// Interpretation of a column.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Assumed {
    /// Heading of the column, as written.
    pub column: String,
    /// Content of the column: a name of a characteristic, `test`, `side`, `time`, or `load NAME`.
    pub holds: String,
    /// Unit of the laboratory.
    pub unit: String,
    /// Positive direction in the laboratory's convention, and whether the sign is changed.
    pub sign: String,
    /// Side of the wheel.
    pub side: String,
}

/// Imported curves and load cases: one row for each sample, in the order driven.
#[derive(Clone, PartialEq, Debug)]
pub struct CurveTable {
    /// Text of the table as CSV.
    pub text: String,
    /// Interpretation of each column.
    pub assumed: Vec<Assumed>,
    /// Headings of columns that were left out.
    pub left_out: Vec<String>,
    /// Number of rows of each test, in the order of the table.
    pub counts: Vec<(TestKind, usize)>,
    /// Paths of the curves in the table with their units, and the names of the load case columns with their units.
    pub curves: Vec<String>,
    /// Names of the load case columns with their units.
    pub loads: Vec<String>,
    /// Lines for the `study.toml` of a study that reads the table.
    pub study_lines: String,
}

impl CurveTable {
    /// Converts the rows of all blocks.
    ///
    /// `map` is the file of the mapping, if there is one, so that diagnostics can point to its entries. Errors are added to `out`; the result is then
    /// `None`.
    pub fn new(
        mapping: &Mapping,
        map: Option<&Source>,
        blocks: &[Block],
        sheets: &[Sheet],
        out: &mut Vec<Diagnostic>,
    ) -> Option<Self> {
        let before = errors(out);
        complain_of_absent(mapping, map, blocks, out);
        let found = converted(mapping, blocks, sheets, out);
        let columns: BTreeSet<(Characteristic, Option<Side>)> = found
            .series
            .iter()
            .flat_map(|series| &series.rows)
            .flat_map(|row| row.values.keys().copied())
            .collect();
        for series in &found.series {
            if !series
                .rows
                .iter()
                .any(|row| row.variable(series.test).is_some())
                && let Some(first) = series.rows.first()
            {
                let (name, of) = (series.test.name(), driven(series.test).0.word());
                let message =
                    format!("the test `{name}` is driven by {of}, which no column contains");
                let help = format!("name its column in the mapping: is = \"{of}\"");
                let sheet = &sheets[series.sheet];
                out.push(
                    sheet
                        .error(Code::MissingColumn, message, first.span)
                        .help(help),
                );
            }
        }
        if errors(out) > before {
            return None;
        }
        let series = joined(found.series);
        if series.iter().all(|series| series.rows.is_empty()) {
            let message = "the file contains no rows of a K&C test";
            let place = sheets.first().map(|sheet| sheet.source.name());
            let wrong = Diagnostic::error(Code::MissingColumn, message);
            out.push(match place {
                Some(name) => wrong.label(name, Span::at(0), ""),
                None => wrong,
            });
            return None;
        }
        let loads: BTreeMap<String, &'static str> = found
            .columns
            .iter()
            .filter_map(|(_, column)| {
                let name = mapping.columns[column.entry].load.clone()?;
                Some((name, load_unit(column.quantity?)))
            })
            .collect();
        let steering = found
            .columns
            .iter()
            .find(|(_, column)| column.characteristic() == Some(Characteristic::SteeringInput))
            .and_then(|(_, column)| column.unit.clone());
        let assumed = found
            .columns
            .iter()
            .map(|(block, column)| {
                let entry = &mapping.columns[column.entry];
                let heading = &blocks[*block].headings[column.at];
                let holds = match (column.is, &entry.load) {
                    (Some(is), Some(load)) => format!("{}, load {load}", is.word()),
                    (Some(is), None) => is.word().to_string(),
                    (None, Some(load)) => format!("load {load}"),
                    (None, None) => String::new(),
                };
                Assumed {
                    column: heading.written.clone(),
                    holds,
                    unit: unit_in_words(column.unit.as_deref(), entry.over_mm, column.is),
                    sign: sign_in_words(
                        entry.positive.as_deref(),
                        entry.load_sign,
                        column.side,
                        column.characteristic(),
                    ),
                    side: match column.side {
                        Some(side) => side.word().to_string(),
                        None if column
                            .characteristic()
                            .is_some_and(Characteristic::is_sided) =>
                        {
                            "by row".to_string()
                        }
                        None => String::new(),
                    },
                }
            })
            .collect();
        let mut counts: Vec<(TestKind, usize)> = Vec::new();
        for own in &series {
            match counts.iter_mut().find(|(test, _)| *test == own.test) {
                Some((_, count)) => *count += own.rows.len(),
                None => counts.push((own.test, own.rows.len())),
            }
        }
        let curves: Vec<(Characteristic, Option<Side>)> = columns
            .into_iter()
            .filter(|(of, _)| *of != Characteristic::SteeringInput)
            .collect();
        let head = |(of, side): &(Characteristic, Option<Side>)| {
            let unit = of.quantity().map_or("", Quantity::unit);
            format!("{} [{unit}]", of.path(*side))
        };
        let heads: Vec<String> = curves.iter().map(head).collect();
        let load_heads: Vec<String> = loads
            .iter()
            .map(|(name, unit)| format!("{name} [{unit}]"))
            .collect();
        let body = Body {
            curves: &curves,
            loads: &loads,
            steering: steering.as_deref().unwrap_or_default(),
        };
        Some(Self {
            text: body.text(&series, &heads, &load_heads),
            assumed,
            left_out: left_out(mapping, blocks),
            counts,
            study_lines: study_lines(&curves, &heads, &load_heads),
            curves: heads,
            loads: load_heads,
        })
    }
}

fn errors(out: &[Diagnostic]) -> usize {
    let is_error =
        |found: &&Diagnostic| found.severity == admire_syntax::diagnostic::Severity::Error;
    out.iter().filter(is_error).count()
}

/// Reports entries of the mapping whose column is missing from all blocks.
fn complain_of_absent(
    mapping: &Mapping,
    map: Option<&Source>,
    blocks: &[Block],
    out: &mut Vec<Diagnostic>,
) {
    let mut names: Vec<String> = Vec::new();
    for heading in blocks.iter().flat_map(|block| &block.headings) {
        if !names.contains(&heading.written) {
            names.push(heading.written.clone());
        }
    }
    for entry in &mapping.columns {
        if blocks.iter().all(|block| find(entry, block) == Err(0)) {
            let message = format!("the table has no column `{}`", entry.name);
            let wrong = Diagnostic::error(Code::MissingColumn, message);
            let wrong = match (map, entry.span) {
                (Some(map), Some(span)) => wrong.label(map.name(), span, ""),
                _ => wrong,
            };
            out.push(wrong.help(did_you_mean(&entry.name, "the table", &names)));
        }
    }
}

/// Returns the headings of columns that no entry names.
fn left_out(mapping: &Mapping, blocks: &[Block]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for block in blocks {
        let entries = mapping.columns.iter();
        let used: BTreeSet<usize> = entries
            .filter_map(|entry| find(entry, block).ok())
            .collect();
        for (at, heading) in block.headings.iter().enumerate() {
            let is_new = !heading.written.is_empty() && !names.contains(&heading.written);
            if !used.contains(&at) && is_new {
                names.push(heading.written.clone());
            }
        }
    }
    names
}

/// Joins rows of the left and of the right wheel from separate tables. Two tables are joined if the test has the same number of rows in both, and the
/// same variable in each pair of rows.
fn joined(all: Vec<Series>) -> Vec<Series> {
    let mut found: Vec<Series> = Vec::new();
    for series in all {
        match found
            .iter_mut()
            .find(|other| belong_together(other, &series))
        {
            Some(other) => {
                for (row, more) in other.rows.iter_mut().zip(series.rows) {
                    row.values.extend(more.values);
                    row.loads.extend(more.loads);
                }
            }
            None => found.push(series),
        }
    }
    // Rows of one test are grouped. Within a test, they keep the order of the files.
    let mut order: Vec<TestKind> = Vec::new();
    for series in &found {
        if !order.contains(&series.test) {
            order.push(series.test);
        }
    }
    found.sort_by_key(|series| order.iter().position(|test| *test == series.test));
    found
}

fn belong_together(a: &Series, b: &Series) -> bool {
    if a.test != b.test || a.rows.len() != b.rows.len() {
        return false;
    }
    let of = |series: &Series| -> Vec<Option<f64>> {
        series
            .rows
            .iter()
            .map(|row| row.variable(series.test))
            .collect()
    };
    let (x, y) = (of(a), of(b));
    let all = || x.iter().flatten();
    let range = all().copied().fold(f64::NEG_INFINITY, f64::max)
        - all().copied().fold(f64::INFINITY, f64::min);
    let keys = |series: &Series| -> BTreeSet<(Characteristic, Option<Side>)> {
        series
            .rows
            .iter()
            .flat_map(|row| row.values.keys().copied())
            .collect()
    };
    let near = |(x, y): (&Option<f64>, &Option<f64>)| match (x, y) {
        (Some(x), Some(y)) => (x - y).abs() <= MAX_JOINED_DIFFERENCE * range,
        _ => false,
    };
    keys(a).is_disjoint(&keys(b)) && x.iter().zip(&y).all(near)
}

fn load_unit(quantity: Quantity) -> &'static str {
    match quantity {
        Quantity::Torque => "N mm",
        _ => quantity.unit(),
    }
}

fn unit_in_words(unit: Option<&str>, over: Option<f64>, is: Option<Target>) -> String {
    if matches!(is, Some(Target::Test | Target::Side | Target::Time)) {
        return String::new();
    }
    let unit = unit.unwrap_or_default();
    match over {
        Some(over) => format!("{unit} over {over} mm"),
        None => unit.to_string(),
    }
}

fn sign_in_words(
    positive: Option<&str>,
    load_sign: Option<f64>,
    side: Option<Side>,
    of: Option<Characteristic>,
) -> String {
    let mut words = Vec::new();
    if let (Some(positive), Some(of)) = (positive, of) {
        let changed = of.sign(positive, side).is_some_and(|sign| sign < 0.0);
        let changed = if changed { ", sign changed" } else { "" };
        words.push(format!("+ {positive}{changed}"));
    }
    if let Some(sign) = load_sign {
        words.push(if sign < 0.0 {
            "load with its sign changed".to_string()
        } else {
            "load as measured".to_string()
        });
    }
    words.join("; ")
}

/// Columns of the table.
struct Body<'a> {
    curves: &'a [(Characteristic, Option<Side>)],
    loads: &'a BTreeMap<String, &'static str>,
    steering: &'a str,
}

impl Body<'_> {
    fn text(&self, series: &[Series], heads: &[String], load_heads: &[String]) -> String {
        let mut csv = csv::Writer::from_writer(Vec::new());
        let first = ["case", "test", "value", "value_unit"].map(str::to_string);
        let head = first.iter().chain(heads).chain(load_heads);
        let mut write = |record: Vec<String>| {
            csv.write_record(record)
                .expect("writing to memory does not fail");
        };
        write(head.cloned().collect());
        let mut case = 0;
        for own in series {
            let unit = match own.test.driven() {
                Driven::Steering => self.steering,
                _ => driven(own.test).0.quantity().map_or("", Quantity::unit),
            };
            for row in &own.rows {
                case += 1;
                write(self.record(case, own.test, unit, row));
            }
        }
        let bytes = csv.into_inner().expect("writing to memory does not fail");
        String::from_utf8_lossy(&bytes).into_owned()
    }

    fn record(&self, case: usize, test: TestKind, unit: &str, row: &Row) -> Vec<String> {
        let spelled = |value: Option<f64>| value.map_or_else(String::new, shortened);
        let mut record = vec![
            case.to_string(),
            test.name().to_string(),
            spelled(row.variable(test)),
            unit.to_string(),
        ];
        let curves = self.curves.iter().map(|key| row.values.get(key).copied());
        record.extend(curves.map(spelled));
        let loads = self.loads.keys().map(|name| row.loads.get(name).copied());
        record.extend(loads.map(spelled));
        record
    }
}

/// Formats a number with 12 significant digits, more than the resolution of any rig.
fn shortened(value: f64) -> String {
    let rounded: f64 = format!("{value:.11e}").parse().unwrap_or(value);
    rounded.to_string()
}

/// Returns the lines of a `study.toml` that reads the table. Curves of a second wheel have separate names and state its marker.
fn study_lines(
    curves: &[(Characteristic, Option<Side>)],
    heads: &[String],
    load_heads: &[String],
) -> String {
    let loads: Vec<String> = load_heads
        .iter()
        .map(|head| format!("\"{head}\" = \"?\""))
        .collect();
    let remark = if loads.is_empty() {
        "# the mapping names no load: add load = \"NAME\" to the column of each load"
    } else {
        "# FILL IN the force or motion of the deck that each load drives"
    };
    let mut text = format!(
        "[loads]\nfile = \"FILE\"\n{remark}\ncolumns = {{ {} }}\n[kc]\nfile = \"FILE\"\n[kc.curves]\n",
        loads.join(", ")
    );
    let mut first = None;
    for ((of, side), head) in curves.iter().zip(heads) {
        let (Some(curve), Some(side)) = (of.study_curve(), *side) else {
            continue;
        };
        _ = if *first.get_or_insert(side) == side {
            writeln!(text, "{curve} = {{ column = \"{head}\" }}")
        } else {
            let name = format!("{curve}_{}", side.word());
            writeln!(
                text,
                "{name} = {{ curve = \"{curve}\", column = \"{head}\", marker = \"MARKER/?\" }}"
            )
        };
    }
    text
}
