//! Page that compares two results files: columns over time, their differences, and the contents that only one file has.

use std::path::Path;

use admire_diagnosis::SharedProgress;
use admire_report::{
    Align, Chart, DrawingError, Figure, Page, Series, SeriesStyle, Table, VERSION, axis_label,
    number, short_unit,
};
use admire_results::{ColumnDifference, Comparison, StepFilter, StepKind, Timestamp};

use super::error::{Error, ErrorKind};
use super::results::{Results, Rows};
use admire_syntax::diagnostic::{Code, Diagnostic};

/// Largest number of columns that are drawn.
const MAX_DRAWN: usize = 4;
/// Largest number of columns in the table of differences that is not folded.
const MAX_LISTED: usize = 20;

/// Creates the page of a comparison as HTML text.
///
/// # Errors
/// When one of the files cannot be read again.
pub(crate) fn compare_page(files: [&Path; 2], comparison: &Comparison) -> Result<String, Error> {
    let names = files.map(|path| {
        let name = path.file_name().unwrap_or(path.as_os_str());
        name.to_string_lossy().into_owned()
    });
    // If both files have the same name, their paths are shown.
    let names = if names[0] == names[1] {
        files.map(|path| path.display().to_string())
    } else {
        names
    };
    let worst = worst_first(comparison);
    let title = names.join(" and ");
    let mut page = Page::new("Comparison", &title, &answer(comparison, &worst, &names));
    page.origin(&[
        (
            "Files",
            files.map(|path| path.display().to_string()).join(", "),
        ),
        ("Date", format!("{} UTC", Timestamp::now().date_time())),
        (
            "Tolerance",
            format!(
                "absolute {}, relative {}",
                comparison.tolerance.absolute, comparison.tolerance.relative
            ),
        ),
        ("Made by", format!("admire {VERSION}")),
    ]);
    page.meaning();
    let drawn = of_each_unit(&worst);
    if !drawn.is_empty() {
        let figures = figures(files, &names, &drawn);
        page.figures(&figures?);
    }
    let differ = worst.len();
    let alone = |paths: &[String], name: &str| {
        let count = paths.len();
        (count > 0).then(|| format!("{} only in {name}", counted(count, "column")))
    };
    let steps = |count: usize, name: &str| {
        (count > 0).then(|| format!("{} only in {name}", counted(count, "step")))
    };
    let units = comparison.units_differ.len();
    let [a, b] = &names;
    let only = [
        alone(&comparison.only_in_a, a),
        alone(&comparison.only_in_b, b),
        steps(comparison.steps_only_in_a, a),
        steps(comparison.steps_only_in_b, b),
        (units > 0).then(|| format!("{} whose units differ", counted(units, "column"))),
    ];
    page.found(&[
        (
            "Compared",
            vec![format!(
                "{} over {}",
                counted(comparison.columns.len(), "column"),
                counted(comparison.steps, "step")
            )],
        ),
        (
            "Found",
            vec![match differ {
                0 => "all values within the tolerance".to_string(),
                1 => "1 column beyond the tolerance".to_string(),
                count => format!("{count} columns beyond the tolerance"),
            }],
        ),
        ("Not compared", only.into_iter().flatten().collect()),
    ]);
    if !worst.is_empty() {
        page.table(&differences(&worst[..worst.len().min(MAX_LISTED)], &names));
        page.note(
            "Each row gives the largest difference of a column, its time, and the values of both files at this time. The relative difference is in percent of the larger value.",
        );
    }
    if worst.len() > MAX_LISTED {
        page.detail("All columns beyond the tolerance");
        page.table(&differences(&worst, &names));
    }
    for (paths, name) in [(&comparison.only_in_a, a), (&comparison.only_in_b, b)] {
        if !paths.is_empty() {
            page.detail(&format!("Columns only in {name}"));
            page.list(paths);
        }
    }
    Ok(page.finish(&format!("admire {VERSION}")))
}

/// Returns the short unit of a column; empty if the column has none.
fn unit(column: &ColumnDifference) -> String {
    column.units.as_deref().map_or_else(String::new, short_unit)
}

fn counted(count: usize, what: &str) -> String {
    let end = if count == 1 { "" } else { "s" };
    format!("{count} {what}{end}")
}

