//! Report page of a sweep: histograms, tornado charts and tables.

use admire_report::{
    Align, Bars, Chart, DrawingError, Figure, Page, Series, SeriesStyle, Table, axis_label, number,
};
use admire_results::Timestamp;

use super::folder::SweepFolder;
use super::summary::{OutputSummary, Spread, Summary};

/// Largest number of bars in a tornado chart.
const MOST_BARS: usize = 15;
/// Largest number of outputs whose main effects are not folded.
const MOST_SHOWN: usize = 3;
/// Largest number of outputs in the answer.
const MOST_TOLD: usize = 2;

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
    let inputs = &folder.manifest.inputs;
    let of = |end: &str| {
        let named = inputs.keys().filter(|name| name.ends_with(end));
        named.cloned().collect::<Vec<_>>().join(", ")
    };
    let (deck, plan) = (of(".adm"), of(".toml"));
    let title = match deck.as_str() {
        "" => format!("Variants of {plan}"),
        deck => format!("Variants of {deck}"),
    };
    let mut page = Page::new("Sweep", &title, &answer(summary, ok));
    page.origin(&[
        ("Deck", deck),
        ("Plan", format!("{plan}, {}", summary.plan)),
        ("Date", format!("{} UTC", Timestamp::now().date_time())),
        ("Made by", format!("admire {}", folder.manifest.version)),
        (
            "Total time of all cases",
            format!("{:.1} s", summary.seconds),
        ),
        (
            "Inputs",
            format!("SHA-256 {}", folder.manifest.inputs_sha256),
        ),
    ]);
    page.meaning();
    for output in summary.outputs.iter().take(MOST_SHOWN) {
        page.figures(&main_effects(output, &summary.inputs)?);
    }
    let numbers = match summary.inputs.len() {
        1 => "one number is varied".to_string(),
        count => format!("{count} numbers are varied"),
    };
    page.found(&[(
        "Variants",
        vec![format!(
            "{ok} of {} variants have a result; {numbers}",
            summary.cases
        )],
    )]);
    page.table(&ranges(summary));
    page.note("Nine of ten variants lie between the 5 % and the 95 % quantile.");
    page.detail("Cases without a result");
    if ok < summary.cases {
        let mut table = Table::new(&[("reason", Align::Wrap), ("cases", Align::Right)]);
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
    for (k, output) in summary.outputs.iter().enumerate() {
        page.detail(&output.spread.name);
        let mut figures = vec![histogram(&output.spread)?];
        if k >= MOST_SHOWN {
            figures.extend(main_effects(output, &summary.inputs)?);
        }
        page.figures(&figures);
        indices(&mut page, output);
        effects(&mut page, output);
    }
    page.detail("All quantiles");
    let outputs = summary.outputs.iter().map(|output| &output.spread);
    page.table(&spreads(outputs.chain(&summary.inputs)));
    page.note("The outputs come first, then the varied numbers.");
    Ok(page.finish(&format!("admire {}", folder.manifest.version)))
}

/// Returns a few sentences with the range of the first outputs, and with the parameter that has the largest effect on each.
fn answer(summary: &Summary, ok: u64) -> String {
    let told = summary.outputs.iter().take(MOST_TOLD).map(|output| {
        let spread = &output.spread;
        let [low, high] = [0.05, 0.95].map(|share| short(spread.quantile(share), spread.sd));
        let unit = spread.unit.as_deref().unwrap_or_default();
        let mut text = format!(
            "In 90 % of the variants, {} lies between {low} and {high} {unit}",
            spread.name
        );
        text.truncate(text.trim_end().len());
        if let Some(swing) = output.swings.first() {
            text += &format!(", most affected by {}", swing.name);
        }
        text + "."
    });
    let told: Vec<String> = told.collect();
    if ok == 0 {
        return format!("None of the {} variants has a result.", summary.cases);
    }
    told.join(" ")
}

/// Formats a value to a hundredth of its standard deviation.
fn short(value: f64, sd: f64) -> String {
    number(value, Some(sd))
}

/// Draws the main effects on an output, and its values over the parameter with the largest effect.
fn main_effects(output: &OutputSummary, inputs: &[Spread]) -> Result<Vec<Figure>, DrawingError> {
    let mut figures: Vec<Figure> = tornado(output).into_iter().collect();
    if let Some(swing) = output.swings.first() {
        let chart = Chart {
            title: format!("{} over {}", output.spread.name, swing.name),
            x: inputs
                .iter()
                .find(|own| own.name == swing.name)
                .map_or_else(|| swing.name.clone(), labelled),
            y: labelled(&output.spread),
            series: vec![Series::new(
                "variants",
                SeriesStyle::Points,
                output.scatter.clone(),
            )],
            level: output.nominal,
            ..Chart::default()
        };
        let caption = "Each point is a variant. The dotted line is the nominal deck.";
        figures.push(Figure::chart(&chart, caption)?);
    }
    Ok(figures)
}

