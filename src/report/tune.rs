use super::number::capitalised;
use super::scene::Role;
use super::tune_spread::{front_chart, goals, sentences, tolerances};
use super::tune_words::{DIGITS, kind, missed, rounded, with_unit};
use super::{
    Align, Bars, Chart, DrawingError, Figure, HeatMap, Page, Series, SeriesStyle, Summary, Table,
};
use admire_syntax::units::short_unit;
use admire_tune::{GoalOutcome, Outcome, UnknownOutcome};

/// Report of a tuning run as an HTML page.
#[derive(Debug)]
pub struct TuneReport<'a> {
    /// Name of the deck.
    pub deck: &'a str,
    /// Result of the tuning run.
    pub outcome: &'a Outcome,
    /// Inputs and settings listed at the end of the page, by name.
    pub facts: &'a [(&'a str, String)],
    /// Lines of the deck that changed, as a diff.
    pub changes: &'a str,
}

/// Share of the largest contribution below which an unknown is not drawn.
const LEAST_SHARE: f64 = 0.005;

/// Returns the number of goals that are met, in words.
fn met(outcome: &Outcome) -> String {
    let count = outcome.goals.iter().filter(|goal| goal.is_met).count();
    let all = outcome.goals.len();
    match (count, all) {
        (1, 1) => "The goal is met".to_string(),
        (0, 1) => "The goal is not met".to_string(),
        (count, all) if count == all => format!("All {all} goals are met"),
        (0, all) => format!("None of {all} goals is met"),
        (1, all) => format!("1 of {all} goals is met"),
        (count, all) => format!("{count} of {all} goals are met"),
    }
}

/// States in words how many starts agree.
fn agreement(outcome: &Outcome) -> String {
    let all = outcome.starts.len();
    if all == 1 {
        return "The search had one start.".to_string();
    }
    let solved = outcome
        .starts
        .iter()
        .filter(|start| start.cost.is_some())
        .count();
    let without = if solved == all {
        String::new()
    } else {
        format!("; the axle has no equilibrium at {} of them", all - solved)
    };
    let reach = if outcome.agreeing == 1 {
        "start reaches"
    } else {
        "starts reach"
    };
    format!(
        "{} of {all} {reach} the best result{without}.",
        outcome.agreeing
    )
}

/// Returns the result of a tuning run in a few sentences: verdict, missed goals, bounds and conflicts, and the next step.
pub fn tune_summary(outcome: &Outcome) -> Summary {
    let share = outcome.robust.as_ref().map_or_else(String::new, |robust| {
        format!(
            "; with the tolerances, {:.0} % of axles meet all goals",
            100.0 * robust.share
        )
    });
    let mut verdict = format!("{}{share}. {}", met(outcome), agreement(outcome));
    if !outcome.keeps_limits {
        verdict += &format!(
            " No values within the bounds keep all limits: the worst limit is missed by {} times its tolerance.",
            rounded(outcome.violation, 3)
        );
    } else if !outcome.converged {
        verdict +=
            " The search did not converge: the values are the best found, but not an optimum.";
    }
    let miss = |goal: &GoalOutcome| {
        format!(
            "{}: off by {} rms before, {} now{}",
            goal.name,
            with_unit(&missed(goal.rms_before, goal), &goal.unit),
            with_unit(&missed(goal.rms_after, goal), &goal.unit),
            if goal.is_met { "" } else { ", not met" }
        )
    };
    let mut items: Vec<String> = outcome.goals.iter().map(miss).collect();
    items.extend(outcome.conflicts.iter().map(conflict));
    let bounds: Vec<String> = outcome
        .unknowns
        .iter()
        .filter_map(|unknown| Some(format!("{} ({} bound)", unknown.name, unknown.at_bound?)))
        .collect();
    if !bounds.is_empty() {
        items.push(format!("bounds reached: {}", bounds.join(", ")));
    }
    items.extend(outcome.robust.iter().flat_map(sentences));
    let next = if outcome.met {
        "continue with tuned.adm; `admire diff` shows what changed".to_string()
    } else if bounds.is_empty() {
        "free more numbers, or increase the tolerances of the goals that conflict".to_string()
    } else {
        "widen the bounds that were reached, or free more numbers".to_string()
    };
    Summary {
        verdict,
        items,
        held_out: String::new(),
        next,
    }
}

fn conflict(conflict: &admire_tune::Conflict) -> String {
    let [a, b] = &conflict.goals;
    format!(
        "{a} and {b} conflict: the directions that improve them have a cosine of {}",
        rounded(conflict.cosine, 2)
    )
}

