//! Report page of a sweep: histograms, tornado charts and tables.

use admire_report::{
    Align, Bars, Chart, DrawingError, Figure, Page, Series, SeriesStyle, Table, number,
};

use super::folder::SweepFolder;
use super::summary::{OutputSummary, Spread, Summary};

/// Largest number of bars in a tornado chart.
const MOST_BARS: usize = 15;

/// Formats a number with six significant digits; empty if it is not finite.
pub fn six_digits(value: f64) -> String {
    if value.is_finite() {
        number(value, None)
    } else {
        String::new()
    }
}

/// Returns the report page as HTML in one file.
///
/// # Errors
/// When a picture cannot be drawn.
pub fn page(folder: &SweepFolder, summary: &Summary) -> Result<String, DrawingError> {
    let ok = summary.statuses.get("ok").copied().unwrap_or_default();
    let lead = format!(
        "{ok} of {} cases have an answer; plan {}, {} numbers vary, {} columns are kept.",
        summary.cases,
        summary.plan,
        summary.inputs.len(),
        summary.outputs.len()
    );
    let mut page = Page::new("Sweep", &lead);
    page.heading("What is kept");
    page.table(&spreads(
        summary.outputs.iter().map(|o| (&o.spread, o.nominal)),
    ));
    if ok < summary.cases {
        page.heading("Cases without an answer");
        let mut table = Table::new(&[("why", Align::Wrap), ("cases", Align::Right)]);
        for (reason, count) in &summary.reasons {
            table.row([reason.clone(), count.to_string()]);
        }
        if summary.more_reasons > 0 {
            table.row([
                "other reasons".to_string(),
                summary.more_reasons.to_string(),
            ]);
        }
        page.table(&table);
    }
    for output in &summary.outputs {
        page.heading(&output.spread.name);
        let mut figures = vec![histogram(&output.spread)?];
        figures.extend(tornado(output));
        page.figures(&figures);
        indices(&mut page, output);
        effects(&mut page, output);
    }
    page.heading("What varies");
    page.table(&spreads(summary.inputs.iter().map(|input| (input, None))));
    page.facts(&[
        ("Version", folder.manifest.version.clone()),
        (
            "SHA-256 of the inputs",
            folder.manifest.inputs_sha256.clone(),
        ),
        (
            "Time of all cases together",
            format!("{:.1} s", summary.seconds),
        ),
    ]);
    Ok(page.finish(&format!("admire {}", folder.manifest.version)))
}

fn spreads<'s>(all: impl Iterator<Item = (&'s Spread, Option<f64>)>) -> Table {
    let heads = [
        "",
        "unit",
        "deck as it is",
        "mean",
        "sd",
        "least",
        "1 %",
        "5 %",
        "median",
        "95 %",
        "99 %",
        "most",
    ];
    let columns: Vec<(&str, Align)> = heads
        .iter()
        .enumerate()
        .map(|(k, head)| (*head, if k < 2 { Align::Left } else { Align::Right }))
        .collect();
    let mut table = Table::new(&columns);
    for (spread, nominal) in all {
        let mut row = vec![
            spread.name.clone(),
            spread.unit.clone().unwrap_or_default(),
            nominal.map_or_else(String::new, six_digits),
        ];
        let values = [
            spread.mean,
            spread.sd,
            spread.ends[0],
            spread.quantile(0.01),
            spread.quantile(0.05),
            spread.quantile(0.5),
            spread.quantile(0.95),
            spread.quantile(0.99),
            spread.ends[1],
        ];
        row.extend(values.map(six_digits));
        table.row(row);
    }
    table
}

fn labelled(spread: &Spread) -> String {
    match &spread.unit {
        Some(unit) => format!("{} [{unit}]", spread.name),
        None => spread.name.clone(),
    }
}

/// Draws a histogram of a column's values over the cases, as the outline of its bars.
fn histogram(spread: &Spread) -> Result<Figure, DrawingError> {
    let [least, most] = spread.ends;
    let wide = (most - least) / spread.bars.len().max(1) as f64;
    let mut points = vec![(least, 0.0)];
    for (k, count) in spread.bars.iter().enumerate() {
        let from = least + k as f64 * wide;
        points.push((from, *count as f64));
        points.push((from + wide, *count as f64));
    }
    points.push((most, 0.0));
    let chart = Chart {
        title: format!("How {} is spread", spread.name),
        x: labelled(spread),
        y: "cases".to_string(),
        series: vec![Series {
            name: spread.name.clone(),
            points,
            mark: SeriesStyle::Line,
        }],
        log_y: false,
        level: None,
    };
    Figure::chart(&chart, &format!("{} cases.", spread.count))
}

/// Draws the linear effect of each parameter on an output, the largest effect first.
fn tornado(output: &OutputSummary) -> Option<Figure> {
    let explained = output.explained?;
    let bars = output.swings.iter().take(MOST_BARS);
    let bars = Bars {
        title: format!("What moves {}", output.spread.name),
        x: match &output.spread.unit {
            Some(unit) => format!("change [{unit}]"),
            None => "change".to_string(),
        },
        rows: bars.map(|s| (s.name.clone(), [s.low, s.high])).collect(),
        level: 0.0,
    };
    let caption = format!(
        "Each number from its 5 % to its 95 % quantile, the others held, by straight lines; they explain {:.1} % of the variance.",
        100.0 * explained
    );
    Some(Figure::bars(&bars, &caption))
}

fn indices(page: &mut Page, output: &OutputSummary) {
    if output.indices.is_empty() {
        return;
    }
    page.subheading("Indices of Sobol");
    let mut table = Table::new(&[
        ("number", Align::Left),
        ("first order", Align::Right),
        ("std error", Align::Right),
        ("total", Align::Right),
        ("std error", Align::Right),
    ]);
    for index in &output.indices {
        let values = [
            index.first[0],
            index.first[1],
            index.total[0],
            index.total[1],
        ];
        let cells = values.map(|value| format!("{value:.4}"));
        table.row(std::iter::once(index.name.clone()).chain(cells));
    }
    page.table(&table);
}

fn effects(page: &mut Page, output: &OutputSummary) {
    if output.effects.is_empty() {
        return;
    }
    page.subheading("Elementary effects (Morris)");
    let mut table = Table::new(&[
        ("number", Align::Left),
        ("mean size", Align::Right),
        ("std error", Align::Right),
        ("mean", Align::Right),
        ("spread", Align::Right),
    ]);
    for effect in &output.effects {
        let values = [effect.size[0], effect.size[1], effect.mean, effect.spread];
        table.row(std::iter::once(effect.name.clone()).chain(values.map(six_digits)));
    }
    page.table(&table);
    page.note("Changes over the whole range of probability. A spread as large as the mean size says that the number acts along a bend or together with others.");
}