/// Tabulates the range of each output, with the parameter that has the largest effect on it.
fn ranges(summary: &Summary) -> Table {
    let mut table = Table::new(&[
        ("output", Align::Left),
        ("unit", Align::Left),
        ("nominal deck", Align::Right),
        ("5 % quantile", Align::Right),
        ("median", Align::Right),
        ("95 % quantile", Align::Right),
        ("most affected by", Align::Left),
    ]);
    for output in &summary.outputs {
        let spread = &output.spread;
        let shown = |value: f64| short(value, spread.sd);
        let [low, middle, high] = [0.05, 0.5, 0.95].map(|share| shown(spread.quantile(share)));
        let moved = output.swings.first();
        table.row([
            spread.name.clone(),
            spread.unit.clone().unwrap_or_default(),
            output.nominal.map_or_else(String::new, shown),
            low,
            middle,
            high,
            moved.map_or_else(String::new, |swing| swing.name.clone()),
        ]);
    }
    table
}

/// Tabulates all statistics, one row for each column of the results.
fn spreads<'s>(all: impl Iterator<Item = &'s Spread>) -> Table {
    let heads = [
        "quantity", "unit", "mean", "sd", "minimum", "1 %", "5 %", "median", "95 %", "99 %",
        "maximum",
    ];
    let columns: Vec<(&str, Align)> = heads
        .iter()
        .enumerate()
        .map(|(k, head)| (*head, if k < 2 { Align::Left } else { Align::Right }))
        .collect();
    let mut table = Table::new(&columns);
    for spread in all {
        let mut row = vec![spread.name.clone(), spread.unit.clone().unwrap_or_default()];
        let values = [
            spread.mean,
            spread.ends[0],
            spread.quantile(0.01),
            spread.quantile(0.05),
            spread.quantile(0.5),
            spread.quantile(0.95),
            spread.quantile(0.99),
            spread.ends[1],
        ];
        row.extend(values.map(|value| short(value, spread.sd)));
        row.insert(3, number(spread.sd, Some(0.1 * spread.sd)));
        table.row(row);
    }
    table
}

fn labelled(spread: &Spread) -> String {
    axis_label(&spread.name, spread.unit.as_deref().unwrap_or_default())
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
        title: format!("Distribution of {}", spread.name),
        x: labelled(spread),
        y: "cases".to_string(),
        series: vec![Series::new(&spread.name, SeriesStyle::Line, points)],
        ..Chart::default()
    };
    Figure::chart(&chart, &format!("Number of cases: {}.", spread.count))
}

/// Draws the linear effect of each parameter on an output, the largest effect first.
fn tornado(output: &OutputSummary) -> Option<Figure> {
    let explained = output.explained?;
    let bars = output.swings.iter().take(MOST_BARS);
    let bars = Bars {
        title: format!("What affects {}", output.spread.name),
        x: axis_label(
            "change of the output",
            output.spread.unit.as_deref().unwrap_or_default(),
        ),
        rows: bars.map(|s| (s.name.clone(), [s.low, s.high])).collect(),
        level: 0.0,
    };
    let caption = format!(
        "Change of the output with each number at its 5 % quantile (orange) and its 95 % quantile (blue), the other numbers held. A linear model explains {:.1} % of the variance.",
        100.0 * explained
    );
    Some(Figure::bars(&bars, &caption))
}

fn indices(page: &mut Page, output: &OutputSummary) {
    if output.indices.is_empty() {
        return;
    }
    page.subheading("Sobol indices");
    let mut table = Table::new(&[
        ("number", Align::Left),
        ("first-order index", Align::Right),
        ("std error", Align::Right),
        ("total index", Align::Right),
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
        ("mean |effect|", Align::Right),
        ("std error", Align::Right),
        ("mean effect", Align::Right),
        ("std deviation", Align::Right),
    ]);
    for effect in &output.effects {
        let values = [effect.size[0], effect.size[1], effect.mean, effect.spread];
        table.row(std::iter::once(effect.name.clone()).chain(values.map(six_digits)));
    }
    page.table(&table);
    page.note("An effect is the change of the output, in its unit, per unit of cumulative probability of the number. A standard deviation as large as the mean |effect| indicates that the number acts nonlinearly or interacts with others.");
}
