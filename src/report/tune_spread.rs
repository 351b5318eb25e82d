//! Tolerances and Pareto front of a tuned deck, for the terminal and for its page.

use super::tune_words::{DIGITS, rounded, with_unit};
use super::{Align, Chart, DrawingError, Figure, Series, SeriesStyle, Table};
use admire_syntax::units::short_unit;
use admire_tune::{Front, Robust};

/// Range of a goal's miss along the Pareto front, as a fraction of the goal's tolerance, below which the report states that the goals hardly
/// conflict.
const FLAT_FRONT_SHARE: f64 = 0.1;
/// Largest number of tolerances in the table.
const MAX_TOLERANCES: usize = 12;

fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}

/// Describes the share of drawn axles that meet the goals, with its standard deviation.
fn drawn(robust: &Robust) -> Option<String> {
    let drawn = robust.drawn.as_ref()?;
    let failed = match drawn.failed {
        0 => String::new(),
        count => format!("; {count} without equilibrium"),
    };
    Some(format!(
        "{:.1} ± {:.1} % of {} Monte Carlo axles do{failed}",
        100.0 * drawn.share,
        100.0 * drawn.share_sd,
        drawn.count
    ))
}

/// Describes the effect of the tolerances on the tuned deck, one sentence per item: the share of good axles, the goals that are not met at two
/// standard deviations, and the tolerance to reduce first.
pub(super) fn sentences(robust: &Robust) -> Vec<String> {
    let mut first = format!(
        "{} of axles within the tolerances meet all goals by the linear model",
        percent(robust.share)
    );
    if let Some(drawn) = drawn(robust) {
        first += &format!("; {drawn}");
    }
    let mut all = vec![first];
    let missed = robust.goals.iter().filter(|goal| !goal.is_met_two_sd);
    let missed: Vec<&str> = missed.map(|goal| goal.name.as_str()).collect();
    all.push(if missed.is_empty() {
        "the mean plus two standard deviations meets all goals".to_string()
    } else {
        let names = missed.join("; ");
        format!("the mean plus two standard deviations misses {names}")
    });
    all.extend(tighten(robust));
    all
}

/// Returns which tolerance to tighten first.
fn tighten(robust: &Robust) -> Option<String> {
    let first = robust.tolerances.first()?;
    Some(if first.share_if_halved > robust.share {
        format!(
            "to tighten first: {}; half its tolerance of {} lets {} of axles meet all goals",
            first.name(),
            with_unit(&rounded(first.sd, DIGITS), &first.unit),
            percent(first.share_if_halved)
        )
    } else if robust.share > 0.5 {
        "halving a single tolerance lets no more axles meet all goals".to_string()
    } else {
        "halving a single tolerance lets no more axles meet all goals: the mean misses a goal"
            .to_string()
    })
}

/// Returns the table of the goals with their shares.
pub(super) fn goals(robust: &Robust) -> Table {
    let mut table = Table::new(&[
        ("goal", Align::Left),
        ("good, linear", Align::Right),
        ("good, Monte Carlo", Align::Right),
        ("largest sd, linear", Align::Right),
        ("largest sd, Monte Carlo", Align::Right),
        ("miss of mean plus two sd", Align::Right),
        ("met", Align::Left),
    ]);
    let missing = String::new;
    for goal in &robust.goals {
        table.row([
            goal.name.clone(),
            percent(goal.share),
            goal.share_drawn.map_or_else(missing, percent),
            rounded(goal.sd, DIGITS),
            goal.sd_drawn.map_or_else(missing, |sd| rounded(sd, DIGITS)),
            rounded(goal.two_sd, DIGITS),
            if goal.is_met_two_sd { "yes" } else { "no" }.to_string(),
        ]);
        table.mark(6, if goal.is_met_two_sd { "good" } else { "bad" });
    }
    let all = robust.drawn.as_ref();
    table.row([
        "all".to_string(),
        percent(robust.share),
        all.map_or_else(missing, |drawn| percent(drawn.share)),
        missing(),
        missing(),
        missing(),
        if robust.met_two_sd { "yes" } else { "no" }.to_string(),
    ]);
    table
}

/// Returns the table of the tolerances whose tightening gains most.
pub(super) fn tolerances(robust: &Robust) -> Table {
    let mut table = Table::new(&[
        ("tolerance", Align::Left),
        ("sd", Align::Right),
        ("unit", Align::Left),
        ("share of the variance", Align::Right),
        ("good if halved", Align::Right),
    ]);
    for own in robust.tolerances.iter().take(MAX_TOLERANCES) {
        table.row([
            own.name(),
            rounded(own.sd, DIGITS),
            short_unit(&own.unit),
            percent(own.variance),
            percent(own.share_if_halved),
        ]);
    }
    table
}

/// Returns the name of an axis: what the miss is, and its unit.
fn axis(front: &Front, k: usize) -> String {
    let unit = short_unit(&front.units[k]);
    format!("{} miss of {} [{unit}]", front.measures[k], front.goals[k])
}

/// Draws a Pareto front, with the tuned deck.
pub(super) fn front_chart(front: &Front) -> Result<Figure, DrawingError> {
    let points = front.points.iter();
    let chart = Chart {
        title: "Trade-off between two goals".to_string(),
        x: axis(front, 0),
        y: axis(front, 1),
        series: vec![
            Series::new(
                "Pareto front",
                SeriesStyle::LinePoints,
                points.map(|point| point.misses.into()).collect(),
            ),
            Series::new("tuned", SeriesStyle::Points, vec![front.tuned.into()]),
        ],
        ..Chart::default()
    };
    Figure::chart(&chart, "")
}

/// Returns a Pareto front as a short table for the terminal.
pub fn front_table(front: &Front) -> String {
    let mut text = "Pareto front, miss of each goal:\n".to_string();
    for (k, letter) in ["A", "B"].into_iter().enumerate() {
        let unit = short_unit(&front.units[k]);
        let (goal, measure) = (&front.goals[k], front.measures[k]);
        text += &format!("  {letter}  {goal}, {measure} [{unit}]\n");
    }
    let mut row = |first: &str, second: &str, remark: &str| {
        text += format!("{first:>12}{second:>12}{remark}").trim_end();
        text += "\n";
    };
    row("A", "B", "");
    for point in &front.points {
        let remark = if !point.keeps_limits {
            "  misses a limit"
        } else if !point.converged {
            "  not converged"
        } else {
            ""
        };
        let [first, second] = point.misses.map(|miss| rounded(miss, DIGITS));
        row(&first, &second, remark);
    }
    let [first, second] = front.tuned.map(|miss| rounded(miss, DIGITS));
    row(&first, &second, "  tuned");
    for (k, letter) in ["A", "B"].into_iter().enumerate() {
        let misses = front.points.iter().map(|point| point.misses[k]);
        let (least, most) = misses.fold((f64::INFINITY, 0.0), |(least, most), miss| {
            (f64::min(least, miss), f64::max(most, miss))
        });
        if most - least < FLAT_FRONT_SHARE * front.tolerances[k] {
            text += &format!(
                "  {letter} varies by less than a tenth of its tolerance: the goals hardly conflict\n"
            );
            break;
        }
    }
    text
}