/// Returns the difference of a column at its worst step, divided by the larger magnitude of the two values at that step. The largest relative
/// difference over all steps is no useful measure, because it reaches 200 percent where a curve crosses zero.
fn of_its_size(column: &ColumnDifference) -> f64 {
    column.worst.map_or(0.0, |worst| {
        let (difference, size) = ((worst.a - worst.b).abs(), worst.a.abs().max(worst.b.abs()));
        if difference.is_finite() && size > 0.0 {
            difference / size
        } else {
            f64::INFINITY
        }
    })
}

/// Returns the columns beyond the tolerance, the one with the largest difference relative to its size first.
fn worst_first(comparison: &Comparison) -> Vec<&ColumnDifference> {
    let columns = comparison.columns.iter();
    let mut worst: Vec<&ColumnDifference> = columns.filter(|column| column.beyond > 0).collect();
    worst.sort_by(|a, b| of_its_size(b).total_cmp(&of_its_size(a)));
    worst
}

/// Returns the columns to draw. `worst` holds columns in the order of their differences. The first column of each unit is chosen first, then
/// further columns. The pictures therefore show several quantities, such as a displacement, an angle and a force.
fn of_each_unit<'c>(worst: &[&'c ColumnDifference]) -> Vec<&'c ColumnDifference> {
    let is_first = |k: usize| {
        worst[..k]
            .iter()
            .all(|before| before.units != worst[k].units)
    };
    let (mut first, rest): (Vec<usize>, Vec<usize>) = (0..worst.len()).partition(|k| is_first(*k));
    first.extend(rest);
    first.truncate(MAX_DRAWN);
    first.sort_unstable();
    first.into_iter().map(|k| worst[k]).collect()
}

fn answer(comparison: &Comparison, worst: &[&ColumnDifference], names: &[String; 2]) -> String {
    let Some(first) = worst.first() else {
        return if comparison.agrees() {
            "The two files agree.".to_string()
        } else {
            "All compared values agree, but the files differ in their columns, units or steps."
                .to_string()
        };
    };
    let largest = number(first.largest, Some(0.1 * first.largest));
    let unit = unit(first);
    let at = first.worst.map_or_else(String::new, |worst| {
        let [a, b] = [worst.a, worst.b].map(|value| number(value, Some(0.1 * first.largest)));
        format!(
            " at time {} ({a} in {}, {b} in {})",
            number(worst.time, None),
            names[0],
            names[1]
        )
    });
    format!(
        "Columns beyond the tolerance: {} of {}. The largest relative difference is in {}: {}{at}.",
        worst.len(),
        comparison.columns.len(),
        first.path,
        format!("{largest} {unit}").trim_end()
    )
}

/// Tabulates the differences of columns.
fn differences(columns: &[&ColumnDifference], names: &[String; 2]) -> Table {
    let [a, b] = names;
    let mut table = Table::new(&[
        ("column", Align::Left),
        ("unit", Align::Left),
        ("largest difference", Align::Right),
        ("relative", Align::Right),
        ("steps beyond the tolerance", Align::Right),
        ("at time", Align::Right),
        (a.as_str(), Align::Right),
        (b.as_str(), Align::Right),
    ]);
    for column in columns {
        let worst = column.worst;
        let shown = |value: Option<f64>| {
            value.map_or_else(String::new, |value| {
                number(value, Some(0.1 * column.largest))
            })
        };
        table.row([
            column.path.clone(),
            unit(column),
            number(column.largest, Some(0.1 * column.largest)),
            format!(
                "{} %",
                number(
                    100.0 * of_its_size(column),
                    Some(10.0 * of_its_size(column))
                )
            ),
            column.beyond.to_string(),
            worst.map_or_else(String::new, |worst| number(worst.time, None)),
            shown(worst.map(|worst| worst.a)),
            shown(worst.map(|worst| worst.b)),
        ]);
    }
    table
}