impl TuneReport<'_> {
    /// Returns the page as HTML text. `footer` names the program that made it.
    ///
    /// # Errors
    /// [`DrawingError`] if a picture cannot be drawn.
    pub fn page(&self, footer: &str) -> Result<String, DrawingError> {
        let outcome = self.outcome;
        let summary = tune_summary(outcome);
        let mut page = Page::new("Design to a target", self.deck, &summary.verdict);
        page.origin(self.facts);
        let mut figures = Vec::new();
        for goal in outcome.goals.iter().filter(|goal| goal.rows.len() > 1) {
            figures.push(curve(goal)?);
        }
        if let Some(front) = &outcome.pareto {
            figures.push(front_chart(front)?);
        }
        page.meaning().figures(&figures);
        let lines = |all: Vec<String>| all.iter().map(|line| capitalised(line)).collect();
        page.found(&[
            ("Improvement", lines(summary.items)),
            ("Confidence", lines(vec![agreement(outcome)])),
            ("To do next", lines(vec![summary.next])),
        ]);
        page.table(&self.goals());
        page.note(
            "A goal is met if no value misses it by more than its tolerance. A limit is met if no value exceeds it. Characteristics are in the axes of Adams/Car; element forces and positions are in the ground axes of the deck.",
        );
        page.subheading("Changed numbers").table(&self.unknowns());
        page.note(
            "Share: the part of the change of all goals, in units of their tolerances, that comes from the change of this number. Cost per unit of bound: decrease of the cost if the bound is moved outwards by one unit. A goal that is missed by its tolerance costs 0.5.",
        );
        if let Some(robust) = &outcome.robust {
            page.subheading("Tolerances").table(&goals(robust));
            page.note(
                "Good: the share of axles within the tolerances that meet the goal. Linear: the goals depend linearly on the tolerances, which are Gaussian. Monte Carlo: decks with random deviations, each solved in full.",
            );
            page.table(&tolerances(robust));
            page.note(
                "Good if halved: the share of axles that meet all goals if this tolerance is halved, by the linear model. The tolerance of a hardpoint applies to each coordinate.",
            );
        }
        page.detail("Sensitivities");
        page.figures(&self.shares());
        page.table(&self.sensitivities());
        page.add(&self.map());
        page.note(
            "Change of each goal per unit of the number, at the tuned deck: rms over a curve, signed for a single value. For a factor, per percent.",
        );
        page.detail("Goals that conflict");
        if outcome.conflicts.is_empty() {
            page.note("No two missed goals conflict.");
        } else {
            let all: Vec<String> = outcome.conflicts.iter().map(conflict).collect();
            page.list(&all);
        }
        page.detail("Starts").table(&self.starts());
        page.detail("Changes to the deck").verbatim(self.changes);
        Ok(page.finish(footer))
    }

    fn goals(&self) -> Table {
        let mut table = Table::new(&[
            ("goal", Align::Left),
            ("kind", Align::Left),
            ("rms miss before", Align::Right),
            ("rms miss now", Align::Right),
            ("largest miss now", Align::Right),
            ("tolerance", Align::Right),
            ("unit", Align::Left),
            ("met", Align::Left),
        ]);
        for goal in &self.outcome.goals {
            table.row([
                goal.name.clone(),
                kind(goal),
                missed(goal.rms_before, goal),
                missed(goal.rms_after, goal),
                missed(goal.largest_after, goal),
                rounded(goal.tolerance, DIGITS),
                short_unit(&goal.unit),
                if goal.is_met { "yes" } else { "no" }.to_string(),
            ]);
            table.mark(7, if goal.is_met { "good" } else { "bad" });
        }
        table
    }

    fn unknowns(&self) -> Table {
        let mut table = Table::new(&[
            ("number", Align::Left),
            ("form", Align::Left),
            ("tuned", Align::Right),
            ("unit", Align::Left),
            ("lower bound", Align::Right),
            ("upper bound", Align::Right),
            ("share of change", Align::Right),
            ("at bound", Align::Left),
            ("cost per unit of bound", Align::Right),
        ]);
        for unknown in &self.outcome.unknowns {
            let number = |value: f64| rounded(value, DIGITS);
            table.row([
                unknown.name.clone(),
                unknown.form.to_string(),
                number(unknown.value),
                short_unit(&unknown.unit),
                number(unknown.bounds[0]),
                number(unknown.bounds[1]),
                format!("{:.1} %", 100.0 * unknown.matters),
                unknown.at_bound.unwrap_or_default().to_string(),
                if unknown.at_bound.is_some() {
                    rounded(unknown.pull, 2)
                } else {
                    String::new()
                },
            ]);
            if unknown.at_bound.is_some() {
                table.mark(7, "bad");
            }
        }
        table
    }

    /// Draws the share of each number's own change in the total improvement.
    fn shares(&self) -> Vec<Figure> {
        let mut rows: Vec<(String, [f64; 2])> = self
            .outcome
            .unknowns
            .iter()
            .filter(|unknown| unknown.matters > LEAST_SHARE)
            .map(|unknown| (unknown.name.clone(), [0.0, 100.0 * unknown.matters]))
            .collect();
        rows.sort_by(|a, b| b.1[1].total_cmp(&a.1[1]));
        if rows.is_empty() {
            return Vec::new();
        }
        let bars = Bars {
            title: "Share of each number in the change of the goals".to_string(),
            x: "share in percent".to_string(),
            rows,
            level: 0.0,
        };
        vec![Figure::bars(
            &bars,
            "Shares by the linear model at the tuned deck.",
        )]
    }

    fn per(unknown: &UnknownOutcome) -> String {
        match (unknown.form, unknown.unit.as_str()) {
            ("factor", _) => "%".to_string(),
            (_, "") => "1".to_string(),
            (_, unit) => short_unit(unit),
        }
    }

    fn sensitivities(&self) -> Table {
        let names: Vec<String> = self
            .outcome
            .goals
            .iter()
            .map(|goal| format!("{} [{}]", goal.name, short_unit(&goal.unit)))
            .collect();
        let mut heads = vec![("number", Align::Left), ("unit of number", Align::Left)];
        heads.extend(names.iter().map(|name| (name.as_str(), Align::Right)));
        let mut table = Table::new(&heads);
        for (k, unknown) in self.outcome.unknowns.iter().enumerate() {
            let mut row = vec![unknown.name.clone(), Self::per(unknown)];
            let goals = self.outcome.goals.iter();
            row.extend(goals.map(|goal| rounded(goal.sensitivities[k], 3)));
            table.row(row);
        }
        table
    }

    /// Draws the sensitivities in units of the tolerances.
    fn map(&self) -> Figure {
        let outcome = self.outcome;
        let value = |goal: &GoalOutcome, k: usize| {
            let value = goal.sensitivities[k] / goal.tolerance;
            value.is_finite().then_some(value)
        };
        let values: Vec<Vec<Option<f64>>> = outcome
            .goals
            .iter()
            .map(|goal| {
                (0..outcome.unknowns.len())
                    .map(|k| value(goal, k))
                    .collect()
            })
            .collect();
        let sizes = values.iter().flatten().flatten();
        let limit = sizes.fold(0.0_f64, |most, value| most.max(value.abs()));
        let map = HeatMap {
            title: "Sensitivities".to_string(),
            rows: outcome.goals.iter().map(|goal| goal.name.clone()).collect(),
            columns: outcome
                .unknowns
                .iter()
                .map(|unknown| unknown.name.clone())
                .collect(),
            values,
            limit: if limit > 0.0 { limit } else { 1.0 },
            what: "change / tolerance of the goal, per unit of the number".to_string(),
        };
        Figure::map(
            &map,
            "Change of each goal, divided by its tolerance, per unit of the number.",
        )
    }

    fn starts(&self) -> Table {
        let mut table = Table::new(&[
            ("start", Align::Left),
            ("cost", Align::Right),
            ("largest limit miss / tolerance", Align::Right),
            ("evaluations", Align::Right),
            ("converged", Align::Left),
            ("goals met", Align::Left),
            ("same result as the best", Align::Left),
        ]);
        let yes = |is: bool| if is { "yes" } else { "no" }.to_string();
        for (k, start) in self.outcome.starts.iter().enumerate() {
            let name = if k == 0 {
                "values of the study".to_string()
            } else {
                format!("Sobol point {k}")
            };
            table.row([
                name,
                start.cost.map_or_else(
                    || "no equilibrium".to_string(),
                    |cost| rounded(cost, DIGITS),
                ),
                rounded(start.violation, DIGITS),
                start.evaluations.to_string(),
                yes(start.converged),
                yes(start.met),
                yes(start.agrees),
            ]);
        }
        table
    }
}

/// Draws a curve before and after the search, with its target.
fn curve(goal: &GoalOutcome) -> Result<Figure, DrawingError> {
    let points = |value: &dyn Fn(&admire_tune::RowOutcome) -> Option<f64>| -> Vec<(f64, f64)> {
        let rows = goal.rows.iter();
        rows.filter_map(|row| Some((row.at, value(row)?))).collect()
    };
    let mut series = vec![
        Series::of(Role::Given, points(&|row| Some(row.before))),
        Series::new(
            "tuned",
            SeriesStyle::LinePoints,
            points(&|row| Some(row.after)),
        ),
    ];
    let bound = |name: &str, points| Series::new(name, SeriesStyle::Dashed, points);
    if goal.kind == "limit" {
        series.push(bound("lower limit", points(&|row| row.least)));
        series.push(bound("upper limit", points(&|row| row.most)));
        series.retain(|series| !series.points.is_empty());
    } else {
        series.push(bound("target", points(&|row| row.least)));
    }
    let chart = Chart {
        title: goal.name.clone(),
        x: format!("{} [{}]", goal.test, goal.at_unit),
        y: format!("{} [{}]", goal.of, goal.unit),
        series,
        ..Chart::default()
    };
    Figure::chart(&chart, "")
}