/// Draws columns of both files over time, and their differences below.
fn figures(
    files: [&Path; 2],
    names: &[String; 2],
    columns: &[&ColumnDifference],
) -> Result<Vec<Figure>, Error> {
    let mut read = Vec::new();
    for file in files {
        read.push(rows(file, columns)?);
    }
    let mut out = Vec::new();
    let failed = |error: DrawingError| {
        let diagnostic = Diagnostic::error(Code::CannotWrite, error.to_string());
        Error::plain(ErrorKind::Input, &diagnostic)
    };
    let both: Vec<Chart> = columns
        .iter()
        .map(|column| overlay(column, names, &read))
        .collect();
    // Pairs of columns are shown side by side: the overlays in one row, the differences below them.
    for pair in both.chunks(2).zip(columns.chunks(2)) {
        for chart in pair.0 {
            out.push(Figure::chart(chart, "").map_err(failed)?);
        }
        for (chart, column) in pair.0.iter().zip(pair.1) {
            out.push(Figure::chart(&difference(chart, column, names), "").map_err(failed)?);
        }
    }
    Ok(out)
}

/// Reads columns of a file, with the time first. Steps of kind `input` contain no solution.
fn rows(file: &Path, columns: &[&ColumnDifference]) -> Result<Rows, Error> {
    let results = Results::open(file)?;
    let is_time = |path: &str| {
        let own = path.rsplit('.').next();
        own.is_some_and(|name| name.eq_ignore_ascii_case("TIME"))
    };
    let time = results
        .columns()
        .iter()
        .find(|column| is_time(&column.path));
    let patterns = time.map(|column| column.path.as_str()).into_iter();
    let patterns: Vec<&str> = patterns
        .chain(columns.iter().map(|column| column.path.as_str()))
        .collect();
    let kinds = StepKind::NAMED.into_iter();
    let filter = StepFilter {
        kinds: kinds.filter(|kind| *kind != StepKind::Input).collect(),
        ..StepFilter::default()
    };
    results.select(&patterns, &filter, &SharedProgress::default())
}

/// Draws a column of both files over time, or over the number of the step if the time is constant.
fn overlay(column: &ColumnDifference, names: &[String; 2], read: &[Rows]) -> Chart {
    let styles = [SeriesStyle::Line, SeriesStyle::Dashed];
    let mut x = "time".to_string();
    let series =
        read.iter()
            .zip(names)
            .zip(styles)
            .map(|((rows, name), style)| {
                let wide = rows.columns.len().max(1);
                let of = |path: &str| {
                    let mut all = rows.columns.iter();
                    all.position(|own| own.path.eq_ignore_ascii_case(path))
                };
                let time = rows.columns.iter().position(|own| {
                    own.path.to_ascii_uppercase().rsplit('.').next() == Some("TIME")
                });
                let times: Vec<f64> = rows
                    .values
                    .chunks(wide)
                    .filter_map(|row| row.get(time?).copied())
                    .collect();
                let moves = times.windows(2).any(|pair| pair[0] < pair[1]);
                if !moves {
                    x = "step".to_string();
                }
                let at = |k: usize| times.get(k).copied().filter(|_| moves);
                let points = rows.values.chunks(wide).enumerate().filter_map(|(k, row)| {
                    let value = *row.get(of(&column.path)?)?;
                    Some((at(k).unwrap_or((k + 1) as f64), value))
                });
                Series::new(name, style, points.collect())
            });
    let series: Vec<Series> = series.collect();
    let quantity = column
        .path
        .rsplit('.')
        .next()
        .unwrap_or_default()
        .replace('_', " ");
    Chart {
        title: column.path.clone(),
        x,
        y: axis_label(&quantity, &unit(column)),
        series,
        ..Chart::default()
    }
}

/// Draws the difference of the two curves of an overlay, step by step.
fn difference(overlay: &Chart, column: &ColumnDifference, [a, b]: &[String; 2]) -> Chart {
    let points = match overlay.series.as_slice() {
        [a, b] => {
            let pairs = a.points.iter().zip(&b.points);
            pairs.map(|(a, b)| (a.0, b.1 - a.1)).collect()
        }
        _ => Vec::new(),
    };
    Chart {
        title: format!("Difference: {b} minus {a}"),
        x: overlay.x.clone(),
        y: axis_label("difference", &unit(column)),
        series: vec![Series::new("difference", SeriesStyle::LinePoints, points)],
        level: Some(0.0),
        ..Chart::default()
    }
}
